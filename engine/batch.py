"""Many cells in one call: runs that differ in η, in the system or in K, D and n, each told in a few numbers.

A sweep wants of each run its Poincaré section and what kind of motion it is, not its events. Solvers that leap from
event to event take less time for a cell than Python takes to set it up, so compiled code runs them from the numbers of
a cell to its description (:mod:`engine.kernels.batch.run`). Solvers that walk through every step go through
:func:`engine.simulate`.
"""

import os
from collections.abc import Callable, Sequence

import numpy as np

from .cells import STATUSES, CellResults, Cells
from .drivers import batch as driver
from .drivers.threads import Worker, share_out
from .kernels.batch import section_statistics as tally
from .methods import Newmark, Reference
from .model import require, whole
from .motions.description import describe
from .result import Cancelled, Response
from .simulate import KEEP_LIMIT, PERIODS_LIMIT, STEPS_LIMIT, simulate

THREADS_LIMIT = 1024


def run_cells(
    cells: Cells,
    *,
    transient: int,
    sample: int,
    coordinates: Sequence[int] = (0, 1, 2, 3),
    early_stop: bool = True,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> CellResults:
    """Run every cell for ``transient`` + ``sample`` periods and tell what its last ``sample`` periods are.

    The result of a cell does not depend on the others, on their order or on the number of threads. A cell that ends
    early says so in its status.

    Parameters
    ----------
    cells : Cells
    transient : int
        Periods before the sample, ≥ 0.
    sample : int
        Periods to describe, ≥ 1.
    coordinates : sequence of int
        Columns of the section to keep: 0 … 3 for ξ₁, ξ₁′, ξ₂, ξ₂′.
    early_stop : bool
        Stop a cell once its motion has become periodic.
    threads : int, optional
        As many as there are processors, if not given.
    progress : callable, optional
        Called, in the calling thread, with the number of cells done so far.
    cancelled : callable, optional
        Polled many times a second in the calling thread; when it returns true the call is withdrawn.

    Raises
    ------
    ValueError
        If a number is out of range: the text names it, the range and what to do.
    Cancelled
        If ``cancelled`` returned true.
    """
    plan = driver.Plan(
        whole("transient", transient, 0, PERIODS_LIMIT, "give the periods before the sample"),
        whole("sample", sample, 1, KEEP_LIMIT, "describe at least one period"),
        bool(early_stop),
        tuple(whole("coordinate", c, 0, 3, "0 to 3 are ξ₁, ξ₁′, ξ₂ and ξ₂′") for c in coordinates),
    )
    threads = whole("threads", os.cpu_count() or 1 if threads is None else threads, 1, THREADS_LIMIT, "give one a core")
    results = driver.empty_results(len(cells), plan)
    if len(cells) > 0:
        most = (plan.transient + plan.sample) * cells.steps_each().max()
        require("periods × steps", most, 0, STEPS_LIMIT, "run fewer periods or fewer steps per period")
        numbers, (order, chained) = cells.numbers(), _in_chains(cells)
        if driver.compiled_for(cells.method, numbers):
            start = np.zeros((len(cells), 4)) if cells.initial is None else cells.initial
            worker = driver.compiled_worker(cells.method, numbers, start, order, chained, plan, results)
        else:
            worker = _simulating(cells, order, chained, plan, results)
        ends = np.append(np.flatnonzero(~chained)[1:], len(order))
        share_out(ends, threads, worker, progress, cancelled)
    return told(cells, results)


def _in_chains(cells: Cells) -> tuple[np.ndarray, np.ndarray]:
    """The order in which cells are run, chain by chain, and which of them go on from the one before."""
    if cells.chain is None:
        return np.arange(len(cells)), np.zeros(len(cells), dtype=bool)
    order = np.argsort(cells.chain, kind="stable")
    chained = np.append(False, np.diff(cells.chain[order]) == 0)
    return order, chained


def _simulating(cells: Cells, order: np.ndarray, chained: np.ndarray, plan: driver.Plan, results) -> Callable:
    """Workers that run one cell after the other by :func:`engine.simulate`."""

    def run(places: tuple[int, int], signals: np.ndarray, slot: int) -> None:
        before = None
        for place in range(*places):
            i = order[place]
            start = np.zeros(4) if cells.initial is None else cells.initial[i]
            if chained[place] and before is not None:
                start = results.end[before]
            try:
                response = simulate(
                    cells.system_of(i),
                    cells.eta[i],
                    cells.method_of(i),
                    periods=plan.transient + plan.sample,
                    keep=plan.sample,
                    initial=start,
                    cancelled=lambda: signals[0] != 0,
                )
            except Cancelled:
                return
            tell(response, plan, results, i)
            before = i if response.ok else None
            signals[slot] += 1

    def worker() -> Worker:
        return run

    return worker


def tell(response: Response, plan: driver.Plan, results, i: int) -> None:
    """Write what a response shows into the results of cell i, as compiled code does."""
    results.status[i] = STATUSES.index(response.status)
    results.periods[i] = response.periods
    if not response.ok:
        return
    found, out = describe(response), results.numbers[i]
    lasting = np.diff(response.contacts, axis=1).max(initial=0.0) / response.period
    end = response.window[1] / response.period
    shares = response.impacts.time / response.period
    recent = shares[shares > end - max(1, found.near_period)]
    out[tally.PERIOD], out[tally.NEAR] = found.period, found.near_period
    out[tally.RATE], out[tally.CONTACTS] = found.impacts_per_period, found.contacts_per_period
    out[tally.SHARE], out[tally.SPREAD], out[tally.SCATTER] = found.contact_share, found.spread, found.scatter
    out[tally.LASTING], out[tally.PHASE] = lasting, recent.min() % 1.0 if len(recent) else np.nan
    results.section[i] = response.section[:, list(plan.coordinates)]
    results.end[i] = response.section[-1]
    if isinstance(response.method, Reference):  # who goes on from there knows no penetration, not even one of rounding
        results.end[i, 2] = max(results.end[i, 0], results.end[i, 2])


def told(cells: Cells, results) -> CellResults:
    """The results as their columns."""
    numbers = results.numbers
    n = cells.steps_each() if isinstance(cells.method, Newmark) else np.nan
    return CellResults(
        status=results.status.astype(np.int8),
        section=results.section,
        period=np.nan_to_num(numbers[:, tally.PERIOD]).astype(np.int32),
        near_period=np.nan_to_num(numbers[:, tally.NEAR]).astype(np.int32),
        impacts_per_period=numbers[:, tally.RATE],
        contacts_per_period=numbers[:, tally.CONTACTS],
        contact_share=numbers[:, tally.SHARE],
        spread=numbers[:, tally.SPREAD],
        scatter=numbers[:, tally.SCATTER],
        longest_contact=numbers[:, tally.LASTING] * 2 * np.pi / cells.eta,
        longest_contact_steps=np.round(numbers[:, tally.LASTING] * n, 6),
        phase=numbers[:, tally.PHASE],
        end=results.end,
        periods=results.periods,
    )
