"""The course of one cell's motion: followed to the end of its transient, then through its sample, which is logged."""

import math

from ..accelerated.skip import finish, leap
from ..compile.options import bare, jit
from ..compile.record import unfold_record
from ..event_driven import integrate as closed
from ..event_driven.integrate import march, note_open
from ..event_driven.state import anchor_of, touches
from ..event_driven.state import unfold as unfold_contact
from ..time_stepping import newmark
from ..time_stepping.newmark import CONTACT
from . import section_statistics as tally
from .recurrence import CYCLE, event_recurs, steps_recur

OK, DIVERGED, PILED_UP, UNRESOLVED, WITHDRAWN = range(5)  # how a cell ends
REFERENCE, EXACT, LEAPS = range(3)  # how it is solved
MOST_PAUSES = 8  # in one period, as in engine.drivers.closed


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
