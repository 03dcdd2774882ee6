"""Physical units, checked by a simulation in SI units that does not use the model's."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from vibroscope.engine import (
    QUANTITIES,
    UNIT_SYSTEMS,
    ExactPenalty,
    Newmark,
    Record,
    Reference,
    System,
    Units,
    simulate,
    written,
)

UNITS = Units(omega1=37.0, m1=2.6, base_amplitude=0.43)
MILLIMETRES = replace(UNITS, system="mm-t-s")
ETA, METHOD = 2.76, ExactPenalty(300.0, 6.0)


@pytest.fixture(scope="module")
def dimensional():
    """The pendulums in kg, m, s and N, by SciPy alone: t, (x1, v1, x2, v2, impulse), contact force."""
    system = System()
    p = UNITS.pendulums(system)
    contact = UNITS.settings(ETA, METHOD)
    frequency, amplitude = 2 * math.pi * contact["excitation"], 0.43e-3

    def force(y):
        closed = y[2] <= y[0]
        return contact["stiffness"] * (y[0] - y[2]) + contact["damping"] * (y[1] - y[3]) if closed else 0.0

    def slope(t, y):
        x1, v1, x2, v2 = y[:4]
        base, f = amplitude * frequency**2 * math.cos(frequency * t), force(y)
        return [
            v1,
            base - (p["c1"] * v1 + p["k1"] * x1 + f) / p["m1"],
            v2,
            base - (p["c2"] * v2 + p["k2"] * x2 - f) / p["m2"],
            f,
        ]

    times = np.linspace(0, 3 * contact["period"], 301)
    found = solve_ivp(
        slope, (0, times[-1]), np.zeros(5), t_eval=times, rtol=1e-9, atol=1e-14, max_step=contact["period"] / 500
    )
    return found.t, found.y, np.array([force(y) for y in found.y.T])


def test_a_converted_trajectory_is_that_of_the_physical_simulation(dimensional):
    time, y, force = dimensional
    run = simulate(System(), ETA, METHOD, periods=3, keep=3, record=Record(3, 100))
    found = UNITS.trajectory(run.trajectory)
    assert found.time == pytest.approx(time, rel=1e-12)
    for row, (x, v) in enumerate(((y[0], y[1]), (y[2], y[3]))):
        assert found.displacement[row] == pytest.approx(x, abs=1e-5 * np.abs(x).max())
        assert found.velocity[row] == pytest.approx(v, abs=1e-5 * np.abs(v).max())
    far = np.abs(y[2] - y[0]) > 1e-6  # the force jumps where contact changes
    assert found.force[far] == pytest.approx(force[far], abs=1e-4 * force.max())
    assert force.max() > 1e-3


def test_converted_impulses_are_those_of_the_physical_simulation(dimensional):
    time, y, _ = dimensional
    run = simulate(System(), ETA, METHOD, periods=3, keep=3)
    found = UNITS.impacts(run.impacts)
    spans = UNITS.physical("time", run.contacts)
    compared = 0
    for start, impulse in zip(found.time, found.impulse, strict=True):
        k = int(np.argmin(np.abs(spans[:, 0] - start)))
        before, after = np.searchsorted(time, spans[k, 0]) - 1, np.searchsorted(time, spans[k, 1])
        alone = not any(time[before] < s < time[after] for s in np.delete(spans, k, 0).ravel())
        if alone and before > 0 and after < len(time):  # no other contact contributes to SciPy's integral
            assert impulse == pytest.approx(y[4, after] - y[4, before], rel=1e-4)
            compared += 1
    assert compared >= 2


@pytest.mark.parametrize("units", [UNITS, MILLIMETRES], ids=UNIT_SYSTEMS)
def test_the_units_of_a_system_are_consistent(units):
    factor = units.factor
    assert factor("force") == pytest.approx(factor("mass") * factor("acceleration"))
    assert factor("stiffness") == pytest.approx(factor("force") / factor("displacement"))
    assert factor("damping") == pytest.approx(2 * factor("force") / factor("velocity"))  # the force is 2Dξ′
    assert factor("impulse") == pytest.approx(factor("force") * factor("time"))
    assert factor("energy") == pytest.approx(factor("force") * factor("displacement"))
    assert factor("frequency") * 2 * math.pi == pytest.approx(factor("angular_frequency"))


def test_both_systems_mean_the_same():
    sizes = {"m": "mm", "m/s": "mm/s", "m/s²": "mm/s²", "J": "mJ", "W": "mW"}  # a thousand of the second
    thousandths = {"kg": "t", "N/m": "N/mm", "N·s/m": "N·s/mm"}  # a thousandth
    for quantity in QUANTITIES:
        si, other = UNITS.unit(quantity), MILLIMETRES.unit(quantity)
        expected = 1e3 if sizes.get(si) == other else 1e-3 if thousandths.get(si) == other else 1.0
        expected = 1e6 if (si, other) == ("m²", "mm²") else expected
        assert (expected == 1.0) == (si == other)
        assert MILLIMETRES.factor(quantity) == pytest.approx(expected * UNITS.factor(quantity))
    assert UNITS.text("stiffness", 300.0, 3) == "1070000 N/m"
    assert MILLIMETRES.text("stiffness", 300.0, 3) == "1070 N/mm"
    with pytest.raises(ValueError, match="system = 'imperial' is not one of si, mm-t-s"):
        Units(system="imperial")


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_conversion_to_physical_units_and_back_is_exact(quantity):
    values = np.array([-3.0, 0.0, 2.76])
    assert UNITS.model(quantity, UNITS.physical(quantity, values)) == pytest.approx(values, rel=1e-14)


def test_the_papers_settings_in_physical_units():
    settings = Units().settings(2.76, Newmark(12000, 18, 8000))
    assert settings["stiffness"] == 12000  # N/m, since m₁ = 1 kg and ω₁ = 1/s
    assert settings["damping"] == 36  # N·s/m
    assert settings["time_step"] == pytest.approx(2 * math.pi / 2.76 / 8000)
    assert Units().physical("displacement", 1.0) == 0.00107
    assert Units(system="mm-t-s").physical("displacement", 1.0) == 1.07
    assert set(Units().settings(2.76, Reference())) == {"excitation", "period"}


@pytest.mark.parametrize(
    ("change", "words"),
    [({"omega1": 0}, "omega1 = 0"), ({"m1": math.nan}, "m1 = nan"), ({"base_amplitude": -1}, "base_amplitude = -1")],
)
def test_units_out_of_range_are_refused(change, words):
    with pytest.raises(ValueError, match=words):
        Units(**change)


def test_an_unknown_quantity_is_refused():
    with pytest.raises(ValueError, match="quantity = 'jerk' is not one of time"):
        Units().factor("jerk")


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (2400.4, 4, "2400"),
        (2355, 3, "2360"),
        (999999, 4, "1000000"),
        (1.23456e9, 4, "1.235e9"),
        (0.0001, 4, "0.0001"),
        (1.2e-5, 4, "1.2e-5"),
        (-0.30000001, 4, "-0.3"),
        (0, 4, "0"),
    ],
)
def test_numbers_are_written_with_few_digits_and_seldom_with_a_power(value, digits, text):
    assert written(value, digits) == text
