"""The zero of a function on an interval at whose ends it has different signs: Chandrupatla's method (1997)."""

from collections.abc import Callable

import numpy as np

TOLERANCE = 1e-12  # of the interval
MOST_STEPS = 200


def first_zero(function: Callable[[float], float], low: float, high: float) -> float | None:
    """A zero between two arguments: inverse quadratic interpolation where it is safe, else bisection.

    Returns None if the function has the same sign at both ends, or is not known (nan) on the way. It may be infinite.
    """
    b, a = low, high
    fb, fa = function(b), function(a)
    if np.isnan(fa) or np.isnan(fb) or fa * fb > 0:
        return None
    least = TOLERANCE * (high - low)
    share = 0.5
    for _ in range(MOST_STEPS):
        x = a + share * (b - a)
        fx = function(x)
        if np.isnan(fx):
            return None
        if np.sign(fx) == np.sign(fa):
            c, fc, a, fa = a, fa, x, fx
        else:
            c, fc, b, fb, a, fa = b, fb, a, fa, x, fx
        best, fbest = (a, fa) if abs(fa) < abs(fb) else (b, fb)
        narrow = least / abs(b - a) if b != a else 1.0
        if narrow > 0.5 or fbest == 0:
            return best
        share = 0.5
        if np.isfinite([fa, fb, fc]).all() and fc != fb and fc != fa and fb != fa:
            place, height = (a - b) / (c - b), (fa - fb) / (fc - fb)
            if 1 - np.sqrt(1 - place) < height < np.sqrt(place):
                share = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        share = min(max(share, narrow), 1 - narrow)
    return best
