"""A study that grows: its cells are computed batch by batch, and after each batch there is a partial result.

Everything that runs a study runs through `grow`: the page draws each partial result, `run` waits for the last one.
Where the results are held (`Memory` or `Store`), where cells are computed (on the threads of this machine, where all of
them share a batch, or on a Dask cluster, see :mod:`.cluster`) and in which order changes no number. In a store there
are complete chunks after a kill at any moment, and the next run goes on from them.
"""

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.result import check_cancelled
from vibroscope.engine.sweeps import batches
from vibroscope.engine.sweeps.batches import (
    Batch,
    Memory,
    Progress,
    ProgressCallback,
    ProgressCounter,
    chunk_shape,
    chunks,
    chunks_in_order,
    coarse_first,
    one_by_one,
)
from vibroscope.engine.sweeps.eta_study import EtaStudy
from vibroscope.engine.sweeps.store import Store
from vibroscope.engine.sweeps.store_location import StoreLocation
from vibroscope.engine.sweeps.study import Study

if TYPE_CHECKING:
    import xarray


_HERE = "threads of one machine"  # where cells were computed


@dataclass(frozen=True)
class RunOptions:
    """How a study is run; none of it changes the result.

    Attributes
    ----------
    out : str, Path or None
        A folder, or a URL that fsspec knows (``s3://…``); None keeps the result in memory.
    scheduler : str or None
        Address of a Dask scheduler; None runs on the threads of this machine.
    threads : int or None
        For a chunk: by default all of this machine, or one on a cluster, where Dask runs chunks side by side.
    cells_per_chunk : int or None
        Most cells in a chunk; by default `chunk_shape` decides.
    progress, cancelled : callable or None
        Called with the progress; polled many times a second, and where true, the study ends
        (`Cancelled`); what is complete is kept.
    wait : bool
        Wait for another process that works on the same result, instead of an error.
    """

    out: str | Path | None = None
    scheduler: str | None = None
    threads: int | None = None
    cells_per_chunk: int | None = None
    progress: ProgressCallback | None = None
    cancelled: Poll | None = None
    wait: bool = False


@dataclass(frozen=True, eq=False)
class Partial:
    """The results of a study so far. They grow with the study: read them before the next partial result is asked for.

    Attributes
    ----------
    study : Study
        Of a refined study its present round; in the last one the whole.
    progress : Progress
    """

    study: Study
    progress: Progress
    results: Memory | Store

    @property
    def share(self) -> float:
        """The share of the cells that are done."""
        return self.progress.done / self.progress.total

    def values(self) -> dict[str, np.ndarray]:
        """The variables of `study.variables` over the whole grid, with their fill values where nothing is known."""
        return self.results.values()

    def dataset(self) -> "xarray.Dataset":
        """The results as a Dataset; its attributes include ``computed``, ``reused``, ``failed`` and ``seconds``."""
        return self.results.dataset().assign_attrs(batches.cost(self.progress))


def run(study: Study, options: RunOptions) -> "xarray.Dataset":
    """The result of a study, computed as far as it is not there already: the last of `grow`, read lazily."""
    for partial in grow(study, options):  # noqa: B007 - the last counts
        pass
    return partial.dataset()


def grow(
    study: Study, options: RunOptions | None = None, *, picture: bool = False, known: Mapping | None = None
) -> Iterator[Partial]:
    """Compute a study batch by batch; after each batch comes a partial result, and at the end the whole.

    Parameters
    ----------
    study : Study
    options : RunOptions, optional
    picture : bool
        In memory, in batches of some tenths of a second, coarse cells first (a continued study: in its direction), for
        a picture that refines while one watches; else in chunks.
    known : mapping of str to ndarray, optional
        The values of an earlier partial result in memory, from which to go on.

    Raises
    ------
    ValueError
        Before any work, if a number is out of range, or there is something else at ``out``.
    OSError
        Before any work, if ``out`` cannot be written or the scheduler does not answer; later, if the disk is full. What
        is complete is kept.
    Cancelled
        If ``cancelled`` returned true. What is complete is kept.
    """
    options = options or RunOptions()
    if picture and options.out is not None:
        raise ValueError("a picture grows in memory: give no out")
    study.check()
    counter = ProgressCounter(options.progress)
    with _results(study, options, known) as results, _executor(options) as execute:
        results.claim(study)
        if isinstance(study, EtaStudy) and study.refine:
            yield from _grow_refined(study, results, options, counter, execute)
        else:
            yield from _grow_grid(study, results, options, counter, execute, picture)
        where = _HERE if options.scheduler is None else "Dask workers"
        results.finish(counter.now(), where)
    yield Partial(study, counter.now(), results)


def store_values(study: Study, values: Mapping[str, np.ndarray], options: RunOptions) -> None:
    """Write the values of a complete study that was computed in memory to ``options.out``, as a run there would have.

    Raises
    ------
    ValueError, OSError
        As `grow`.
    """
    counter = ProgressCounter()
    counter.total = study.cells
    with _results(study, options, None) as results:
        results.claim(study)
        _write_missing(study, results, values, options)
        counter.add(values["status"], reused=False)
        results.finish(counter.now(), _HERE)


@contextlib.contextmanager
def _results(study: Study, options: RunOptions, known: Mapping | None) -> Iterator[Memory | Store]:
    if options.out is None:
        yield Memory(known)
        return
    location = StoreLocation(options.out)
    location.check_space(study)
    with location.lock(wait=options.wait, cancelled=options.cancelled), contextlib.closing(Store(location)) as store:
        yield store


# Computes the batches that the results lack, has them written, counts all, and yields after each.
Executor = Callable[[Study, Memory | Store, Iterable[Batch], ProgressCounter], Iterator[None]]


@contextlib.contextmanager
def _executor(options: RunOptions) -> Iterator[Executor]:
    if options.scheduler is None:
        yield lambda *grid: _compute_here(*grid, options)
    else:
        from vibroscope.engine.sweeps.cluster import connect

        with connect(options.scheduler, options.threads or 1, options.cancelled) as execute:
            yield execute


def _compute_here(
    study: Study, results: Memory | Store, batches: Iterable[Batch], counter: ProgressCounter, options: RunOptions
) -> Iterator[None]:
    def compute(batch: Batch, before: dict[str, np.ndarray] | None) -> dict[str, np.ndarray]:
        check_cancelled(options.cancelled)  # a batch may be done before it asks
        how = {"threads": options.threads, "progress": counter.report, "cancelled": options.cancelled}
        return study.compute(batch, before=before, **how)

    return one_by_one(study, results, batches, counter, compute)


def _grow_grid(
    study: Study,
    results: Memory | Store,
    options: RunOptions,
    counter: ProgressCounter,
    execute: Executor,
    picture: bool = False,
) -> Iterator[Partial]:
    sides = _create(study, results, options)
    counter.total += study.cells
    counter.report()  # the first batch may take long: its kernels are compiled, or a cluster has to take it up
    batches = coarse_first(study, results.known) if picture else chunks_in_order(study, sides)
    for _ in execute(study, results, batches, counter):
        if counter.now().done < counter.total:  # else there is the whole
            yield Partial(study, counter.now(), results)


def _create(study: Study, results: Memory | Store, options: RunOptions) -> tuple[int, ...]:
    sides = chunk_shape(study.shape, study.periods_per_cell, study.numbers_per_cell, options.cells_per_chunk)
    return results.create(study, sides)


def _grow_refined(
    study: EtaStudy, results: Memory | Store, options: RunOptions, counter: ProgressCounter, execute: Executor
) -> Iterator[Partial]:
    """Round after round, each with results of its own, which are then put together in ascending order."""
    found, current, level = None, replace(study, refine=0), 0
    while current is not None:
        with contextlib.closing(results.part(f"round-{level}")) as part:
            part.claim(current)
            yield from _grow_grid(current, part, options, counter, execute)
            found = _merged(study.over, found, {study.over: current.values} | part.values())
        current = current.refined(found) if level < study.refine else None
        level += 1
    _write_missing(replace(study, values=found[study.over]), results, found, options)


def _write_missing(
    study: Study, results: Memory | Store, values: Mapping[str, np.ndarray], options: RunOptions
) -> None:
    """Write what the results lack of the values of all cells."""
    for chunk in chunks(study.shape, _create(study, results, options)):
        if results.read(chunk) is None:
            results.write(chunk, {name: values[name][chunk] for name in study.variables})


def _merged(over: str, found: dict[str, np.ndarray] | None, more: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    if found is not None:
        more = {name: np.concatenate([found[name], values]) for name, values in more.items()}
    order = np.argsort(more[over], kind="stable")
    return {name: values[order] for name, values in more.items()}
