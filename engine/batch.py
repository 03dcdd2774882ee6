"""Many cells in one call: runs that differ in η, in the system or in K, D and n, each described by a few numbers.

A sweep needs the Poincaré section of each run and what kind of motion it is, not its events.
"""

from collections.abc import Callable, Sequence

import numpy as np
from vibroscope.engine.cells import STATUSES, CellResults, Cells
from vibroscope.engine.checks import require, whole
from vibroscope.engine.drivers import batch as driver
from vibroscope.engine.drivers.section import describe_section, name_numbers
from vibroscope.engine.drivers.threads import GRAIN, share_out, thread_count
from vibroscope.engine.result import Cancelled, Response
from vibroscope.engine.simulate import KEEP_LIMIT, PERIODS_LIMIT, STEPS_LIMIT, simulate

FEW_CELLS = 8  # cells or chains for each thread: so few may take long, and threads take them one by one


def run_cells(
    cells: Cells,
    *,
    transient: int,
    sample: int,
    coordinates: Sequence[int] = (0, 1, 2, 3),
    recurrence: float = driver.RECURRENCE,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> CellResults:
    """Run every cell for ``transient`` + ``sample`` periods and describe its last ``sample`` periods.

    The result of a cell does not depend on the others (but for those before it in its chain), on their order or on the
    number of threads. A cell that ends early has that in its status.

    Parameters
    ----------
    cells : Cells
    transient : int
        Periods before the sample, ≥ 0.
    sample : int
        Periods to describe, ≥ 1.
    coordinates : sequence of int
        Columns of the section to keep: 0 … 3 for ξ₁, ξ₁′, ξ₂, ξ₂′.
    recurrence : float
        Share of its size within which a state must return after a cycle, twice, for a cell to stop early: its motion
        has become periodic. By default what follows is the same to rounding; 0: all cells run to their end. So do those
        of Newmark whose every step is taken; those with located steps may stop at some lengths only.
    threads : int, optional
        As many as there are processors, if not given.
    progress : callable, optional
        Called, in the calling thread, with the number of cells done so far.
    cancelled : callable, optional
        Polled many times a second in the calling thread; when it returns true the call is cancelled.

    Raises
    ------
    ValueError
        If a number is out of range: the text names it, the range and what to do.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Cells, Newmark, System, run_cells
    >>> cells = Cells(System(), [1.08, 2.76], Newmark(1, 1, 2000), stiffness=[2500, 12000], damping=[8, 18])
    >>> found = run_cells(cells, transient=500, sample=20)
    >>> found.period.tolist(), found.section.shape
    ([1, 0], (2, 20, 4))
    """
    if recurrence != 0:
        advice = "let cells stop early where what follows is nearly the same, or not at all by 0"
        require("recurrence", recurrence, driver.RECURRENCE, 1e-6, advice)
    task = driver.Task(
        whole("transient", transient, 0, PERIODS_LIMIT, "give the periods before the sample"),
        whole("sample", sample, 1, KEEP_LIMIT, "describe at least one period"),
        tuple(whole("coordinate", c, 0, 3, "0 to 3 are ξ₁, ξ₁′, ξ₂ and ξ₂′") for c in coordinates),
        float(recurrence),
    )
    threads = thread_count(threads)
    results = driver.empty_results(len(cells), task)
    solutions = np.zeros((len(cells), 3), dtype=np.int64)
    if len(cells) > 0:
        most = (task.transient + task.sample) * cells.steps_each().max()
        require("periods × steps", most, 0, STEPS_LIMIT, "run fewer periods or fewer steps per period")
        order, chained = _in_chains(cells)
        start = cells.starts()
        run_cell = _single_runs(cells, task, results, solutions)
        worker = driver.make_worker(cells.method, cells.parameters(), start, order, chained, task, results, run_cell)
        ends = np.append(np.flatnonzero(~chained)[1:], len(order))
        grain = 1 if len(ends) <= FEW_CELLS * threads else GRAIN
        share_out(ends, worker, threads=threads, progress=progress, cancelled=cancelled, grain=grain)
    return cell_results(cells, results, solutions)


def _in_chains(cells: Cells) -> tuple[np.ndarray, np.ndarray]:
    """The order in which cells are run, chain by chain, and which of them go on from the one before.

    Without chains those of most steps come first, so that no thread begins the longest one when the others are done.
    """
    if cells.chain is None:
        return np.argsort(-cells.steps_each(), kind="stable"), np.zeros(len(cells), dtype=bool)
    order = np.argsort(cells.chain, kind="stable")
    chained = np.append(False, np.diff(cells.chain[order]) == 0)
    return order, chained


def _single_runs(
    cells: Cells, task: driver.Task, results, solutions: np.ndarray
) -> Callable[[int, np.ndarray, np.ndarray], bool]:
    """A function that runs one cell by :func:`engine.simulate`; false if it was cancelled."""
    located = cells.method.located
    lengths = driver.lengths(task) if located else [task.transient + task.sample]

    def run_cell(i: int, start: np.ndarray, signals: np.ndarray) -> bool:
        done = 0  # periods
        for length in lengths:
            begun = done
            try:
                response = simulate(
                    cells.system_of(i),
                    cells.eta[i],
                    cells.method_of(i),
                    periods=length - done,
                    keep=task.sample,
                    initial=start,
                    cancelled=lambda: signals[0] != 0,
                )
            except Cancelled:
                return False
            if not response.ok or driver.section_recurs(response.section, task.recurrence):
                break
            start, done = response.checkpoint, response.checkpoint.periods
        write_response(response, task, results, i)
        taken = begun * int(cells.steps_each()[i]) + response.cost.steps
        solutions[i] = response.steps_without_solution, response.steps_with_two, taken
        return True

    return run_cell


def write_response(response: Response, task: driver.Task, results, i: int) -> None:
    """Write a response into the results of cell i, as the kernel does."""
    results.status[i] = STATUSES.index(response.status)
    results.periods[i] = response.checkpoint.periods + response.keep if response.ok else response.periods
    if not response.ok:
        return
    results.numbers[i] = describe_section(response)
    results.section[i] = response.section[:, list(task.coordinates)]
    results.end[i] = response.section[-1]
    if response.method.rigid:  # a run that starts from there must not penetrate, not even by rounding
        results.end[i] = response.system.without_penetration(response.section[-1])


def cell_results(cells: Cells, results, solutions: np.ndarray) -> CellResults:
    """The results as named columns; ``solutions``: steps without a solution, with two, and all of them, (n, 3)."""
    numbers = name_numbers(results.numbers)
    periods = {name: np.nan_to_num(numbers.pop(name)).astype(np.int32) for name in ("period", "near_period")}
    share = numbers.pop("longest_contact")
    n = cells.steps_each() if cells.method.has_step else np.nan
    return CellResults(
        status=results.status.astype(np.int8),
        section=results.section,
        **periods,
        **numbers,
        longest_contact=share * 2 * np.pi / cells.eta,
        longest_contact_steps=np.round(share * n, 6),
        end=results.end,
        periods=results.periods,
        steps_without_solution=solutions[:, 0],
        steps_with_two=solutions[:, 1],
        steps_taken=solutions[:, 2],
    )
