"""Driver of many cells that are run until their section enters a trapping region (:mod:`..kernels.batch.settle`)."""

import numpy as np
from vibroscope.engine.drivers.batch import kind_of_events, make_work_space
from vibroscope.engine.drivers.event_driven import COMPLETION
from vibroscope.engine.drivers.slow_subspace import separating_circles
from vibroscope.engine.drivers.threads import Worker, share_out
from vibroscope.engine.kernels.batch import run as kernel
from vibroscope.engine.kernels.batch.course import EXACT
from vibroscope.engine.kernels.batch.recurrence import CYCLE
from vibroscope.engine.kernels.batch.settle import NO_TRAP, LateCells, Settled, Traps, settle_cells
from vibroscope.engine.methods import Method

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
