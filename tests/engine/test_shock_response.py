"""Shock response: it is that of the system of a data sheet whose natural frequency of body 1 alone is another one."""

import math

import numpy as np
import pytest
from vibroscope.engine import (
    ExactPenalty,
    Load,
    Newmark,
    Reference,
    System,
    TimeStepping,
    Units,
    shock_response,
    system_of_physical,
    transient,
)
from vibroscope.engine.physical import G

BOX = {
    "mass1_kg": 0.5,
    "frequency1_Hz": 40.0,
    "damping1_ratio": 0.05,
    "wall": True,
    "clearance_mm": 0.6,
    "restitution": 0.6,
    "base_amplitude_mm": 1.0,
    "frequency_Hz": 20.0,
}
TWO_STOPS = BOX | {"clearance2_mm": 0.4, "stiffness_factor2": 3.0, "damping_factor2": 0.5, "restitution2": 0.4}
PAIR = {
    "mass1_kg": 2.4,
    "frequency1_Hz": 40.0,
    "damping1_ratio": 0.02,
    "mass2_kg": 0.9,
    "frequency2_Hz": 60.0,
    "damping2_ratio": 0.03,
    "joint_damping_ratio": 0.04,
    "clearance_mm": 0.2,
    "restitution": 0.6,
    "base_amplitude_mm": 0.5,
}
LOOSE = {name: value for name, value in PAIR.items() if name not in ("damping2_ratio", "frequency2_Hz")} | {
    "stiffness2_N_per_m": 0.0,
    "damping2_Ns_per_m": 12.0,
}
SYSTEMS = {"wall": BOX, "two stops": TWO_STOPS, "pair": PAIR, "loose": LOOSE}
FREQUENCIES = 10.0, 23.0, 40.0, 160.0  # Hz
K, D, STEP = 1e6, 40.0, 1e-4  # N/m, N·s/m, s
METHODS = {
    "reference": lambda units: Reference(),
    "exact": lambda units: ExactPenalty(*_contact(units)),
    "newmark": lambda units: Newmark(*_contact(units), _steps(units)),
    "hunt-crossley": lambda units: ExactPenalty(*_contact(units, "hunt-crossley"), "hunt-crossley"),
    "flores": lambda units: TimeStepping(_contact(units, "flores")[0], None, _steps(units), law="flores"),
}


def _contact(units, law="kelvin-voigt"):
    """K and D of the model that are those numbers in the SI units of a law."""
    own = Units(units.omega1, units.m1, units.base_amplitude, law=law)
    return own.model("contact_stiffness", K), own.model("contact_damping", D)


def _steps(units):
    return math.ceil(2 * math.pi / units.omega1 / STEP * (1 - 1e-9))


def half_sine(units, peak=30.0, duration=11e-3):
    return Load.half_sine(units.model("acceleration", -peak * G), units.model("time", duration))


def read(entry):
    system, units, *_ = system_of_physical(entry)
    return system, units


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("entry", SYSTEMS.values(), ids=SYSTEMS)
def test_it_is_a_run_of_the_system_with_another_natural_frequency_of_body_1(entry, method):
    system, units = read(entry)
    ratios = np.array(FREQUENCIES) / entry["frequency1_Hz"]
    peak = -30.0 if entry is LOOSE else 30.0  # a body without a spring is driven towards the other one
    found = shock_response(system, half_sine(units, peak), ratios, METHODS[method](units))
    touched = 0
    for place, frequency in enumerate(FREQUENCIES):
        other, own = read(entry | {"frequency1_Hz": frequency})
        run = transient(other, half_sine(own, peak), METHODS[method](own))
        touched += len(run.response.impacts)
        for name, quantity in {"displacement": "displacement1", "acceleration": "acceleration1", "impulse": ""}.items():
            expected = own.physical(name, run.peaks[quantity or name])
            seen = units.physical(name, getattr(found, name)[place])
            assert seen == pytest.approx(expected, rel=1e-7, nan_ok=True), (frequency, name)
    assert touched > 1


@pytest.mark.parametrize("length", [1.0, 1e-4], ids=["millimetres", "tenths of a micrometre"])
@pytest.mark.parametrize("entry", [BOX, TWO_STOPS, PAIR], ids=["wall", "two stops", "pair"])
def test_without_the_stop_it_is_the_oscillator_alone(entry, length):
    """A half-sine a sin(πt/T) on ẍ + 2dωẋ + ω²x = −b̈, by its Duhamel integral; at 6 Hz and 2 % 52.8 mm."""
    held = {"base_amplitude_mm": 0.0, "length_mm": length, "damping1_ratio": 0.02}
    system, units = read({name: value for name, value in entry.items() if name != "frequency_Hz"} | held)
    found = shock_response(system, half_sine(units), [0.15, 0.5], Reference())
    assert units.physical("displacement", found.displacement_without[0]) == pytest.approx(0.0528, abs=5e-5)
    for place, frequency in enumerate((6.0, 20.0)):
        w, d, end = 2 * math.pi * frequency, 0.02, 11e-3
        wd, times = w * math.sqrt(1 - d * d), np.linspace(0.0, 4 / frequency, 200_001)
        grid = np.linspace(0.0, end, 4001)
        pull = 30 * G * np.sin(math.pi * grid / end)
        # ∫ e^{-dw(t-s)} sin(wd (t-s)) p(s) ds is a sum of two integrals up to min(t, end)
        kernel = np.exp(d * w * grid) * pull
        sums = [
            np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]) * np.diff(grid))])
            for y in (kernel * np.cos(wd * grid), kernel * np.sin(wd * grid))
        ]
        cosine, sine = (np.interp(times, grid, each) for each in sums)
        x = np.exp(-d * w * times) / wd * (np.sin(wd * times) * cosine - np.cos(wd * times) * sine)
        seen = units.physical("displacement", found.displacement_without[place])
        assert seen == pytest.approx(np.abs(x).max(), rel=1e-5)


def test_what_a_natural_frequency_puts_out_of_range_is_named_with_it():
    system, units = read(BOX)
    with pytest.raises(ValueError, match=r"natural frequency 100 of body 1: its natural period has 2.5 time steps"):
        shock_response(system, half_sine(units), [100.0], Newmark(100.0, 1.0, 250))
    light = System(kappa=0.002, mu=1.0, d3=None)
    with pytest.raises(ValueError, match=r"natural frequency 10 of body 1: kappa = 0\.0002 is outside"):
        shock_response(light, half_sine(units), [1.0, 10.0])
