"""Newton's method to the orbit at given parameters, a step a call."""

from collections.abc import Callable, Sequence

import numpy as np

from ..kernels.event_driven.orbit_steps import (
    GO_ON,
    LOST,
    NEWTON_STEPS,
    STALLED,
    outcome_of_step,
    scales_of,
    step_at_value,
)
from .orbit import Evaluation


def solve_stepwise(
    equations: Callable[..., Evaluation],
    sequence: tuple[Sequence[int], bool, int],
    unknowns: np.ndarray,
    width: float,
) -> Evaluation | None:
    """The equations at the orbit near a guess; None if Newton's method does not find it.

    Parameters
    ----------
    equations : callable
        Such as :class:`.orbit.OrbitEquations`, whose own :meth:`~.orbit.OrbitEquations.solve` is one call.
    sequence : tuple
        Events, whether the bodies touch at τ = 0, and the periods of the cycle.
    unknowns : (4 + m,) ndarray
        Of a guess; moved to the orbit in place.
    width : float
        The unit of α₁.
    """
    scales, room = scales_of(unknowns, width), Evaluation.without_facts(len(sequence[0]))
    before, said = np.inf, GO_ON
    for _ in range(NEWTON_STEPS):
        found = equations(*sequence, unknowns, room)
        length = step_at_value(found.residual, found.jacobian, scales, unknowns)
        said = outcome_of_step(length, before)
        if said != GO_ON:
            break
        before = length
    if said == LOST or (said == GO_ON and not before < STALLED):
        return None
    return equations(*sequence, unknowns)
