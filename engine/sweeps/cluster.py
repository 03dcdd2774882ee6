"""The chunks of a study on a Dask cluster.

Results go to a folder or to memory by way of this process, since workers elsewhere do not see it; to an object store
the workers write themselves, and look there themselves for what an earlier run left. A worker that dies loses the
chunks in its hands, and Dask gives them to another.
"""

import contextlib
import itertools
import logging
from collections.abc import Callable, Iterable, Iterator

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.result import Cancelled
from vibroscope.engine.sweeps.batches import Chunk, Memory, ProgressCounter, one_by_one
from vibroscope.engine.sweeps.digest import engine_digest
from vibroscope.engine.sweeps.store import Store
from vibroscope.engine.sweeps.store_location import StoreLocation
from vibroscope.engine.sweeps.study import Study

ANSWER_SECONDS = 20.0  # seconds for the scheduler to answer and a worker to be there
AHEAD = 3  # chunks a thread of the cluster: one at work, two that wait for it


def compute(study: Study, before: dict[str, np.ndarray] | None, digest: str, threads: int) -> dict[str, np.ndarray]:
    """Compute the variables of a part of a study; runs on a worker.

    Raises
    ------
    ValueError
        If the worker's engine is another one.
    """
    if engine_digest() != digest:
        raise ValueError(f"a worker runs another engine ({engine_digest()}, not {digest}): install the same on all")
    return study.compute(before=before, threads=threads)


def compute_into_store(study: Study, digest: str, threads: int, location: tuple) -> tuple[bool, np.ndarray]:
    """Compute a part of a study on a worker unless the store has it; whether it had, and the cells' status."""
    target, group, key, chunk = location
    store = Store(StoreLocation(target), group).open(study, key)
    values = store.read(chunk)
    reused = values is not None
    if not reused:
        values = compute(study, None, digest, threads)
        store.write_now(chunk, values)
    return reused, values["status"]


@contextlib.contextmanager
def connect(scheduler: str, threads: int, cancelled: Poll | None) -> Iterator[Callable]:
    """An executor of chunks (see :mod:`.growth`) on the cluster of a scheduler.

    Raises
    ------
    ValueError
        If Dask is not installed.
    OSError
        If no scheduler answers at that address, it has no worker, or, while the executor runs, it is lost.
    """
    try:
        from distributed import Client
        from distributed.comm import CommClosedError
    except ImportError:
        raise ValueError(
            "a scheduler needs Dask: install the extra `cluster` (pip install 'vibroscope[cluster]')"
        ) from None
    try:
        client = Client(scheduler, timeout=ANSWER_SECONDS, set_as_default=False)
    except (OSError, ValueError) as problem:
        raise OSError(f"no Dask scheduler answers at {scheduler}: {problem}") from None
    with _clear_end(scheduler), client, client.as_current():
        try:
            client.wait_for_workers(1, timeout=ANSWER_SECONDS)
        except TimeoutError:
            raise OSError(f"the scheduler at {scheduler} has no workers: start some") from None
        try:
            yield _Cluster(client, threads, cancelled).execute
        except OSError as problem:
            if client.status == "running":
                raise
            raise CommClosedError(problem) from None  # what it waited for was not connected any more


@contextlib.contextmanager
def _clear_end(scheduler: str) -> Iterator[None]:
    """Raise one error for all that a lost scheduler makes the client raise, and keep its tracebacks out of the log."""
    from distributed import CancelledError
    from distributed.comm import CommClosedError

    names = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] == "distributed"]
    levels = {logging.getLogger(name): logging.getLogger(name).level for name in names}
    for logger in levels:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    except (CancelledError, CommClosedError):
        raise OSError(
            f"the Dask scheduler at {scheduler} was lost: run the same again once it is there; nothing is lost of what "
            "is stored"
        ) from None
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)


class _Cluster:
    def __init__(self, client, threads: int, cancelled: Poll | None) -> None:
        self._client, self._threads, self._cancelled = client, threads, cancelled

    def execute(
        self, study: Study, results: Memory | Store, chunks: Iterable[Chunk], counter: ProgressCounter
    ) -> Iterator[None]:
        """All chunks in this order, some at a time; of a sequential study one after the other."""
        if study.sequential:
            return self._one_by_one(study, results, chunks, counter)
        if isinstance(results, Store) and results.location.shared:
            return self._by_workers(study, results, chunks, counter)
        return self._by_way_of_here(study, results, chunks, counter)

    def _by_way_of_here(self, study, results, chunks, counter) -> Iterator[None]:
        missing = (chunk for chunk in chunks if not _count_if_there(results, chunk, counter))
        for chunk, values in self._results(missing, lambda chunk: self._compute(study.cut(chunk), None), counter):
            results.write(chunk, values)
            counter.add(values["status"], reused=False)
            yield

    def _by_workers(self, study, store, chunks, counter) -> Iterator[None]:
        def submit(chunk: Chunk):
            location = store.location.target, store.group, store.key, chunk
            return self._submit(compute_into_store, study.cut(chunk), engine_digest(), self._threads, location)

        for _, (reused, status) in self._results(chunks, submit, counter):
            counter.add(status, reused=reused)
            yield

    def _one_by_one(self, study, results, chunks, counter) -> Iterator[None]:
        def compute(chunk: Chunk, before: dict[str, np.ndarray] | None) -> dict[str, np.ndarray]:
            end = before and {name: before[name] for name in ("status", "end")}
            ((_, values),) = self._results([chunk], lambda chunk: self._compute(study.cut(chunk), end), counter)
            return values

        return one_by_one(study, results, chunks, counter, compute)

    def _compute(self, part: Study, before: dict[str, np.ndarray] | None):
        return self._submit(compute, part, before, engine_digest(), self._threads)

    def _submit(self, function, *arguments):
        return self._client.submit(function, *arguments, pure=False)

    def _results(
        self, chunks: Iterable[Chunk], submit: Callable, counter: ProgressCounter
    ) -> Iterator[tuple[Chunk, object]]:
        """Chunks with what their workers return, as they come; meanwhile the counter reports how long they take."""
        from distributed import wait

        ahead = AHEAD * max(1, sum(self._client.nthreads().values()))
        waiting, running = iter(chunks), {}
        try:
            while True:
                for chunk in itertools.islice(waiting, ahead - len(running)):
                    running[submit(chunk)] = chunk
                if not running:
                    return
                if self._cancelled is not None and self._cancelled():
                    raise Cancelled
                counter.report()
                with contextlib.suppress(TimeoutError):
                    wait(list(running), timeout=0.2, return_when="FIRST_COMPLETED")
                for future in [future for future in running if future.done()]:
                    yield running.pop(future), future.result()
        finally:
            self._client.cancel(list(running))


def _count_if_there(results: Memory | Store, chunk: Chunk, counter: ProgressCounter) -> bool:
    values = results.read(chunk)
    if values is not None:
        counter.add(values["status"], reused=True)
    return values is not None
