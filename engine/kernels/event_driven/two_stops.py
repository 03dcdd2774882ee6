"""Two stops: flights that may meet either, and what is seen from the other one.

Seen from its own stop a loop knows one surface (:class:`..parameters.Parameters`). The gap of the other one is
play − g, whose tables are those of the flight with the other sign. Where a flight meets it first, the hybrid state is
mirrored, so that impact, chatter and contact there are those of a first stop.
"""

from vibroscope.engine.kernels.compile.options import jit_no_alloc
from vibroscope.engine.kernels.compile.record import no_contact
from vibroscope.engine.kernels.event_driven.saltation import COURSES, scale_row
from vibroscope.engine.kernels.event_driven.state import (
    COLLISION,
    SEEN_FROM,
    SLOW_CONTACT,
    count_event,
    later_state,
    start_state,
    unpack_system,
    write_state,
)
from vibroscope.engine.kernels.linear.tables import Phase, position_at, state_after

CROSSING = int(SLOW_CONTACT)  # in the course of events, in which it is no mode


@jit_no_alloc
def flight_of_other(p, phase, z):
    """A flight as seen from the other stop, and z there; its load counts with the other sign, too."""
    z0, z1, z2, z3, z4, z5 = z
    gap = p.play - phase.gap
    other = Phase(phase.spacing, -phase.position, gap, gap, -phase.pulled, phase.rows, phase.transitions, phase.offsets)
    return other, (-z0, -z1, -z2, -z3, -z4, -z5)


@jit_no_alloc
def touch_other(p, phase, a, z, at, slope):
    """The hybrid state where a flight meets the other stop, as seen from there.

    ``at``: interval and share of it; ``slope``: of the gap of that stop.
    """
    i, u = at
    x1, v1 = position_at(phase, state_after(phase, z, i), u, p.scratch)
    y = -(x1 + phase.position), -v1, 0.0, slope
    return count_event(later_state(p, a, (i + u) * phase.spacing, y, COLLISION, 0.0, no_contact()))


@jit_no_alloc
def turned(y, play):
    """The motion y = (ξ₁, ξ₁′, g, g′) as seen from the other stop."""
    return -y[0], -y[1], play - y[2], -y[3]


@jit_no_alloc
def from_first(y, stop, play):
    """The motion y = (ξ₁, ξ₁′, g, g′) as seen from the first stop, of that seen from ``stop``, 0 or 1; or back."""
    return y if stop == 0 else turned(y, play)


@jit_no_alloc
def turn_variation(d):
    """Mirror δ, or δ_e."""
    for k in range(4):
        scale_row(d, k, -1.0)


@jit_no_alloc
def carry_across(d):
    """Mirror δ where a flight meets the other stop, which adds to the course of events."""
    if d is None:
        return
    turn_variation(d)
    d.course[0] = (d.course[0] * 4 + CROSSING) % COURSES


@jit_no_alloc
def write_start(packed, state, y):
    """Write the packed hybrid state of a run that starts at τ = 0, as seen from the stop that is nearer.

    ``packed``: (1, n) or (2, n), a :class:`.state.HybridSystem` of each stop; y = (ξ₁, ξ₁′, g, g′), of which a
    penetration of the reference is left out: not even rounding may leave one.
    """
    p = unpack_system(packed[0])
    x1, v1, gap, rate = y
    if p.rigid:
        gap = min(max(gap, 0.0), p.play)
    stop = int(gap > 0.5 * p.play)
    p = unpack_system(packed[stop])
    state[SEEN_FROM] = stop
    write_state(state, start_state(p, from_first((x1, v1, gap, rate), stop, p.play)))
