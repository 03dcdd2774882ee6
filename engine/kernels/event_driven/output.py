"""What a run records between events: rows of the section, samples, contacts and impulses."""

import numpy as np
from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.record import record_contact, record_impact, with_impulse
from vibroscope.engine.kernels.equations.motion import displacements
from vibroscope.engine.kernels.event_driven.events import other_force
from vibroscope.engine.kernels.event_driven.state import (
    COLLISION,
    SLOW_CONTACT,
    absolute,
    in_contact,
    later_state,
    linear_state,
    load_integral,
    time_of,
    with_contact,
)
from vibroscope.engine.kernels.linear.tables import (
    CURVATURE,
    GAP,
    INTEGRAL,
    POINTS,
    POSITION,
    find_gap,
    find_position,
    gap_at,
    polynomial_at,
    position_at,
    pulled_by,
    state_after,
)

# An event on the section itself: rounding must not make both of its phases leave the row to the other one.
SLACK = -1e-13  # of a period


@jit_inlined
def records(buffers):
    """Whether anything is recorded."""
    return buffers.section.shape[0] > 0


@jit_no_alloc
def evaluate(p, phase, z, s):
    """(ξ₁, ξ₁′, g, g′) at s within the block that begins at z."""
    h = phase.spacing
    i = min(max(int(s / h), 0), POINTS - 1)
    u = s / h - i
    z = state_after(phase, z, i)
    x1, v1 = position_at(phase, z, u, p.scratch)
    gap, rate = gap_at(phase, z, u, p.scratch)
    return absolute(phase, (x1, v1, gap, rate))


@jit_inlined
def write_output(p, phase, a, z, s, window, buffers):
    """Write the section rows and samples of [a, a + s], s within the block that begins at z, if there are any."""
    if records(buffers):  # decided here, since a call that hands over all tables costs as much as an event
        write_rows(p, phase, a, z, s, window, buffers)


@jit_inlined
def time_to_row(p, a, k):
    """Time from a hybrid state to the section of period k."""
    return (k - a.period) * p.period - a.tau


@jit_inlined
def first_sample(p, a, sampled_from, phases):
    """The number of a sample that is not later than a hybrid state, or is the first of all."""
    m = phases.shape[0]
    return max(0, int(a.period - sampled_from) * m + np.searchsorted(phases, a.tau / p.period) - 1)


@jit_inlined
def time_to_instant(p, a, whole, part, sampled_from, phases):
    """Time from a hybrid state to one of the instants of a period, so many whole periods after the first sample."""
    return (sampled_from + whole - a.period + phases[part]) * p.period - a.tau


@jit_inlined
def time_to_sample(p, a, j, sampled_from, phases):
    """Time from a hybrid state to sample j, and which of the instants of a period that is."""
    whole, part = divmod(j, phases.shape[0])
    return time_to_instant(p, a, whole, part, sampled_from, phases), part


@jit_inlined
def evaluate_again(p, phase, z, s, held):
    """The result of :func:`evaluate`, and the interval of the block for which ``scratch`` now holds the polynomials.

    ``held``: that interval, if they are from an earlier s of the same block, or −1.
    """
    h = phase.spacing
    i = min(max(int(s / h), 0), POINTS - 1)
    u = s / h - i
    if i != held:
        later = state_after(phase, z, i)
        find_position(phase, later, p.scratch)
        find_gap(phase, later, p.scratch)
    x1, v1 = polynomial_at(p.scratch.products[POSITION:GAP], u)
    gap, rate = polynomial_at(p.scratch.products[GAP:CURVATURE], u)
    return absolute(phase, (x1, v1 / h, gap, rate / h)), i


@jit_inlined
def write_motion(p, row, y):
    """Write a motion (ξ₁, ξ₁′, g, g′) as the user counts it."""
    row[0], row[1], row[2], row[3] = displacements(p, y[0], y[1], y[2], y[3])


@jit_no_alloc
def write_rows(p, phase, a, z, s, window, buffers):
    """Write what :func:`write_output` is asked for."""
    kept_from, sampled_from = window
    k = max(a.period, kept_from + 1.0)
    while k - kept_from <= buffers.section.shape[0] and time_to_row(p, a, k) <= s:
        t = time_to_row(p, a, k)
        if t >= SLACK * p.period:
            write_motion(p, buffers.section[int(k - kept_from) - 1], evaluate(p, phase, z, max(t, 0.0)))
        k += 1.0
    if buffers.samples.shape[0] == 0:
        return
    phases, held = buffers.phases, -1
    j = first_sample(p, a, sampled_from, phases)
    whole, part = divmod(j, phases.shape[0])  # counted from here on: a division takes as long as a polynomial
    while j < buffers.samples.shape[0]:
        t = time_to_instant(p, a, whole, part, sampled_from, phases)
        if t > s:
            return
        if t >= SLACK * p.period:
            (x1, v1, gap, rate), held = evaluate_again(p, phase, z, max(t, 0.0), held)
            row = buffers.samples[j]
            write_motion(p, row, (x1, v1, gap, rate))
            row[4] = 0.0
            if in_contact(a):
                row[4] = p.force_position * x1 + p.force_velocity * v1 + p.force_gap * gap + p.force_rate * rate
                row[4] += other_force(p, phases[part])
                row[4] *= p.sign
        j += 1
        part += 1
        if part == phases.shape[0]:
            whole, part = whole + 1, 0


@jit_no_alloc
def write_chatter(p, a, b, stop, window, buffers):
    """Write what falls into the summed end of a chatter, from a to b, as the bodies' common motion."""
    if not records(buffers):
        return
    x1, v1, gap, rate, c, s = linear_state(p, p.contact, a)
    together = (x1, v1 + p.mass_share * rate, gap, 0.0, c, s)
    length = (b.period - a.period) * p.period + b.tau - a.tau
    write_output(p, p.contact, a, together, min(length, (stop - a.period) * p.period - a.tau), window, buffers)


@jit_inlined
def record_collision(p, before, after, buffers):
    """Append the reference's impact, if a collision was due; the hybrid states are those before and after it."""
    if records(buffers) and p.rigid and before.mode == COLLISION and before.rate < 0.0:
        x1, v1, _, v2 = displacements(p, before.x1, before.v1, before.gap, before.rate)
        _, w1, _, w2 = displacements(p, after.x1, after.v1, after.gap, after.rate)
        record_impact(buffers, time_of(p, before), x1, (v1, v2), (w1, w2), v1 - w1, -before.rate)


@jit_inlined
def add_impulse(p, phase, begin, end, z, buffers):
    """``end`` with the impulse of the penalty contact that was open from ``begin``, where z is, to it."""
    if not records(buffers) or p.rigid or not in_contact(begin):
        return end
    length = (end.period - begin.period) * p.period + end.tau - begin.tau
    return gather_impulse(p, phase, end, z, linear_state(p, phase, end), length)


@jit_no_alloc
def gather_impulse(p, phase, a, begin, end, length):
    """The hybrid state with the impulse of its open penalty contact between two states, ∫λ = K ∫(−g) − 2D Δg."""
    squeezed = (phase.watched + pulled_by(phase, INTEGRAL)) * length
    for i in range(4):
        squeezed += phase.rows[i, INTEGRAL] * (end[i] - begin[i])
    c, s = load_integral(p, begin, end, length)
    squeezed += phase.rows[4, INTEGRAL] * c
    squeezed += phase.rows[5, INTEGRAL] * s
    impulse = a.contact.impulse - p.force_gap * squeezed + p.force_rate * (end[2] - begin[2])
    return with_contact(a, with_impulse(a.contact, impulse))


@jit_inlined
def record_contact_end(p, begin, now, window, buffers):
    """Append the contact that was open at ``begin`` and ends at the hybrid state ``now``."""
    if records(buffers) and in_contact(begin):
        append_contact(p, now, window, buffers)


@jit_no_alloc
def append_contact(p, now, window, buffers):
    """Append the contact that ends at ``now``; a penalty contact is an impact as well."""
    contact = with_impulse(now.contact, p.sign * now.contact.impulse)
    impact = not p.rigid and contact.begun >= window[0] * p.period
    _, v1, _, v2 = displacements(p, now.x1, now.v1, now.gap, now.rate)
    record_contact(buffers, contact, time_of(p, now), (v1, v2), impact)


@jit_no_alloc
def record_open_contact(p, a, stop, window, buffers):
    """Append the contact that is open at the end of period ``stop``, as if it ended there."""
    if not in_contact(a):
        return
    phase = p.slow_contact if a.mode == SLOW_CONTACT else p.contact
    z = linear_state(p, phase, a)
    s = (stop - a.period) * p.period - a.tau
    now = later_state(p, a, s, evaluate(p, phase, z, s), a.mode, 0.0, a.contact)
    if not p.rigid:
        now = gather_impulse(p, phase, now, z, linear_state(p, phase, now), s)
    append_contact(p, now, window, buffers)
