"""Equations solved: by Newton's method, or for the zero of a function that has different signs at two ends.

Newton's method is one loop over steps, of whatever equations, and what ends it; most orbits of a branch are found by
its compiled twin for one α₁ (:mod:`..kernels.event_driven.orbit_steps`). Zeros are those on an interval (Chandrupatla
1997) or along a curve.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple, TypeVar

from vibroscope.engine.continuation.tolerances import ROOT_TOLERANCE

P = TypeVar("P")


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


def zero_ahead(
    at: Callable[[float], P | None], length: float, value: Callable[[P], float], tolerance: float = ROOT_TOLERANCE
) -> tuple[float, P] | None:
    """How far ahead along a curve, and at which point, a number is zero; None if that is not found.

    ``at``: the point a distance ahead, None if there is none; up to ``length`` the number changes its sign.
    """

    def function(s: float) -> float:
        point = at(s)
        return math.nan if point is None else value(point)

    s = first_zero(function, 0.0, length, tolerance)
    point = None if s is None else at(s)
    return None if point is None else (s, point)


def changes_ahead(
    at: Callable[[float], P | None],
    length: float,
    ends: tuple[dict, dict],
    test: Callable[[object, P], float],
    confirmed: Callable[[object, P], P | None],
) -> list[tuple[object, P]]:
    """Where numbers change their signs along a curve, in that order: the key of each, and the confirmed point.

    ``ends``: the numbers by their keys, here and ``length`` ahead; ``test``: that of a key at a point.
    """
    found = []
    for key, before in ends[0].items():
        zero = zero_ahead(at, length, partial(test, key)) if before * ends[1][key] < 0 else None
        point = zero and confirmed(key, zero[1])
        if point is not None:
            found.append((zero[0], key, point))
    return [(key, point) for _, key, point in sorted(found, key=lambda each: each[0])]


def first_zero(
    function: Callable[[float], float], low: float, high: float, tolerance: float = ROOT_TOLERANCE
) -> float | None:
    """A zero between two arguments: inverse quadratic interpolation where it is safe, else bisection.

    Returns None if the function has the same sign at both ends, or is not known (nan) on the way. It may be infinite.
    """
    b, a = low, high
    fb, fa = function(b), function(a)
    if math.isnan(fa) or math.isnan(fb) or fa * fb > 0:
        return None
    least = abs(tolerance * (high - low))
    share = 0.5
    for _ in range(200):
        x = a + share * (b - a)
        fx = function(x)
        if math.isnan(fx):
            return None
        if (fx > 0) - (fx < 0) == (fa > 0) - (fa < 0):
            c, fc, a, fa = a, fa, x, fx
        else:
            c, fc, b, fb, a, fa = b, fb, a, fa, x, fx
        best, fbest = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        narrow = least / abs(b - a) if b != a else 1.0
        if narrow > 0.5 or fbest == 0:
            return best
        share = 0.5
        if math.isfinite(fa) and math.isfinite(fb) and math.isfinite(fc) and fc != fb and fc != fa and fb != fa:
            place, height = (a - b) / (c - b), (fa - fb) / (fc - fb)
            if 1 - math.sqrt(1 - place) < height < math.sqrt(place):
                share = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        share = min(max(share, narrow), 1 - narrow)
    return best
