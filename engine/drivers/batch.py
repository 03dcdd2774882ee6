"""Driver of many cells: work space, settings and order for the kernel that runs them, or one run after the other.

Event-driven and skipping solvers take less time for a cell than Python takes to set it up, so compiled code runs them
from the parameters of a cell to its description (:mod:`engine.kernels.batch`). Cells whose steps are all taken go
through :func:`engine.simulate`. Which way a cell goes depends on its own numbers alone.

Driver of disturbances that are followed along the motions of many cells (:mod:`..kernels.batch.run`).

Driver of many cells that are run until their section enters a trapping region (:mod:`..kernels.batch.run`).
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
from vibroscope.engine.kernels.batch.course import CYCLE, EXACT, RECURRENCE, REFERENCE, SKIPPING
from vibroscope.engine.kernels.batch.run import NO_TRAP, LateCells, Settled, Traps, settle_cells
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.compile.record import make_buffers
from vibroscope.engine.kernels.event_driven.saltation import make_variation
from vibroscope.engine.kernels.event_driven.state import STATE as EVENT_STATE
from vibroscope.engine.kernels.event_driven.state import SYSTEM
from vibroscope.engine.kernels.parameters import Parameters, no_keys
from vibroscope.engine.kernels.time_stepping.newmark import STATE as STEP_STATE
from vibroscope.engine.methods import ExactPenalty, Method, Reference

# Transient after which it is first seen whether a cell that the kernel does not run is periodic; how much later again.
SHORTEST, LATER = 96, (0, 10 * CYCLE, 40 * CYCLE, 80 * CYCLE)


def kind_of_events(method: Method) -> int:
    """Which event loop solves a method without a step."""
    return REFERENCE if method.rigid else EXACT


class Task(NamedTuple):
    """The settings that all cells share."""

    transient: int
    sample: int
    coordinates: tuple[int, ...]
    recurrence: float = RECURRENCE  # share of its size within which a state recurs; 0: no cell stops early


def are_compiled(method: Method, rows: np.ndarray) -> np.ndarray:
    """Whether the kernel runs each cell, (n,) of bool.

    It does not with other laws or steps, nor if all steps are taken, nor between two stops.
    """
    p = Parameters(*rows.T)
    if not method.has_step:
        return np.isinf(p.play) & (method.rigid or method.linear)
    fastest = np.maximum(np.maximum(p.kappa, p.eta), 1.0)
    return np.isinf(p.play) & are_held(p) & can_skip(p.eta, fastest, p.steps, method)


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


def empty_results(n: int, task: Task) -> kernel.BatchResults:
    """Results of cells that have not been run."""
    return kernel.BatchResults(
        status=np.zeros(n, dtype=np.int64),
        section=np.full((n, task.sample, len(task.coordinates)), np.nan),
        numbers=np.full((n, section_statistics.NUMBERS), np.nan),
        end=np.full((n, 4), np.nan),
        periods=np.zeros(n, dtype=np.int64),
    )


def make_worker(
    method: Method,
    rows: np.ndarray,
    initial: np.ndarray,
    order: np.ndarray,
    chained: np.ndarray,
    task: Task,
    results: kernel.BatchResults,
    run_cell: Callable[[int, np.ndarray, np.ndarray], bool],
) -> Callable[[], Worker]:
    """A function that makes the worker of a thread (see :func:`.threads.share_out`).

    Parameters
    ----------
    rows : (n, len(Parameters)) ndarray
    initial : (n, 4) ndarray
    order : (n,) ndarray of int64
        The cells in the order of their places.
    chained : (n,) ndarray of bool
        Whether the cell at a place starts from the end of the one at the place before.
    run_cell : callable
        ``run_cell(i, start, signals)`` runs cell i, which the kernel does not run; false if it was cancelled.
    """
    compiled = are_compiled(method, rows)[order]
    cells, plan = batch_of(method, rows, initial, task, order, chained)

    def start_of(place: int) -> np.ndarray:
        before = order[place - 1]
        return results.end[before] if chained[place] and results.status[before] == 0 else initial[order[place]]

    def worker() -> Worker:
        work = make_work_space(plan.kind, task.sample) if compiled.any() else None

        def run(places: tuple[int, int], signals: np.ndarray, slot: int) -> None:
            for by_kernel, group in groupby(range(*places), key=compiled.__getitem__):
                group = list(group)
                if by_kernel:
                    kernel.run_cells(cells, (group[0], group[-1] + 1), plan, work, results, signals, slot)
                    continue
                for place in group:
                    if signals[0] != 0 or not run_cell(order[place], start_of(place), signals):
                        return
                    signals[slot] += 1

        return run

    return worker


def batch_of(
    method: Method,
    rows: np.ndarray,
    initial: np.ndarray,
    task: Task,
    order: np.ndarray | None = None,
    chained: np.ndarray | None = None,
) -> tuple[kernel.BatchCells, kernel.BatchPlan]:
    """Cells, by default as they stand and each on its own, and their plan, as the kernels of many cells take them."""
    kind, n = SKIPPING if method.has_step else kind_of_events(method), len(rows)
    columns = np.array(task.coordinates, dtype=np.int64)
    plan = kernel.BatchPlan(kind, task.transient, task.sample, task.recurrence, columns, COMPLETION)
    circles = separating_circles(rows) if kind == EXACT else np.zeros((n, 2))
    order = np.arange(n) if order is None else order
    chained = np.zeros(n, bool) if chained is None else chained
    return kernel.BatchCells(order, chained, rows, initial, circles), plan


def make_work_space(kind: int, sample: int, phases: np.ndarray | None = None) -> kernel.WorkSpace:
    """The work space of one thread; ``phases``: the instants of a period to sample, as shares of T."""
    layout, state = (SKIPPING_LAYOUT, STEP_STATE) if kind == SKIPPING else (SYSTEM, EVENT_STATE)
    instants = np.zeros(1) if phases is None else phases
    nothing, cycle, kept = (
        make_buffers(rows, instants, 0 if phases is None else rows, CAPACITY if rows else 0)
        for rows in (0, CYCLE, sample)
    )
    return kernel.WorkSpace(
        packed=layout.zeros(),
        keys=no_keys(),
        state=state.zeros(),
        before=state.zeros(),
        nothing=nothing.flat,
        no_sizes=nothing.sizes,
        cycle=cycle.flat,
        cycle_sizes=cycle.sizes,
        sample=kept.flat,
        sample_sizes=kept.sizes,
        cycle_log=np.zeros((CYCLE, section_statistics.COLUMNS)),
        log=np.zeros((sample, section_statistics.COLUMNS)),
    )


def follow(
    method: Reference | ExactPenalty,
    rows: np.ndarray,
    initial: np.ndarray,
    periods: int,
    settling: int,
    found: Callable[[int, np.ndarray, np.ndarray], None],
    by_itself: Callable[[int, np.ndarray, np.ndarray, np.ndarray], bool],
    **how,
) -> None:
    """Follow a disturbance of the motion of each cell.

    Parameters
    ----------
    method : Reference or ExactPenalty
    rows : (n, len(Parameters)) ndarray
    initial : (n, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ ≡ 0 mod T.
    periods, settling : int
        Periods to follow, and those before them, at most as many, in which the disturbance finds its direction.
    found : callable
        ``found(i, growth, section)`` takes what :func:`..kernels.batch.follow.follow_cell` finds, in the thread that
        found it. The arrays are used again.
    by_itself : callable
        ``by_itself(i, growth, section, signals)`` follows a cell that the kernel does not run; false if it was
        cancelled.
    **how
        ``threads`` and ``cancelled`` of :func:`.threads.share_out`.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    compiled = are_compiled(method, rows)
    cells, plan = batch_of(method, rows, initial, Task(0, 1, (), recurrence=0.0))

    def worker() -> Worker:
        variation = uncompiled(make_variation)(1)
        space = kernel.FollowSpace(make_work_space(plan.kind, 1), variation, np.empty((2, 4)))
        growth, section = np.empty(periods), np.empty((periods, 4))

        def run(places: tuple[int, int], signals: np.ndarray, slot: int) -> None:
            for i in range(*places):
                if compiled[i]:
                    done = kernel.follow_cell(cells, i, plan, space, settling, growth, section, signals)
                else:
                    done = by_itself(i, growth, section, signals)
                if not done:
                    return
                found(i, growth, section)
                signals[slot] += 1

        return run

    share_out(np.arange(1, len(rows) + 1), worker, grain=1, **how)


TOGETHER = 16  # cells that a thread takes at a time

__all__ = ["NO_TRAP", "Settled", "Traps", "settle"]


def settle(
    method: Method,
    rows: np.ndarray,
    initial: np.ndarray,
    taus: np.ndarray,
    traps: Traps,
    *,
    periods: int,
    stride: int,
    **how,
) -> Settled:
    """Run each cell until its section lies in a trapping region, or to the end.

    Parameters
    ----------
    method : Reference or ExactPenalty
        Of the first contact law: what the kernels of many cells solve in closed form.
    rows : (n, len(Parameters)) ndarray
        All of the same bodies.
    initial : (n, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ of each cell; a reference without penetration but for rounding.
    taus : (n,) ndarray
        When each cell begins, 0 ≤ τ < T.
    traps : Traps
    periods : int
        Most periods of a cell.
    stride : int
        Periods between two looks at the section, 1 to CYCLE. It changes no result but the time that it takes.
    **how
        ``threads``, ``progress`` and ``cancelled`` of :func:`.threads.share_out`.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    n = len(rows)
    kind = kind_of_events(method)
    results = Settled(
        np.zeros(n, np.int64), np.full(n, NO_TRAP, np.int64), np.zeros(n, np.int64), np.full((n, 4), np.nan)
    )
    if n == 0:
        return results
    plan = kernel.BatchPlan(kind, periods, min(stride, CYCLE), 0.0, np.zeros(0, np.int64), COMPLETION)
    circles = separating_circles(rows[:1]).repeat(n, axis=0) if kind == EXACT else np.zeros((n, 2))
    cells = LateCells(kernel.BatchCells(np.arange(n), np.zeros(n, bool), rows, initial, circles), taus)

    def worker() -> Worker:
        work = make_work_space(kind, 1)

        def run(places: tuple[int, int], signals: np.ndarray, slot: int) -> None:
            settle_cells(cells, places, plan, traps, work, results, signals, slot)

        return run

    ends = np.append(np.arange(TOGETHER, n, TOGETHER), n)
    share_out(ends, worker, **how)
    return results
