"""Measurements of bodies that nothing drives: compared and fitted from their start."""

from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    ExactPenalty,
    Excitation,
    Measurement,
    Newmark,
    Record,
    Reference,
    System,
    compare_measured,
    fit,
    measured_verdict,
    simulate,
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


@pytest.mark.parametrize("system", [PAIR, WALL])
def test_stiffness_and_damping_of_a_contact_are_fitted(system):
    made = recorded(system, method=ExactPenalty(300, 1.5), noise=0.002)
    found = fit(system, 0.2, made, names=("K", "D"), method=ExactPenalty(60, 0.2), initial=START)
    for name, true in (("K", 300), ("D", 1.5)):
        assert 0 < found.errors[name] < 0.1 * true
        assert abs(found.values[name] - true) < 4 * found.errors[name]
    fitted = found.applied(Newmark(60, 0.2, 20_000, located=True))
    assert (fitted.stiffness, fitted.damping) == (found.values["K"], found.values["D"])
    words = measured_verdict(compare_measured(system, 0.2, made, fitted, initial=START))
    assert "The penalty solution agrees within the noise" in words


def test_a_contact_is_fitted_with_a_penalty_solution_that_has_its_number():
    with pytest.raises(ValueError, match="cannot fit K, which the reference does not have: give a penalty solution"):
        fit(WALL, 0.2, recorded(WALL), names=("K",), initial=START)
    with pytest.raises(ValueError, match="cannot fit D, which follows from the restitution: give D"):
        fit(WALL, 0.2, recorded(WALL), names=("D",), method=ExactPenalty(60, None, law="flores"), initial=START)
