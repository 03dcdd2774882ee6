"""Newmark's discrete solution, the same steps as the plain loop, without taking each of them.

:mod:`.certificate` says of how many steps it is certain that contact does not change; these are skipped, and what a
record asks of them is read off tables (:mod:`.output`). Where rounding could change the sign of the gap, a step is
taken as the plain loop takes it; only there may contact change at another step than in the plain loop. Skips do not
depend on where a run is cut: one that reaches beyond its end is not made, what is asked for within it is read off, and
the next call begins with it.

Plain twin: :func:`..time_stepping.newmark.integrate` (tests/engine/kernels/test_skip.py).
"""

from typing import NamedTuple

from vibroscope.engine.kernels.accelerated.certificate import CHANGE, TAKE_STEP, certify_skip, steps_of
from vibroscope.engine.kernels.accelerated.output import impulse_of, motion_after, write_skipped
from vibroscope.engine.kernels.accelerated.step_map import unpack_skipping
from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.record import no_room, unpack_buffers, unrecorded_contact, with_impulse
from vibroscope.engine.kernels.linear.cos_sin import cos_sin
from vibroscope.engine.kernels.linear.tables import apply_transition
from vibroscope.engine.kernels.status import DIVERGED, FULL, OK
from vibroscope.engine.kernels.time_stepping.newmark import (
    LIMIT,
    StepState,
    begin_contact,
    end_contact,
    force_at,
    motion,
    motion_of,
    phased,
    step,
    unpack_state,
    with_contact,
    write_output,
    write_sample,
    write_state,
)

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
def integrate_skipping(packed, state, stop, window, flat, sizes, full):
    """Integrate the discrete solution to the end of step ``stop``, as :func:`..time_stepping.newmark.integrate` does.

    Parameters
    ----------
    packed : (SKIPPING.size,) float64
        A :class:`.step_map.SkippingScheme`.
    state : (STATE.size,) float64
        A :class:`..time_stepping.newmark.StepState`, changed in place. Its ``step`` is the one from which the next call
        goes on: ``stop`` or, where a skip reaches beyond, the step before that skip.
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
            if not abs(now.gap) < LIMIT:
                status = DIVERGED
                break
    write_state(state, now)
    return status


@jit_no_alloc
def record_open_contact(packed, state, stop, buffers):
    """Take the steps that are left of an open contact up to ``stop``, and record it as if it ended there."""
    p, now = unpack_skipping(packed), unpack_state(state)
    while now.step < stop:
        now = state_after_step(p, now, excitation_at(p, (now.step + 1) % p.steps))
    end_contact(p.scheme, now.contact, now.step, motion_of(p.scheme, now), 0.0, buffers)
