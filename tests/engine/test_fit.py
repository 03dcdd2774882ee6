"""Fit of restitution and damping: it recovers the true values, and its standard errors are right."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Measurement, Reference, System, fit, fitted_names, synthetic_measurement
from vibroscope.engine.measurement.cycle import reference_cycle
from vibroscope.engine.measurement.fit import FitProblem

TRUE = System(restitution=0.43, d1=0.006, d2=0.018, d3=0.045)


def test_all_constants_are_recovered_within_their_errors():
    made = synthetic_measurement(TRUE, 1.08, noise=0.02, phase=2.3, seed=7)
    found = fit(System(), 1.08, made)
    zeros = {"zero1": 0.0, "zero2": 0.0}
    for name, value in found.values.items():
        assert 0 < found.errors[name] < 0.02
        assert abs(value - (TRUE.as_dict() | zeros)[name]) < 3 * found.errors[name]
    constants = {name: value for name, value in found.values.items() if name not in zeros}
    assert found.system.as_dict() == System().as_dict() | constants
    assert found.phase == pytest.approx(2.3, abs=0.01)
    assert found.deviation == pytest.approx(0.02, rel=0.05)
    assert found.remarks == ()
    assert found.agreeing >= 3


@pytest.fixture
def one_guess(monkeypatch):
    """The search starts from the given system alone: what follows from the minimum is tried, not how it is found."""
    monkeypatch.setattr("vibroscope.engine.measurement.fit.GUESSES", ({},))


@pytest.mark.usefixtures("one_guess")
def test_the_standard_errors_are_those_of_repeated_measurements():
    pulls = []
    for seed in range(8):
        made = synthetic_measurement(TRUE, 2.76, periods=4, per_period=100, noise=0.05, seed=seed)
        found = fit(TRUE, 2.76, made, names=("restitution", "d2"))
        pulls.append(
            [(found.values[name] - getattr(TRUE, name)) / found.errors[name] for name in ("restitution", "d2")]
        )
    pulls = np.array(pulls)
    # the sum of the squares of 8 normal numbers lies in this range in 99.8 % of all cases
    assert ((np.sum(pulls**2, axis=0) > 0.85) & (np.sum(pulls**2, axis=0) < 26.2)).all()
    assert np.abs(pulls.mean(axis=0)).max() < 3 / np.sqrt(8)


@pytest.mark.usefixtures("one_guess")
def test_the_standard_errors_of_one_sensor_with_another_zero_are_those_of_repeated_measurements():
    true = System(wall=True, d1=0.05, clearance=0.5, restitution=0.6)
    pulls = []
    for seed in range(8):
        made = synthetic_measurement(true, 0.8, periods=4, per_period=100, noise=0.05, seed=seed)
        off = replace(made, displacement=made.displacement + 3.0)
        found = fit(true, 0.8, off)
        truth = {"restitution": 0.6, "d1": 0.05, "zero1": 3.0}
        assert list(found.values) == list(truth)
        pulls.append([(found.values[name] - value) / found.errors[name] for name, value in truth.items()])
        assert found.corrected(off).displacement == pytest.approx(off.displacement - found.values["zero1"])
    # the sum of the squares of 8 normal numbers lies in this range in 99.8 % of all cases
    assert ((np.sum(np.square(pulls), axis=0) > 0.85) & (np.sum(np.square(pulls), axis=0) < 26.2)).all()


@pytest.mark.usefixtures("one_guess")
def test_a_sensor_with_another_zero_is_named_and_its_zero_fitted():
    made = synthetic_measurement(TRUE, 2.76, noise=0.02, seed=1)
    off = replace(made, displacement=made.displacement - [[0.5], [0.0]])
    guess = replace(TRUE, restitution=0.5, d2=0.012)
    without = fit(guess, 2.76, off, names=("restitution", "d2"))
    assert abs(without.values["restitution"] - TRUE.restitution) > 5 * without.errors["restitution"]
    assert "fitted with the zeros of the sensors, too, the residual is 0.0199" in without.remarks[-1]
    assert without.remarks[-1].endswith("fit zero1, zero2 as well")
    found = fit(guess, 2.76, off, names=("restitution", "d2", "zero1"))
    assert found.values["zero1"] == pytest.approx(-0.5, abs=3 * found.errors["zero1"])
    assert abs(found.values["restitution"] - TRUE.restitution) < 3 * found.errors["restitution"]


@pytest.mark.parametrize(("bodies", "known", "names"), [(1, True, "zero2"), (2, False, "zero1, zero2")])
def test_a_zero_that_no_sensor_shows_is_refused(bodies, known, names):
    made = synthetic_measurement(System(), 2.76)
    made = replace(made, displacement=made.displacement[:bodies], mean_known=known)
    with pytest.raises(ValueError, match=f"cannot fit {names}: no sensor shows the mean of this displacement"):
        fit(System(), 2.76, made, names=("d1", *names.split(", ")))
    assert not set(names.split(", ")) & set(fitted_names(System(), made))


@pytest.mark.usefixtures("one_guess")
def test_standard_errors_shrink_with_the_root_of_the_number_of_samples():
    errors = []
    for periods in (4, 16, 64):
        made = synthetic_measurement(TRUE, 2.76, periods=periods, per_period=25, noise=0.02, seed=1)
        errors.append(fit(TRUE, 2.76, made, names=("restitution",)).errors["restitution"])
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(2, rel=0.15)


@pytest.mark.usefixtures("one_guess")
def test_the_fit_is_a_minimum_with_the_right_jacobian():
    made = synthetic_measurement(TRUE, 2.76, noise=0.02, phase=0.3, seed=2)
    names = ("restitution", "d2")
    found = fit(System(), 2.76, made, names=names)
    problem = FitProblem(System(), 2.76, made, names, Reference(threshold=0.0), None)
    best = np.array([*found.values.values(), found.phase])
    least = np.sum(problem.residuals(best) ** 2)
    for i, step in enumerate((1e-3, 1e-4, 1e-3)):
        for sign in (-1, 1):
            beside = best.copy()
            beside[i] += sign * step
            assert np.sum(problem.residuals(beside) ** 2) > least
    jacobian = problem.jacobian(best)
    wide = np.stack(
        [(problem.residuals(best + h) - problem.residuals(best - h)) / 2e-4 for h in 1e-4 * np.eye(3)], axis=1
    )
    assert (np.linalg.norm(jacobian - wide, axis=0) < 0.01 * np.linalg.norm(wide, axis=0)).all()
    expected = 0.02 * np.sqrt(np.diag(np.linalg.inv(wide.T @ wide)))[:2]  # the noise of the measurement
    assert list(found.errors.values()) == pytest.approx(expected, rel=0.05)


@pytest.mark.usefixtures("one_guess")
def test_a_constant_that_does_not_change_the_motion_keeps_its_value():
    made = synthetic_measurement(TRUE, 2.76, noise=0.02)  # one impact in a period, no permanent contact
    found = fit(System(), 2.76, made, names=("restitution", "d3"))
    assert found.values["d3"] == System().d3
    assert found.errors["d3"] == np.inf
    assert found.correlation.shape == (1, 1)
    assert "d3 does not change this motion and was left as it is" in found.remarks


@pytest.mark.usefixtures("one_guess")
def test_residuals_above_the_noise_are_remarked_on():
    made = synthetic_measurement(TRUE, 2.76, noise=0.02)
    bent = Measurement(made.time, made.displacement + 0.3 * np.sin(2 * 2.76 * made.time), None, made.frame)
    found, plain = (fit(System(), 2.76, each, names=("restitution", "d2")) for each in (bent, made))
    assert found.deviation > 5 * found.noise
    for name, error in plain.errors.items():  # a deviation of any kind makes them larger
        assert found.errors[name] / error == pytest.approx(found.deviation / plain.deviation, rel=0.3)
    assert any("larger than the measurement's own noise" in remark for remark in found.remarks)


@pytest.mark.usefixtures("one_guess")
def test_scale_zero_and_contact_are_fitted_to_a_driven_motion_at_once():
    """Only the restitution, and so D/√K, is seen well: D alone, with another K, is as much larger."""
    system, true = System(wall=True, d1=0.05, clearance=0.5), ExactPenalty(1200, 8)
    time = np.linspace(0.0, 8 * np.pi / 0.8, 401)
    moved = reference_cycle(system, 0.8, true).cycle.displacement(time + 1.0)[:1]
    shown = 1.1 * moved + 0.3 + np.random.default_rng(1).normal(0.0, 0.01, moved.shape)
    made, guess = Measurement(time, shown, None, "relative"), ExactPenalty(1680, 6.4)
    found = fit(system, 0.8, made, names=("K", "D", "scale", "zero1"), method=guess)
    for name, value in {"K": 1200, "D": 8, "scale": 1.1, "zero1": 0.3}.items():
        assert 0 < found.errors[name] < 0.03 * value
        assert abs(found.values[name] - value) < 3 * found.errors[name]
    assert any("K and D can hardly be distinguished" in remark for remark in found.remarks)
    assert np.abs(found.corrected(made).displacement - moved).max() < 0.05
    alone = fit(system, 0.8, found.corrected(made), names=("D",), method=guess)
    assert alone.values["D"] == pytest.approx(8 * np.sqrt(1.4), rel=0.01)


@pytest.mark.usefixtures("one_guess")
def test_dependent_residuals_are_remarked_on():
    made = synthetic_measurement(TRUE, 2.76, noise=0.0)
    random = np.random.default_rng(3).standard_normal((2, len(made) + 19))
    slow = np.stack([np.convolve(row, np.ones(20), "valid") for row in random])
    drifting = Measurement(made.time, made.displacement + 0.01 * slow, None, made.frame)
    found = fit(TRUE, 2.76, drifting, names=("d2",))
    assert any("depend on each other" in remark for remark in found.remarks)


@pytest.mark.parametrize("names", [(), ("kappa",), ("d1", "d1")])
def test_unknown_repeated_or_missing_names_are_refused(names):
    with pytest.raises(ValueError, match="give some of restitution, d1, d2, d3, K, D, zero1, zero2, scale, each once"):
        fit(System(), 2.76, synthetic_measurement(System(), 2.76), names=names)


def test_a_chaotic_motion_is_refused():
    made = synthetic_measurement(System(), 2.76)
    chaotic = Measurement(made.time * 2.76 / 1.7, made.displacement, None, made.frame)
    with pytest.raises(ValueError, match=r"not periodic at eta = 1\.7"):
        fit(System(), 1.7, chaotic, names=("d3",))


def test_without_scipy_the_fit_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)
    with pytest.raises(ValueError, match=r"needs SciPy: install .* vibroscope\[fit\]"):
        fit(System(), 2.76, synthetic_measurement(System(), 2.76))
