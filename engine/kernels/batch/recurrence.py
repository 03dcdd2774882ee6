"""Whether a motion has returned to where it was, so that its cycle stands for all that would follow.

The solvers are deterministic: a state that recurs after CYCLE periods, with the excitation in the same phase, repeats
what lay between for ever. So a cell is integrated in pieces of CYCLE periods. Once its state at the end of a piece is
that of the two ends before, within RECURRENCE of its size, the next piece is recorded and stands for all that would
follow. The state is that of the last event, so the events must agree as well. CYCLE is divisible by the periods that
matter; any other motion is integrated to its end.

A difference within RECURRENCE does no harm: a periodic motion that is reached is stable, and the difference shrinks. On
an unstable orbit, or in chaos, it would have to be smaller than RECURRENCE at three ends, which happens only to a
motion that is on the cycle to rounding.
"""

from vibroscope.engine.kernels.compile.options import jit_no_alloc
from vibroscope.engine.kernels.event_driven.state import unpack_state as unpack_event_state
from vibroscope.engine.kernels.time_stepping.newmark import unpack_state as unpack_step_state

CYCLE = 12
RECURRENCE = 1e-13


@jit_no_alloc
def close(value, other, allowed):
    """Whether two numbers differ by no more than allowed."""
    return abs(value - other) <= allowed


@jit_no_alloc
def event_state_recurs(now, before, period, tolerance):
    """Whether a packed hybrid state is that of CYCLE periods before."""
    a, b = unpack_event_state(now), unpack_event_state(before)
    if a.period != b.period + CYCLE or a.mode != b.mode or a.order != b.order:
        return False
    allowed = tolerance * (abs(a.x1) + abs(a.v1) + abs(a.gap) + abs(a.rate))
    same = close(a.tau, b.tau, tolerance * period) and close(a.x1, b.x1, allowed) and close(a.v1, b.v1, allowed)
    return same and close(a.gap, b.gap, allowed) and close(a.rate, b.rate, allowed)


@jit_no_alloc
def step_state_recurs(now, before, n, tolerance):
    """Whether a packed state of Newmark's method is that of CYCLE periods before."""
    a, b = unpack_step_state(now), unpack_step_state(before)
    if a.step != b.step + CYCLE * n or a.pressed != b.pressed:
        return False
    far = tolerance * (abs(a.p1) + abs(a.p2))
    fast = tolerance * (abs(a.q1) + abs(a.q2)) + far / n  # Q = Δτ ξ′: a displacement over a step
    near = close(a.p1, b.p1, far) and close(a.p2, b.p2, far)
    return near and close(a.q1, b.q1, fast) and close(a.q2, b.q2, fast)
