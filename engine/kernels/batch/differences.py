"""Differences between the motion of each cell, the same without a time step, and a cycle of the reference.

The displacements of a cell are sampled over some periods and compared at once: they would fill the memory. See
:mod:`engine.sweeps.errors` for what the differences say.
"""

import math
from typing import NamedTuple

import numpy as np

from ..compile.options import jit, jit_no_alloc
from ..compile.record import unpack_buffers
from ..parameters import unpack_parameters
from ..status import OK, WITHDRAWN
from .course import NO_ORIGIN, log_periods
from .recurrence import CYCLE
from .run import BatchCells, BatchPlan, WorkSpace, begin, set_up

ALONE, OWN_LIMIT, BESIDE = range(3)  # parts of a difference: none; of a motion without a time step; of both motions
TOTAL, TIME_STEP, REGULARISATION, DIFFERENCES = range(4)


class Sampled(NamedTuple):
    """A motion of each cell; the work space has buffers with samples, for a cycle and for ``plan.sample`` periods."""

    cells: BatchCells
    plan: BatchPlan
    work: WorkSpace
    recurs: np.ndarray  # (n,) bool: the motion repeats itself after CYCLE periods


class Cycles(NamedTuple):
    """ξ₁ and ξ₂ over a cycle of the reference, with the joint damping as measured and as derived."""

    table: np.ndarray  # (p, m, 2)
    derived: np.ndarray


@jit
def sample_cell(motion, i, out, signals):
    """Write ξ₁ and ξ₂ of cell i to ``out``, (periods, m, 2); returns the status."""
    work, plan = motion.work, motion.plan
    p = unpack_parameters(motion.cells.parameters[i])
    set_up(work, motion.cells, plan, i)
    begin(work, plan, p, motion.cells.initial[i])
    flat, sizes = work.sample, work.sample_sizes
    if motion.recurs[i] and plan.sample > CYCLE:
        flat, sizes = work.cycle, work.cycle_sizes
    status = log_periods(work, plan, p, work.log, (flat, sizes, NO_ORIGIN), signals)
    samples = unpack_buffers(flat, sizes).samples
    for j in range(out.shape[0]):
        first = j % sizes[0] * out.shape[1]
        for k in range(out.shape[1]):
            out[j, k, 0], out[j, k, 1] = samples[first + k, 0], samples[first + k, 2]
    return status


@jit_no_alloc
def least_difference(one, other, shifts):
    """Root mean square of ``one`` − ``other``, both (periods, m, 2), where ``other`` is repeated.

    It begins with its period 0 … shifts − 1, whichever is closest.
    """
    least = math.inf
    for shift in range(shifts):
        total = 0.0
        for j in range(one.shape[0]):
            a, b = one[j], other[(j + shift) % other.shape[0]]
            for k in range(one.shape[1]):
                total += (a[k, 0] - b[k, 0]) ** 2 + (a[k, 1] - b[k, 1]) ** 2
        least = min(least, total)
    return math.sqrt(least / one.size)


@jit_no_alloc
def write_differences(penalty, limit, parts, cycles, out):
    """Write the differences of a cell from its samples; ``parts``: ALONE, OWN_LIMIT or BESIDE."""
    shifts = cycles.table.shape[0]
    out[TOTAL] = least_difference(penalty, cycles.table, shifts)
    if parts == BESIDE:
        out[TIME_STEP] = least_difference(penalty, limit, shifts)
        out[REGULARISATION] = least_difference(limit, cycles.derived, shifts)
    elif parts == OWN_LIMIT:
        out[TIME_STEP], out[REGULARISATION] = 0.0, least_difference(penalty, cycles.derived, shifts)


@jit
def compare_cells(penalty, limit, room, places, parts, cycles, out, signals, slot):
    """Compare the cells from the first of ``places`` to the one before the second with the reference.

    Parameters
    ----------
    penalty, limit : Sampled
        The motions with and without a time step; the latter is run where ``parts`` is BESIDE.
    room : (2, periods, m, 2) float64
        Work space for the samples.
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
        status, beside, kind = sample_cell(penalty, i, room[0], signals), OK, parts[i]
        if status == OK and kind == BESIDE:
            beside = sample_cell(limit, i, room[1], signals)
            kind = BESIDE if beside == OK else ALONE
        if status == WITHDRAWN or beside == WITHDRAWN:
            return
        if status == OK:
            write_differences(room[0], room[1], kind, cycles, out[i])
        signals[slot] += 1
