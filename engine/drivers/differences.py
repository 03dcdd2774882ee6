"""Driver of the differences of many cells from the reference (:mod:`..kernels.batch.differences`)."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.batch import ONE_BY_ONE, Task, are_compiled, batch_of, make_work_space, share_cells
from vibroscope.engine.drivers.threads import Worker
from vibroscope.engine.kernels.batch import differences as kernel
from vibroscope.engine.kernels.batch.differences import ALONE, BESIDE, DIFFERENCES, OWN_LIMIT, Cycles
from vibroscope.engine.methods import Method

__all__ = ["ALONE", "BESIDE", "OWN_LIMIT", "Cycles", "Grid", "Motions", "Sampling", "differences"]


class Motions(NamedTuple):
    """A motion of each cell.

    Attributes
    ----------
    method : Method
    rows : (n, s, len(Parameters)) ndarray
    initial : (n, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ where the samples begin.
    period, cycle : (n,) ndarray of int64
        Periods after which its section and its state repeat themselves, so that no more of them are run; 0 if they do
        not.
    sample : callable
        ``sample(i, signals)`` samples a cell that the kernel does not run: ξ₁ and ξ₂, (periods, m, 2); None if it ends
        early or was cancelled.
    """

    method: Method
    rows: np.ndarray
    initial: np.ndarray
    period: np.ndarray
    cycle: np.ndarray
    sample: Callable[[int, np.ndarray], np.ndarray | None]


class Grid(NamedTuple):
    """The instants at which a cell is compared, as shares of T, (m,), and the reference at these instants."""

    phases: np.ndarray
    cycles: Cycles


class Sampling(NamedTuple):
    """How cells are sampled: on which grid each one, (n,), the number of a grid, and for how many periods."""

    grids: Sequence[Grid]
    grid: np.ndarray
    periods: int


def differences(
    penalty: Motions,
    limit: Motions,
    parts: np.ndarray,
    sampling: Sampling,
    **how,
) -> np.ndarray:
    """Root mean square differences of each cell, (n, DIFFERENCES): in all, by the time step, by the regularisation.

    Parameters
    ----------
    penalty, limit : Motions
        With and without the time step; the latter is run where ``parts`` is BESIDE.
    parts : (n,) ndarray of int64
        ALONE, OWN_LIMIT or BESIDE.
    sampling : Sampling
    **how
        ``threads``, ``progress`` and ``cancelled`` of :func:`.threads.share_out`.
    """
    found = np.full((len(parts), DIFFERENCES), np.nan)
    grids, grid, periods = sampling
    task = Task(0, periods, (), recurrence=0.0)
    batches = [batch_of(motions.method, motions.rows, motions.initial, task) for motions in (penalty, limit)]
    recurs = [np.column_stack([motions.period, motions.cycle]).astype(np.int64) for motions in (penalty, limit)]

    def sides(phases: np.ndarray) -> list[kernel.Sampled]:
        rooms = np.empty((2, periods, len(phases), 2))
        spaces = (make_work_space(plan.kind, periods, cells.parameters.shape[1], phases) for cells, plan in batches)
        return [kernel.Sampled(*batch, *rest) for batch, *rest in zip(batches, spaces, recurs, rooms, strict=True)]

    def in_kernel() -> Worker:
        made = {}  # for the grid of the last cells

        def run(places: tuple[int, int], *signals) -> None:
            g = grid[places[0]]
            if g not in made:
                made.clear()
                made[g] = sides(grids[g].phases)
            kernel.compare_cells(*made[g], places, parts, grids[g].cycles, found, *signals)

        return run

    def by_itself(i: int, signals: np.ndarray) -> bool:
        one = penalty.sample(i, signals)
        if one is None:
            return True
        other = limit.sample(i, signals) if parts[i] == BESIDE else None
        kind = ALONE if parts[i] == BESIDE and other is None else parts[i]
        other = one if other is None else other
        kernel.write_differences((one, len(one)), (other, len(other)), kind, grids[grid[i]].cycles, len(one), found[i])
        return True

    calls = np.where(are_compiled(penalty.method, penalty.rows), grid, ONE_BY_ONE)
    share_cells(calls, np.arange(1, len(parts) + 1), in_kernel, by_itself, **how)
    return found
