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


def recorded(system, *, late=None, held=0.0, interval=0.05, noise=0.01, seed=0, method=None):
    """The displacements since ``late`` after the start, or since ``held`` before it, of two periods of eta = 0.2."""
    run = simulate(
        system, 0.2, method or Reference(), periods=2, keep=2, initial=START, record=Record(2, 1500)
    ).trajectory
    time = np.arange(-held, run.time[-1] - 10.0, interval)
    time = time if late is None else time[time >= late]
    exact = np.stack([np.interp(time, run.time, row) for row in run.displacement])
    exact[:, time < 0] = np.array(START)[[0, 2]][:, None]
    exact += noise * np.random.default_rng(seed).standard_normal(exact.shape)
    return Measurement(time - time[0], exact, None, "relative").of(system)


@pytest.mark.parametrize("system", [PAIR, WALL])
@pytest.mark.parametrize("how", [{}, {"late": 0.1}, {"held": 3.0}])
def test_a_measurement_is_compared_from_its_start(system, how):
    made = recorded(system, **how)
    found = compare_measured(system, 0.2, made, Newmark(200, 5, 20_000), initial=START)
    assert found.is_free
    assert found.recurrence.noise == pytest.approx(0.01, rel=0.1)
    assert found.reference.alignment.phase == pytest.approx(how.get("late", 0.0) - how.get("held", 0.0), abs=0.02)
    assert measured_verdict(found).startswith("The reference agrees within the noise of the measurement")
    assert found.penalty.alignment.phase == found.reference.alignment.phase  # a sensor has one trigger
    words = measured_verdict(found)
    assert "The reference is nearer" in words
    assert "the most that is allowed" not in words


def decay(*, restitution=0.45, damping=0.025, natural=0.1987, noise=0.005, samples=1200, interval=1e-3):
    """A body let go at −10 in front of a stop at 1, by steps of the trapezoidal rule, on an instrument's time."""
    omega, parts = 2 * np.pi / natural, 200
    h = interval / parts
    left = np.array([[1.0, -h / 2], [h / 2 * omega**2, 1.0 + h * damping * omega]])
    step = np.linalg.solve(left, np.array([[1.0, h / 2], [-h / 2 * omega**2, 1.0 - h * damping * omega]]))
    (a, b), (c, d) = step.tolist()
    x, v, seen = -10.0, 0.0, []
    for _ in range(samples):
        seen.append(x)
        for _ in range(parts):
            x, v = a * x + b * v, c * x + d * v
            if x > 1.0 and v > 0.0:
                x, v = 1.0, -restitution * v
    return omega * interval * np.arange(samples), np.array(seen) + noise * np.random.default_rng(3).normal(size=samples)


def test_a_solution_is_not_slid_over_another_oscillation_of_a_decay():
    """With the wrong restitution the best shift of all is half a natural period, which would hide the difference."""
    time, seen = decay()
    made = Measurement(time, seen[None], None, "relative")
    thrown = System(excitation=FREE, wall=True, clearance=1.0, d1=0.01, restitution=0.6)
    start = (-10.0, 0.0, 0.0, 0.0)
    found = compare_measured(thrown, 1.0, made, Newmark(1000, 5, 2000), initial=start)
    exact = simulate(thrown, 1.0, Reference(), periods=7, keep=7, initial=start, record=Record(7, 4000)).trajectory
    off = np.interp(time, exact.time, exact.displacement[0]) - seen
    from_the_start = np.sqrt(np.mean(off**2) / np.mean(seen**2))
    solved = found.reference.alignment
    assert abs(solved.phase) <= 12 * time[1]
    assert solved.rms == pytest.approx(from_the_start, rel=0.1)
    assert solved.rms > 0.5
    assert found.penalty.alignment.phase == solved.phase


def test_a_record_that_begins_too_late_is_said_to():
    made, words = recorded(WALL, late=0.5), "after the start, the most that is allowed (3 samples): check the start"
    assert words in measured_verdict(compare_measured(WALL, 0.2, made, Newmark(200, 5, 20_000), initial=START))
    found = fit(WALL, 0.2, made, names=("d1",), initial=START)
    assert found.phase == pytest.approx(3 * 0.05, rel=1e-3)
    assert any(words in str(each) for each in found.remarks)


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
        made = recorded(WALL, interval=0.1, noise=0.02, seed=seed)
        found = fit(guess, 0.2, made, names=("restitution", "d1"), initial=START)
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
def test_a_measured_response_to_a_pulse_is_compared_from_its_start(system):
    made = shaken(system, late=0.1)
    loaded = replace(system, excitation=replace(FREE, load=PULSE))
    found = compare_measured(loaded, 1.0, made, Newmark(200, 5, 20_000))
    assert len(found.reference.response.impacts) > 0
    assert found.reference.alignment.phase == pytest.approx(0.1, abs=0.01)
    assert measured_verdict(found).startswith("The reference agrees within the noise of the measurement")


def test_constants_are_fitted_to_a_measured_response_to_a_pulse_from_its_start():
    loaded = replace(WALL, excitation=replace(FREE, load=PULSE))
    made = shaken(WALL, late=0.1)
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
