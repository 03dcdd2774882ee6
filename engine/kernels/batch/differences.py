"""Differences between the motion of each cell, the same without a time step, and a cycle of the reference.

The displacements of a cell are sampled over some periods and compared at once: they would fill the memory. See
:mod:`engine.sweeps.errors` for what the differences say.
"""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.batch.course import NO_ORIGIN, RECURRENCE, close, integrate_to
from vibroscope.engine.kernels.batch.run import BatchCells, BatchPlan, WorkSpace, prepare
from vibroscope.engine.kernels.compile.options import jit, jit_no_alloc
from vibroscope.engine.kernels.compile.record import unpack_buffers
from vibroscope.engine.kernels.status import OK, WITHDRAWN

ALONE, OWN_LIMIT, BESIDE = range(3)  # parts of a difference: none; of a motion without a time step; of both motions
TOTAL, TIME_STEP, REGULARISATION, DIFFERENCES = range(4)


class Sampled(NamedTuple):
    """A motion of each cell; the work space has buffers with samples for ``plan.sample`` periods."""

    cells: BatchCells
    plan: BatchPlan
    work: WorkSpace
    recurs: np.ndarray  # (n, 2) int64 periods after which its section and its state repeat themselves; 0: they do not
    room: np.ndarray  # (periods, m, 2) work space for ξ₁ and ξ₂ of a cell


class Cycles(NamedTuple):
    """ξ₁ and ξ₂ over a cycle of the reference, with the joint damping as measured and as derived."""

    table: np.ndarray  # (p, m, 2)
    derived: np.ndarray


@jit
def sample_cell(motion, i, signals):
    """Write ξ₁ and ξ₂ of cell i to ``motion.room``.

    Returns the status, and the periods after which what is written repeats itself: all of them, if it does not.
    """
    work, plan, out, start = motion.work, motion.plan, motion.room, motion.cells.initial[i]
    grid = prepare(work, motion.cells, plan, i, start)
    period, cycle = motion.recurs[i]
    shortest = period if 0 < period <= cycle and cycle % period == 0 else cycle
    distinct = shortest if 0 < shortest < out.shape[0] else out.shape[0]
    record = work.sample, NO_ORIGIN
    status = integrate_to(work, plan, grid, distinct, work.log, record, signals)
    if status == OK and distinct < min(cycle, out.shape[0]) and not has_returned(record, start, distinct):
        distinct = min(cycle, out.shape[0])
        status = integrate_to(work, plan, grid, distinct, work.log, record, signals)
    buffers = unpack_buffers(work.sample[0], work.sample[1])
    buffers.used[0] = buffers.used[1] = 0
    for j in range(distinct):
        first = j * out.shape[1]
        for k in range(out.shape[1]):
            out[j, k, 0], out[j, k, 1] = buffers.samples[first + k, 0], buffers.samples[first + k, 2]
    return status, distinct


@jit_no_alloc
def has_returned(record, start, periods):
    """Whether the section is after so many periods where it was at the start."""
    (flat, sizes), _ = record
    row = unpack_buffers(flat, sizes).section[periods - 1]
    allowed = RECURRENCE * (abs(row[0]) + abs(row[1]) + abs(row[2]) + abs(row[3]))
    same = close(row[0], start[0], allowed) and close(row[1], start[1], allowed)
    return same and close(row[2], start[2], allowed) and close(row[3], start[3], allowed)


@jit_no_alloc
def least_difference(one, other, periods, shifts):
    """Root mean square of the difference of two motions that begins with a period 0 … ``shifts`` − 1 of the other.

    The closest of these counts. ``one``, ``other``: ξ₁ and ξ₂, (n, m, 2), and the first periods of these after which
    they repeat themselves; ``periods``: those over which the mean is taken, a multiple of ``shifts``.
    """
    (a, a_repeats), (b, b_repeats) = one, other
    if shifts % a_repeats == 0 and shifts % b_repeats == 0:
        periods = shifts  # what follows is the same again
    least = math.inf
    for shift in range(shifts):
        total = 0.0
        for j in range(periods):
            later = j + shift if j + shift < periods else j + shift - periods
            x, y = a[j % a_repeats], b[later % b_repeats]
            for k in range(x.shape[0]):
                total += (x[k, 0] - y[k, 0]) ** 2 + (x[k, 1] - y[k, 1]) ** 2
        least = min(least, total)
    return math.sqrt(least / (periods * a.shape[1] * 2))


@jit_no_alloc
def write_differences(penalty, limit, parts, cycles, periods, out):
    """Write the differences of a cell over some periods, a multiple of those of the reference's cycle.

    ``penalty``, ``limit``: ξ₁ and ξ₂, (n, m, 2), and the periods after which they repeat themselves; ``parts``: ALONE,
    OWN_LIMIT or BESIDE.
    """
    shifts = cycles.table.shape[0]
    table, derived = (cycles.table, shifts), (cycles.derived, cycles.derived.shape[0])
    out[TOTAL] = least_difference(penalty, table, periods, shifts)
    if parts == BESIDE:
        out[TIME_STEP] = least_difference(penalty, limit, periods, shifts)
        out[REGULARISATION] = least_difference(limit, derived, periods, shifts)
    elif parts == OWN_LIMIT:
        out[TIME_STEP], out[REGULARISATION] = 0.0, least_difference(penalty, derived, periods, shifts)


@jit
def compare_cells(penalty, limit, places, parts, cycles, out, signals, slot):
    """Compare the cells from the first of ``places`` to the one before the second with the reference.

    Parameters
    ----------
    penalty, limit : Sampled
        The motions with and without a time step; the latter is run where ``parts`` is BESIDE.
    places : (int, int)
    parts : (n,) int64
        ALONE, OWN_LIMIT or BESIDE.
    cycles : Cycles
    out : (n, DIFFERENCES) float64
        Root mean squares; nan stays where a cell ends early.
    signals : (1 + threads,) int64
        ``signals[0]`` is set to withdraw the call; ``signals[slot]`` counts the cells done.
    slot : int
    """
    for i in range(places[0], places[1]):
        periods, beside, kind = penalty.room.shape[0], OK, parts[i]
        status, own_repeats = sample_cell(penalty, i, signals)
        limit_repeats = own_repeats
        if status == OK and kind == BESIDE:
            beside, limit_repeats = sample_cell(limit, i, signals)
            kind = BESIDE if beside == OK else ALONE
        if status == WITHDRAWN or beside == WITHDRAWN:
            return
        if status == OK:
            write_differences((penalty.room, own_repeats), (limit.room, limit_repeats), kind, cycles, periods, out[i])
        signals[slot] += 1
