"""Entry in physical units: the same system as its non-dimensional numbers, there and back, and refused in one line."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from vibroscope.engine import (
    ExactPenalty,
    Excitation,
    System,
    Units,
    parse_system,
    physical_entry,
    physical_text,
    simulate,
    system_of_physical,
    system_text,
)

from tests.systems_strategy import general_systems

# Code_Aster SDND102: a body on a spring, a wall half a millimetre away, a shaken base
WALL = {
    "mass1_kg": 25.0,
    "stiffness1_N_per_m": 98696.0,
    "damping1_ratio": 0.07,
    "wall": True,
    "clearance_mm": 0.5,
    "base_acceleration_m_per_s2": 1.0,
    "frequency_Hz": 10.0,
}


def test_numbers_of_a_data_sheet():
    system, units, eta, _ = system_of_physical(WALL)
    omega1, amplitude = math.sqrt(98696.0 / 25.0), 1 / (20 * math.pi) ** 2
    assert eta == pytest.approx(20 * math.pi / omega1)
    assert units.base_amplitude == pytest.approx(1e3 * amplitude)
    assert system.clearance == pytest.approx(0.5e-3 / amplitude)
    assert (system.wall, system.d1) == (True, 0.07)
    assert system.excitation == Excitation(base=system.excitation.base, held="acceleration")
    assert system.excitation.base == pytest.approx(eta**2)


@pytest.mark.parametrize("name", ["base_amplitude_mm", "base_acceleration_m_per_s2"])
def test_a_base_of_amplitude_zero_stands_still(name):
    still = {each: value for each, value in WALL.items() if not each.startswith("base")}
    for more in {"force1_N": 3.0}, {"length_mm": 2.0}:
        assert system_of_physical(still | more | {name: 0.0}) == system_of_physical(still | more)


def test_a_damper_and_a_frequency_say_the_same_as_ratio_and_spring():
    k, m = 98696.0, 25.0
    other = {"frequency1_Hz": math.sqrt(k / m) / (2 * math.pi), "damping1_Ns_per_m": 2 * 0.07 * math.sqrt(k * m)}
    kept = {name: value for name, value in WALL.items() if name not in ("stiffness1_N_per_m", "damping1_ratio")}
    one, two = system_of_physical(WALL), system_of_physical(kept | other)
    assert two.system.d1 == pytest.approx(one.system.d1, rel=1e-14)
    assert two.units.omega1 == pytest.approx(one.units.omega1, rel=1e-14)


def test_the_motion_in_millimetres_does_not_depend_on_the_unit_of_length():
    force = {"force1_N": 40.0, "frequency_Hz": 9.0, "clearance_mm": 0.3}
    kept = {name: value for name, value in WALL.items() if not name.startswith("base")}
    ends = []
    for length in ({}, {"length_mm": 1.7}):
        system, units, eta, _ = system_of_physical(kept | force | length)
        method = ExactPenalty(units.model("stiffness", 5.76e7), units.model("damping", 300.0))
        ends.append(simulate(system, eta, method, periods=20, keep=1).section[0, 0] * units.base_amplitude)
    assert ends[1] == pytest.approx(ends[0], rel=1e-9)


@given(general_systems, st.floats(1, 1e4), st.floats(1e-3, 1e3), st.floats(1e-3, 10), st.floats(0.1, 5))
def test_an_entry_describes_the_system_that_it_was_made_of(system, omega1, m1, length, eta):
    """Where the base moves its amplitude is the unit of length."""
    units = Units(omega1, m1, length)
    found = system_of_physical(physical_entry(system, units, eta))
    scale = found.units.base_amplitude / length
    assert scale == pytest.approx(abs(system.excitation.base) or 1.0)
    assert found.eta == pytest.approx(eta)
    assert found.system.clearance * scale == pytest.approx(system.clearance, abs=1e-12)
    assert found.system.rest == pytest.approx(np.array(system.rest) / scale, abs=1e-9)
    for name in ("base", "force1", "force2"):
        expected = np.array(system.excitation.harmonic(name, eta)) / scale
        np.testing.assert_allclose(found.system.excitation.harmonic(name, eta), expected, atol=1e-9)
    for name in ("wall", "d1", "d2", "restitution"):
        assert getattr(found.system, name) == pytest.approx(getattr(system, name))
    assert found.system.mass_ratio == pytest.approx(system.mass_ratio)


@given(general_systems)
def test_files_of_any_system_are_read_back(system):
    assert parse_system(system_text(system).encode()).system == system
    text = physical_text(system, Units(), 1.3)
    assert parse_system(text.encode()).eta == pytest.approx(1.3)


def test_a_number_is_written_as_it_was_given():
    entry = {"mass1_kg": 2.4, "frequency1_Hz": 12.0, "mass2_kg": 0.9, "frequency2_Hz": 30.0, "length_mm": 1.0}
    found = system_of_physical(entry)
    assert "mass2_kg = 0.9 " in physical_text(found.system, found.units)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mass1_kg": 0.0}, r"mass1_kg must be from 1e-15 to 1e12 kg; 0 was given"),
        ({"mass1_kg": 1e308}, "mass1_kg must be from 1e-15 to 1e12 kg; 1e308 was given"),
        ({"mass1_kg": "two"}, "mass1_kg must be .* 'two' was given"),
        ({"stiffness1_N_per_m": 5e-324}, "stiffness1_N_per_m must be .* beside mass1_kg = 25; "),
        ({"frequency_Hz": 1e-200}, "frequency_Hz must be .* beside body 1 at 10 Hz; 1e-200 was"),
        ({"stiffness1_N_per_m": 0.0}, "damping1_ratio of a body without a spring: give stiffness1_N_per_m or"),
        ({"stiffness1_N_per_m": -1.0}, "stiffness1_N_per_m must be from 0 to 1e15 N/m; -1 was"),
        (
            {"stiffness1_N_per_m": 1e-14},
            "stiffness1_N_per_m must be from 2.5e-11 to 2.5e19 N/m beside mass1_kg = 25; 1e-14",
        ),
        ({"restitution": 1.1}, "restitution must be from 0 to 1; 1.1 was given"),
        ({"base_phase_rad": 1e4}, "base_phase_rad must be from -1000 to 1000 rad"),
        ({"frequency_Hz": 1e5}, "frequency_Hz must be from 0.01 to 10000 Hz beside body 1 at 10 Hz; 100000 was"),
        ({"base_acceleration_m_per_s2": 1e9}, "base_acceleration_m_per_s2 must be .* at frequency_Hz = 10; 1e9 was"),
        (
            {"clearance_mm": 1e6},
            "clearance_mm must be from -253303 to 253303 mm where lengths are counted in 0.253303 mm",
        ),
        ({"force1_N": 1e9}, r"force1_N must be from -2.5e7 to 2.5e7 N where lengths"),
        (
            {"damping1_ratio": None, "damping1_Ns_per_m": 1e5},
            "damping1_Ns_per_m must be from 0 to below 3141.59 N·s/m so",
        ),
        ({"stiffness1_N_per_m": None}, "damping1_ratio of a body without a spring: give stiffness1_N_per_m or"),
        (
            {"stiffness1_N_per_m": None, "wall": None, "mass2_kg": 1.0, "stiffness2_N_per_m": 1.0},
            "stiffness1_N_per_m or frequency1_Hz is missing",
        ),
        (
            {"frequency1_Hz": 10.0},
            "mass1_kg, stiffness1_N_per_m and frequency1_Hz: one follows from the two others, leave one out",
        ),
        ({"mass2_kg": 1.0}, "wall = true and mass2_kg"),
        ({"wall": None}, "neither mass2_kg nor wall = true"),
        ({"damping1_ratio": 1.0}, "damping1_ratio must be from 0 to below 1; 1 was given"),
        (
            {"length_mm": 1.0, "base_amplitude_mm": 1.0, "base_acceleration_m_per_s2": None},
            "length_mm although the base moves",
        ),
        ({"base_acceleration_g": 1.0}, "both base_acceleration_m_per_s2 and base_acceleration_g"),
        ({"base_acceleration_m_per_s2": None, "clearance_mm": None}, "give length_mm"),
    ],
)
def test_a_faulty_entry_is_refused_in_one_line(change, words):
    entry = {name: value for name, value in (WALL | change).items() if value is not None}
    with pytest.raises(ValueError, match=words) as caught:
        system_of_physical(entry)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"[physical]\nmass1_g = 2", "'mass1_g'; did you mean mass1_kg"),
        (b"[physical]\nmass1_kg = 2\n[system]\nd1 = 0", r"gives \[physical\] and \[system\]"),
        (b"[system]\nwall = true\nkappa = 2", "wall = true and kappa"),
        (b"[system]\nwall = true\n[excitation]\nforce2 = 2", "wall = true and force2"),
        (b"[system]\nwall = 1", "wall = '1' in .system. is not true or false"),
        (b"[system]\nkappa = 1", "kappa = 1 leaves the mass ratio open"),
        (b"[system]\nclearance = 1e308", "clearance = 1e.308 is outside"),
        (b"[excitation]\nbas = 1", "did you mean base"),
    ],
)
def test_a_faulty_file_is_refused_in_one_line(content, words):
    with pytest.raises(ValueError, match=words) as caught:
        parse_system(content)
    assert "\n" not in str(caught.value)


def test_equal_bodies_are_given_by_their_mass_ratio():
    system = parse_system(b"[system]\nkappa = 1\nmass_ratio = 2\nd3 = 'derived'").system
    assert (system.mass_ratio, system.kappa3) == (2.0, 1.0)
    assert system.joint_damping("table") == system.derived_joint_damping
    assert System.from_dict(system.as_dict()) == system


def test_a_mass_follows_from_its_spring_and_its_natural_frequency():
    """A cantilever of 42 N/m at 21 kHz weighs 2.4e-9 kg, less than was once allowed with a frequency alone."""
    given = {"stiffness1_N_per_m": 42.0, "frequency1_Hz": 21_000.0, "wall": True, "clearance_mm": 2.6e-3}
    found = system_of_physical(given)
    assert found.units.m1 == pytest.approx(2.412e-9, rel=1e-3)
    assert found.units.omega1 == pytest.approx(2 * np.pi * 21_000)
    with pytest.raises(ValueError, match="gives mass1_kg, stiffness1_N_per_m and frequency1_Hz: one follows"):
        system_of_physical(given | {"mass1_kg": 1.0})
    assert system_of_physical(given | {"frequency1_Hz": 1e7}).units.m1 == pytest.approx(1.064e-14, rel=1e-3)
