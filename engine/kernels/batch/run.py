"""Many cells in one call, each from its parameters to its description, without a return to Python.

The growth of a small disturbance along the motion of each cell (:mod:`..event_driven.disturbance`).

Cells that are run until it is known which motion they tend to: until their section enters a trapping region.

A trapping region is an ellipsoid around a point of a known cycle from which no motion returns
(:mod:`engine.motions.trapping`). The plain twin is :func:`.run.run_cells` with a long transient
(`tests/engine/test_basin_twin.py`).
"""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels import section_statistics as statistics
from vibroscope.engine.kernels.accelerated.step_map import set_up_skipping
from vibroscope.engine.kernels.batch.course import REFERENCE, SKIPPING, integrate_to, run_cell
from vibroscope.engine.kernels.compile.options import jit, jit_no_alloc
from vibroscope.engine.kernels.compile.record import unpack_buffers
from vibroscope.engine.kernels.equations.motion import contact_coordinates, displacements
from vibroscope.engine.kernels.event_driven.disturbance import follow_disturbance
from vibroscope.engine.kernels.event_driven.saltation import Variation
from vibroscope.engine.kernels.event_driven.setup import set_up_events
from vibroscope.engine.kernels.event_driven.state import HybridState, start_state, unpack_state, unpack_system
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
    circles: np.ndarray  # (n, 2) between slow and fast eigenvalues in contact (engine.drivers.event_driven)


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


PERIODS_A_LOOK = 512  # periods between two looks at whether the call is withdrawn: some milliseconds


class FollowSpace(NamedTuple):
    """What one thread works in."""

    work: WorkSpace
    variation: Variation  # of one number
    ends: np.ndarray  # (2, 4) the state and the disturbance


@jit
def follow_pieces(space, growth, section, signals):
    """Follow a disturbance as :func:`follow_disturbance` does, to the end or until the call is withdrawn (False)."""
    work, y, direction = space.work, space.ends[0], space.ends[1]
    growth[:] = math.nan
    for begin in range(0, growth.shape[0], PERIODS_A_LOOK):
        if signals[0] != 0:
            return False
        end, nothing = min(begin + PERIODS_A_LOOK, growth.shape[0]), (work.nothing, work.no_sizes)
        rows = growth[begin:end], section[begin:end]
        follow_disturbance(work.packed, work.state, space.variation, nothing, y, direction, rows[0], rows[1])
        if math.isnan(growth[end - 1]):
            break
    return True


@jit
def follow_cell(cells, i, plan, space, settling, growth, section, signals):
    """Follow the motion of one cell, and a disturbance of it; False if the call was withdrawn.

    Parameters
    ----------
    cells : BatchCells
    i : int
    plan : BatchPlan
        Of the reference or the exact penalty method.
    space : FollowSpace
    settling : int
        Periods before those of ``growth``, and at most as many, in which the disturbance turns into the direction of
        fastest growth.
    growth : (n,) float64
        ln of the growth in each period: −∞ where nothing is left of the disturbance; nan from the period on that ends
        early or has no derivative.
    section : (n, 4) float64
        ξ₁, ξ₁′, ξ₂, ξ₂′ at the end of each period.
    signals : (n,) int64
        ``signals[0]`` is set to withdraw the call.
    """
    set_up(space.work, cells, plan, i)
    system, start = unpack_system(space.work.packed), cells.initial[i]
    y, direction = space.ends[0], space.ends[1]
    y[0], y[1], y[2], y[3] = contact_coordinates(system, start[0], start[1], start[2], start[3])
    direction[:] = 0.5
    before = growth[:settling]
    if not follow_pieces(space, before, section[:settling], signals):
        return False
    if math.isnan(before[settling - 1]):
        growth[:] = math.nan
        return True
    if not follow_pieces(space, growth, section, signals):
        return False
    for n in range(growth.shape[0]):
        x = section[n]
        x[0], x[1], x[2], x[3] = displacements(system, x[0], x[1], x[2], x[3])
    return True


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
