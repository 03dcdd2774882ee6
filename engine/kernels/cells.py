"""Cells of a sweep, one after the other, from their numbers to their description, without a return to Python.

**Early stop.** The solvers are deterministic: a state that comes back after CYCLE periods, the phase of the excitation
being the same, repeats what lay between for ever. So a cell is followed in pieces of CYCLE periods, and once its state
at the end of a piece is that of the two ends before, to ALIKE of its size, the next piece is taken down and stands for
all that would follow. The state is that of the last event, so the events must agree as well. CYCLE is divisible by the
periods that matter; any other motion is simply run to its end.

What a difference of ALIKE can do: a periodic motion that is reached is stable, and the difference only shrinks. On an
unstable one, or in chaos, it would have to be smaller than ALIKE at three ends, which a motion that is not *on* the
cycle to rounding does not do.
"""

import math
from typing import NamedTuple

import numpy as np

from . import march as closed
from . import newmark, tally
from .anchor import touches
from .anchor import unfold as unfold_contact
from .jit import bare, jit
from .leaps import finish, leap
from .march import anchor_of, march, note_open, prepare
from .newmark import CONTACT, P1, P2, Q1, Q2, STEP
from .record import unfold_record
from .setup import begin_steps, cell_of, scheme_of, set_up_closed, set_up_leaps

OK, DIVERGED, PILED_UP, UNRESOLVED, WITHDRAWN = range(5)  # how a cell ends
REFERENCE, EXACT, LEAPS = range(3)  # how it is solved
CYCLE = 12
ALIKE = 1e-13
MOST_PAUSES = 8  # in one period, as in engine.drivers.closed


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
    """What one thread works in. Records as :class:`.record.Folded`: of nothing, of a cycle and of a sample."""

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


@bare
def close(value, other, allowed):
    """Whether two numbers differ by no more than allowed."""
    return abs(value - other) <= allowed


@bare
def event_recurs(now, before, period):
    """Whether the anchor of a march is, to ALIKE, that of CYCLE periods before."""
    a, b = anchor_of(now), anchor_of(before)
    if a.period != b.period + CYCLE or a.mode != b.mode or a.order != b.order:
        return False
    allowed = ALIKE * (abs(a.x1) + abs(a.v1) + abs(a.gap) + abs(a.rate))
    same = close(a.tau, b.tau, ALIKE * period) and close(a.x1, b.x1, allowed) and close(a.v1, b.v1, allowed)
    return same and close(a.gap, b.gap, allowed) and close(a.rate, b.rate, allowed)


@bare
def steps_recur(now, before, n):
    """Whether the state of Newmark's method is, to ALIKE, that of CYCLE periods before."""
    if now[STEP] != before[STEP] + CYCLE * n or now[CONTACT] != before[CONTACT]:
        return False
    far = ALIKE * (abs(now[P1]) + abs(now[P2]))
    fast = ALIKE * (abs(now[Q1]) + abs(now[Q2])) + far / n  # Q = Δτ ξ′: a displacement over a step
    near = close(now[P1], before[P1], far) and close(now[P2], before[P2], far)
    return near and close(now[Q1], before[Q1], fast) and close(now[Q2], before[Q2], fast)


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
    closed.keep_anchor(room.state, prepare(p, start[0], start[1], start[2] - start[0], start[3] - start[1]))


@bare
def march_on(room, cell, stop, log, taken, signals):
    """A motion in closed form up to the end of period ``stop``; returns how it ends.

    ``taken``: the folded record to fill, and the period with which it begins.
    """
    flat, sizes, origin = taken
    window, pauses, paused_in = (float(origin), float(stop)), 0, -1.0
    while signals[0] == 0:
        code, _, _ = march(room.folded, room.state, float(stop), window, flat, sizes)
        if code == closed.FULL:
            log_events(room, cell, log, taken)
        elif code == closed.PAUSED:
            pauses = pauses + 1 if room.state[0] == paused_in else 0
            paused_in = room.state[0]
            if pauses > MOST_PAUSES:
                return UNRESOLVED
        else:
            return OK if code == closed.DONE else PILED_UP if code == closed.PILED_UP else UNRESOLVED
    return WITHDRAWN


@bare
def leap_on(room, cell, stop, log, taken, signals):
    """Newmark's solution up to the end of period ``stop``, as :func:`march_on`."""
    flat, sizes, origin = taken
    n = int(cell.steps)
    while signals[0] == 0:
        code = leap(room.folded, room.state, stop * n, (origin * n, stop * n, n), flat, sizes, False)
        if code != newmark.FULL:
            return DIVERGED if code == newmark.DIVERGED else OK
        log_events(room, cell, log, taken)
    return WITHDRAWN


@bare
def log_events(room, cell, log, taken):
    """Add what a record holds to a log, and empty the record."""
    flat, sizes, origin = taken
    record = unfold_record(flat, sizes)
    tally.note_events(log, sizes[0], origin, 2 * math.pi / cell.eta, cell.steps, record)


@bare
def end_contact(room, cell, stop, log, taken):
    """Log the contact that is open at the end of period ``stop`` as if it ended there."""
    flat, sizes, origin = taken
    record = unfold_record(flat, sizes)
    if cell.steps > 0.0:
        if room.state[CONTACT] > 0.0:
            for k in range(room.state.size):
                room.before[k] = room.state[k]
            finish(room.folded, room.before, stop * int(cell.steps), record)
    elif touches(anchor_of(room.state)):
        window = (float(origin), float(stop))
        note_open(unfold_contact(room.folded), anchor_of(room.state), float(stop), window, record)
    log_events(room, cell, log, taken)


@jit
def go_on(room, plan, cell, stop, log, taken, signals):
    """Follow the motion up to the end of period ``stop``."""
    if plan.kind == LEAPS:
        return leap_on(room, cell, stop, log, taken, signals)
    return march_on(room, cell, stop, log, taken, signals)


@jit
def take_down(room, plan, cell, log, taken, signals):
    """Follow the motion through a record and log what it holds; returns how it ends."""
    flat, sizes, origin = taken
    rows = sizes[0]
    stop = origin + rows
    tally.clear(log, rows)
    status = go_on(room, plan, cell, stop, log, taken, signals)
    if status == OK:
        log_events(room, cell, log, taken)
        end_contact(room, cell, stop, log, taken)
        tally.copy_rows(log, rows, unfold_record(flat, sizes).section)
    return status


@jit
def recurs(room, plan, cell):
    """Whether the state is that of a cycle before, which is forgotten for it."""
    if plan.kind == LEAPS:
        same = steps_recur(room.state, room.before, int(cell.steps))
    else:
        same = event_recurs(room.state, room.before, 2 * math.pi / cell.eta)
    for k in range(room.state.size):
        room.before[k] = room.state[k]
    return same


@jit
def pass_transient(room, plan, cell, signals):
    """Follow the motion to the end of the transient, or until it has turned out to be periodic.

    Returns how it ends, the periods done, and whether it is periodic.
    """
    nothing, done, alike = (room.nothing, room.no_sizes, 0), 0, 0
    room.before[:] = math.nan
    while done < plan.transient:
        done = min(done + CYCLE, plan.transient)
        status = go_on(room, plan, cell, done, room.log, nothing, signals)
        if status != OK:
            return status, done, False
        if plan.early:
            alike = alike + 1 if recurs(room, plan, cell) else 0
            if alike == 2 and plan.transient + plan.sample - done > CYCLE:
                return OK, done, True
    return OK, done, False


@jit
def follow(room, plan, cell, signals):
    """Follow the motion of a cell and log its sample; returns how it ends and the periods done."""
    status, done, periodic = pass_transient(room, plan, cell, signals)
    if status != OK:
        return status, done
    if not periodic:
        return take_down(room, plan, cell, room.log, (room.kept, room.kept_sizes, done), signals), done + plan.sample
    status = take_down(room, plan, cell, room.cycle_log, (room.cycle, room.cycle_sizes, done), signals)
    tally.repeat(room.log, plan.sample, plan.transient, room.cycle_log, CYCLE, done)
    return status, done + CYCLE


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
