"""The thread pools of one process, shared by all sessions; threads suffice because the kernels release the GIL.

Every pool is created here, so that a server that stops knows which jobs are still running.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

from vibroscope.app.runtime import metrics
from vibroscope.app.runtime.settings import current_settings

_SOLVER = "solver"
_NICE = 10  # added to the niceness of background threads; on Linux each thread has its own


class Workers(ThreadPoolExecutor):
    """A thread pool that counts its unfinished jobs."""

    def __init__(self, name: str, threads: int, initializer: Callable[[], None] | None = None) -> None:
        super().__init__(max_workers=threads, thread_name_prefix=name, initializer=initializer)
        self._jobs = 0
        self._lock = threading.Lock()

    def submit(self, job: Callable, /, *args, **kwargs) -> Future:
        """See `concurrent.futures.Executor.submit`."""
        self._count(1)
        try:
            future = super().submit(job, *args, **kwargs)
        except RuntimeError:  # the pool is shut down
            self._count(-1)
            raise
        future.add_done_callback(lambda _: self._count(-1))
        return future

    def _count(self, more: int) -> None:
        with self._lock:
            self._jobs += more

    @property
    def jobs(self) -> int:
        """Number of jobs that wait or run."""
        return self._jobs


class _Solvers(Workers):
    """The pool that solves what figures wait for; it measures how long a job waits for its thread."""

    def submit(self, job: Callable, /, *args, **kwargs) -> Future:
        submitted = time.monotonic()

        def measured():
            metrics.WAITED.add(time.monotonic() - submitted)
            return job(*args, **kwargs)

        return super().submit(measured)


_pools: dict[str, Workers] = {}
_pools_lock = threading.Lock()


def _pool(name: str, create: Callable[[], Workers]) -> Workers:
    with _pools_lock:
        if name not in _pools:
            _pools[name] = create()
        return _pools[name]


def pool(name: str, threads: int, initializer: Callable[[], None] | None = None) -> Workers:
    """Return the pool of this name, created on first use; ``initializer`` runs once in each of its threads."""
    return _pool(name, lambda: Workers(name, threads, initializer))


def workers() -> Workers:
    """Return the pool that solves what figures wait for."""
    return _pool(_SOLVER, lambda: _Solvers(_SOLVER, current_settings().threads))


def background_worker() -> Workers:
    """Return a pool of two threads for explanations, so that many of them never delay another session's figures.

    Two, since one that takes seconds must not keep all other sessions waiting.
    """
    return pool("patient", 2)


def jobs() -> int:
    """Number of figures that wait for a thread or are being solved."""
    return _pools[_SOLVER].jobs if _SOLVER in _pools else 0


def lower_priority() -> None:
    """Give this thread, and those that it starts, a lower priority than the solvers of the figures (on Linux)."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)


def shut_down(seconds: float) -> int:
    """Cancel the waiting jobs of all pools, give the running ones ``seconds`` to end, and return how many still run.

    No pool takes jobs afterwards. Cancel what can be cancelled beforehand: at exit the interpreter waits for every
    thread without a limit, and jobs that start threads of their own then fail.
    """
    deadline = time.monotonic() + seconds
    pools = list(_pools.values())
    for each in pools:
        each.shutdown(wait=False, cancel_futures=True)
    while (left := sum(each.jobs for each in pools)) and time.monotonic() < deadline:
        time.sleep(0.02)
    return left


metrics.QUEUE.read = lambda: {name: each.jobs for name, each in sorted(_pools.items())}
