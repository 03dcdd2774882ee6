"""What is given of the base, its displacement, velocity or acceleration, is what keeps its amplitude over η."""

import math
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    Cells,
    EtaStudy,
    ExactPenalty,
    Excitation,
    Newmark,
    Reference,
    System,
    brief_system_text,
    parse_system,
    physical_text,
    run_cells,
    simulate,
    sweep,
    system_of_physical,
    system_text,
)
from vibroscope.engine.excitation import HELD
from vibroscope.engine.physical import held_text

BRACKET = {"mass1_kg": 0.8, "frequency1_Hz": 22.0, "damping1_ratio": 0.02, "wall": True, "clearance_mm": 0.3}
BRACKET |= {"restitution": 0.6, "base_acceleration_m_per_s2": 4.0, "frequency_Hz": 18.0}


def acceleration_at(system, units, frequency):
    """Amplitude of the base's acceleration in m/s² at a frequency in Hz."""
    omega = 2 * math.pi * frequency
    return 1e-3 * units.base_amplitude * system.excitation.base_amplitude(omega / units.omega1) * omega**2


def test_four_metres_per_second_squared_at_18_hz_are_four_at_25_hz():
    system, units, *_ = system_of_physical(BRACKET)
    for frequency in (10.0, 18.0, 25.0, 300.0):
        assert acceleration_at(system, units, frequency) == pytest.approx(4.0, rel=1e-14)
    assert held_text(system.excitation, units) == "base acceleration 4 m/s²"


@pytest.mark.parametrize(
    ("name", "value", "power"),
    [
        ("base_amplitude_mm", 0.5, 0),
        ("base_velocity_mm_per_s", 30.0, 1),
        ("base_acceleration_m_per_s2", 4.0, 2),
        ("base_acceleration_g", 0.4, 2),
    ],
)
def test_the_amplitude_follows_what_is_held(name, value, power):
    entry = {key: number for key, number in BRACKET.items() if not key.startswith("base_")} | {name: value}
    system, units, eta, forms = system_of_physical(entry)
    drive = system.excitation
    assert drive.held == HELD[power]
    assert drive.base_amplitude(eta) == pytest.approx(1.0)
    assert drive.base_amplitude(2 * eta) == pytest.approx(0.5**power)
    again = parse_system(physical_text(system, units, 2 * eta, forms).encode())
    assert again.system.excitation.base == pytest.approx(drive.base, rel=1e-13)
    assert f"{name} = " in physical_text(system, units, 2 * eta, forms)
    assert parse_system(system_text(system, units).encode()).system == system
    assert parse_system(brief_system_text(system).encode()).system == system


def test_an_acceleration_needs_no_frequency():
    """Then lengths are counted in the amplitude that it has at the natural frequency of body 1."""
    entry = {name: value for name, value in BRACKET.items() if name != "frequency_Hz"}
    system, units, eta, _ = system_of_physical(entry)
    assert eta is None
    assert system.excitation.base == pytest.approx(1.0)
    assert acceleration_at(system, units, 18.0) == pytest.approx(4.0)


def test_numbers_come_back_in_the_form_in_which_they_were_given():
    system, units, eta, forms = system_of_physical(BRACKET | {"base_acceleration_m_per_s2": 4.0})
    text = physical_text(system, units, eta, forms)
    assert "frequency1_Hz = 22.0 " in text
    assert "base_acceleration_m_per_s2 = 4.0 " in text
    assert "stiffness1" not in text


@pytest.mark.parametrize("held", HELD)
@pytest.mark.parametrize("method", [Reference(), ExactPenalty(2500, 8), Newmark(2500, 8, 400)])
def test_every_run_has_the_amplitude_of_its_frequency(held, method):
    """One run, the cells of a sweep, and a sweep over η are those of a base that moves by that amplitude."""
    etas = np.array([0.8, 1.08, 2.76])
    system = System(excitation=Excitation(base=1.3, base_phase=0.4, held=held))
    cells = run_cells(Cells(system, etas, method), transient=40, sample=4, recurrence=0)
    of_each = run_cells(Cells([system] * 3, etas, method), transient=40, sample=4, recurrence=0)
    swept = sweep(EtaStudy(system, method, values=etas, transient=40, sample=4))
    for i, eta in enumerate(etas):
        amplitude = 1.3 / eta ** HELD.index(held)
        plain = replace(system, excitation=Excitation(base=amplitude, base_phase=0.4))
        expected = simulate(plain, eta, method, periods=44, keep=4).section
        found = simulate(system, eta, method, periods=44, keep=4).section
        assert found == pytest.approx(expected, abs=1e-9)
        assert cells.section[i] == pytest.approx(expected, abs=1e-9)
        assert of_each.section[i] == pytest.approx(expected, abs=1e-9)
        assert swept["xi2"].to_numpy()[i] == pytest.approx(expected[:, 2], abs=1e-9)


def test_what_is_held_is_one_of_three():
    with pytest.raises(ValueError, match=r"held = 'speed'.*displacement, velocity, acceleration"):
        Excitation(held="speed")
    with pytest.raises(ValueError, match="held = 'speed'"):
        parse_system(b'[excitation]\nheld = "speed"')
