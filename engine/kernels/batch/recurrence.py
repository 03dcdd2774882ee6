"""Whether a cell's motion has come back to where it was, so that its cycle stands for all that would follow.

The solvers are deterministic: a state that comes back after CYCLE periods, the phase of the excitation being the same,
repeats what lay between for ever. So a cell is followed in pieces of CYCLE periods, and once its state at the end of a
piece is that of the two ends before, to ALIKE of its size, the next piece is taken down and stands for all that would
follow. The state is that of the last event, so the events must agree as well. CYCLE is divisible by the periods that
matter; any other motion is simply run to its end.

What a difference of ALIKE can do: a periodic motion that is reached is stable, and the difference only shrinks. On an
unstable one, or in chaos, it would have to be smaller than ALIKE at three ends, which a motion that is not *on* the
cycle to rounding does not do.
"""

from ..compile.options import bare
from ..event_driven.state import anchor_of
from ..time_stepping.newmark import CONTACT, P1, P2, Q1, Q2, STEP

CYCLE = 12
ALIKE = 1e-13


@bare
def close(value, other, allowed):
    """Whether two numbers differ by no more than allowed."""
    return abs(value - other) <= allowed


@bare
def event_recurs(now, before, period):
    """Whether the anchor of a march is, to ALIKE, that of CYCLE periods before."""
    a, b = anchor_of(now), anchor_of(before)
    if a.period != b.period + CYCLE or a.mode != b.mode or a.order != b.order:
        return False
    allowed = ALIKE * (abs(a.x1) + abs(a.v1) + abs(a.gap) + abs(a.rate))
    same = close(a.tau, b.tau, ALIKE * period) and close(a.x1, b.x1, allowed) and close(a.v1, b.v1, allowed)
    return same and close(a.gap, b.gap, allowed) and close(a.rate, b.rate, allowed)


@bare
def steps_recur(now, before, n):
    """Whether the state of Newmark's method is, to ALIKE, that of CYCLE periods before."""
    if now[STEP] != before[STEP] + CYCLE * n or now[CONTACT] != before[CONTACT]:
        return False
    far = ALIKE * (abs(now[P1]) + abs(now[P2]))
    fast = ALIKE * (abs(now[Q1]) + abs(now[Q2])) + far / n  # Q = Δτ ξ′: a displacement over a step
    near = close(now[P1], before[P1], far) and close(now[P2], before[P2], far)
    return near and close(now[Q1], before[Q1], fast) and close(now[Q2], before[Q2], fast)
