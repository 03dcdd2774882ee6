"""Running a study: the chunks that are not there yet are computed and written, one after the other or on a cluster.

On one machine a chunk is run by all threads at once, which take its cells one by one (see :mod:`engine.batch`), while
the chunk before it is written. On a cluster each worker has chunks of its own (:mod:`.cluster`). Either way a chunk
holds the same numbers, and what is there after a kill, at any moment, is a set of complete chunks.
"""

import contextlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..result import Cancelled
from . import provenance
from .chunks import Chunk, chunk_shape, chunks
from .eta import EtaStudy
from .place import Place
from .progress import Hook, Tally
from .store import Store
from .study import Study

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class Run:
    """How a study is to be run; none of it changes the result.

    Attributes
    ----------
    out : str, Path or None
        A folder, or a URL that fsspec knows (``s3://…``); None keeps the result in memory.
    scheduler : str or None
        Address of a Dask scheduler; None runs on the threads of this machine.
    threads : int or None
        For a chunk: by default all of this machine, or one on a cluster, where Dask runs chunks side by side.
    cells_per_chunk : int or None
        Most cells in a chunk; None: as `chunk_shape` says.
    progress, cancelled : callable or None
        Told how far it is; polled many times a second, and where true, the study is left (`Cancelled`) with what is
        complete kept.
    wait : bool
        Wait for another process that works on the same result, instead of an error.
    """

    out: str | Path | None = None
    scheduler: str | None = None
    threads: int | None = None
    cells_per_chunk: int | None = None
    progress: Hook | None = None
    cancelled: Callable[[], bool] | None = None
    wait: bool = False


def run(study: Study, how: Run) -> "xarray.Dataset":
    """The result of a study, computed as far as it is not there already.

    Returns
    -------
    xarray.Dataset
        Opened lazily; its attributes ``computed``, ``reused``, ``failed`` and ``seconds`` are those of this call.

    Raises
    ------
    ValueError
        Before any work, if a number is out of range, or something else lies at ``out``.
    OSError
        Before any work, if ``out`` cannot be written or the scheduler does not answer; later, if the disk is full. What
        is complete is kept.
    Cancelled
        If ``cancelled`` returned true. What is complete is kept.
    """
    study.check()
    place = Place(how.out)
    place.check_space(study)
    store = Store(place)
    tally = Tally(how.progress)
    with place.locked(wait=how.wait, cancelled=how.cancelled), _executor(how) as execute:
        store.claim(study)
        if isinstance(study, EtaStudy) and study.refine:
            _run_refined(study, store, how, tally, execute)
        else:
            _run_grid(study, store, how, tally, execute)
        store.keep(study.conclusions(store.dataset()))
        if not store.attributes()["complete"]:
            where = "threads of one machine" if how.scheduler is None else "Dask workers"
            store.finish(provenance.account(tally.seconds, tally.computed, tally.reused, tally.failed, where))
    own = {"seconds": tally.seconds, "computed": tally.computed, "reused": tally.reused, "failed": tally.failed}
    return store.dataset().assign_attrs(own)


Executor = Callable[[Study, Store, Sequence[Chunk], Tally], None]


@contextlib.contextmanager
def _executor(how: Run) -> Iterator[Executor]:
    if how.scheduler is None:
        yield lambda study, store, order, tally: _here(study, store, order, tally, how)
    else:
        from .cluster import connected

        with connected(how.scheduler, how.threads or 1, how.cancelled) as execute:
            yield execute


def _run_grid(study: Study, store: Store, how: Run, tally: Tally, execute: Executor) -> None:
    most = how.cells_per_chunk
    sides = store.frame(study, chunk_shape(study.shape, study.periods_per_cell, study.numbers_per_cell, most))
    tally.total += study.cells
    order = list(chunks(study.shape, sides))
    execute(study, store, order[::-1] if study.backwards else order, tally)


def _here(study: Study, store: Store, order: Sequence[Chunk], tally: Tally, how: Run) -> None:
    before, writing = None, None
    with ThreadPoolExecutor(1) as writer:
        for chunk in order:
            values = store.read(chunk)
            reused = values is not None
            if not reused:
                if how.cancelled is not None and how.cancelled():
                    raise Cancelled  # also between chunks that are done before they ask
                part = study.cut(chunk)
                values = part.compute(before=before, threads=how.threads, progress=tally.tell, cancelled=how.cancelled)
                if writing is not None:
                    writing.result()
                writing = writer.submit(store.write, chunk, values)
            before = values if study.sequential else None
            tally.add(values["status"], reused=reused)
        if writing is not None:
            writing.result()


def _run_refined(study: EtaStudy, store: Store, how: Run, tally: Tally, execute: Executor) -> None:
    """Round after round, each a result of its own below the whole, which is then put together of all, in order."""
    found, current, level = None, replace(study, refine=0), 0
    while current is not None:
        part = store.part(f"round-{level}")
        part.claim(current)
        _run_grid(current, part, how, tally, execute)
        found = _merged(study.over, found, part.dataset())
        current = current.refined(found) if level < study.refine else None
        level += 1
    together = replace(study, values=found[study.over])
    sides = store.frame(
        together, chunk_shape(together.shape, study.periods_per_cell, study.numbers_per_cell, how.cells_per_chunk)
    )
    for chunk in chunks(together.shape, sides):
        if store.read(chunk) is None:
            store.write(chunk, {name: found[name][chunk] for name in together.variables})


def _merged(over: str, found: dict[str, np.ndarray] | None, more: "xarray.Dataset") -> dict[str, np.ndarray]:
    names = [name for name in more.variables if name == over or over in more[name].dims]
    added = {name: more[name].values for name in names}
    if found is not None:
        added = {name: np.concatenate([found[name], values]) for name, values in added.items()}
    order = np.argsort(added[over], kind="stable")
    return {name: values[order] for name, values in added.items()}
