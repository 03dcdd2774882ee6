"""Newton's method to an orbit in one call equals its plain twin, and ∂F/∂α₁ the difference of two evaluations."""

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Reference, System
from vibroscope.engine.continuation.curve import Curve
from vibroscope.engine.continuation.family import Family, ParameterRange
from vibroscope.engine.continuation.seeds import OrbitFinder
from vibroscope.engine.continuation.tolerances import SLOPE_DIFFERENCE
from vibroscope.engine.drivers.orbit import Evaluation
from vibroscope.engine.kernels.event_driven.orbit_steps import (
    GO_ON,
    LOST,
    NEWTON_STEPS,
    STALLED,
    outcome_of_step,
    scales_of,
    step_at_value,
)

EXACT = ExactPenalty(12_000.0, 18.0)
CASES = [(Reference(), 1.08), (Reference(), 2.76), (EXACT, 2.76), (Reference(threshold=0.0), 1.08)]


def orbit_at(method, eta):
    """The equations at η, their curve, and the orbit that a run from rest settles to."""
    family = Family("eta", System(), eta, method)
    curve = Curve(family, ParameterRange.of(family, 0.5, 4.0))
    return curve, OrbitFinder(curve, 1, None, None).settled(eta, None)


def solve_stepwise(equations, sequence, unknowns, width):
    """The equations at the orbit near a guess, which is moved there, a step a call; None if none is found."""
    scales, room = scales_of(unknowns, width), Evaluation.zeros(len(sequence[0]))
    before, said = np.inf, GO_ON
    for _ in range(NEWTON_STEPS):
        found = equations(sequence, unknowns, room)
        length = step_at_value(found.residual, found.jacobian, scales, unknowns)
        said = outcome_of_step(length, before)
        if said != GO_ON:
            break
        before = length
    if said == LOST or (said == GO_ON and not before < STALLED):
        return None
    return equations(sequence, unknowns)


@pytest.mark.parametrize(("method", "eta"), CASES)
@pytest.mark.parametrize("off", [1e-9, 1e-4, 0.3])  # within rounding of the orbit, near it, and where none is found
def test_an_orbit_is_found_in_one_call_as_step_by_step(method, eta, off):
    curve, orbit = orbit_at(method, eta)
    scales = curve.scales(orbit)
    guess = orbit.unknowns + off * scales[:-1] * np.random.default_rng(3).uniform(-1, 1, len(orbit.unknowns))
    sequence, ends = (orbit.kinds, orbit.first, orbit.period), (guess.copy(), guess.copy())
    found = curve.equations(eta).solve(sequence, ends[0], curve.width)
    plain = solve_stepwise(curve.equations(eta), sequence, ends[1], curve.width)
    assert (found is None) == (plain is None)
    assert found is not None or off == 0.3
    if found is not None:
        np.testing.assert_array_equal(*ends)
        for one, other in zip(found, plain, strict=True):
            np.testing.assert_array_equal(one, other)
        assert np.abs(found.residual).max() < 1e-9 * scales[0]


@pytest.mark.parametrize(("method", "eta"), CASES)
def test_the_slope_is_the_difference_of_two_evaluations(method, eta):
    curve, orbit = orbit_at(method, eta)
    h, here = SLOPE_DIFFERENCE * curve.width, curve.evaluate(orbit, eta).residual
    expected = (curve.evaluate(orbit, eta + h).residual - here) / h
    np.testing.assert_allclose(curve.slope(orbit, eta, here), expected, rtol=0, atol=1e-6 * np.abs(expected).max())
