"""Cells that are run until it is known which motion they tend to: until their section enters a trapping region.

A trapping region is an ellipsoid around a point of a known cycle from which no motion returns
(:mod:`engine.motions.trapping`). The plain twin is :func:`.run.run_cells` with a long transient
(`tests/engine/test_basin_twin.py`).
"""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.batch.course import integrate_to
from vibroscope.engine.kernels.batch.run import BatchCells, begin, set_up
from vibroscope.engine.kernels.compile.options import jit, jit_no_alloc
from vibroscope.engine.kernels.compile.record import unpack_buffers
from vibroscope.engine.kernels.event_driven.state import HybridState, unpack_state
from vibroscope.engine.kernels.event_driven.state import write_state as write_event_state
from vibroscope.engine.kernels.parameters import unpack_parameters
from vibroscope.engine.kernels.status import OK, WITHDRAWN

NO_TRAP = -1


class Traps(NamedTuple):
    """Trapping regions: x lies in region j if |factors[j] (x − centres[j])| ≤ 1, x being a row of the section."""

    centres: np.ndarray  # (m, 4)
    factors: np.ndarray  # (m, 4, 4)


class LateCells(NamedTuple):
    """Cells, and when each of them begins in its first period."""

    cells: BatchCells
    taus: np.ndarray  # (n,)


class Settled(NamedTuple):
    """What becomes of the cells."""

    status: np.ndarray  # (n,) int64
    trap: np.ndarray  # (n,) int64 index of the trapping region, or NO_TRAP
    periods: np.ndarray  # (n,) int64 that were run, up to the section in the region
    end: np.ndarray  # (n, 4) that section; without a region the last one


@jit_no_alloc
def trap_of(traps, x):
    """Index of the trapping region that holds a row of the section; NO_TRAP if none does."""
    for j in range(traps.centres.shape[0]):
        distance = 0.0
        for row in range(4):
            part = 0.0
            for k in range(4):
                part += traps.factors[j, row, k] * (x[k] - traps.centres[j, k])
            distance += part * part
        if distance <= 1.0:
            return j
    return NO_TRAP


@jit
def begin_later(work, plan, p, start, tau):
    """Write the solver's state at τ = ``tau`` of the first period; later than 0 for event-driven solvers alone."""
    begin(work, plan, p, start)
    if tau > 0.0:
        a = unpack_state(work.state)
        later = HybridState(a.period, tau, a.x1, a.v1, a.gap, a.rate, a.mode, a.order, a.events, a.contact)
        write_event_state(work.state, later)


@jit
def settle(work, plan, p, traps, signals, end):
    """Integrate ``plan.sample`` periods at a time, ``plan.transient`` at most, until a section lies in a region.

    Writes that section, or the last one, to ``end``; returns the status, the periods and the index of the region.
    """
    done = 0
    while done < plan.transient:
        origin = done
        done = min(done + plan.sample, plan.transient)
        record = (work.cycle, work.cycle_sizes, origin)
        status = integrate_to(work, plan, p, done, work.cycle_log, record, signals)
        if status != OK:
            return status, done, NO_TRAP
        buffers = unpack_buffers(work.cycle, work.cycle_sizes)
        buffers.used[0] = buffers.used[1] = 0
        for k in range(done - origin):
            trap = trap_of(traps, buffers.section[k])
            if trap != NO_TRAP or origin + k + 1 == plan.transient:
                end[:] = buffers.section[k]
            if trap != NO_TRAP:
                return OK, origin + k + 1, trap
    return OK, done, NO_TRAP


@jit
def settle_cells(late, places, plan, traps, work, results, signals, slot):
    """Run the cells at some places of the order, one after the other.

    Parameters
    ----------
    late : LateCells
    places : (int, int)
        First place, and the one after the last.
    plan : BatchPlan
        Its ``transient``: most periods of a cell; its ``sample``: periods between two looks at the section, CYCLE at
        most.
    traps : Traps
    work : WorkSpace
    results : Settled
    signals : (1 + threads,) int64
        ``signals[0]`` is set to withdraw the call; ``signals[slot]`` counts the cells done.
    slot : int
    """
    cells = late.cells
    for place in range(places[0], places[1]):
        i = cells.order[place]
        p = unpack_parameters(cells.parameters[i])
        set_up(work, cells, plan, i)
        begin_later(work, plan, p, cells.initial[i], late.taus[i])
        status, periods, trap = settle(work, plan, p, traps, signals, results.end[i])
        if status == WITHDRAWN:
            return
        results.status[i], results.periods[i], results.trap[i] = status, periods, trap
        signals[slot] += 1
