"""The event loop for contact laws other than spring and damper: exact penalty solutions, from event to event.

The flight is known in closed form (:mod:`..linear.tables`). So is each *piece* of a piecewise linear law
(:data:`..equations.contact_law.PIECES`); a piece ends where one of the quantities that it watches falls to zero: one
for each kink that leads to another piece, and in a contact that may open there, −g.

The force is continuous over these events but for the one at touch, so that the quantity which ends a piece begins the
next one with its sign changed, at zero and rising. A contact lasts as long as the gap is not positive, whether or not
the law pushes, as it does in the time-stepping methods. Other laws are followed step by step while the bodies overlap
(:mod:`.law_contact`).
"""

import math

from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.record import no_room, unpack_buffers, with_impulse
from vibroscope.engine.kernels.equations.contact_law import (
    MAIN,
    OTHER,
    count_kinks,
    is_piecewise_linear,
    kink,
    law_force,
    takes_larger,
)
from vibroscope.engine.kernels.event_driven.events import (
    HIGHEST_ORDER,
    begin_flight,
    first_nonzero,
    first_nonzero_derivative,
    is_hidden,
    opened_contact,
)
from vibroscope.engine.kernels.event_driven.law_contact import TABLE, extrapolate, set_start, stepped, take_step
from vibroscope.engine.kernels.event_driven.output import (
    SLACK,
    append_contact,
    evaluate,
    first_sample,
    records,
    time_to_row,
    time_to_sample,
    write_motion,
)
from vibroscope.engine.kernels.event_driven.state import (
    COLLISION,
    CONTACT,
    FLIGHT,
    MOST_EFFORT,
    MOST_EVENTS,
    absolute,
    advance_load,
    at_load_change,
    at_once,
    count_event,
    later_state,
    linear_state,
    load_integral,
    time_to_load_change,
    unpack_state,
    with_contact,
    write_state,
)
from vibroscope.engine.kernels.event_driven.two_stops import flight_of_other, touch_other
from vibroscope.engine.kernels.linear.first_root import first_root
from vibroscope.engine.kernels.linear.tables import POINTS, Phase, gap_at, position_at, state_after
from vibroscope.engine.kernels.status import CROSSED, FULL, OK, PAUSED, PILED_UP, UNRESOLVED

# Modes: a piece of a contact has its number, from MAIN on, and this; CONTACT: the piece is still to be found
PIECES_FROM = 3.0
SMOOTH = 7.0
STEP_EFFORT = 10  # intervals examined, as which a step of a contact counts
GOES_ON, ENDS, CROSSES = range(3)  # how a phase has ended
SECOND_WATCHED = 8.0  # added to the order of the second watched quantity


@jit_inlined
def first_piece(law, depth, speed):
    """The mode of a contact with this δ and v."""
    if not is_piecewise_linear(law.kind):
        return SMOOTH
    spring, damper, knee = law.stiffness * depth, law.gain * speed, law.stiffness * law.penetration
    for piece in range(OTHER, OTHER + count_kinks(law.kind)):
        value = kink(law, piece, spring, damper, knee)
        # at a touch the damper acts before the spring does: a smaller force than both follows at once
        if value < 0.0 or (value == 0.0 and not takes_larger(law.kind, piece)):
            return PIECES_FROM + piece
    return PIECES_FROM + MAIN


@jit_inlined
def begin_law_contact(p, a, rate, order):
    """The hybrid state from which the bodies touch; ``order``: of the first derivative of v that is not zero."""
    mode = first_piece(p.law, 0.0, -rate)
    order = 0.0 if mode == SMOOTH else order_at_touch(p, int(mode - PIECES_FROM), order)
    return at_once(a, a.v1, 0.0, rate, mode, order, opened_contact(p, a))


@jit_inlined
def order_at_touch(p, piece, order):
    """The order of the first derivative that is not zero, of the gap where a piece watches it, or of v."""
    for k in range(p.counts[piece]):
        if p.targets[2 * piece + k] == FLIGHT:
            return min(order + 1.0, POINTS) + SECOND_WATCHED * k
    return order


@jit_no_alloc
def resolve_law_event(p, a):
    """The hybrid state after a touch that is due, a start in contact, or a flight that begins too slowly."""
    if a.mode == CONTACT:
        return at_once(a, a.v1, a.gap, a.rate, first_piece(p.law, -a.gap, -a.rate), 0.0, a.contact)
    start = 0
    if a.mode == COLLISION:
        if a.rate < 0.0:
            return begin_law_contact(p, a, a.rate, 0.0)
        start = 1
    elif a.mode == FLIGHT and a.order == 1.0 and is_hidden(p, a):
        start = 2
    if start == 0:
        return a
    order, value = first_nonzero_derivative(p.flight, linear_state(p, p.flight, a), start)
    rate = a.rate if order == 1 else 0.0
    if value > 0.0:
        return begin_flight(a, a.v1, rate, float(order))
    return begin_law_contact(p, a, rate, float(min(order, POINTS) - 1))


@jit_inlined
def phase_of(p, piece, k):
    """The tables of a piece, for the k-th quantity that it watches."""
    i = 2 * piece + k
    place, pulled, offsets = p.position[piece], p.pulled[piece], p.offsets[piece]
    return Phase(p.spacing[piece], place, p.gap[piece], p.watched[i], pulled, p.rows[i], p.transitions[piece], offsets)


@jit_no_alloc
def first_event(p, piece, z, order):
    """Interval, share of it, which quantity falls to zero there and at which rate, intervals examined."""
    i, u, k, fall, examined = POINTS, 0.0, 0, 0.0, 0
    for j in range(p.counts[piece] + int(piece == 0 and p.play < math.inf)):
        own = int(order) % 8 if (order >= SECOND_WATCHED) == (j == 1) else 0
        phase, seen = phase_of(p, piece, j), z
        if piece == 0 and j == 1:  # the gap of the other stop
            phase, seen = flight_of_other(p, phase_of(p, piece, 0), z)
        at, share, slope, tries = first_root(phase, seen, own, p.scratch)
        examined += tries
        if at + share < i + u:
            i, u, k, fall = at, share, j, slope
    return i, u, k, fall, examined


@jit_no_alloc
def law_motion(p, a, z, t):
    """(ξ₁, ξ₁′, g, g′) t after a hybrid state; of a piece z is its state there."""
    if a.mode == SMOOTH:
        extrapolate(p, a.tau, set_start(p, a), t)
        return stepped(p)
    return evaluate(p, phase_of(p, piece_of(a), 0), z, t)


@jit_inlined
def piece_of(a):
    """The number of the piece, 0 in flight."""
    return 0 if a.mode == FLIGHT else int(a.mode - PIECES_FROM)


@jit_no_alloc
def write_law_rows(p, a, z, s, gain, window, buffers):
    """Write the section rows and samples of [a, a + s]."""
    kept_from, sampled_from = window
    k = max(a.period, kept_from + 1.0)
    while k - kept_from <= buffers.section.shape[0] and time_to_row(p, a, k) <= s:
        t = time_to_row(p, a, k)
        if t >= SLACK * p.period:
            write_motion(p, buffers.section[int(k - kept_from) - 1], law_motion(p, a, z, max(t, 0.0)))
        k += 1.0
    j = first_sample(p, a, sampled_from, buffers.phases)
    while j < buffers.samples.shape[0]:
        t, _ = time_to_sample(p, a, j, sampled_from, buffers.phases)
        if t > s:
            return
        if t >= SLACK * p.period:
            y = law_motion(p, a, z, max(t, 0.0))
            write_motion(p, buffers.samples[j], y)
            buffers.samples[j, 4] = p.sign * (law_force(p.law, gain, -y[2], -y[3]) if a.mode != FLIGHT else 0.0)
        j += 1


@jit_inlined
def piece_impulse(p, piece, z, end, s):
    """∫λ dτ of a piece between two states of it, s apart."""
    total = p.impulse[piece, 6] * s
    for i in range(4):
        total += p.impulse[piece, i] * (end[i] - z[i])
    cosine, sine = load_integral(p, z, end, s)
    total += p.impulse[piece, 4] * cosine
    return total + p.impulse[piece, 5] * sine


@jit_inlined
def with_piece_impulse(p, piece, phase, z, a, s):
    """The hybrid state a, at which a piece has lasted s from z on, with the impulse on the way."""
    if piece == 0:
        return a
    impulse = a.contact.impulse + piece_impulse(p, piece, z, linear_state(p, phase, a), s)
    return with_contact(a, with_impulse(a.contact, impulse))


@jit_no_alloc
def resolve_law_load_change(p, a):
    """The hybrid state where the load jumps or bends: what a piece watches, and is zero there, may fall at once."""
    if a.mode in (FLIGHT, COLLISION, SMOOTH):
        return a
    piece, mode, gap, order, falls = piece_of(a), a.mode, a.gap, 0.0, HIGHEST_ORDER + 2
    for k in range(p.counts[piece]):
        phase = phase_of(p, piece, k)
        first, value = first_nonzero(phase, linear_state(p, phase, a))
        if value < 0.0 and first < falls:
            falls, mode = first, float(p.targets[2 * piece + k])
            mirrored = p.mirrored[2 * piece + k]
            order = max(first, 1) + (SECOND_WATCHED * mirrored if mirrored >= 0 else 0.0)
            gap = 0.0 if mode == FLIGHT else a.gap
        elif first > 0 and value > 0.0 and mode == a.mode:
            order = first + SECOND_WATCHED * k
    return at_once(a, a.v1, gap, a.rate, mode, float(order), a.contact)


@jit_no_alloc
def follow_piece(p, a, z):
    """Follow a piece, or the flight, to its first event or to the end of the block.

    Returns
    -------
    tuple
        Time that passes; the hybrid state then; GOES_ON, ENDS if that is an event, CROSSES if it is seen from the other
        stop; intervals examined.
    """
    piece = piece_of(a)
    phase = phase_of(p, piece, 0)
    i, u, k, fall, examined = first_event(p, piece, z, a.order)
    s, y, mode, order = (i + u) * phase.spacing, absolute(phase, state_after(phase, z, i)), a.mode, 0.0
    if piece == 0 and k == 1:
        return s, touch_other(p, phase, a, z, (i, u), fall), CROSSES, examined
    if i < POINTS:
        at = state_after(phase, z, i)
        x1, v1 = position_at(phase, at, u, p.scratch)
        gap, rate = gap_at(phase, at, u, p.scratch)
        mode, mirrored = float(p.targets[2 * piece + k]), p.mirrored[2 * piece + k]
        order = 1.0 + SECOND_WATCHED * mirrored if mirrored >= 0 else 0.0
        gap += phase.gap
        if mode in (FLIGHT, COLLISION):
            gap, order, mode = 0.0, 1.0, (FLIGHT if rate > 0.0 else COLLISION)
        y = (x1 + phase.position, v1, gap, rate)
    after = later_state(p, a, s, y, mode, order, a.contact)
    return s, with_piece_impulse(p, piece, phase, z, after, s), ENDS if i < POINTS else GOES_ON, examined


@jit_no_alloc
def follow_smooth(p, a, longest):
    """Take a step of a contact; returns what :func:`follow_piece` does, a negative time if none is exact enough."""
    s, following, ends, at_kink, tries = take_step(p, a, longest)
    x1, v1, gap, rate = stepped(p)
    contact = with_impulse(a.contact, a.contact.impulse + p.work[TABLE, 4])
    mode, order, how = SMOOTH, following, GOES_ON
    if ends:
        gap, mode, order, how = 0.0, (FLIGHT if rate > 0.0 else COLLISION), 1.0, ENDS
    elif at_kink:
        gap = -p.law.penetration
    return s, later_state(p, a, max(s, 0.0), (x1, v1, gap, rate), mode, order, contact), how, STEP_EFFORT * tries


@jit_no_alloc
def follow(p, a):
    """Follow a hybrid state to its first event, the end of a block or a step, or the next segment of the load.

    Returns z where it begins, unless the contact is taken by steps, and what :func:`follow_piece` does.
    """
    change = time_to_load_change(p, a.tau)
    if a.mode == SMOOTH:
        z = linear_state(p, phase_of(p, 0, 0), a)
        s, after, ends, effort = follow_smooth(p, a, change)
        if s < change or ends:
            return z, s, after, ends, effort
        y = after.x1, after.v1, after.gap, after.rate
    else:
        piece = piece_of(a)
        phase = phase_of(p, piece, 0)
        z = linear_state(p, phase, a)
        s, after, ends, effort = follow_piece(p, a, z)
        if s < change:
            return z, s, after, ends, effort
        y = evaluate(p, phase, z, change)
        after = with_piece_impulse(p, piece, phase, z, later_state(p, a, change, y, a.mode, 0.0, a.contact), change)
    return z, change, at_load_change(p, a, y, after.order, after.contact), GOES_ON, effort


@jit_no_alloc
def resolve_law(p, a):
    """The hybrid state after what is due: another segment of the load, a touch, a start in contact."""
    if advance_load(p, p.segments, a.tau):
        a = resolve_law_load_change(p, a)
    return resolve_law_event(p, a)


@jit_no_alloc
def integrate_law(p, state, stop, window, flat, sizes):
    """Integrate the motion to the end of period ``stop``; as :func:`.integrate.integrate`, without a variation.

    Parameters
    ----------
    p : LawSystem
    state : (n,) float64
        The :class:`.state.HybridState` from which to go on, changed in place to the last one before the end.
    stop : float
    window : (2,) tuple of float64
    flat, sizes
        Packed record buffers.

    Returns
    -------
    (int, int, int)
        Status, events, effort. UNRESOLVED: a contact needs shorter steps than there are. CROSSED: the state is that of
        the other stop.
    """
    buffers, a = unpack_buffers(flat, sizes), unpack_state(state)
    events, effort, status = 0, 0, OK
    while True:
        if no_room(buffers):
            status = FULL
            break
        touching, a = a, resolve_law(p, a)
        if a.mode == FLIGHT and touching.mode >= PIECES_FROM and records(buffers):  # opened by the load
            append_contact(p, touching, window, buffers)
        horizon = (stop - a.period) * p.period - a.tau
        z, s, after, ends, work = follow(p, a)
        effort += work
        if s < 0.0:
            status = UNRESOLVED
            break
        if records(buffers):
            gain = set_start(p, a)
            write_law_rows(p, a, z, min(s, horizon), gain, window, buffers)
        if s >= horizon and time_to_load_change(p, a.tau) >= horizon:
            status = OK
            break
        if ends == CROSSES:
            a, events = after, events + 1
            status = PILED_UP if a.events > MOST_EVENTS else CROSSED
            break
        if ends == ENDS:
            events += 1
            if a.mode != FLIGHT and after.mode in (FLIGHT, COLLISION) and records(buffers):
                append_contact(p, after, window, buffers)
            after = count_event(after)
        a = after
        if a.events > MOST_EVENTS:
            status = PILED_UP
            break
        if effort > MOST_EFFORT:
            status = PAUSED
            break
    write_state(state, a)
    return status, events, effort
