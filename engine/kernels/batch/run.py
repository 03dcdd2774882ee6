"""Many cells in one call, each from its parameters to its description, without a return to Python.

The growth of a small disturbance along the motion of each cell (:mod:`..event_driven.disturbance`).
"""

import math
from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels import section_statistics as statistics
from vibroscope.engine.kernels.accelerated.step_map import set_up_skipping
from vibroscope.engine.kernels.batch.course import REFERENCE, SKIPPING, run_cell
from vibroscope.engine.kernels.compile.options import jit, jit_no_alloc
from vibroscope.engine.kernels.equations.motion import contact_coordinates, displacements
from vibroscope.engine.kernels.event_driven.disturbance import follow_disturbance
from vibroscope.engine.kernels.event_driven.saltation import Variation
from vibroscope.engine.kernels.event_driven.setup import set_up_events
from vibroscope.engine.kernels.event_driven.state import SEEN_FROM, STATE, unpack_state
from vibroscope.engine.kernels.event_driven.two_stops import from_first, write_start
from vibroscope.engine.kernels.parameters import unpack_parameters
from vibroscope.engine.kernels.status import OK, WITHDRAWN
from vibroscope.engine.kernels.time_stepping.newmark import write_start as write_step_start

write_tau = STATE.writer("tau")


class Traps(NamedTuple):
    """Trapping regions: x lies in region j if |factors[j] (x − centres[j])| ≤ 1, x being a row of the section."""

    centres: np.ndarray  # (m, 4)
    factors: np.ndarray  # (m, 4, 4)


class BatchPlan(NamedTuple):
    """What is the same for all cells of a call."""

    kind: int  # REFERENCE, EXACT or SKIPPING
    transient: int
    sample: int  # periods; 0: the cells end where their section lies in a trapping region, or with the transient
    recurrence: float  # share of its size within which a state is one of before; 0: no cell stops early
    coordinates: np.ndarray  # (c,) int64
    completion: float  # of a chatter (engine.drivers.event_driven)
    traps: Traps


class BatchCells(NamedTuple):
    """The cells, as arrays with an entry each, and the order in which they are run."""

    order: np.ndarray  # (n,) int64
    chained: np.ndarray  # (n,) bool, by place in the order: starts from the end of the one before
    parameters: np.ndarray  # (n, s, len(Parameters)) as seen from each stop: s is 2 if any cell has a second one
    initial: np.ndarray  # (n, 4)
    taus: np.ndarray  # (n,) at which each begins in its first period; 0 with a step
    circles: np.ndarray  # (n, s, 2) between slow and fast eigenvalues in contact (engine.drivers.event_driven)


class BatchResults(NamedTuple):
    """What becomes of the cells."""

    status: np.ndarray  # (n,) int64
    section: np.ndarray  # (n, sample, c)
    numbers: np.ndarray  # (n, section_statistics.NUMBERS)
    end: np.ndarray  # (n, 4) the last row of the section; without a sample that in a trapping region, if there is one
    periods: np.ndarray  # (n,) int64 that were run; without a sample up to the section in the region
    known: np.ndarray  # (n,) int64 index of the trapping region, or NO_TRAP
    cycle: np.ndarray  # (n,) int64 periods after which the state was seen to recur within ``recurrence``, or 0


class WorkSpace(NamedTuple):
    """What one thread works in. Packed buffers, (flat, sizes), are for nothing, for a cycle and for a sample."""

    packed: np.ndarray  # (s, …) as seen from each stop
    keys: np.ndarray  # (s, 2, len(Parameters)) the parameters that the tables in it are made for
    state: np.ndarray
    ends: np.ndarray  # (LAST, …) the state at the ends of the last pieces
    positions: np.ndarray  # (LAST,) ξ₁ of these
    nothing: tuple
    cycle: tuple
    sample: tuple
    cycle_log: np.ndarray  # (the longer of both, section_statistics.COLUMNS)
    log: np.ndarray  # (sample, section_statistics.COLUMNS)


@jit
def prepare(work, cells, plan, i, start):
    """Write the tables of cell i and the state in which it begins; returns T and its steps per period, 0 for none."""
    rows, rigid = cells.parameters[i], plan.kind == REFERENCE
    p = unpack_parameters(rows[0])
    if plan.kind == SKIPPING:
        for k in range(rows.shape[0]):
            set_up_skipping(work.packed[k], work.keys[k], rows[k])
        write_step_start(rows, work.state, start[0], start[1], start[2], start[3])
    else:
        for k in range(rows.shape[0]):
            set_up_events(work.packed[k], work.keys[k], rows[k], rigid, cells.circles[i, k], plan.completion)
        write_start(work.packed, work.state, contact_coordinates(p, start[0], start[1], start[2], start[3]))
        write_tau(work.state, cells.taus[i])
    return 2 * math.pi / p.eta, p.steps


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
        goes_on = cells.chained[place] and results.status[before] == OK
        grid = prepare(work, cells, plan, i, results.end[before] if goes_on else cells.initial[i])
        status, periods, known, cycle = run_cell(work, plan, grid, signals, results.end[i])
        if status == WITHDRAWN:
            return
        results.status[i], results.periods[i], results.known[i], results.cycle[i] = status, periods, known, cycle
        if status == OK and plan.sample > 0:
            describe_cell(work.log, plan, 2 - int(unpack_parameters(cells.parameters[i, 0]).wall), results, i)
        signals[slot] += 1


@jit_no_alloc
def describe_cell(log, plan, body, results, i):
    """Write the description, with scatters of one body, the section and the end of a cell from its log."""
    statistics.describe(log, plan.sample, -1, body, results.numbers[i])
    for j in range(plan.sample):
        for c in range(plan.coordinates.size):
            results.section[i, j, c] = log[j, statistics.SECTION + plan.coordinates[c]]
    for c in range(4):
        results.end[i, c] = log[plan.sample - 1, statistics.SECTION + c]


class FollowSpace(NamedTuple):
    """What one thread works in."""

    work: WorkSpace
    variation: Variation  # of one number
    ends: np.ndarray  # (2, 4) the state and the disturbance


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
    work, ends = space.work, space.ends
    prepare(work, cells, plan, i, cells.initial[i])
    p, start = unpack_parameters(cells.parameters[i, 0]), unpack_state(work.state)
    y = from_first((start.x1, start.v1, start.gap, start.rate), int(work.state[SEEN_FROM]), p.play)
    ends[0, 0], ends[0, 1], ends[0, 2], ends[0, 3] = y
    ends[1] = 0.5
    solver, before = (work.packed, work.state, work.nothing), growth[:settling]
    if not follow_disturbance(solver, space.variation, ends, before, section, signals):
        return False
    if math.isnan(before[settling - 1]):
        growth[:] = math.nan
        return True
    if not follow_disturbance(solver, space.variation, ends, growth, section, signals):
        return False
    for n in range(growth.shape[0]):
        x = section[n]
        x[0], x[1], x[2], x[3] = displacements(p, x[0], x[1], x[2], x[3])
    return True
