"""Cells of a sweep, one after the other, from their numbers to their description, without a return to Python."""

from typing import NamedTuple

import numpy as np

from ..compile.options import jit
from ..event_driven.integrate import prepare
from ..event_driven.setup import cell_of, set_up_closed
from ..event_driven.state import keep_anchor
from ..event_driven.state import unfold as unfold_contact
from ..time_stepping.setup import begin_steps, scheme_of, set_up_leaps
from . import section_statistics as tally
from .course import LEAPS, OK, REFERENCE, WITHDRAWN, follow


class Plan(NamedTuple):
    """What is the same for all cells of a call."""

    kind: int  # REFERENCE, EXACT or LEAPS
    transient: int
    sample: int
    early: bool
    coordinates: np.ndarray  # (c,) int64
    tolerance: float  # of a period, and what a near period is (engine.motions.section)
    scatter: float
    most_nearly: int
    completion: float  # of a chatter (engine.drivers.closed)


class Work(NamedTuple):
    """The cells, as arrays with an entry each, and the order in which they are run."""

    order: np.ndarray  # (n,) int64
    chained: np.ndarray  # (n,) bool, by place in the order: starts from the end of the one before
    numbers: np.ndarray  # (n, len(Cell))
    initial: np.ndarray  # (n, 4)
    circles: np.ndarray  # (n, 2) between the slow and the fast motion in contact (engine.drivers.slow)


class Results(NamedTuple):
    """What becomes of the cells."""

    status: np.ndarray  # (n,) int64
    section: np.ndarray  # (n, sample, c)
    numbers: np.ndarray  # (n, tally.NUMBERS)
    end: np.ndarray  # (n, 4)
    periods: np.ndarray  # (n,) int64


class Room(NamedTuple):
    """What one thread works in. Records as :class:`..compile.record.Folded`: of nothing, of a cycle and of a sample."""

    folded: np.ndarray
    keys: np.ndarray  # (2, len(Cell)) the numbers for which the tables in it are made
    state: np.ndarray
    before: np.ndarray  # the state a cycle ago
    nothing: np.ndarray
    no_sizes: np.ndarray
    cycle: np.ndarray
    cycle_sizes: np.ndarray
    kept: np.ndarray
    kept_sizes: np.ndarray
    cycle_log: np.ndarray  # (CYCLE, tally.COLUMNS)
    log: np.ndarray  # (sample, tally.COLUMNS)


@jit
def set_up(room, work, plan, i):
    """Tables of cell i."""
    if plan.kind == LEAPS:
        set_up_leaps(room.folded, room.keys, work.numbers[i])
    else:
        rigid = plan.kind == REFERENCE
        set_up_closed(room.folded, room.keys, work.numbers[i], rigid, work.circles[i], plan.completion)


@jit
def begin(room, plan, cell, start):
    """The solver's state at τ = 0."""
    if plan.kind == LEAPS:
        begin_steps(room.state, scheme_of(cell), cell, start)
        return
    p = unfold_contact(room.folded)
    keep_anchor(room.state, prepare(p, start[0], start[1], start[2] - start[0], start[3] - start[1]))


@jit
def run_cells(work, places, plan, room, results, signals, slot):
    """Run the cells at some places of the order, one after the other.

    Parameters
    ----------
    work : Work
    places : (int, int)
        First place, and the one after the last.
    plan : Plan
    room : Room
    results : Results
    signals : (1 + threads,) int64
        ``signals[0]`` is set to withdraw the call; ``signals[slot]`` counts the cells done.
    slot : int
    """
    before = -1
    for place in range(places[0], places[1]):
        i = work.order[place]
        cell = cell_of(work.numbers[i])
        set_up(room, work, plan, i)
        start = results.end[before] if before >= 0 and work.chained[place] else work.initial[i]
        begin(room, plan, cell, start)
        status, periods = follow(room, plan, cell, signals)
        if status == WITHDRAWN:
            return
        results.status[i], results.periods[i] = status, periods
        before = i if status == OK else -1
        if status == OK:
            report(room, plan, results, i)
        signals[slot] += 1


@jit
def report(room, plan, results, i):
    """Write what the log of a cell tells."""
    log, out = room.log, results.numbers[i]
    tally.describe(log, plan.sample, plan.tolerance, plan.scatter, plan.most_nearly, out)
    for j in range(plan.sample):
        for c in range(plan.coordinates.size):
            results.section[i, j, c] = log[j, tally.SECTION + plan.coordinates[c]]
    for c in range(4):
        results.end[i, c] = log[plan.sample - 1, tally.SECTION + c]
    if plan.kind == REFERENCE:  # who goes on from there knows no penetration, not even one of rounding
        results.end[i, 2] = max(results.end[i, 0], results.end[i, 2])
