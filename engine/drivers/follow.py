"""Driver of disturbances that are followed along the motions of many cells (:mod:`..kernels.batch.follow`)."""

from collections.abc import Callable

import numpy as np
from vibroscope.engine.drivers.batch import Task, are_compiled, batch_of, make_work_space
from vibroscope.engine.drivers.threads import Worker, share_out
from vibroscope.engine.kernels.batch import follow as kernel
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.event_driven.saltation import make_variation
from vibroscope.engine.methods import ExactPenalty, Reference


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
