"""Newton's method to the orbit at given parameters, in one call: most orbits of a branch are found so."""

import numpy as np
from vibroscope.engine.kernels.compile.options import jit
from vibroscope.engine.kernels.event_driven.orbit import evaluate_orbit
from vibroscope.engine.kernels.event_driven.orbit_steps import (
    GO_ON,
    LOST,
    NEWTON_STEPS,
    STALLED,
    outcome_of_step,
    scales_of,
    step_at_value,
)


@jit
def solve_orbit(tables, problem, sequence, unknowns, width, out):
    """Move the unknowns by Newton's method, in place, to the orbit near them; False if there is none.

    ``width``: the unit of α₁; the other arguments are those of :func:`evaluate_orbit`, filled at the orbit.

    Plain twin: a step a call (tests/engine/kernels/test_orbit_newton.py).
    """
    residual, jacobian, facts, after, section = out
    scales = scales_of(unknowns, width)
    bare, before, found = (residual, jacobian, facts[:0], after, section[:0]), np.inf, GO_ON
    for _ in range(NEWTON_STEPS):
        evaluate_orbit(tables, problem, sequence, unknowns, bare)
        length = step_at_value(residual, jacobian, scales, unknowns)
        found = outcome_of_step(length, before)
        if found != GO_ON:
            break
        before = length
    if found == LOST or (found == GO_ON and not before < STALLED):
        return False
    evaluate_orbit(tables, problem, sequence, unknowns, out)
    return True
