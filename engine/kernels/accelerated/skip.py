"""Newmark's discrete solution, the same steps as the plain loop, without taking each of them.

:mod:`.certificate` says of how many steps it is certain that contact does not change; these are skipped, and what a
record asks of them is read off tables. Where rounding could change the sign of the gap, a step is
taken as the plain loop takes it; only there may contact change at another step than in the plain loop. Skips do not
depend on where a run is cut: one that reaches beyond its end is not made, what is asked for within it is read off, and
the next call begins with it.

Between two stops a flight is certified up to a gap that is far from the stop from which it is seen, and goes on as seen
from the other one, with the tables of that.

Plain twin: :func:`..time_stepping.newmark.integrate` (tests/engine/kernels/test_skip.py).

Output of steps that are skipped: motion, contact force and impulse, read off tables (:mod:`.step_map`).

Every step is one entry of each level away from where the skip begins, so no step is taken.
"""

from typing import NamedTuple

from vibroscope.engine.kernels.accelerated.certificate import CHANGE, TAKE_STEP, certify_skip, steps_of
from vibroscope.engine.kernels.accelerated.step_map import ENTRIES, PRESSED, unpack_skipping
from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.record import no_room, unpack_buffers, unrecorded_contact, with_impulse
from vibroscope.engine.kernels.linear.cos_sin import cos_sin
from vibroscope.engine.kernels.linear.tables import apply_transition, dot
from vibroscope.engine.kernels.status import CROSSED, FULL, OK
from vibroscope.engine.kernels.time_stepping.newmark import (
    LIMIT,
    SEEN_FROM,
    StepState,
    begin_contact,
    displaced,
    end_contact,
    ending_of,
    force_at,
    motion,
    motion_of,
    phased,
    step,
    turned,
    unpack_state,
    with_contact,
    write_output,
    write_sample,
    write_state,
)


@jit_inlined
def state_after_strides(t, pressed, z, coarse, middle):
    """z after so many entries of the two levels above single steps, all with the same contact state."""
    return apply_transition(t.matrices[pressed, 1], apply_transition(t.matrices[pressed, 2], z, coarse), middle)


@jit_inlined
def split(steps, stride):
    """Whole strides in so many steps, at most as many as the table has, and the steps that are left."""
    strides = min(steps // stride, ENTRIES) if stride > 0 else 0
    return strides, steps - strides * stride


@jit_inlined
def entries_of(p, pressed, steps):
    """Entries of each level, from the coarsest on, that so many steps of a skip are."""
    strides = p.tables.strides
    coarse, rest = split(steps, int(strides[pressed, 2]))
    middle, fine = split(rest, int(strides[pressed, 1]))
    return coarse, middle, fine


@jit_inlined
def motion_at(p, pressed, z, fine, k):
    """(ξ₁, ξ₁′, ξ₂, ξ₂′) at the end of the step that follows ``fine`` single steps after z, k steps into a period."""
    h = p.scheme.h
    c, s = cos_sin(k / p.steps)
    z = (*apply_transition(p.tables.matrices[pressed, 0], z, fine)[:4], c, s)  # before the step
    rows = p.tables.accelerations[pressed]
    a1, a2 = dot(rows[0], z), dot(rows[1], z)
    x, gap = p.tables.origins[pressed, 0], p.tables.origins[pressed, 1]
    p1, q1, p2, q2 = z[0], z[1], z[0] + z[2], z[1] + z[3]
    return displaced(
        p.scheme,
        p1 + 0.25 * a1 + x,
        (q1 + 0.5 * a1) / h,
        p2 + 0.25 * a2 + (x + gap),
        (q2 + 0.5 * a2) / h,
    )


@jit_no_alloc
def motion_after(p, pressed, z, i, t):
    """(ξ₁, ξ₁′, ξ₂, ξ₂′) at the end of step t, from z after step i < t."""
    coarse, middle, fine = entries_of(p, pressed, t - 1 - i)
    return motion_at(p, pressed, state_after_strides(p.tables, pressed, z, coarse, middle), fine, (t - 1) % p.steps)


@jit_inlined
def next_entries(p, pressed, entries, steps):
    """The result of :func:`entries_of` so many steps later, without a division: one takes as long as a motion."""
    middle_stride, coarse_stride = int(p.tables.strides[pressed, 1]), int(p.tables.strides[pressed, 2])
    coarse, middle, fine = entries
    fine += steps
    while 0 < middle_stride <= fine and middle < ENTRIES:
        fine, middle = fine - middle_stride, middle + 1
        # a coarse stride is a whole number of the middle ones
        if middle * middle_stride == coarse_stride and coarse < ENTRIES:
            middle, coarse = 0, coarse + 1
    return coarse, middle, fine


@jit_inlined
def impulse_of(t, z, skip):
    """Δτ Σλ over the steps of a skip in contact."""
    total = t.origins[PRESSED, 2] * steps_of(t, PRESSED, skip)
    total += dot(t.impulses[2, skip.coarse - 1], z) if skip.coarse > 0 else 0.0
    z = apply_transition(t.matrices[PRESSED, 2], z, skip.coarse)
    total += dot(t.impulses[1, skip.middle - 1], z) if skip.middle > 0 else 0.0
    z = apply_transition(t.matrices[PRESSED, 1], z, skip.middle)
    return total + (dot(t.impulses[0, skip.fine - 1], z) if skip.fine > 0 else 0.0)


@jit_no_alloc
def write_skipped(p, pressed, z, i, end, change, window, buffers):
    """Write the section rows and samples of the steps i + 1 … end; ``change``: the step that changes contact, or −1."""
    n = p.steps
    kept_from, sampled_from, stride = window
    t = (max(i, kept_from) // n + 1) * n
    while t <= end:
        row = buffers.section[(t - kept_from) // n - 1]
        row[0], row[1], row[2], row[3] = motion_after(p, pressed, z, i, t)
        t += n
    if buffers.samples.shape[0] == 0:
        return
    t = max(i + 1, sampled_from)
    late = (t % n) % stride
    if late > 0:
        t += min(stride - late, n - t % n)
    k, j = t % n, (t - sampled_from) // n * buffers.phases.shape[0] + (t % n) // stride
    entries = entries_of(p, pressed, t - 1 - i)
    coarse, middle = entries[0], entries[1]
    before = state_after_strides(p.tables, pressed, z, coarse, middle)
    while t <= end and j < buffers.samples.shape[0]:  # from sample to sample without a division
        if entries[0] != coarse or entries[1] != middle:  # most samples lie within the stride of the one before
            coarse, middle = entries[0], entries[1]
            before = state_after_strides(p.tables, pressed, z, coarse, middle)
        now = motion_at(p, pressed, before, entries[2], k - 1 if k > 0 else n - 1)
        write_sample(buffers.samples[j], now, force_at(p.scheme, now, (pressed == PRESSED) != (t == change)))
        ahead = min(stride, n - k)
        t, k, j = t + ahead, k + ahead if k + ahead < n else 0, j + 1
        entries = next_entries(p, pressed, entries, ahead)


NOT_ASKED = (0.0, 0.0, 0.0, 0.0)  # a motion that no record asks for


class ExcitationPhase(NamedTuple):
    """The phase of the excitation at the end of a step."""

    k: int  # steps done in the period
    cosine: float  # of ητ
    sine: float


@jit_inlined
def excitation_at(p, k):
    """The excitation after k steps of a period."""
    c, s = cos_sin(k * (1.0 / p.steps))
    return ExcitationPhase(k, c, s)


@jit_inlined
def relative_state(t, pressed, now, at):
    """z of the discrete solution, from which the next skip begins."""
    x, apart = t.origins[pressed, 0], t.origins[pressed, 1]
    return now.p1 - x, now.q1, now.p2 - now.p1 - apart, now.q2 - now.q1, at.cosine, at.sine


@jit_inlined
def state_after_skip(p, now, skip, reached):
    """The discrete solution after a skip to step ``reached``; accelerations stay those of the last step taken."""
    pressed = int(now.pressed)
    t = p.tables
    p1, q1, apart, drift, _, _ = apply_transition(t.matrices[pressed, 0], skip.beginning, skip.fine)
    apart += t.origins[pressed, 1]
    gap = (-skip.signed_gap if now.pressed else skip.signed_gap) + p.scheme.touch
    after = now.pressed != (skip.outcome == CHANGE)
    p1 += t.origins[pressed, 0]
    return StepState(p1, q1, p1 + apart, q1 + drift, now.a1, now.a2, gap, after, reached, now.contact)


@jit_inlined
def state_after_step(p, now, at):
    """The discrete solution after one step as the plain loop takes it; ``at``: the excitation at its end."""
    cosine1, cosine2 = phased(p.scheme, at.cosine, at.sine)
    a1, a2, push = step(p.scheme, now.p1, now.q1, now.p2, now.q2, now.pressed, cosine1, cosine2)
    gap = now.p2 - now.p1 + 0.25 * (a2 - a1)
    q1, q2 = now.q1 + a1, now.q2 + a2
    # the trapezoidal rule gives each force two half steps, hence one whole step
    contact = with_impulse(now.contact, now.contact.impulse + p.scheme.h * push)
    return StepState(now.p1 + q1, q1, now.p2 + q2, q2, a1, a2, gap, gap <= p.scheme.touch, now.step + 1, contact)


@jit_inlined
def change_contact(m, now, there, closed, kept, buffers):
    """The state whose contact begins or has ended with the last step, in which the gap fell by ``closed``."""
    contact = now.contact
    if now.pressed:
        contact = begin_contact(m, now.step, there, closed / m.h) if kept else unrecorded_contact(now.step * m.h)
    elif kept:
        end_contact(m, contact, now.step, there, force_at(m, there, True), buffers)
    return with_contact(now, contact)


@jit_no_alloc
def turn(packed, state, kept_from):
    """Write the state as seen from the other stop; the impact of a contact that begins counts from a step on."""
    seen_from, now = int(state[SEEN_FROM]), unpack_state(state)
    here, there = unpack_skipping(packed[seen_from]).scheme, unpack_skipping(packed[1 - seen_from]).scheme
    write_state(state, turned(here, there, now, now.step >= kept_from))
    state[SEEN_FROM] = 1 - seen_from


@jit_no_alloc
def integrate_skipping(packed, state, stop, window, flat, sizes, full):
    """Integrate the discrete solution to the end of step ``stop``, as :func:`..time_stepping.newmark.integrate` does.

    Parameters
    ----------
    packed : (1, SKIPPING.size) or (2, SKIPPING.size) float64
        A :class:`.step_map.SkippingScheme` of each stop.
    state : (STATE.size + 1,) float64
        A :class:`..time_stepping.newmark.StepState` and the stop from which it is seen, changed in place. Its ``step``
        is the one from which the next call goes on: ``stop`` or, where a skip reaches beyond, the step before that
        skip.
    stop : int
    window : (3,) int64
        The step at which the kept periods begin, the step at which sampling begins, and the steps from sample to
        sample, counted anew in each period.
    flat, sizes
        Packed record buffers. Nothing is recorded if they have no room for a section.
    full : bool
        Whether motion and impulse of an impact are asked for, and not only its instant and closing speed.

    Returns
    -------
    int
        OK, DIVERGED or FULL.
    """
    status = skip_from_stop(packed[int(state[SEEN_FROM])], state, stop, window, flat, sizes, full)
    while status == CROSSED:
        turn(packed, state, window[0])
        status = skip_from_stop(packed[int(state[SEEN_FROM])], state, stop, window, flat, sizes, full)
    return status


@jit_no_alloc
def skip_from_stop(packed, state, stop, window, flat, sizes, full):
    """The same as seen from one stop, whose tables are ``packed``, (SKIPPING.size,): OK, DIVERGED, FULL or CROSSED."""
    p, buffers, now, status = unpack_skipping(packed), unpack_buffers(flat, sizes), unpack_state(state), OK
    kept, sampled = buffers.section.shape[0] > 0, buffers.samples.shape[0] > 0
    at = excitation_at(p, now.step % p.steps)
    if sampled and now.step == window[1]:
        there = motion_of(p.scheme, now)
        write_sample(buffers.samples[0], there, force_at(p.scheme, there, now.pressed))
    while now.step < stop:
        if kept and no_room(buffers):
            status = FULL
            break
        pressed = int(now.pressed)
        z, gap = relative_state(p.tables, pressed, now, at), now.gap - p.scheme.touch
        skip = certify_skip(p, pressed, z, -gap if now.pressed else gap)
        reached = now.step + steps_of(p.tables, pressed, skip)
        if reached > now.step:
            if sampled or (kept and at.k + reached - now.step >= p.steps):
                change = reached if skip.outcome == CHANGE else -1
                write_skipped(p, pressed, z, now.step, min(reached, stop), change, window, buffers)
            if reached >= stop:
                break
            before, k = now, at.k + reached - now.step
            now = state_after_skip(p, before, skip, reached)
            at = excitation_at(p, k if k < p.steps else k % p.steps)
            if kept and full and before.pressed:
                now = with_contact(now, with_impulse(now.contact, now.contact.impulse + impulse_of(p.tables, z, skip)))
            if skip.outcome == CHANGE:
                there = motion_after(p, pressed, z, before.step, reached) if kept and full else NOT_ASKED
                now = change_contact(p.scheme, now, there, skip.before - skip.signed_gap, kept, buffers)
        if skip.outcome == TAKE_STEP:
            before, at = now, excitation_at(p, at.k + 1 if at.k + 1 < p.steps else 0)
            now = state_after_step(p, before, at)
            there = motion(p.scheme, now.p1, now.q1, now.a1, now.p2, now.q2, now.a2) if kept else NOT_ASKED
            if now.pressed != before.pressed:
                now = change_contact(p.scheme, now, there, before.gap - now.gap, kept, buffers)
            if kept:
                push = force_at(p.scheme, there, now.pressed)
                write_output(now.step, at.k, p.steps, there, push, window, buffers)
            if not -LIMIT < now.gap < p.scheme.reach:
                status = ending_of(now.gap)
                break
    write_state(state, now)
    return status


@jit_no_alloc
def record_open_contact(packed, state, stop, buffers):
    """Take the steps that are left of an open contact up to ``stop``, and record it as if it ended there."""
    p, now = unpack_skipping(packed[int(state[SEEN_FROM])]), unpack_state(state)
    while now.step < stop:
        now = state_after_step(p, now, excitation_at(p, (now.step + 1) % p.steps))
    end_contact(p.scheme, now.contact, now.step, motion_of(p.scheme, now), 0.0, buffers)
