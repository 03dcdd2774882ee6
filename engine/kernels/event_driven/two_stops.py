"""Two stops: flights that may meet either, and the event loop between them.

Seen from its own stop a loop knows one surface (:class:`..parameters.Parameters`). The gap of the other one is
play − g, whose tables are those of the flight with the other sign. Where a flight meets it first, the hybrid state is
mirrored, so that impact, chatter and contact there are those of a first stop.
"""

from vibroscope.engine.kernels.compile.options import jit_no_alloc
from vibroscope.engine.kernels.compile.record import no_contact, unpack_buffers
from vibroscope.engine.kernels.event_driven.integrate import end_of_block, end_of_segment, integrate
from vibroscope.engine.kernels.event_driven.load import time_to_load_change
from vibroscope.engine.kernels.event_driven.output import write_output
from vibroscope.engine.kernels.event_driven.saltation import COURSES, carry_along, carry_to_end, leave_event, scale_row
from vibroscope.engine.kernels.event_driven.state import (
    COLLISION,
    MOST_EFFORT,
    MOST_EVENTS,
    SEEN_FROM,
    SLOW_CONTACT,
    count_event,
    later_state,
    linear_state,
    unpack_state,
    unpack_system,
    write_start,
    write_state,
)
from vibroscope.engine.kernels.linear.first_root import first_root
from vibroscope.engine.kernels.linear.tables import POINTS, Phase, position_at, state_after
from vibroscope.engine.kernels.status import CROSSED, FLYING, OK, PAUSED, PILED_UP

CROSSING = int(SLOW_CONTACT)  # in the course of events, in which it is no mode


@jit_no_alloc
def flight_of_other(p, phase, z):
    """A flight as seen from the other stop, and z there; its load counts with the other sign, too."""
    z0, z1, z2, z3, z4, z5 = z
    gap = p.play - phase.gap
    other = Phase(phase.spacing, -phase.position, gap, gap, phase.rows, phase.transitions)
    return other, (-z0, -z1, -z2, -z3, -z4, -z5)


@jit_no_alloc
def other_root(p, phase, z):
    """What :func:`..linear.first_root.first_root` returns of the gap of the other stop in a flight."""
    other, mirrored = flight_of_other(p, phase, z)
    return first_root(other, mirrored, 0, p.scratch)


@jit_no_alloc
def touch(p, phase, a, z, at, slope, side):
    """The hybrid state where a flight meets its own stop, ``side`` = 1, or the other one, −1, as seen from that.

    ``at``: interval and share of it; ``slope``: of the gap of that stop.
    """
    i, u = at
    x1, v1 = position_at(phase, state_after(phase, z, i), u, p.scratch)
    y = side * (x1 + phase.position), side * v1, 0.0, slope
    return count_event(later_state(p, a, (i + u) * phase.spacing, y, COLLISION, 0.0, no_contact()))


@jit_no_alloc
def turned(y, play):
    """The motion y = (ξ₁, ξ₁′, g, g′) as seen from the other stop."""
    return -y[0], -y[1], play - y[2], -y[3]


@jit_no_alloc
def turn_variation(d):
    """Mirror δ, or δ_e."""
    for k in range(4):
        scale_row(d, k, -1.0)


@jit_no_alloc
def fly(packed, state, stop, window, flat, sizes, variation):
    """Follow a flight between two stops to the first of them, the end of its block or the end of the run.

    Arguments and results are those of :func:`.integrate.integrate`, with FLYING at the end of a block, where the load
    changes, and at the stop that the state is seen from, CROSSED at the other one. δ is that before the event.
    """
    p, buffers, a = unpack_system(packed), unpack_buffers(flat, sizes), unpack_state(state)
    phase = p.flight
    z = linear_state(p, phase, a)
    leave_event(phase, variation, z)
    i, u, slope, examined = first_root(phase, z, int(a.order), p.scratch)
    j, w, fall, more = other_root(p, phase, z)
    crosses, events = j + w < i + u, 0
    if crosses:
        i, u = j, w
    s, horizon = (i + u) * phase.spacing, (stop - a.period) * p.period - a.tau
    change = time_to_load_change(p, a.tau)
    write_output(p, phase, a, z, min(min(s, horizon), change), window, buffers)
    if s >= horizon and change >= horizon:
        carry_to_end(p, phase, variation, z, horizon)
        return OK, events, examined + more
    if s >= change:
        write_state(state, end_of_segment(p, phase, a, z, change))
        return FLYING, events, examined + more
    carry_along(p, phase, variation, i, u)
    status = CROSSED if crosses else FLYING
    if i == POINTS:
        a = end_of_block(p, phase, a, z)
    else:
        a = touch(p, phase, a, z, (i, u), fall if crosses else slope, -1.0 if crosses else 1.0)
        events = 1
        if variation is not None:
            variation.course[0] = (variation.course[0] * 4 + (CROSSING if crosses else int(COLLISION))) % COURSES
    if crosses:
        turn_variation(variation)
    write_state(state, a)
    return (PILED_UP if a.events > MOST_EVENTS else status), events, examined + more


@jit_no_alloc
def integrate_between(packed, state, stop, window, flat, sizes, variation):
    """Integrate the motion between two stops; as :func:`.integrate.integrate`, the events of both counted.

    Parameters
    ----------
    packed : (2, n) float64
        A :class:`.state.HybridSystem` of each stop.
    state : (n + 1,) float64
        A :class:`.state.HybridState`, and the number of the stop from which it is seen, 0 or 1.
    variation : Variation or None
        As seen from the first stop, at the beginning and in the end.
    """
    here, events, examined, status = int(state[SEEN_FROM]), 0, 0, FLYING
    if here == 1:
        turn_variation(variation)
    while status == FLYING:
        status, more, tries = integrate(packed[here], state, stop, window, flat, sizes, variation)
        events, examined = events + more, examined + tries
        if status == FLYING:
            status, more, tries = fly(packed[here], state, stop, window, flat, sizes, variation)
            events, examined = events + more, examined + tries
            if status == CROSSED:
                here, status = 1 - here, FLYING
        if status == FLYING and examined > MOST_EFFORT:
            status = PAUSED
    state[SEEN_FROM] = here
    if here == 1 and variation is not None:
        turn_variation(variation)
        end = variation.end
        end[0], end[1], end[2], end[3] = turned(end, unpack_system(packed[0]).play)
    return status, events, examined


@jit_no_alloc
def write_start_between(packed, state, x1, v1, gap, rate):
    """Write the start of a run, :func:`.state.write_start`, as seen from the stop that is nearer."""
    play = unpack_system(packed[0]).play
    other = gap > 0.5 * play
    state[SEEN_FROM] = 1.0 if other else 0.0
    if other:
        write_start(packed[1], state, -x1, -v1, play - gap, -rate)
    else:
        write_start(packed[0], state, x1, v1, gap, rate)
