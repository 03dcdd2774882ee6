"""The load of a run: cos ητ for ever, or segments that follow one another.

In z = (…, C, S) the load is C. Of a harmonic C = cos ητ and S = sin ητ. Any other load is a sequence of segments with
one generator, so that one table of each phase serves them all; only C and S begin anew with each segment:

    linear in time      C′ = S,  S′ = 0         between two samples of a record, on a ramp
    pulse               C′ = −ωS, S′ = ωC       half a sine with ω = π/duration; C = S = 0 before and after it

The segments are rows (τ at the beginning, C, S), one after the other in one array; a jump of the load is a new segment.
The last one lasts to the end of the run, which is its only period.

Plain twin: tests/naive_load.py.
"""

import math

from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.linear.cos_sin import cos_sin

# Of the segment that a run stands in: whether there are any, ω, τ at its beginning, C and S there, τ at its end, and
# the number of the next one
GIVEN, FREQUENCY, BEGIN, COSINE, SINE, END, NEXT = range(7)
NUMBERS = NEXT + 1
SEGMENT_NUMBERS = 3


@jit_inlined
def load_at(p, tau, share):
    """C and S at a time τ of the period, ``share`` of it."""
    now = p.load
    if now[GIVEN] == 0.0:
        return cos_sin(share)
    t, c, s = tau - now[BEGIN], now[COSINE], now[SINE]
    if now[FREQUENCY] == 0.0:
        return c + s * t, s
    cosine, sine = math.cos(now[FREQUENCY] * t), math.sin(now[FREQUENCY] * t)
    return c * cosine - s * sine, s * cosine + c * sine


@jit_inlined
def load_integral(p, begin, end, length):
    """What the last two factors of ∫z dτ are multiplied with, of two states in one segment.

    They are the changes of C and S, as for the rest of z, but ∫C and ∫S where the load is linear in time.
    """
    if p.load[GIVEN] > 0.0 and p.load[FREQUENCY] == 0.0:
        return 0.5 * (begin[4] + end[4]) * length, begin[5] * length
    return end[4] - begin[4], end[5] - begin[5]


@jit_inlined
def time_to_load_change(p, tau):
    """Time from τ to the next segment."""
    return p.load[END] - tau if p.load[GIVEN] > 0.0 else math.inf


@jit_no_alloc
def advance_load(p, segments, tau):
    """Go on to the segment of τ; returns whether it is another one."""
    now = p.load
    if now[GIVEN] == 0.0 or tau < now[END]:
        return False
    k, last = int(now[NEXT]), segments.shape[0] // SEGMENT_NUMBERS - 1
    while k < last and segments[SEGMENT_NUMBERS * (k + 1)] <= tau:
        k += 1
    k = min(k, last)
    for i in range(SEGMENT_NUMBERS):
        now[BEGIN + i] = segments[SEGMENT_NUMBERS * k + i]
    now[END] = segments[SEGMENT_NUMBERS * (k + 1)] if k < last else max(p.period, tau * (1.0 + 1e-15))
    now[NEXT] = k + 1.0
    return True
