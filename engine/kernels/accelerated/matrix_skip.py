"""Skips of the one-step methods whose step is a matrix: the steps of the plain loop, without taking each of them.

A *mode* is a contact status that stays: flight, contact, or a piece of a contact whose law is piecewise linear. As long
as it stays, a step maps

    u = (ξ₁, g, ξ₁′, g′, ξ₁″, g″, λ, cos ητ₀, sin ητ₀, 1)

linearly, u → Φ u. Whatever the plain loop decides a step by is a row w times the u before the step: the gap at its end,
the forces of which a law takes the larger or the smaller, and with the status from the end the gaps at the end of each
stage with either status. Given signs by which they are positive, these are the *watched rows* of the mode. While the
*deciding* rows are positive, every step belongs to the mode, none has no solution or two. While the gap at the end has
its sign, too, contact does not change. Of the steps for which all rows are positive :mod:`.skip_search` says how many
follow. The next step, at whose end the gap has changed sides, is part of the skip where it belongs to the mode. A skip
may begin with such a step: with the status from the end, contact changes in the first step of its new status.

The deciding rows exclude each other, so that one mode at most takes a step. Where no mode certainly does, the plain
loop's own step follows.

Of laws whose contact is not piecewise linear the flight is such a mode, and contact is not: its force is solved for
step by step. But for law (5) the force at a positive gap is zero, or that of
:data:`..equations.contact_law.COMPRESSION`, which no end without contact that is open allows to be closed with contact:
λ = −Kg + c max(v, 0) would not be negative there, as it must be to close the gap. So of a flight the ends without
contact are watched alone, except with (5) and (6).

Plain twin: :func:`..time_stepping.linear_step.integrate_linear` (tests/engine/kernels/test_matrix_skip.py).
"""

from typing import NamedTuple

from vibroscope.engine.kernels.accelerated.skip_search import CHUNK, ENTRIES, FREE, find_steps, impulse_of, write_u_at
from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.record import no_room, unrecorded_contact, with_impulse
from vibroscope.engine.kernels.status import FULL, OK
from vibroscope.engine.kernels.time_stepping.linear_step import (
    FORCE,
    StepProgress,
    advance,
    force_at,
    motion_of,
    unpack_state,
    write_first_sample,
    write_progress,
)
from vibroscope.engine.kernels.time_stepping.newmark import (
    begin_contact,
    end_contact,
    next_output,
    write_output,
    write_sample,
)

WORK_ROWS = 10  # of the work space: three for a step, five u, one of least values, and one y
STATE_ROW = 6  # the y, of those after a step's


class Skip(NamedTuple):
    """What :func:`.skip_search.find_steps` says of the next steps."""

    mode: int
    coarse: int  # entries of the coarser level
    fine: int  # single steps after these
    steps: int  # in all; 0 where no mode certainly takes the next one
    turns: bool  # whether the gap has changed sides at the end of the last


@jit_inlined
def may_have(t, m, mode, at):
    """Whether the next step may be of a mode."""
    return (mode == FREE) != at.pressed or (m.at_end and t.counts.shape[0] > 1)


@jit_inlined
def write_relative(m, y, cosine, sine, u):
    """Write u of a state y."""
    u[0], u[1], u[2], u[3], u[4], u[5] = y[0], (y[1] - y[0]) - m.system.touch, y[2], y[3] - y[2], y[4], y[5] - y[4]
    u[6], u[7], u[8], u[9] = y[6], cosine, sine, 1.0


@jit_inlined
def write_state(m, u, y):
    """Write the y of a u."""
    y[0], y[1], y[2], y[3], y[4], y[5] = u[0], u[0] + (u[1] + m.system.touch), u[2], u[2] + u[3], u[4], u[4] + u[5]
    y[6] = u[6]


@jit_inlined
def next_skip(m, t, mode, at, us):
    """The next :class:`Skip`, whose mode is sought from ``mode`` on."""
    modes, coarse, fine, turns = t.counts.shape[0], 0, 0, False
    for _ in range(modes):
        if may_have(t, m, mode, at):
            coarse, fine, turns = find_steps(t, mode, us, m.system.touch)
            if coarse + fine > 0:
                break
        mode = mode + 1 if mode + 1 < modes else 0
    return Skip(mode, coarse, fine, coarse * t.strides[mode] + fine, turns)


@jit_no_alloc
def write_skipped(m, t, skip, n, at, stop, us, record):
    """Write the section rows and samples of the steps of a skip, up to step ``stop``; n: steps of a period."""
    (window, buffers), y, reached = record, us[STATE_ROW], at.step + skip.steps
    sampled, end = buffers.samples.shape[0] > 0, min(reached, stop)
    i = next_output(at.step, n, window, sampled)
    while i <= end:
        if i > window[0] or i == window[1]:
            pressed = (skip.mode != FREE) != (skip.turns and i == reached)
            write_u_at(t, skip.mode, i - at.step, skip.coarse, us)
            write_state(m, us[4], y)
            now, push = motion_of(m, y), force_at(m, y, pressed, at.contact)
            if i > window[0]:
                write_output(i, i % n, n, now, push, window, buffers)
            elif sampled:
                write_sample(buffers.samples[0], now, push)
        i = next_output(i, n, window, sampled)


@jit_inlined
def motion_at(m, t, skip, steps, us):
    """The motion after so many steps of a skip, and g."""
    write_u_at(t, skip.mode, steps, skip.coarse, us)
    write_state(m, us[4], us[STATE_ROW])
    return motion_of(m, us[STATE_ROW]), us[4, 1]


@jit_inlined
def is_recorded(step, record):
    """Whether a change of contact with a step is recorded; a skip may begin before the kept periods."""
    window, buffers = record
    return buffers.contacts.shape[0] > 0 and step > window[0]


@jit_no_alloc
def contact_begun(m, t, skip, i, at, us, record):
    """The contact that begins with the i-th step of a skip."""
    if not is_recorded(at.step + i, record):
        return unrecorded_contact((at.step + i) * m.system.h)
    was, before = motion_at(m, t, skip, i - 1, us)
    now, gap = motion_at(m, t, skip, i, us)
    if t.statuses[skip.mode] == 1:  # the force has acted in this step already: the speeds are those before it
        now = now[0], was[1], now[2], was[3]
    return begin_contact(m.system, at.step + i, now, (before - gap) / m.system.h)


@jit_inlined
def contact_after(m, t, skip, at, us, record):
    """The contact after a skip; what ends in it is recorded.

    Contact may change with the first step, which then is the first of its side, and with the last, if that turns.
    """
    contact, side, steps, turns, (_, buffers) = at.contact, skip.mode != FREE, skip.steps, skip.turns, record
    enters, leaves = side != at.pressed and steps > int(turns), turns and (steps > 1 or side == at.pressed)
    if side and enters:
        contact = contact_begun(m, t, skip, 1, at, us, record)
    if buffers.contacts.shape[0] > 0 and t.statuses[skip.mode] == 1:
        contact = with_impulse(contact, contact.impulse + impulse_of(t, skip.mode, skip.coarse, skip.fine, us))
    last = steps if side else 1
    if (leaves if side else enters) and is_recorded(at.step + last, record):
        now, _ = motion_at(m, t, skip, last, us)
        end_contact(m.system, contact, at.step + last, now, us[STATE_ROW, FORCE], buffers)
    if leaves and not side:
        contact = contact_begun(m, t, skip, steps, at, us, record)
    return contact


@jit_inlined
def may_go_on(skip):
    """Whether the mode may last longer than its skip."""
    return skip.coarse == ENTRIES or (skip.fine > 0 and skip.fine % CHUNK == 0)


@jit_no_alloc
def integrate_skipping(m, t, angles, state, work, stop, window, buffers):
    """Integrate to the end of step ``stop`` as :func:`..time_stepping.linear_step.integrate_linear` does.

    Skips do not depend on where a run is cut: one that reaches beyond its end is not made, what is asked for within it
    is read off, and the next call begins with it.

    Parameters
    ----------
    m : LinearScheme
    t : SkipTables
    angles, stop, window, buffers
        As there.
    state : (STATE.size,) float64
        A :class:`..time_stepping.linear_step.LinearState`, changed in place. Its ``step`` is the one from which the
        next call goes on: ``stop`` or, where a skip reaches beyond, the step before that skip.
    work : (WORK_ROWS, WORK) float64
        Work space.

    Returns
    -------
    int
        As there.
    """
    s, code, n, us = unpack_state(state), OK, angles.shape[1], work[3:]
    y, at, recorded = s.y, s.progress, buffers.contacts.shape[0] > 0
    write_first_sample(m, y, at, window, buffers)
    mode, k = FREE, at.step % n
    while at.step < stop and code == OK:
        write_relative(m, y, angles[0, k], angles[1, k], us[0])
        skip = next_skip(m, t, mode, at, us)
        mode = skip.mode
        if skip.steps == 0:
            at, code = advance(m, angles, y, at, work, window, buffers)
            k = k + 1 if k + 1 < n else 0
            continue
        reached, k = at.step + skip.steps, k + skip.steps if k + skip.steps < n else (k + skip.steps) % n
        if recorded:
            write_skipped(m, t, skip, n, at, stop, us, (window, buffers))
        if reached >= stop:
            break
        contact = contact_after(m, t, skip, at, us, (window, buffers))
        write_state(m, us[2], y)
        at = StepProgress(t.statuses[mode], (mode != FREE) != skip.turns, reached, at.none, at.two, contact)
        code = FULL if recorded and no_room(buffers) else OK
        if skip.turns or not may_go_on(skip):
            mode = mode + 1 if mode + 1 < t.counts.shape[0] else FREE
    write_progress(state, at)
    return code
