"""The chunks of a study on a Dask cluster.

Results go to a folder by way of this process, since workers elsewhere do not see it; to an object store the workers
write themselves, and look there themselves for what an earlier run left. A worker that dies loses the chunks in its
hands, and Dask gives them to another.
"""

import contextlib
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from ..result import Cancelled
from .chunks import Chunk
from .place import Place
from .progress import Tally
from .provenance import engine_digest
from .store import Store
from .study import Study

PATIENCE = 20.0  # seconds for the scheduler to answer and a worker to be there
AHEAD = 3  # chunks a thread of the cluster: one at work, two that wait for it
POLL = 0.2  # seconds


def compute(study: Study, before: dict[str, np.ndarray] | None, digest: str, threads: int) -> dict[str, np.ndarray]:
    """On a worker: the variables of a part of a study.

    Raises
    ------
    ValueError
        If the worker's engine is another one.
    """
    if engine_digest() != digest:
        raise ValueError(f"a worker runs another engine ({engine_digest()}, not {digest}): install the same on all")
    return study.compute(before=before, threads=threads)


def ensure(study: Study, digest: str, threads: int, place: tuple) -> tuple[bool, np.ndarray]:
    """On a worker: have a part of a study in the store; whether it was there, and the status of its cells."""
    target, group, chunk = place
    store = Store(Place(target), group).opened(study)
    values = store.read(chunk)
    reused = values is not None
    if not reused:
        values = compute(study, None, digest, threads)
        store.write(chunk, values)
    return reused, values["status"]


@contextlib.contextmanager
def connected(scheduler: str, threads: int, cancelled: Callable[[], bool] | None) -> Iterator[Callable]:
    """An executor of chunks (see :mod:`.runner`) on the cluster of a scheduler.

    Raises
    ------
    ValueError
        If Dask is not installed.
    OSError
        If no scheduler answers at that address, or it has no worker.
    """
    try:
        from distributed import Client
    except ImportError:
        raise ValueError(
            "a scheduler needs Dask: install the extra `cluster` (pip install 'vibroscope[cluster]')"
        ) from None
    try:
        client = Client(scheduler, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as problem:
        raise OSError(f"no Dask scheduler answers at {scheduler}: {problem}") from None
    with client, client.as_current():
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise OSError(f"the scheduler at {scheduler} has no workers: start some") from None
        cluster = _Cluster(client, threads, cancelled)
        yield cluster.execute


class _Cluster:
    def __init__(self, client, threads: int, cancelled: Callable[[], bool] | None):
        self._client, self._threads, self._cancelled = client, threads, cancelled

    def execute(self, study: Study, store: Store, order: Sequence[Chunk], tally: Tally) -> None:
        """All chunks in this order, some at a time; of a sequential study one after the other."""
        waiting = iter(order)
        if study.sequential:
            self._one_by_one(study, store, waiting, tally)
        elif store.place.shared:
            self._by_workers(study, store, waiting, tally)
        else:
            self._by_way_of_here(study, store, waiting, tally)

    def _by_way_of_here(self, study: Study, store: Store, order: Iterator[Chunk], tally: Tally) -> None:
        missing = (chunk for chunk in order if not _kept(store, chunk, tally))
        for chunk, values in self._results(missing, lambda chunk: self._compute(study.cut(chunk), None)):
            store.write(chunk, values)
            tally.add(values["status"], reused=False)

    def _by_workers(self, study: Study, store: Store, order: Iterator[Chunk], tally: Tally) -> None:
        def submit(chunk: Chunk):
            place = store.place.target, store.group, chunk
            return self._submit(ensure, study.cut(chunk), engine_digest(), self._threads, place)

        for _, (reused, status) in self._results(order, submit):
            tally.add(status, reused=reused)

    def _one_by_one(self, study: Study, store: Store, order: Iterator[Chunk], tally: Tally) -> None:
        before = None
        for chunk in order:
            values = store.read(chunk)
            reused = values is not None
            if not reused:
                link = before
                ((_, values),) = self._results([chunk], lambda chunk: self._compute(study.cut(chunk), link))  # noqa: B023 - used at once
                store.write(chunk, values)
            tally.add(values["status"], reused=reused)
            before = {name: values[name] for name in ("status", "end")}

    def _compute(self, part: Study, before: dict[str, np.ndarray] | None):
        return self._submit(compute, part, before, engine_digest(), self._threads)

    def _submit(self, function, *arguments):
        return self._client.submit(function, *arguments, pure=False)

    def _results(self, order, submit: Callable) -> Iterator[tuple[Chunk, object]]:
        """Chunks and what became of them, as they come."""
        from distributed import wait

        ahead = AHEAD * max(1, sum(self._client.nthreads().values()))
        order, running = iter(order), {}
        try:
            while True:
                for chunk in order:
                    running[submit(chunk)] = chunk
                    if len(running) >= ahead:
                        break
                if not running:
                    return
                if self._cancelled is not None and self._cancelled():
                    raise Cancelled
                with contextlib.suppress(TimeoutError):
                    wait(list(running), timeout=POLL, return_when="FIRST_COMPLETED")
                for future in [future for future in running if future.done()]:
                    yield running.pop(future), future.result()
        finally:
            self._client.cancel(list(running))


def _kept(store: Store, chunk: Chunk, tally: Tally) -> bool:
    values = store.read(chunk)
    if values is not None:
        tally.add(values["status"], reused=True)
    return values is not None
