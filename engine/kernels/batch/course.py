"""The course of one cell: integrated through its transient, then through its sample, which is logged.

A cell without a sample is integrated until its section enters a trapping region: an ellipsoid around a point of a known
cycle from which no motion returns (:mod:`engine.motions.trapping`). Its plain twin is a long transient
(`tests/engine/test_basin_twin.py`).

Whether a motion has returned to where it was, so that its cycle stands for all that would follow.

The solvers are deterministic: a state that recurs after CYCLE periods, with the excitation in the same phase, repeats
what lay between for ever. So a cell is integrated in pieces of CYCLE periods. Once its state at the end of a piece is
that of the two ends before, within RECURRENCE of its size, the next piece is recorded and stands for all that would
follow. The state is that of the last event, so the events must agree as well. CYCLE is divisible by the periods that
matter; any other motion is integrated to its end.

A difference within RECURRENCE does no harm: a periodic motion that is reached is stable, and the difference shrinks. On
an unstable orbit, or in chaos, it would have to be smaller than RECURRENCE at three ends, which happens only to a
motion that is on the cycle to rounding.
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
from vibroscope.engine.kernels.time_stepping.newmark import unpack_state as unpack_step_state

CYCLE = 12
RECURRENCE = 1e-13


@jit_no_alloc
def close(value, other, allowed):
    """Whether two numbers differ by no more than allowed."""
    return abs(value - other) <= allowed


@jit_no_alloc
def event_state_recurs(now, before, period, tolerance):
    """Whether a packed hybrid state is that of CYCLE periods before."""
    a, b = unpack_event_state(now), unpack_event_state(before)
    if a.period != b.period + CYCLE or a.mode != b.mode or a.order != b.order or now[SEEN_FROM] != before[SEEN_FROM]:
        return False
    allowed = tolerance * (abs(a.x1) + abs(a.v1) + abs(a.gap) + abs(a.rate))
    same = close(a.tau, b.tau, tolerance * period) and close(a.x1, b.x1, allowed) and close(a.v1, b.v1, allowed)
    return same and close(a.gap, b.gap, allowed) and close(a.rate, b.rate, allowed)


@jit_no_alloc
def step_state_recurs(now, before, n, tolerance):
    """Whether a packed state of Newmark's method is that of CYCLE periods before."""
    a, b = unpack_step_state(now), unpack_step_state(before)
    if a.step != b.step + CYCLE * n or a.pressed != b.pressed:
        return False
    far = tolerance * (abs(a.p1) + abs(a.p2))
    fast = tolerance * (abs(a.q1) + abs(a.q2)) + far / n  # Q = Δτ ξ′: a displacement over a step
    near = close(a.p1, b.p1, far) and close(a.p2, b.p2, far)
    return near and close(a.q1, b.q1, fast) and close(a.q2, b.q2, fast)


REFERENCE, EXACT, SKIPPING = range(3)  # how a cell is solved
NO_TRAP, PERIODIC = -1, -2  # what a motion tends to, beside the indices of trapping regions


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
            status = integrate_skipping(work.packed[0], work.state, stop * n, window, flat, sizes, BRIEFLY)
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
    """Add what buffers hold to a log, and empty them."""
    (flat, sizes), origin = record
    buffers = unpack_buffers(flat, sizes)
    impacts, contacts = buffers.impacts[: buffers.used[0], 0], buffers.contacts[: buffers.used[1]]
    statistics.add_events(log, sizes[0], (origin, grid[0], grid[1]), impacts, contacts)
    buffers.used[0] = buffers.used[1] = 0


@jit_no_alloc
def log_open_contact(work, plan, grid, stop, log, record):
    """Log the contact that is open at the end of period ``stop`` as if it ended there."""
    (flat, sizes), origin = record
    buffers = unpack_buffers(flat, sizes)
    if plan.kind == SKIPPING:
        if unpack_step_state(work.state).pressed:
            record_open_steps(work.packed[0], work.state, stop * int(grid[1]), buffers)
    else:
        window = (float(origin), float(stop))
        system = unpack_system(work.packed[int(work.state[SEEN_FROM])])
        output.record_open_contact(system, unpack_state(work.state), float(stop), window, buffers)
    log_events(grid, log, record)


@jit_no_alloc
def log_periods(work, plan, grid, log, record, signals):
    """Integrate through the periods of a record and log them; returns the status."""
    (flat, sizes), origin = record
    rows, buffers = sizes[0], unpack_buffers(flat, sizes)
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
def state_recurs(work, plan, grid):
    """Whether the state is that of a cycle before; it becomes that of the cycle before."""
    if plan.kind == SKIPPING:
        same = step_state_recurs(work.state, work.before, int(grid[1]), plan.recurrence)
    else:
        same = event_state_recurs(work.state, work.before, grid[0], plan.recurrence)
    for k in range(work.state.size):
        work.before[k] = work.state[k]
    return same


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
def pass_transient(work, plan, grid, signals, end):
    """Integrate to the end of the transient, or until it is known what the motion tends to.

    Without a sample its section is looked at; the row in a trapping region, or the last one, is written to ``end``.
    Returns the status, the periods done, and what is known: the index of the region, PERIODIC or NO_TRAP.
    """
    trapped, done, alike = plan.sample == 0, 0, 0
    packed = work.cycle if trapped else work.nothing
    work.before[:] = math.nan
    while done < plan.transient:
        begun, done = done, min(done + CYCLE, plan.transient)
        record = packed, begun if trapped else NO_ORIGIN
        status = integrate_to(work, plan, grid, done, work.cycle_log, record, signals)
        if status != OK:
            return status, done, NO_TRAP
        if trapped:
            buffers = unpack_buffers(packed[0], packed[1])
            buffers.used[0] = buffers.used[1] = 0
            k, trap = first_trap(plan.traps, buffers.section, done - begun)
            for c in range(4):
                end[c] = buffers.section[k, c]
            if trap != NO_TRAP:
                return OK, begun + k + 1, trap
        elif plan.recurrence > 0.0:
            alike = alike + 1 if state_recurs(work, plan, grid) else 0
            if alike == 2 and plan.transient + plan.sample - done > CYCLE:
                return OK, done, PERIODIC
    return OK, done, NO_TRAP


@jit_no_alloc
def run_cell(work, plan, grid, signals, end):
    """Integrate one cell and log its sample; returns what :func:`pass_transient` does, for the whole cell."""
    status, done, known = pass_transient(work, plan, grid, signals, end)
    if status != OK or plan.sample == 0:
        return status, done, known
    if known != PERIODIC:
        record = work.sample, done
        return log_periods(work, plan, grid, work.log, record, signals), done + plan.sample, known
    record = work.cycle, done
    status = log_periods(work, plan, grid, work.cycle_log, record, signals)
    statistics.repeat_cycle(work.log, plan.sample, plan.transient, work.cycle_log, CYCLE, done)
    return status, done + CYCLE, known
