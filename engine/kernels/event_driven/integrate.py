"""The event loop in closed form: the reference and the exact penalty solution.

From a hybrid state the motion is known in closed form (:mod:`..linear.tables`) until the next event, which is the first
zero of a watched quantity: the gap in flight, the contact force or the penetration in contact
(:mod:`..linear.first_root`). At the event the laws (:mod:`.events`) give the next hybrid state. Displacements between
events are evaluated only where a record asks for them (:mod:`.output`).

The derivative of the motion with respect to its start, the Jacobian of the Poincaré map, is an optional part of the
loop (:mod:`.saltation`): with ``variation`` = None Numba compiles the loop without it.

Between two stops a flight ends at the first of them. Where that is the other one the loop ends, and goes on as seen
from there (:mod:`.two_stops`).
"""

import math

from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.record import no_contact, no_room, unpack_buffers
from vibroscope.engine.kernels.event_driven.events import (
    can_separate,
    release,
    remain_in_contact,
    resolve_collision,
    resolve_flight_start,
    resolve_load_change,
)
from vibroscope.engine.kernels.event_driven.output import (
    add_impulse,
    evaluate,
    record_collision,
    record_contact_end,
    write_chatter,
    write_output,
)
from vibroscope.engine.kernels.event_driven.saltation import (
    carry_along,
    carry_over_chatter,
    carry_over_fast_decay,
    carry_over_reset,
    carry_to_end,
    carry_to_event,
    leave_event,
    start_variation,
)
from vibroscope.engine.kernels.event_driven.state import (
    COLLISION,
    CONTACT,
    FLIGHT,
    MOST_EFFORT,
    MOST_EVENTS,
    SEEN_FROM,
    SLOW_CONTACT,
    SYSTEM,
    HybridState,
    absolute,
    advance_load,
    at_load_change,
    count_event,
    in_contact,
    later_state,
    linear_state,
    time_of,
    time_to_load_change,
    unpack_state,
    unpack_system,
    write_state,
)
from vibroscope.engine.kernels.event_driven.two_stops import (
    carry_across,
    flight_of_other,
    from_first,
    touch_other,
    turn_variation,
)
from vibroscope.engine.kernels.linear.first_root import first_root
from vibroscope.engine.kernels.linear.tables import POINTS, dot, position_at, state_after
from vibroscope.engine.kernels.status import CROSSED, FULL, OK, PAUSED, PILED_UP, UNRESOLVED

MOST_PAUSES = 8  # in one period, after which it is given up
SYSTEM_SIZE = SYSTEM.size
GOING_ON = -1  # beside the statuses: a run does not end
LOST = 2.0**-44  # a fast part below this share of the penetration is lost in its rounding


@jit_inlined
def drop_fast_part(p, a):
    """The hybrid state without its fast part, once that has decayed below the rounding of the penetration."""
    if a.mode != CONTACT or a.order > 0.0 or not p.stiff:
        return a
    z = linear_state(p, p.contact, a)
    x1, v1, gap, rate = dot(p.fast[0], z), dot(p.fast[1], z), dot(p.fast[2], z), dot(p.fast[3], z)
    if abs(gap) + abs(rate) * p.contact.spacing > LOST * abs(a.gap):
        return a
    slow = a.x1 - x1, a.v1 - v1, a.gap - gap, a.rate - rate
    return HybridState(a.period, a.tau, slow[0], slow[1], slow[2], slow[3], SLOW_CONTACT, 0.0, a.events, a.contact)


@jit_inlined
def end_of_phase(p, phase, a, z, i, u, slope):
    """The hybrid state where a phase ends, u into interval i."""
    x1, v1 = position_at(phase, state_after(phase, z, i), u, p.scratch)
    x1 += phase.position
    s = (i + u) * phase.spacing
    if in_contact(a):
        return release(p, a, s, x1, v1, slope)
    return later_state(p, a, s, (x1, v1, 0.0, slope), COLLISION, 0.0, no_contact())


@jit_inlined
def end_of_block(p, phase, a, z):
    """The hybrid state at which the search for an event goes on."""
    return later_state(
        p, a, POINTS * phase.spacing, absolute(phase, state_after(phase, z, POINTS)), a.mode, 0.0, a.contact
    )


@jit_inlined
def first_event(p, phase, a, z):
    """What :func:`..linear.first_root.first_root` returns of a phase, and whether it is the other stop that is met."""
    two, seen, seen_z, order = p.play < math.inf and a.mode == FLIGHT, phase, z, int(a.order)
    i, u, slope, examined, crosses = POINTS, 1.0, 0.0, 0, False
    for stop in range(1 + two):  # one call, of a function that is large and inlined
        j, w, fall, tries = first_root(seen, seen_z, order, p.scratch)
        examined += tries
        if j + w < i + u:
            i, u, slope, crosses = j, w, fall, stop == 1
        if two:
            (seen, seen_z), order = flight_of_other(p, phase, z), 0
    return i, u, slope, examined, crosses


@jit_inlined
def resolve(p, variation, a, stop, window, buffers):
    """The hybrid state after what is due at a, from which a phase begins: an impact, a touch, the rest of a chatter.

    Also GOING_ON, or why the run ends there: OK, within the rest of a chatter, or UNRESOLVED.
    """
    due, a = a, resolve_collision(p, a)
    carry_over_reset(p, variation, due, a)
    record_collision(p, due, a, buffers)
    start, a = a, resolve_flight_start(p, a)
    if time_of(p, a) > time_of(p, start):
        write_chatter(p, start, a, stop, window, buffers)
        if carry_over_chatter(p, variation, start, a, stop):
            return a, OK
    else:
        carry_over_reset(p, variation, start, a)
    if not can_separate(p, a):
        a = remain_in_contact(p, a)
        if not in_contact(a):
            return a, UNRESOLVED
    touching, a = a, drop_fast_part(p, a)
    carry_over_fast_decay(p, variation, touching, a)
    return a, GOING_ON


@jit_no_alloc
def integrate_from_stop(packed, state, stop, window, flat, sizes, variation):
    """The work of :func:`integrate` as seen from one stop, ``packed`` its :class:`.state.HybridSystem`, (n,).

    It ends as CROSSED where a flight meets the other one: the state is that at the other stop, as seen from there, and
    so is δ before the event.
    """
    p, buffers, a = unpack_system(packed), unpack_buffers(flat, sizes), unpack_state(state)
    phases, segments = (p.flight, p.contact, p.slow_contact), packed[SYSTEM_SIZE:]
    events, examined = 0, 0
    start_variation(p, variation, a)
    while True:
        if no_room(buffers):
            status = FULL
            break
        if advance_load(p, segments, a.tau):
            touching, a = a, resolve_load_change(p, a)
            if not in_contact(a):
                record_contact_end(p, touching, a, window, buffers)
        # 1. What is due at this state
        a, status = resolve(p, variation, a, stop, window, buffers)
        if status != GOING_ON:
            break
        # 2. The phase that begins here, up to its first event, the end of the block or the end of the run
        phase = phases[int(a.mode)]
        z = linear_state(p, phase, a)
        leave_event(phase, variation, z)
        i, u, slope, tries, crosses = first_event(p, phase, a, z)
        examined += tries
        s, horizon = (i + u) * phase.spacing, (stop - a.period) * p.period - a.tau
        change = time_to_load_change(p, a.tau)
        write_output(p, phase, a, z, min(min(s, horizon), change), window, buffers)
        if s >= horizon and change >= horizon:
            carry_to_end(p, phase, variation, z, horizon)
            status = OK
            break
        carry_along(p, phase, variation, i, u)
        if crosses and s < change:
            a, events = touch_other(p, phase, a, z, (i, u), slope), events + 1
            carry_across(variation)
            status = PILED_UP if a.events > MOST_EVENTS else CROSSED
            break
        begin = a
        if s >= change:
            a = at_load_change(p, a, evaluate(p, phase, z, change), 0.0, a.contact)
        else:
            a = end_of_block(p, phase, a, z) if i == POINTS else end_of_phase(p, phase, a, z, i, u, slope)
        a = add_impulse(p, phase, begin, a, z, buffers)
        if i < POINTS and s < change:
            # 3. The event
            carry_to_event(p, phase, variation, a, slope)
            record_contact_end(p, begin, a, window, buffers)
            events += 1
            a = count_event(a)
            if a.events > MOST_EVENTS:
                status = PILED_UP
                break
        if examined > MOST_EFFORT:
            status = PAUSED
            break
    write_state(state, a)
    return status, events, examined


@jit_no_alloc
def integrate(packed, state, stop, window, flat, sizes, variation):
    """Integrate the motion to the end of period ``stop``.

    Parameters
    ----------
    packed : (1, n) or (2, n) float64
        A :class:`.state.HybridSystem` of each stop, and behind it the segments of its load, if it has any
        (:mod:`.state`).
    state : (n + 1,) float64
        The :class:`.state.HybridState` from which to go on, and the number of the stop from which it is seen, 0 or 1;
        changed in place to the last one before the end of ``stop``. A run that goes on from there gives the same bits
        as one that never stopped.
    stop : float
        Number of periods since the start of the run.
    window : (2,) float64
        Period at which the section begins, period at which sampling begins.
    flat, sizes
        Packed record buffers. Nothing is recorded if they have no room for a section.
    variation : Variation or None
        What small changes of the start change, at τ = ``stop`` T in the end; as seen from the first stop.

    Returns
    -------
    (int, int, int)
        Status: OK, PILED_UP or UNRESOLVED; FULL (empty the buffers and call again), PAUSED (call again). Events.
        Intervals examined. With a variation only OK has a meaning for it.
    """
    here, events, examined, status = int(state[SEEN_FROM]), 0, 0, CROSSED
    if here == 1:
        turn_variation(variation)
    while status == CROSSED:
        status, more, tries = integrate_from_stop(packed[here], state, stop, window, flat, sizes, variation)
        events, examined = events + more, examined + tries
        if status == CROSSED:
            here, status = 1 - here, CROSSED if examined <= MOST_EFFORT else PAUSED
    state[SEEN_FROM] = here
    if here == 1 and variation is not None:
        turn_variation(variation)
        end, play = variation.end, unpack_system(packed[0]).play
        end[0], end[1], end[2], end[3] = from_first((end[0], end[1], end[2], end[3]), here, play)
    return status, events, examined
