"""Many cells in one call, each from its parameters to its description, without a return to Python."""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels import section_statistics as statistics
from vibroscope.engine.kernels.accelerated.step_map import set_up_skipping
from vibroscope.engine.kernels.batch.course import REFERENCE, SKIPPING, run_cell
from vibroscope.engine.kernels.compile.options import jit, jit_no_alloc
from vibroscope.engine.kernels.equations.coordinates import contact_coordinates
from vibroscope.engine.kernels.event_driven.setup import set_up_events
from vibroscope.engine.kernels.event_driven.state import start_state, unpack_system
from vibroscope.engine.kernels.event_driven.state import write_state as write_event_state
from vibroscope.engine.kernels.parameters import unpack_parameters
from vibroscope.engine.kernels.status import OK, WITHDRAWN
from vibroscope.engine.kernels.time_stepping.newmark import scheme_of
from vibroscope.engine.kernels.time_stepping.newmark import start_state as step_start_state
from vibroscope.engine.kernels.time_stepping.newmark import write_state as write_step_state


class BatchPlan(NamedTuple):
    """What is the same for all cells of a call."""

    kind: int  # REFERENCE, EXACT or SKIPPING
    transient: int
    sample: int
    recurrence: float  # share of the size of a state within which it is that of a cycle before; 0: no cell stops early
    coordinates: np.ndarray  # (c,) int64
    completion: float  # of a chatter (engine.drivers.event_driven)


class BatchCells(NamedTuple):
    """The cells, as arrays with an entry each, and the order in which they are run."""

    order: np.ndarray  # (n,) int64
    chained: np.ndarray  # (n,) bool, by place in the order: starts from the end of the one before
    parameters: np.ndarray  # (n, len(Parameters))
    initial: np.ndarray  # (n, 4)
    circles: np.ndarray  # (n, 2) between slow and fast eigenvalues in contact (engine.drivers.slow_subspace)


class BatchResults(NamedTuple):
    """What becomes of the cells."""

    status: np.ndarray  # (n,) int64
    section: np.ndarray  # (n, sample, c)
    numbers: np.ndarray  # (n, section_statistics.NUMBERS)
    end: np.ndarray  # (n, 4)
    periods: np.ndarray  # (n,) int64


class WorkSpace(NamedTuple):
    """What one thread works in. Packed buffers are for nothing, for a cycle and for a sample."""

    packed: np.ndarray
    keys: np.ndarray  # (2, len(Parameters)) the parameters that the tables in it are made for
    state: np.ndarray
    before: np.ndarray  # the state a cycle ago
    nothing: np.ndarray
    no_sizes: np.ndarray
    cycle: np.ndarray
    cycle_sizes: np.ndarray
    sample: np.ndarray
    sample_sizes: np.ndarray
    cycle_log: np.ndarray  # (CYCLE, section_statistics.COLUMNS)
    log: np.ndarray  # (sample, section_statistics.COLUMNS)


@jit
def set_up(work, cells, plan, i):
    """Tables of cell i."""
    row = cells.parameters[i]
    if plan.kind == SKIPPING:
        set_up_skipping(work.packed, work.keys, row)
    else:
        set_up_events(work.packed, work.keys, row, plan.kind == REFERENCE, cells.circles[i], plan.completion)


@jit
def begin(work, plan, p, start):
    """Write the solver's state at τ = 0."""
    if plan.kind == SKIPPING:
        write_step_state(work.state, step_start_state(scheme_of(p), p, start))
    else:
        system = unpack_system(work.packed)
        x1, v1, gap, rate = contact_coordinates(system, start[0], start[1], start[2], start[3])
        if plan.kind == REFERENCE:  # not even by rounding
            gap = max(gap, 0.0)
        write_event_state(work.state, start_state(system, (x1, v1, gap, rate)))


@jit
def run_cells(cells, places, plan, work, results, signals, slot):
    """Run the cells at some places of the order, one after the other.

    Parameters
    ----------
    cells : BatchCells
    places : (int, int)
        First place, and the one after the last.
    plan : BatchPlan
    work : WorkSpace
    results : BatchResults
    signals : (1 + threads,) int64
        ``signals[0]`` is set to withdraw the call; ``signals[slot]`` counts the cells done.
    slot : int
    """
    for place in range(places[0], places[1]):
        i, before = cells.order[place], cells.order[place - 1]
        p = unpack_parameters(cells.parameters[i])
        set_up(work, cells, plan, i)
        goes_on = cells.chained[place] and results.status[before] == OK
        begin(work, plan, p, results.end[before] if goes_on else cells.initial[i])
        status, periods = run_cell(work, plan, p, signals)
        if status == WITHDRAWN:
            return
        results.status[i], results.periods[i] = status, periods
        if status == OK:
            describe_cell(work, plan, p, results, i)
        signals[slot] += 1


@jit_no_alloc
def describe_cell(work, plan, p, results, i):
    """Write the description, the section and the end of a cell from its log."""
    log = work.log
    statistics.describe(log, plan.sample, -1, 2 - int(p.wall), results.numbers[i])
    for j in range(plan.sample):
        for c in range(plan.coordinates.size):
            results.section[i, j, c] = log[j, statistics.SECTION + plan.coordinates[c]]
    for c in range(4):
        results.end[i, c] = log[plan.sample - 1, statistics.SECTION + c]
