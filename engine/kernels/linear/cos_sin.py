"""Cosine and sine of the excitation's phase, given as a share of its period."""

import math

import numpy as np
from vibroscope.engine.kernels.compile.options import jit_inlined

_TURNS = 64  # entries of the table
_ANGLE = 2 * math.pi / _TURNS


def _unit_circle(k):
    # from an angle of at most an eighth of a turn, where rounding is smallest
    quarters, rest = divmod(k + _TURNS // 8, _TURNS // 4)
    angle = (rest - _TURNS // 8) * _ANGLE
    c, s = math.cos(angle), math.sin(angle)
    return ((c, s), (-s, c), (-c, -s), (s, -c))[quarters % 4]


# e^{iητ} at _TURNS instants of a period
_COSINES = np.array([_unit_circle(k)[0] for k in range(_TURNS)])
_SINES = np.array([_unit_circle(k)[1] for k in range(_TURNS)])


@jit_inlined
def cos_sin(share):
    """cos 2πs and sin 2πs for a share 0 ≤ s < 1, from a table and a short series, without a library call."""
    scaled = share * _TURNS
    nearest = np.floor(scaled + 0.5)  # stays a float: the way through a whole number and back would take longer
    x = (scaled - nearest) * _ANGLE
    k = int(nearest) & (_TURNS - 1)
    y = x * x
    # x is at most π/64, so the terms left out are below rounding. Products: one division would cost as much as the rest
    sine = x * (1.0 + y * (-1 / 6 + y * (1 / 120 + y * (-1 / 5040 + y * (1 / 362880)))))
    versine = y * (1 / 2 + y * (-1 / 24 + y * (1 / 720 + y * (-1 / 40320))))
    c, s = _COSINES[k], _SINES[k]
    return c - (c * versine + s * sine), s + (c * sine - s * versine)
