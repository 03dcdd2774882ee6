"""The course of one cell: integrated through its transient, then through its sample, which is logged.

A cell without a sample is integrated until its section enters a trapping region: an ellipsoid around a point of a known
cycle from which no motion returns (:mod:`engine.motions.trapping`). Its plain twin is a long transient
(`tests/engine/test_basin_twin.py`).

Whether a motion has returned to where it was, so that its cycle stands for all that would follow.

The solvers are deterministic: a state that recurs, with the excitation in the same phase, repeats what lay between for
ever. So a cell is integrated in pieces of CYCLE periods, and its state at the end of each is compared with that at the
end before. Once it is the same within RECURRENCE of its size, and so is the next one, what lies between stands for all
that would follow. The state is that of the last event, so the events must agree as well. CYCLE is divisible by the
periods that matter. A time step locks many a motion into a longer cycle, so that with one the state is compared with
those at the LAST ends before, and must recur after as many pieces twice.

A difference within RECURRENCE does no harm: a periodic motion that is reached is stable, and the difference shrinks. On
an unstable orbit, or in chaos, it would have to be smaller than RECURRENCE at two ends in succession, which happens
only to a motion that is on the cycle to rounding.
"""

import math

import numpy as np
from vibroscope.engine.kernels import section_statistics as statistics
from vibroscope.engine.kernels.accelerated.skip import integrate_skipping
from vibroscope.engine.kernels.accelerated.skip import record_open_contact as record_open_steps
from vibroscope.engine.kernels.compile.options import jit_no_alloc
from vibroscope.engine.kernels.compile.record import unpack_buffers
from vibroscope.engine.kernels.event_driven import output
from vibroscope.engine.kernels.event_driven.integrate import MOST_PAUSES, integrate
from vibroscope.engine.kernels.event_driven.state import SEEN_FROM, unpack_state, unpack_system
from vibroscope.engine.kernels.event_driven.state import unpack_state as unpack_event_state
from vibroscope.engine.kernels.status import FULL, OK, PAUSED, UNRESOLVED, WITHDRAWN
from vibroscope.engine.kernels.time_stepping.newmark import SEEN_FROM as STEPS_SEEN_FROM
from vibroscope.engine.kernels.time_stepping.newmark import unpack_state as unpack_step_state

CYCLE = 12
LAST = 64  # ends of pieces
RECURRENCE = 1e-13


@jit_no_alloc
def close(value, other, allowed):
    """Whether two numbers differ by no more than allowed."""
    return abs(value - other) <= allowed


@jit_no_alloc
def event_state_recurs(now, before, periods, period, tolerance):
    """Whether a packed hybrid state is that of so many periods before."""
    a, b = unpack_event_state(now), unpack_event_state(before)
    if a.period != b.period + periods or a.mode != b.mode or a.order != b.order or now[SEEN_FROM] != before[SEEN_FROM]:
        return False
    allowed = tolerance * (abs(a.x1) + abs(a.v1) + abs(a.gap) + abs(a.rate))
    same = close(a.tau, b.tau, tolerance * period) and close(a.x1, b.x1, allowed) and close(a.v1, b.v1, allowed)
    return same and close(a.gap, b.gap, allowed) and close(a.rate, b.rate, allowed)


@jit_no_alloc
def step_state_recurs(now, before, periods, n, tolerance):
    """Whether a packed state of Newmark's method is that of so many periods before."""
    a, b = unpack_step_state(now), unpack_step_state(before)
    if a.step != b.step + periods * n or a.pressed != b.pressed or now[STEPS_SEEN_FROM] != before[STEPS_SEEN_FROM]:
        return False
    far = tolerance * (abs(a.p1) + abs(a.p2))
    fast = tolerance * (abs(a.q1) + abs(a.q2)) + far / n  # Q = Δτ ξ′: a displacement over a step
    near = close(a.p1, b.p1, far) and close(a.p2, b.p2, far)
    return near and close(a.q1, b.q1, fast) and close(a.q2, b.q2, fast)


REFERENCE, EXACT, SKIPPING = range(3)  # how a cell is solved
NO_TRAP = -1  # what a motion tends to, beside the indices of trapping regions


# A constant that is handed on has the type of a variable, not a type of its own for which everything that it reaches
# would be compiled again.
BRIEFLY, NO_ORIGIN = np.bool_(False), np.int64(0)  # events without their motion; the origin of a record of nothing


@jit_no_alloc
def integrate_to(work, plan, grid, stop, log, record, signals):
    """Integrate a cell to the end of period ``stop``; returns its status.

    ``grid``: T, and steps per period, 0 for none; ``record``: packed buffers to fill, and the period with which they,
    and their samples, begin.
    """
    (flat, sizes), origin = record
    n, pauses, paused_in = int(grid[1]), 0, -1.0
    while signals[0] == 0:
        if plan.kind == SKIPPING:
            window = (origin * n, origin * n, -(-n // sizes[3]))
            status = integrate_skipping(work.packed, work.state, stop * n, window, flat, sizes, BRIEFLY)
        else:
            start = float(origin), float(origin)
            status, _, _ = integrate(work.packed, work.state, float(stop), start, flat, sizes, None)
        if status == FULL:
            log_events(grid, log, record)
        elif status == PAUSED:
            period = unpack_state(work.state).period
            pauses = pauses + 1 if period == paused_in else 0
            paused_in = period
            if pauses > MOST_PAUSES:
                return UNRESOLVED
        else:
            return status
    return WITHDRAWN


@jit_no_alloc
def log_events(grid, log, record):
    """Add what buffers hold to a log, which begins with the period of the record, and empty them."""
    (flat, sizes), origin = record
    buffers = unpack_buffers(flat, sizes)
    impacts, contacts = buffers.impacts[: buffers.used[0], 0], buffers.contacts[: buffers.used[1]]
    statistics.add_events(log, log.shape[0], (origin, grid[0], grid[1]), impacts, contacts)
    buffers.used[0] = buffers.used[1] = 0


@jit_no_alloc
def log_open_contact(work, plan, grid, stop, log, record):
    """Log the contact that is open at the end of period ``stop`` as if it ended there."""
    (flat, sizes), origin = record
    buffers = unpack_buffers(flat, sizes)
    if plan.kind == SKIPPING:
        if unpack_step_state(work.state).pressed:
            record_open_steps(work.packed, work.state, stop * int(grid[1]), buffers)
    else:
        window = (float(origin), float(stop))
        system = unpack_system(work.packed[int(work.state[SEEN_FROM])])
        output.record_open_contact(system, unpack_state(work.state), float(stop), window, buffers)
    log_events(grid, log, record)


@jit_no_alloc
def log_periods(work, plan, grid, log, record, signals):
    """Integrate through as many periods as a log has rows, and log them; returns the status."""
    (flat, sizes), origin = record
    rows, buffers = log.shape[0], unpack_buffers(flat, sizes)
    stop = origin + rows
    statistics.clear(log, rows)
    buffers.used[0] = buffers.used[1] = 0  # a cell before may have ended early
    status = integrate_to(work, plan, grid, stop, log, record, signals)
    if status == OK:
        log_events(grid, log, record)
        log_open_contact(work, plan, grid, stop, log, record)
        statistics.write_section(log, rows, buffers.section)
    return status


@jit_no_alloc
def position_of(work, plan):
    """A displacement of the packed state, and the difference within which it recurs."""
    if plan.kind == SKIPPING:
        now = unpack_step_state(work.state)
        return now.p1, plan.recurrence * (abs(now.p1) + abs(now.p2))
    now = unpack_event_state(work.state)
    return now.x1, plan.recurrence * (abs(now.x1) + abs(now.v1) + abs(now.gap) + abs(now.rate))


@jit_no_alloc
def is_among(x, positions, allowed):
    """Whether a number is one of some others: without a branch, so that the processor compares them side by side."""
    found = False
    for k in range(positions.size):
        found |= close(positions[k], x, allowed)
    return found


@jit_no_alloc
def state_recurs(work, plan, grid, before, periods):
    """Whether the state is a packed one of so many periods before."""
    if plan.kind == SKIPPING:
        return step_state_recurs(work.state, before, periods, int(grid[1]), plan.recurrence)
    return event_state_recurs(work.state, before, periods, grid[0], plan.recurrence)


@jit_no_alloc
def periods_since(work, plan, grid, pieces):
    """Periods since the state at the end of so many pieces was there before; 0 if it is none of the last ones.

    It becomes one of them.
    """
    found, (x, allowed) = 0, position_of(work, plan)
    if is_among(x, work.positions, allowed):
        for k in range(1, 1 + min(pieces - 1, LAST if plan.kind == SKIPPING else 1)):
            if state_recurs(work, plan, grid, work.ends[(pieces - k) % LAST], k * CYCLE):
                found = k * CYCLE
                break
    work.positions[pieces % LAST] = x
    for k in range(work.state.size):
        work.ends[pieces % LAST, k] = work.state[k]
    return found


@jit_no_alloc
def first_trap(traps, section, rows):
    """The first of some rows of a section that lies in a trapping region, and the index of that region.

    If none does, the last row and NO_TRAP.
    """
    for k in range(rows):
        for j in range(traps.centres.shape[0]):
            distance = 0.0
            for row in range(4):
                part = 0.0
                for c in range(4):
                    part += traps.factors[j, row, c] * (section[k, c] - traps.centres[j, c])
                distance += part * part
            if distance <= 1.0:
                return k, j
    return rows - 1, NO_TRAP


@jit_no_alloc
def is_shorter(cycle, plan, done):
    """Whether a cell need not run on to the end of its sample, since its motion repeats itself after a cycle."""
    left = plan.transient - done
    return 0 < cycle < left + (plan.sample if cycle <= plan.sample else 1)


@jit_no_alloc
def pass_transient(work, plan, grid, signals, end):
    """Integrate to the end of the transient, or until it is known what the motion tends to.

    Without a sample its section is looked at; the row in a trapping region, or the last one, is written to ``end``.
    Returns the status, the periods done, the index of the region or NO_TRAP, and the periods after which the motion
    repeats itself if that is known, else 0.
    """
    trapped, done, pieces, before = plan.sample == 0, 0, 0, 0
    packed = work.cycle if trapped else work.nothing
    work.positions[:] = math.nan
    while done < plan.transient:
        begun, done, pieces = done, min(done + CYCLE, plan.transient), pieces + 1
        record = packed, begun if trapped else NO_ORIGIN
        status = integrate_to(work, plan, grid, done, work.cycle_log, record, signals)
        if status != OK:
            return status, done, NO_TRAP, 0
        if trapped:
            buffers = unpack_buffers(packed[0], packed[1])
            buffers.used[0] = buffers.used[1] = 0
            k, trap = first_trap(plan.traps, buffers.section, done - begun)
            for c in range(4):
                end[c] = buffers.section[k, c]
            if trap != NO_TRAP:
                return OK, begun + k + 1, trap, 0
        elif plan.recurrence > 0.0:
            cycle = periods_since(work, plan, grid, pieces)
            if cycle == before and is_shorter(cycle, plan, done):
                return OK, done, NO_TRAP, cycle
            before = cycle
    return OK, done, NO_TRAP, 0


@jit_no_alloc
def run_cell(work, plan, grid, signals, end):
    """Integrate one cell and log its sample; returns what :func:`pass_transient` does, for the whole cell.

    A cycle that is shorter than the sample is logged and repeated; of a longer one what is left of the transient is
    taken without whole cycles.
    """
    status, done, trap, cycle = pass_transient(work, plan, grid, signals, end)
    if status != OK or plan.sample == 0:
        return status, done, trap, cycle
    repeats = 0 < cycle <= plan.sample
    log = work.cycle_log[:cycle] if repeats else work.log
    if cycle > plan.sample:
        done += (plan.transient - done) % cycle
        record = work.nothing, NO_ORIGIN
        status = integrate_to(work, plan, grid, done, log, record, signals)
        if status != OK:
            return status, done, trap, cycle
    record = work.sample, done
    status = log_periods(work, plan, grid, log, record, signals)
    if repeats:
        statistics.repeat_cycle(work.log, plan.sample, plan.transient, log, cycle, done)
    return status, done + log.shape[0], trap, cycle
