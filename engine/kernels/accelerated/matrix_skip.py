"""Skips of the one-step methods whose step is a matrix: the steps of the plain loop, without taking each of them.

A *mode* is a contact status that stays: flight, contact, or the contact of a law that is cut where its force would
pull. As long as it stays, a step maps

    u = (ξ₁, g, ξ₁′, g′, ξ₁″, g″, λ, cos ητ₀, sin ητ₀, 1)

linearly, u → Φ u. Whatever the plain loop decides a step by is a row w times the u before the step: the gap at its end,
with the law that is cut the force, and with the status from the end both of them at the end of each stage with either
status. Given signs by which they are positive, these are the *watched rows* of the mode: while all of them are
positive, no step has another status, none has no solution or two, and contact does not change.

The values of a row at the ends of the next steps, or of every s-th of them, are the rows w Φʲ⁻¹ times one u. Where the
second differences of single steps, rows w(Φ − 1)²Φʲ⁻², are at most B, a row lies between two entries of the coarser
level no more than b = B s²/8 below its chord: where it exceeds b at both, the mode stays between them
(:mod:`.step_map`, with the same condition for the first interval). B is the supremum over all steps of the level, each
of which is formed when the tables are made (:mod:`engine.drivers.skip_tables`).

Of other laws the flight is such a mode, and contact is not: its force is solved for step by step. Their force at a
positive gap is zero, or that of :data:`..equations.contact_law.COMPRESSION`, which no end without contact that is open
allows to be closed with contact: λ = −Kg + c max(v, 0) would not be negative there, as it must be to close the gap. So
the ends without contact are watched alone.

Single steps are skipped by the sign of the rows. A skip ends before the first step of which a row is not positive, or
so near to zero that rounding could change its sign; the plain loop's own step follows.

At a wall ξ₁ with its derivatives is zero. Where λ follows from g and g′, too (:mod:`.located_skip`), six numbers are
left,

    u = (g, g′, g″, cos ητ₀, sin ητ₀, 1).

Plain twin: :func:`..time_stepping.linear_step.integrate_linear` (tests/engine/kernels/test_matrix_skip.py).
"""

from typing import NamedTuple

import numpy as np

from ..compile.options import jit_inlined, jit_no_alloc
from ..compile.record import with_impulse
from ..status import OK
from ..time_stepping.linear_step import (
    COLUMNS,
    StepProgress,
    advance,
    motion_of,
    unpack_state,
    write_first_sample,
    write_progress,
)
from ..time_stepping.newmark import next_output, write_output, write_sample
from .certificate import CERTAIN, CHUNK, FAR
from .step_map import ENTRIES

FREE, PRESSED, PULLED = range(3)  # modes; PULLED: the gap is closed, and the force would pull
MODES, LEVELS = 3, 2
WORK_ROWS = 10  # of the work space: three for a step, five u, one of least values, and one y
LEAST = 5  # row of the work space of a skip: what each watched row must exceed
UNLIMITED = 1 << 62
ALONE = 6  # numbers of u at a wall
WORTHWHILE = 2 * CHUNK  # steps that a skip by the coarser level has at least


class SkipTables(NamedTuple):
    """What many steps of each mode do; R is the largest number of watched rows. At a wall COLUMNS stands for ALONE."""

    rows: np.ndarray  # (MODES, R, LEVELS, COLUMNS, ENTRIES) watched rows after 1 … ENTRIES strides
    firsts: np.ndarray  # (MODES, R, LEVELS, COLUMNS) the same after one stride
    bounds: np.ndarray  # (MODES, R, COLUMNS) b between entries of the coarser level
    sizes: np.ndarray  # (MODES, R) of a row, in units of a displacement
    counts: np.ndarray  # (MODES,) int64 watched rows; 0 where no step is skipped
    strides: np.ndarray  # (MODES,) int64 steps from entry to entry of the coarser level, 0 if there is none
    columns: np.ndarray  # (MODES, LEVELS, ENTRIES, COLUMNS, COLUMNS) those of Φ, Φ², … and Φˢ, Φ²ˢ, …
    impulses: np.ndarray  # (MODES, LEVELS, ENTRIES, COLUMNS) Δτ Σλ over the steps up to each entry
    begins: np.ndarray  # (MODES, R, COLUMNS) what the rows watch, at the beginning; none where dips do not count
    dips: np.ndarray  # the same shape: how far it may fall within a step
    rates: np.ndarray  # (COLUMNS, CHUNK) g′ of a flight at the beginning of each step; none where dips do not count
    period: float  # of the excitation
    wall: tuple | None  # AT_WALL where u has ALONE numbers, else TWO_BODIES (see ..parameters)


@jit_inlined
def mode_of(t, at_end, at):
    """The mode that the next steps may have, by the status of the last one."""
    if not at.pressed:
        return FREE if at.status == 0 or not at_end else -1
    if at.status == 0 and t.counts[PULLED] > 0:
        return PULLED
    return PRESSED if at.status == 1 or not at_end else -1


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
def columns_of(wall):
    """Numbers of u."""
    return ALONE if wall else COLUMNS


@jit_inlined
def dot(row, u, wall):
    """A row, or a column of a table, times u."""
    value = 0.0
    for i in range(columns_of(wall)):
        value += row[i] * u[i]
    return value


@jit_no_alloc
def steps_above_of_two(rows, u, bound, most):
    """As :func:`steps_above`, of two bodies."""
    u0, u1, u2, u3, u4, u5, u6, u7, u8, u9 = u[0], u[1], u[2], u[3], u[4], u[5], u[6], u[7], u[8], u[9]
    for begin in range(0, most, CHUNK):
        end, first = begin + CHUNK, CHUNK
        r0, r1, r2, r3 = rows[0, begin:end], rows[1, begin:end], rows[2, begin:end], rows[3, begin:end]
        r4, r5, r6, r7 = rows[4, begin:end], rows[5, begin:end], rows[6, begin:end], rows[7, begin:end]
        r8, r9 = rows[8, begin:end], rows[9, begin:end]
        for j in range(CHUNK):  # without a branch: vector instructions
            value = (r0[j] * u0 + r1[j] * u1 + r2[j] * u2) + (r3[j] * u3 + r4[j] * u4 + r5[j] * u5)
            value += (r6[j] * u6 + r7[j] * u7) + (r8[j] * u8 + r9[j] * u9)
            first = min(first, CHUNK if value > bound else j)
        if first < CHUNK:
            return min(most, begin + first)
    return most


@jit_no_alloc
def steps_above_at_wall(rows, u, bound, most):
    """As :func:`steps_above`, of one body at a wall."""
    u0, u1, u2, u3, u4, u5 = u[0], u[1], u[2], u[3], u[4], u[5]
    for begin in range(0, most, CHUNK):
        end, first = begin + CHUNK, np.int32(CHUNK)
        r0, r1, r2 = rows[0, begin:end], rows[1, begin:end], rows[2, begin:end]
        r3, r4, r5 = rows[3, begin:end], rows[4, begin:end], rows[5, begin:end]
        # without a branch, and with indices of half the size: fewer vector instructions
        for j in range(CHUNK):
            value = (r0[j] * u0 + r1[j] * u1) + (r2[j] * u2 + r3[j] * u3) + (r4[j] * u4 + r5[j] * u5)
            first = min(first, np.int32(CHUNK) if value > bound else np.int32(j))
        if first < CHUNK:
            return min(most, begin + int(first))
    return most


@jit_inlined
def steps_above(rows, u, bound, most, wall):
    """Entries, at most so many, before the first whose row times u does not exceed the bound."""
    if wall:
        return steps_above_at_wall(rows, u, bound, most)
    return steps_above_of_two(rows, u, bound, most)


@jit_inlined
def bound_of(row, u, wall):
    """A row of bounds times |u|."""
    value = 0.0
    for i in range(columns_of(wall)):
        value += row[i] * abs(u[i])
    return value


@jit_inlined
def coarse_entries(t, mode, u, least):
    """Entries of the coarser level up to which the mode certainly stays; 0 where single steps do as well."""
    stride, entries = t.strides[mode], ENTRIES
    if stride == 0:
        return 0
    for r in range(t.counts[mode]):
        bound = bound_of(t.bounds[mode, r], u, t.wall)
        # a row that is small at the next step and grows to v at the first entry: the chord lies above its share of v,
        # and the row at most 4 times this share of the bound below the chord
        near, first = dot(t.firsts[mode, r, 0], u, t.wall), dot(t.firsts[mode, r, 1], u, t.wall)
        if not (near > bound + least[r] or (near > least[r] and first > 4.0 * bound + least[r])):
            return 0
        entries = steps_above(t.rows[mode, r, 1], u, bound + least[r], entries, t.wall)
        if entries * stride < WORTHWHILE:
            return 0
    return entries


@jit_inlined
def single_entries(t, mode, u, least):
    """Single steps before the first that may leave the mode."""
    for r in range(t.counts[mode]):
        if not dot(t.firsts[mode, r, 0], u, t.wall) > least[r]:
            return 0
    entries = ENTRIES
    for r in range(t.counts[mode]):
        entries = steps_above(t.rows[mode, r, 0], u, least[r], entries, t.wall)
    return entries


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


@jit_no_alloc
def apply_at_wall(columns, u, out):
    """The same at a wall."""
    v0, v1, v2, v3, v4, v5 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(ALONE):
        c, x = columns[j], u[j]
        v0, v1, v2 = v0 + c[0] * x, v1 + c[1] * x, v2 + c[2] * x
        v3, v4, v5 = v3 + c[3] * x, v4 + c[4] * x, v5 + c[5] * x
    out[0], out[1], out[2], out[3], out[4], out[5] = v0, v1, v2, v3, v4, v5


@jit_inlined
def carry(t, mode, level, entries, u, out):
    """Write u after so many entries of a level."""
    if entries == 0:
        for i in range(columns_of(t.wall)):
            out[i] = u[i]
    elif t.wall:
        apply_at_wall(t.columns[mode, level, entries - 1], u, out)
    else:
        apply(t.columns[mode, level, entries - 1], u, out)


@jit_inlined
def reach_of(t, u):
    """How far the motion may go within a period."""
    if t.wall:
        return abs(u[0]) + t.period * abs(u[1])
    return abs(u[0]) + abs(u[1]) + t.period * (abs(u[2]) + abs(u[3]))


@jit_inlined
def extent_of(t, u):
    """Sum of the displacements, by which rounding is judged."""
    return abs(u[0]) if t.wall else abs(u[0]) + abs(u[1])


@jit_inlined
def gap_rate_of(t, u):
    """g′."""
    return u[1] if t.wall else u[3]


@jit_inlined
def rising_steps(t, us, noise):
    """As :func:`find_skip`, of a flight whose first step ends within the dip: those at whose beginning it rises."""
    positive = steps_above(t.rows[FREE, 0, 0], us[0], noise, CHUNK, t.wall)
    steps = steps_above(t.rates, us[0], 0.0, positive, t.wall)
    carry(t, FREE, 0, steps, us[0], us[2])
    carry(t, FREE, 1, 0, us[0], us[1])
    return 0, steps


@jit_inlined
def find_skip(t, mode, us, touch, most):
    """Coarse and single entries of the skip from us[0]; us[1] and us[2] become u after the former and the latter.

    ``touch``: ξ₂ − ξ₁ where the bodies touch, by which rounding is judged; ``most``: steps that the mode may last.
    """
    u, least, stride, rises = us[0], us[LEAST], t.strides[mode], False
    if not reach_of(t, u) < FAR:
        return 0, 0
    noise = CERTAIN * (extent_of(t, u) + abs(touch))
    for r in range(t.counts[mode]):
        least[r] = noise * t.sizes[mode, r]
        if t.dips.shape[1] > 0:
            dip = bound_of(t.dips[mode, r], u, t.wall)
            if not dot(t.begins[mode, r], u, t.wall) > dip:
                rises = mode == FREE and gap_rate_of(t, u) > 0.0
                if not rises:
                    return 0, 0
            least[r] += dip
    if rises and not dot(t.firsts[FREE, 0, 0], u, t.wall) > least[0]:
        return rising_steps(t, us, noise)
    coarse = coarse_entries(t, mode, u, least)
    if coarse * stride > most:
        coarse = most // stride
    carry(t, mode, 1, coarse, u, us[1])
    fine = min(single_entries(t, mode, us[1], least), most - coarse * stride) if coarse < ENTRIES else 0
    carry(t, mode, 0, fine, us[1], us[2])
    return (coarse, fine) if reach_of(t, us[2]) < FAR else (0, 0)


@jit_inlined
def impulse_of(t, mode, coarse, fine, us):
    """Δτ Σλ over the steps of a skip."""
    total = dot(t.impulses[mode, 1, coarse - 1], us[0], t.wall) if coarse > 0 else 0.0
    return total + (dot(t.impulses[mode, 0, fine - 1], us[1], t.wall) if fine > 0 else 0.0)


@jit_inlined
def write_u_at(t, mode, steps, coarse, us):
    """Write u after so many steps of a skip to us[4]."""
    entries = min(steps // t.strides[mode], coarse) if coarse > 0 else 0
    carry(t, mode, 1, entries, us[0], us[3])
    carry(t, mode, 0, steps - entries * t.strides[mode], us[3], us[4])


@jit_no_alloc
def write_skipped(m, t, mode, n, at, coarse, end, us, y, window, buffers):
    """Write the section rows and samples of the steps at.step + 1 … end."""
    sampled = buffers.samples.shape[0] > 0
    i = next_output(at.step, n, window, sampled)
    while i <= end:
        if i > window[0] or i == window[1]:
            write_u_at(t, mode, i - at.step, coarse, us)
            write_state(m, us[4], y)
            if i > window[0]:
                write_output(m.system, i, i % n, n, motion_of(m, y), at.pressed, window, buffers)
            elif sampled:
                write_sample(m.system, buffers.samples[0], motion_of(m, y), at.pressed)
        i = next_output(i, n, window, sampled)


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
        A :class:`LinearState`, changed in place. Its ``step`` is the one from which the next call goes on: ``stop`` or,
        where a skip reaches beyond, the step before that skip.
    work : (WORK_ROWS, WORK) float64
        Work space.

    Returns
    -------
    int
        As there.
    """
    s, code, n, us = unpack_state(state), OK, angles.shape[1], work[3:9]
    y, at, recorded = s.y, s.progress, buffers.contacts.shape[0] > 0
    write_first_sample(m, n, y, at, window, buffers)
    while at.step < stop and code == OK:
        mode, coarse, fine = mode_of(t, m.at_end, at), 0, 0
        if mode >= 0 and t.counts[mode] > 0:
            k = at.step % n
            write_relative(m, y, angles[0, k], angles[1, k], us[0])
            coarse, fine = find_skip(t, mode, us, m.system.touch, UNLIMITED)
        if coarse + fine > 0:
            reached = at.step + coarse * t.strides[mode] + fine
            if recorded:
                write_skipped(m, t, mode, n, at, coarse, min(reached, stop), us, work[9], window, buffers)
            if reached >= stop:
                break
            contact = at.contact
            if recorded and mode == PRESSED:
                contact = with_impulse(contact, contact.impulse + impulse_of(t, mode, coarse, fine, us))
            write_state(m, us[2], y)
            at = StepProgress(int(mode == PRESSED), at.pressed, reached, at.none, at.two, contact)
        if max(coarse, fine) < ENTRIES:  # else the table has ended, and not the mode
            at, code = advance(m, angles, y, at, work, window, buffers)
    write_progress(state, at)
    return code
