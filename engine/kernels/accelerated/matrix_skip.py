"""Skips of the one-step methods whose step is a matrix: the steps of the plain loop, without taking each of them.

A *mode* is a contact status that stays: flight, contact, or a piece of a contact whose law is piecewise linear. As long
as it stays, a step maps

    u = (ξ₁, g, ξ₁′, g′, ξ₁″, g″, λ, cos ητ₀, sin ητ₀, 1)

linearly, u → Φ u. Whatever the plain loop decides a step by is a row w times the u before the step: the gap at its end,
the forces of which a law takes the larger or the smaller, and with the status from the end the gaps at the end of each
stage with either status. Given signs by which they are positive, these are the *watched rows* of the mode. While the
*deciding* rows are positive, every step belongs to the mode, none has no solution or two. While the gap at the end has
its sign, too, contact does not change. It is known for how many steps all rows are positive. The next step, at whose
end the gap has changed sides, is part of the skip where it belongs to the mode. A skip may begin with such a step: with
the status from the end, contact changes in the first step of its new status.

The deciding rows exclude each other, so that one mode at most takes a step. Where no mode certainly does, the plain
loop's own step follows.

Of laws whose contact is not piecewise linear the flight is such a mode, and contact is not: its force is solved for
step by step. But for law (5) the force at a positive gap is zero, or that of
:data:`..equations.contact_law.COMPRESSION`, which no end without contact that is open allows to be closed with contact:
λ = −Kg + c max(v, 0) would not be negative there, as it must be to close the gap. So of a flight the ends without
contact are watched alone, except with (5), (6) and (60).

Plain twin: :func:`..time_stepping.linear_step.integrate_linear` (tests/engine/kernels/test_matrix_skip.py).

How many steps keep a mode, by tables of what many of them do.

The values of a row w at the ends of the next steps, or of every s-th of them, are the rows w Φʲ⁻¹ times one u. Where
the second differences of single steps, rows w(Φ − 1)²Φʲ⁻², are at most B, a row lies between two entries of the coarser
level no more than b = B s²/8 below its chord: where it exceeds b at both, the mode stays between them
(:mod:`.step_map`, with the same condition for the first interval). B is the supremum over all steps of the level, each
of which is formed when the tables are made (:mod:`engine.drivers.skip_tables`).

Single steps are skipped by the sign of the rows. A skip ends before the first step of which a row is not positive, or
so near to zero that rounding could change its sign.
"""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.accelerated.certificate import CERTAIN, FAR
from vibroscope.engine.kernels.accelerated.step_map import ENTRIES
from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.compile.record import no_room, unrecorded_contact, with_impulse
from vibroscope.engine.kernels.status import FULL, OK
from vibroscope.engine.kernels.time_stepping.linear_step import (
    COLUMNS,
    FORCE,
    STATE_ROWS,
    StepProgress,
    advance,
    begin_step,
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

FREE = 0  # the mode without contact
CHUNK = 16  # entries that are examined together: most contacts last as long
LEVELS, CHUNKS = 2, ENTRIES // CHUNK
AFTER_STEP, AFTER_STRIDE, IN_MIDST, AT_WORTH = range(4)  # rows of ``SkipTables.firsts``
FIRSTS = AT_WORTH + 1
AFTER, LEAST = 4, 5  # rows of the work space of a skip: u after some of its steps; what each watched row must exceed
WORTHWHILE = 64  # steps that a skip by the coarser level has at least
NOT_YET = -1  # entries of the coarser level that pays some steps later


class SkipTables(NamedTuple):
    """What many steps of each mode do; M modes, R the most watched rows of one."""

    rows: np.ndarray  # (M, R, LEVELS, CHUNKS, COLUMNS, CHUNK) watched rows after 1 … ENTRIES strides
    firsts: np.ndarray  # (M, R, FIRSTS, COLUMNS) … after a step, a stride, half of WORTHWHILE steps, and as many
    bounds: np.ndarray  # (M, R, COLUMNS) b between entries of the coarser level
    sizes: np.ndarray  # (M, R) of a row, in units of a displacement
    counts: np.ndarray  # (M,) int64 watched rows; 0 where no step is skipped
    deciding: np.ndarray  # (M,) int64 those of them by which a step belongs to the mode; one more: the gap at its end
    sought: np.ndarray  # (M,) int64 those of these that the gaps at both ends of a step do not imply
    statuses: np.ndarray  # (M,) int64 of the steps, 1 where a force acts
    strides: np.ndarray  # (M,) int64 steps from entry to entry of the coarser level, 0 if there is none
    columns: np.ndarray  # (M, LEVELS, ENTRIES, COLUMNS, COLUMNS) those of Φ, Φ², … and Φˢ, Φ²ˢ, …
    impulses: np.ndarray  # (M, LEVELS, ENTRIES, COLUMNS) Δτ Σλ over the steps up to each entry
    period: float  # of the excitation


@jit_inlined
def dot(row, u):
    """A row, or a column of a table, times u."""
    value = 0.0
    for i in range(COLUMNS):
        value += row[i] * u[i]
    return value


@jit_inlined
def value_of(row, u):
    """The same, by a shorter chain of sums."""
    value = (row[0] * u[0] + row[1] * u[1] + row[2] * u[2]) + (row[3] * u[3] + row[4] * u[4] + row[5] * u[5])
    return value + ((row[6] * u[6] + row[7] * u[7]) + (row[8] * u[8] + row[9] * u[9]))


@jit_no_alloc
def steps_above(rows, u, bound, most):
    """Entries, at most so many, before the first whose row times u does not exceed the bound."""
    u0, u1, u2, u3, u4, u5, u6, u7, u8, u9 = u[0], u[1], u[2], u[3], u[4], u[5], u[6], u[7], u[8], u[9]
    none = np.int32(CHUNK)  # indices of half the size: fewer vector instructions
    for c in range((most + CHUNK - 1) // CHUNK):
        r, first = rows[c], none
        for j in range(CHUNK):  # without a branch: vector instructions
            value = (r[0, j] * u0 + r[1, j] * u1 + r[2, j] * u2) + (r[3, j] * u3 + r[4, j] * u4 + r[5, j] * u5)
            value += (r[6, j] * u6 + r[7, j] * u7) + (r[8, j] * u8 + r[9, j] * u9)
            first = min(first, none if value > bound else np.int32(j))
        if first < none:
            return min(most, c * CHUNK + int(first))
    return most


@jit_inlined
def bound_of(row, u):
    """A row of bounds times |u|."""
    value = 0.0
    for i in range(COLUMNS):
        value += row[i] * abs(u[i])
    return value


@jit_inlined
def is_implied(t, mode, r):
    """Whether a row is positive where the gaps at both ends of a step are: only a step with another gap asks for it."""
    return t.sought[mode] <= r < t.deciding[mode]


@jit_inlined
def coarse_entries(t, mode, u, least):
    """Entries of the coarser level in which the mode certainly stays; 0 where single steps do as well, or NOT_YET."""
    stride, entries = t.strides[mode], ENTRIES
    if stride == 0:
        return 0
    for r in range(t.counts[mode]):  # most contacts end sooner than the level is worth its search
        if is_implied(t, mode, r):
            continue
        midst = value_of(t.firsts[mode, r, IN_MIDST], u)
        if not min(midst, value_of(t.firsts[mode, r, AT_WORTH], u)) > least[r]:
            return 0
    for r in range(t.counts[mode]):
        if is_implied(t, mode, r):
            continue
        bound = bound_of(t.bounds[mode, r], u)
        # a row that is small at the next step and grows to v at the first entry: the chord lies above its share of v,
        # and the row at most 4 times this share of the bound below the chord
        near, first = dot(t.firsts[mode, r, AFTER_STEP], u), dot(t.firsts[mode, r, AFTER_STRIDE], u)
        if not (near > bound + least[r] or (near > least[r] and first > 4.0 * bound + least[r])):
            return NOT_YET
        entries = steps_above(t.rows[mode, r, 1], u, bound + least[r], entries)
        if entries * stride < WORTHWHILE:
            return 0
    return entries


@jit_inlined
def steps_of_rows(t, mode, count, u, least, entries):
    """Single steps, at most so many, before one at which one of the first watched rows, ``count``, is not positive."""
    for r in range(count):
        entries = steps_above(t.rows[mode, r, 0], u, least[r], entries)
    return entries


@jit_inlined
def first_step_stays(t, mode, count, u, least):
    """Whether these rows are positive for the next step."""
    stays = True
    for r in range(count):
        stays = stays and value_of(t.firsts[mode, r, AFTER_STEP], u) > least[r]
    return stays


@jit_no_alloc
def apply(columns, u, out):
    """Write the product of a matrix, given by its columns, and u."""
    v0, v1, v2, v3, v4, v5, v6, v7, v8, v9 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(COLUMNS):
        c, x = columns[j], u[j]
        v0, v1, v2, v3, v4 = v0 + c[0] * x, v1 + c[1] * x, v2 + c[2] * x, v3 + c[3] * x, v4 + c[4] * x
        v5, v6, v7, v8, v9 = v5 + c[5] * x, v6 + c[6] * x, v7 + c[7] * x, v8 + c[8] * x, v9 + c[9] * x
    out[0], out[1], out[2], out[3], out[4] = v0, v1, v2, v3, v4
    out[5], out[6], out[7], out[8], out[9] = v5, v6, v7, v8, v9


@jit_inlined
def carry(t, mode, level, entries, u, out):
    """Write u after so many entries of a level."""
    if entries == 0:
        for i in range(COLUMNS):
            out[i] = u[i]
    else:
        apply(t.columns[mode, level, entries - 1], u, out)


@jit_inlined
def reach_of(t, u):
    """How far the motion may go within a period."""
    return abs(u[0]) + abs(u[1]) + t.period * (abs(u[2]) + abs(u[3]))


@jit_inlined
def extent_of(u):
    """Sum of the displacements, by which rounding is judged."""
    return abs(u[0]) + abs(u[1])


@jit_inlined
def find_steps(t, mode, us, touch):
    """Coarse and single entries of the skip from us[0], and whether the gap is on the other side after its last step.

    us[1] and us[2] become u after the former and the latter. ``touch``: ξ₂ − ξ₁ where the bodies touch, by which
    rounding is judged.
    """
    u, least = us[0], us[LEAST]
    deciding = t.deciding[mode]
    noise = CERTAIN * (extent_of(u) + abs(touch))
    for r in range(t.counts[mode]):
        least[r] = noise * t.sizes[mode, r]
    if not (reach_of(t, u) < FAR and first_step_stays(t, mode, deciding, u, least)):
        return 0, 0, False
    coarse, fine, turns, most = coarse_entries(t, mode, u, least), 0, False, ENTRIES
    if coarse == NOT_YET:
        coarse, most = 0, CHUNK
    carry(t, mode, 1, coarse, u, us[1])
    if coarse < ENTRIES and (coarse == 0 or first_step_stays(t, mode, deciding, us[1], least)):
        fine = steps_of_rows(t, mode, t.sought[mode], us[1], least, most)
        if deciding < t.counts[mode]:
            gaps, within = t.rows[mode, deciding, 0], fine
            fine = steps_above(gaps, us[1], least[deciding], within)
            # the step at whose end the gap is on the other side is of this mode, too
            if fine < within:
                turns = dot(gaps[fine // CHUNK, :, fine % CHUNK], us[1]) < -least[deciding]
                for r in range(t.sought[mode], deciding):
                    row = t.rows[mode, r, 0, fine // CHUNK, :, fine % CHUNK]
                    turns = turns and dot(row, us[1]) > least[r]
                fine += int(turns)
    carry(t, mode, 0, fine, us[1], us[2])
    return (coarse, fine, turns) if reach_of(t, us[2]) < FAR else (0, 0, False)


@jit_inlined
def impulse_of(t, mode, coarse, fine, us):
    """Δτ Σλ over the steps of a skip."""
    total = dot(t.impulses[mode, 1, coarse - 1], us[0]) if coarse > 0 else 0.0
    return total + (dot(t.impulses[mode, 0, fine - 1], us[1]) if fine > 0 else 0.0)


@jit_inlined
def write_u_at(t, mode, steps, coarse, us):
    """Write u after so many steps of a skip to us[AFTER]."""
    entries = min(steps // t.strides[mode], coarse) if coarse > 0 else 0
    carry(t, mode, 1, entries, us[0], us[3])
    carry(t, mode, 0, steps - entries * t.strides[mode], us[3], us[AFTER])


WORK_ROWS = 9  # of the work space: three for a step, five u, and one of least values


class Skip(NamedTuple):
    """What :func:`find_steps` says of the next steps."""

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
def write_state(u, out):
    """Write the state of a u."""
    for i in range(STATE_ROWS):
        out[i] = u[i]


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
    (window, buffers), u, reached = record, us[AFTER], at.step + skip.steps
    sampled, end = buffers.samples.shape[0] > 0, min(reached, stop)
    i = next_output(at.step, n, window, sampled)
    while i <= end:
        if i > window[0] or i == window[1]:
            pressed = (skip.mode != FREE) != (skip.turns and i == reached)
            write_u_at(t, skip.mode, i - at.step, skip.coarse, us)
            now, push = motion_of(m, u), force_at(m, u, pressed, at.contact)
            if i > window[0]:
                write_output(i, i % n, n, now, push, window, buffers)
            elif sampled:
                write_sample(buffers.samples[0], now, push)
        i = next_output(i, n, window, sampled)


@jit_inlined
def motion_at(m, t, skip, steps, us):
    """The motion after so many steps of a skip, and g."""
    write_u_at(t, skip.mode, steps, skip.coarse, us)
    return motion_of(m, us[AFTER]), us[AFTER, 1]


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
        end_contact(m.system, contact, at.step + last, now, us[AFTER, FORCE], buffers)
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
    u, at, recorded = s.u, s.progress, buffers.contacts.shape[0] > 0
    write_first_sample(m, u, at, window, buffers)
    mode, k = FREE, at.step % n
    while at.step < stop and code == OK:
        begin_step(us[0], u, angles[0, k], angles[1, k])
        skip = next_skip(m, t, mode, at, us)
        mode = skip.mode
        if skip.steps == 0:
            at, code = advance(m, angles, u, at, work, window, buffers)
            k = k + 1 if k + 1 < n else 0
            continue
        reached, k = at.step + skip.steps, k + skip.steps if k + skip.steps < n else (k + skip.steps) % n
        if recorded:
            write_skipped(m, t, skip, n, at, stop, us, (window, buffers))
        if reached >= stop:
            break
        contact = contact_after(m, t, skip, at, us, (window, buffers))
        write_state(us[2], u)
        at = StepProgress(t.statuses[mode], (mode != FREE) != skip.turns, reached, at.none, at.two, contact)
        code = FULL if recorded and no_room(buffers) else OK
        if skip.turns or not may_go_on(skip):
            mode = mode + 1 if mode + 1 < t.counts.shape[0] else FREE
    write_progress(state, at)
    return code
