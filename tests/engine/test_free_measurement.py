"""Measurements of bodies that nothing drives, or a pulse: compared and fitted from their start."""

from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    ExactPenalty,
    Excitation,
    Load,
    Measurement,
    Newmark,
    Record,
    Reference,
    System,
    compare_measured,
    fit,
    measured_verdict,
    simulate,
    transient,
)

FREE = Excitation(base=0.0)
PAIR = System(excitation=FREE, clearance=0.5, d1=0.02, d2=0.03, restitution=0.6)
WALL = System(excitation=FREE, wall=True, clearance=0.5, d1=0.02, restitution=0.6)
START = (-3.0, 0.0, 0.0, 0.0)


def recorded(system, *, late=None, held=0.0, noise=0.01, seed=0, method=None):
    """The displacements since ``late`` after the start, or since ``held`` before it, of two periods of eta = 0.2."""
    run = simulate(
        system, 0.2, method or Reference(), periods=2, keep=2, initial=START, record=Record(2, 1500)
    ).trajectory
    time = np.arange(-held, run.time[-1] - 10.0, 0.05)
    time = time if late is None else time[time >= late]
    exact = np.stack([np.interp(time, run.time, row) for row in run.displacement])
    exact[:, time < 0] = np.array(START)[[0, 2]][:, None]
    exact += noise * np.random.default_rng(seed).standard_normal(exact.shape)
    return Measurement(time - time[0], exact, None, "relative").of(system)


@pytest.mark.parametrize("system", [PAIR, WALL])
@pytest.mark.parametrize("how", [{}, {"late": 2.0}, {"held": 3.0}])
def test_a_measurement_is_compared_from_its_start(system, how):
    made = recorded(system, **how)
    found = compare_measured(system, 0.2, made, Newmark(200, 5, 20_000), initial=START)
    assert found.is_free
    assert found.recurrence.noise == pytest.approx(0.01, rel=0.1)
    assert found.reference.alignment.phase == pytest.approx(how.get("late", 0.0) - how.get("held", 0.0), abs=0.02)
    assert measured_verdict(found).startswith("The reference agrees within the noise of the measurement")
    assert "The reference is nearer" in measured_verdict(found)


def test_a_penalty_solution_that_was_measured_is_nearer():
    soft = ExactPenalty(30, 0.5)
    found = compare_measured(WALL, 0.2, recorded(WALL, method=soft), Newmark(30, 0.5, 20_000), initial=START)
    assert "The penalty solution agrees within the noise" in measured_verdict(found)
    assert "The penalty solution is nearer" in measured_verdict(found)


def test_accelerations_of_a_decay_are_refused():
    made = replace(recorded(WALL), mean_known=False)
    with pytest.raises(ValueError, match=r"accelerations do not show where .* starts: give displacements"):
        compare_measured(WALL, 0.2, made, Newmark(200, 5, 20_000), initial=START)


def test_the_constants_of_a_decay_are_fitted_with_errors_that_hold():
    pulls = []
    for seed in range(6):
        guess = System(excitation=FREE, wall=True, clearance=0.5, d1=0.03, restitution=0.4)
        found = fit(guess, 0.2, recorded(WALL, noise=0.02, seed=seed), names=("restitution", "d1"), initial=START)
        pulls.append(
            [(found.values[name] - getattr(WALL, name)) / found.errors[name] for name in ("restitution", "d1")]
        )
    # the sum of the squares of 6 normal numbers lies in this range in 99.8 % of all cases
    squares = np.sum(np.square(pulls), axis=0)
    assert ((squares > 0.38) & (squares < 22.5)).all()


def test_stiffness_and_damping_of_a_contact_are_fitted():
    """At a wall: to a response to a pulse, below."""
    made = recorded(PAIR, method=ExactPenalty(300, 1.5), noise=0.002)
    found = fit(PAIR, 0.2, made, names=("K", "D"), method=ExactPenalty(60, 0.2), initial=START)
    for name, true in (("K", 300), ("D", 1.5)):
        assert 0 < found.errors[name] < 0.1 * true
        assert abs(found.values[name] - true) < 4 * found.errors[name]
    fitted = found.applied(Newmark(60, 0.2, 20_000, located=True))
    assert (fitted.stiffness, fitted.damping) == (found.values["K"], found.values["D"])
    words = measured_verdict(compare_measured(PAIR, 0.2, made, fitted, initial=START))
    assert "The penalty solution agrees within the noise" in words


def test_a_contact_is_fitted_with_a_penalty_solution_that_has_its_number():
    with pytest.raises(ValueError, match="cannot fit K, which the reference does not have: give a penalty solution"):
        fit(WALL, 0.2, recorded(WALL), names=("K",), initial=START)
    with pytest.raises(ValueError, match="cannot fit D, which follows from the restitution: give D"):
        fit(WALL, 0.2, recorded(WALL), names=("D",), method=ExactPenalty(60, None, law="flores"), initial=START)
    with pytest.raises(ValueError, match=r"cannot fit restitution beside K: .* has no restitution; fit D in place of"):
        fit(WALL, 0.2, recorded(WALL), names=("restitution", "K"), method=ExactPenalty(60, 0.2), initial=START)


PULSE = Load.half_sine(peak=-2.0, duration=1.5)


def shaken(system, load=PULSE, method=None, *, noise=0.002, late=0.0):
    """The displacements under a load, since ``late`` after its beginning."""
    run = transient(system, load, method or Reference()).response.trajectory
    time = np.arange(late, run.time[-1], 0.05)
    exact = np.stack([np.interp(time, run.time, row) for row in run.displacement])
    exact += noise * np.random.default_rng(2).standard_normal(exact.shape)
    return Measurement(time - time[0], exact, None, "relative").of(system)


@pytest.mark.parametrize("system", [PAIR, WALL])
def test_a_measured_response_to_a_pulse_is_compared_and_fitted_from_its_start(system):
    made = shaken(system, late=0.5)
    loaded = replace(system, excitation=replace(FREE, load=PULSE))
    found = compare_measured(loaded, 1.0, made, Newmark(200, 5, 20_000))
    assert len(found.reference.response.impacts) > 0
    assert found.reference.alignment.phase == pytest.approx(0.5, abs=0.01)
    assert measured_verdict(found).startswith("The reference agrees within the noise of the measurement")
    fitted = fit(replace(loaded, restitution=0.4, d1=0.03), 1.0, made, names=("restitution", "d1"))
    assert fitted.values["restitution"] == pytest.approx(0.6, abs=1e-3)
    assert fitted.values["d1"] == pytest.approx(0.02, abs=5e-4)  # from another one, other impacts fit nearly as well
    assert fitted.deviation < 1.1 * fitted.noise
    assert fitted.system.excitation.load is PULSE


def test_a_contact_is_fitted_to_a_measured_response_to_a_pulse():
    made = shaken(WALL, method=ExactPenalty(300, 1.5))
    loaded = replace(WALL, excitation=replace(FREE, load=PULSE))
    fitted = fit(loaded, 1.0, made, names=("K", "D"), method=ExactPenalty(100, 0.5))
    for name, true in (("K", 300), ("D", 1.5)):
        assert fitted.errors[name] < 0.2 * true
        assert abs(fitted.values[name] - true) < 4 * fitted.errors[name]
    words = measured_verdict(compare_measured(loaded, 1.0, made, fitted.applied(Newmark(100, 0.5, 20_000))))
    assert "The penalty solution agrees within the noise" in words


def test_a_fixed_sensor_does_not_see_the_base_under_an_acceleration_of_it():
    made = replace(shaken(WALL), frame="absolute")
    with pytest.raises(ValueError, match="does not show where the base is: give displacements relative to it"):
        compare_measured(replace(WALL, excitation=replace(FREE, load=PULSE)), 1.0, made, Newmark(200, 5, 2000))
    push = replace(PULSE, on="force1")
    loaded = replace(WALL, excitation=replace(FREE, load=push))
    found = compare_measured(loaded, 1.0, replace(shaken(WALL, push), frame="absolute"), Newmark(200, 5, 2000))
    assert "The reference agrees within the noise" in measured_verdict(found)
