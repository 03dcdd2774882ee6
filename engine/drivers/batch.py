"""Driver of many cells: work space, settings and order for the kernel that runs them, or one run after the other.

Event-driven and skipping solvers take less time for a cell than Python takes to set it up, so compiled code runs them
from the parameters of a cell to its description (:mod:`engine.kernels.batch`). Cells whose steps are all taken go
through :func:`engine.simulate`. Which way a cell goes depends on its own numbers alone.

The same of cells that are run until their section enters a trapping region, and of disturbances that are followed along
the motions of many cells.
"""

from collections.abc import Callable
from itertools import groupby
from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.base import CAPACITY
from vibroscope.engine.drivers.event_driven import COMPLETION, separating_circles
from vibroscope.engine.drivers.newmark import are_held, can_skip
from vibroscope.engine.drivers.threads import Worker, share_out
from vibroscope.engine.kernels import section_statistics
from vibroscope.engine.kernels.accelerated.step_map import SKIPPING as SKIPPING_LAYOUT
from vibroscope.engine.kernels.batch import run as kernel
from vibroscope.engine.kernels.batch.course import CYCLE, EXACT, LAST, NO_TRAP, RECURRENCE, REFERENCE, SKIPPING
from vibroscope.engine.kernels.batch.run import BatchResults, Traps
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.compile.record import make_buffers
from vibroscope.engine.kernels.equations.motion import free_rate
from vibroscope.engine.kernels.event_driven.saltation import make_variation
from vibroscope.engine.kernels.event_driven.state import STATE as EVENT_STATE
from vibroscope.engine.kernels.event_driven.state import SYSTEM
from vibroscope.engine.kernels.parameters import Parameters, no_tables
from vibroscope.engine.kernels.time_stepping.newmark import STATE as STEP_STATE
from vibroscope.engine.methods import ExactPenalty, Method, Reference

NO_TRAPS = Traps(np.zeros((0, 4)), np.zeros((0, 4, 4)))
# Transient after which it is first seen whether a cell that the kernel does not run is periodic; how much later again.
SHORTEST, LATER = 96, (0, 10 * CYCLE, 40 * CYCLE, 80 * CYCLE)
ONE_BY_ONE = -1  # a place whose cell no kernel of many cells runs
TOGETHER = 16  # cells that a thread takes at a time


def kind_of_events(method: Method) -> int:
    """Which event loop solves a method without a step."""
    return REFERENCE if method.rigid else EXACT


class Task(NamedTuple):
    """The settings that all cells share."""

    transient: int
    sample: int  # 0: a cell ends in a trapping region, or with its transient
    coordinates: tuple[int, ...]
    recurrence: float = RECURRENCE  # share of its size within which a state recurs; 0: no cell stops early


def are_compiled(method: Method, rows: np.ndarray) -> np.ndarray:
    """Whether the kernel runs each cell, (n,) of bool.

    It does not with other laws or steps, nor if all steps are taken.
    """
    p = Parameters(*rows[:, 0].T)
    if not method.has_step:
        return np.full(len(rows), method.rigid or method.linear)
    return are_held(p) & can_skip(p.eta, uncompiled(free_rate)(p), p.steps, method)


def calls_of(method: Method, rows: np.ndarray) -> np.ndarray:
    """The numbers of calls of :func:`share_cells`: one call for all that the kernel runs."""
    return np.where(are_compiled(method, rows), 0, ONE_BY_ONE)


def lengths(task: Task) -> list[int]:
    """Periods after which a run that the kernel does not make may end, since its section recurs; last the whole run.

    All differ by whole cycles, so that each ends in the same phase of a cycle. A section of less than two cycles does
    not show whether it recurs.
    """
    whole = task.transient + task.sample
    if not task.recurrence or task.sample < 2 * CYCLE:
        return [whole]
    shortest = SHORTEST + task.sample
    shortest += (whole - shortest) % CYCLE
    return [*(shortest + later for later in LATER if shortest + later < whole), whole]


def section_recurs(section: np.ndarray, tolerance: float) -> bool:
    """Whether the rows of a section are those of CYCLE periods before, as in :mod:`..kernels.batch.course`."""
    allowed = tolerance * np.abs(section).sum(axis=1).min()
    return bool((np.abs(section[CYCLE:] - section[:-CYCLE]) <= allowed).all())


def empty_results(n: int, task: Task) -> BatchResults:
    """Results of cells that have not been run."""
    return BatchResults(
        status=np.zeros(n, dtype=np.int64),
        section=np.full((n, task.sample, len(task.coordinates)), np.nan),
        numbers=np.full((n, section_statistics.NUMBERS), np.nan),
        end=np.full((n, 4), np.nan),
        periods=np.zeros(n, dtype=np.int64),
        known=np.full(n, NO_TRAP),
        cycle=np.zeros(n, dtype=np.int64),
    )


def share_cells(
    calls: np.ndarray,
    ends: np.ndarray,
    in_kernel: Callable[[], Worker],
    by_itself: Callable[[int, np.ndarray], bool],
    **how,
) -> None:
    """Share out the places of an order: a kernel runs several in one call, or they are run one by one.

    Parameters
    ----------
    calls : (n,) ndarray of int
        Places that follow one another and have the same number go to one call of the kernel; see ONE_BY_ONE.
    ends, **how
        As of :func:`.threads.share_out`.
    in_kernel : callable
        Called once in each thread, gives the function that calls the kernel for some places.
    by_itself : callable
        ``by_itself(place, signals)`` runs the cell at a place; false if it was cancelled.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """

    def worker() -> Worker:
        call = in_kernel() if (calls != ONE_BY_ONE).any() else None

        def run(places: tuple[int, int], signals: np.ndarray, slot: int) -> None:
            for number, group in groupby(range(*places), key=calls.__getitem__):
                chosen = list(group)
                if number != ONE_BY_ONE:
                    call((chosen[0], chosen[-1] + 1), signals, slot)
                    continue
                for place in chosen:
                    if signals[0] != 0 or not by_itself(place, signals):
                        return
                    signals[slot] += 1

        return run

    share_out(ends, worker, **how)


def run_batch(
    method: Method,
    batch: tuple[kernel.BatchCells, kernel.BatchPlan],
    results: BatchResults,
    run_cell: Callable[[int, np.ndarray, np.ndarray], bool] | None,
    **how,
) -> None:
    """Run cells, those of a chain one after the other in one thread.

    Parameters
    ----------
    batch : (BatchCells, BatchPlan)
        As :func:`batch_of` gives them.
    run_cell : callable
        ``run_cell(i, start, signals)`` runs cell i, which the kernel does not run; false if it was cancelled. None: the
        kernel runs all of them.
    **how
        As of :func:`.threads.share_out`.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    cells, plan = batch
    order, chained = cells.order, cells.chained

    def in_kernel() -> Worker:
        work = make_work_space(plan.kind, plan.sample, cells.parameters.shape[1])
        return lambda places, *signals: kernel.run_cells(cells, places, plan, work, results, *signals)

    def by_itself(place: int, signals: np.ndarray) -> bool:
        before = order[place - 1]
        goes_on = chained[place] and results.status[before] == 0
        return run_cell(order[place], results.end[before] if goes_on else cells.initial[order[place]], signals)

    ends = np.append(np.flatnonzero(~chained)[1:], len(order))
    share_cells(calls_of(method, cells.parameters[order]), ends, in_kernel, by_itself, **how)


def batch_of(
    method: Method,
    rows: np.ndarray,
    initial: np.ndarray,
    task: Task,
    order: np.ndarray | None = None,
    chained: np.ndarray | None = None,
    taus: np.ndarray | None = None,
    traps: Traps = NO_TRAPS,
) -> tuple[kernel.BatchCells, kernel.BatchPlan]:
    """Cells and their plan, as the kernels of many cells take them.

    Parameters
    ----------
    rows : (n, s, len(Parameters)) ndarray
        As seen from each stop: s is 2 if any cell has a second one.
    initial : (n, 4) ndarray
    order : (n,) ndarray of int64, optional
        The cells in the order of their places, by default as they stand.
    chained : (n,) ndarray of bool, optional
        Whether the cell at a place starts from the end of the one at the place before; by default none does.
    taus : (n,) ndarray, optional
        When each begins in its first period; by default at 0.
    traps : Traps, optional
        That a task without a sample looks for.
    """
    kind, n = SKIPPING if method.has_step else kind_of_events(method), len(rows)
    columns = np.array(task.coordinates, dtype=np.int64)
    plan = kernel.BatchPlan(kind, task.transient, task.sample, task.recurrence, columns, COMPLETION, traps)
    circles = np.zeros((*rows.shape[:2], 2))
    if kind == EXACT:
        distinct = rows[:1] if (rows == rows[:1]).all() else rows
        circles[:] = separating_circles(distinct.reshape(-1, rows.shape[-1])).reshape(len(distinct), *circles.shape[1:])
    order = np.arange(n) if order is None else order
    chained = np.zeros(n, bool) if chained is None else chained
    taus = np.zeros(n) if taus is None else taus
    return kernel.BatchCells(order, chained, rows, initial, taus, circles), plan


def make_work_space(kind: int, sample: int, stops: int, phases: np.ndarray | None = None) -> kernel.WorkSpace:
    """The work space of one thread; ``phases``: the instants of a period of the sample, as shares of T."""
    layout, state = (SKIPPING_LAYOUT, STEP_STATE) if kind == SKIPPING else (SYSTEM, EVENT_STATE)
    packed, keys = no_tables(layout, stops)
    instants = np.zeros(1) if phases is None else phases
    nothing, cycle, kept = (
        make_buffers(rows, instants, sampled, CAPACITY if rows else 0)[:2]
        for rows, sampled in ((0, 0), (CYCLE, 0), (sample, 0 if phases is None else sample))
    )
    return kernel.WorkSpace(
        packed=packed,
        keys=keys,
        state=np.zeros(state.size + 1),
        ends=np.zeros((LAST, state.size + 1)),
        positions=np.zeros(LAST),
        nothing=nothing,
        cycle=cycle,
        sample=kept,
        cycle_log=np.zeros((max(CYCLE, sample), section_statistics.COLUMNS)),
        log=np.zeros((sample, section_statistics.COLUMNS)),
    )


def follow(
    method: Reference | ExactPenalty,
    rows: np.ndarray,
    initial: np.ndarray,
    periods: int,
    settling: int,
    found: Callable[[int, np.ndarray, np.ndarray], None],
    by_itself: Callable[[int, np.ndarray], bool],
    **how,
) -> None:
    """Follow a disturbance of the motion of each cell.

    Parameters
    ----------
    method : Reference or ExactPenalty
    rows : (n, s, len(Parameters)) ndarray
    initial : (n, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ ≡ 0 mod T.
    periods, settling : int
        Periods to follow, and those before them, at most as many, in which the disturbance finds its direction.
    found : callable
        ``found(i, growth, section)`` takes what :func:`..kernels.batch.run.follow_cell` finds, in the thread that found
        it. The arrays are used again.
    by_itself : callable
        ``by_itself(i, signals)`` follows a cell that the kernel does not run; false if it was cancelled.
    **how
        ``threads`` and ``cancelled`` of :func:`.threads.share_out`.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    cells, plan = batch_of(method, rows, initial, Task(0, 1, (), recurrence=0.0))

    def in_kernel() -> Worker:
        variation = uncompiled(make_variation)(1)
        space = kernel.FollowSpace(make_work_space(plan.kind, 1, rows.shape[1]), variation, np.empty((2, 4)))
        growth, section = np.empty(periods), np.empty((periods, 4))

        def run(places: tuple[int, int], signals: np.ndarray, slot: int) -> None:
            for i in range(*places):
                if not kernel.follow_cell(cells, i, plan, space, settling, growth, section, signals):
                    return
                found(i, growth, section)
                signals[slot] += 1

        return run

    share_cells(calls_of(method, rows), np.arange(1, len(rows) + 1), in_kernel, by_itself, grain=1, **how)


def settle(
    method: Method,
    rows: np.ndarray,
    initial: np.ndarray,
    taus: np.ndarray,
    traps: Traps,
    periods: int,
    **how,
) -> BatchResults:
    """Run each cell until its section lies in a trapping region, or to the end.

    Parameters
    ----------
    method : Reference or ExactPenalty
        Of the first contact law: what the kernels of many cells solve in closed form.
    rows : (n, s, len(Parameters)) ndarray
    initial : (n, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ of each cell; a reference without penetration but for rounding.
    taus : (n,) ndarray
        When each cell begins, 0 ≤ τ < T.
    traps : Traps
    periods : int
        Most periods of a cell.
    **how
        ``threads``, ``progress`` and ``cancelled`` of :func:`.threads.share_out`.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    task = Task(periods, 0, (), recurrence=0.0)
    results = empty_results(len(rows), task)
    if len(rows):
        batch = batch_of(method, rows, initial, task, taus=taus, traps=traps)
        run_batch(method, batch, results, None, grain=TOGETHER, **how)
    return results
