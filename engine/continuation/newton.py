"""Newton's method: one loop over steps, of whatever equations, and what ends it.

Most orbits of a branch are found by its compiled twin for one α₁ (:mod:`..kernels.event_driven.orbit_newton`).
"""

import math
from collections.abc import Callable
from typing import NamedTuple


class Convergence(NamedTuple):
    """When Newton's method ends, by the length of its steps: the largest scaled component."""

    most: int  # steps
    far: float  # a longer step has gone astray
    converged: float  # after a shorter step the next would be rounding
    stalled: float = 0.0  # the same, where rounding prevents any smaller
    following: float = 0.0  # a next step that would be shorter, by the ratio of the last two, is not taken


def converges(step: Callable[[float], float], until: Convergence) -> bool:
    """Whether Newton's method converges. ``step`` takes a step, given the length of the one before; returns its own."""
    before = math.inf
    for _ in range(until.most):
        length = step(before)
        if not length < until.far:
            return False
        following = length * length / before if before < math.inf else math.inf
        stalls = length >= before and before < until.stalled
        if length < until.converged or stalls or following < until.following:
            return True
        before = length
    return before < until.stalled
