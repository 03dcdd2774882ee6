"""The threads that compute, shared by all sessions of a process: the kernels release the GIL, so threads are enough.

All of them belong to pools that are made here, so that a server that stops knows what is still under way.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

from vibroscope.app.runtime import metrics
from vibroscope.app.runtime.settings import in_force

_SOLVER = "solver"


class Workers(ThreadPoolExecutor):
    """A pool that knows how many jobs wait or run."""

    def __init__(self, name: str, threads: int, initializer: Callable[[], None] | None = None) -> None:
        super().__init__(max_workers=threads, thread_name_prefix=name, initializer=initializer)
        self._jobs = 0
        self._counted = threading.Lock()

    def submit(self, job: Callable, /, *args, **kwargs) -> Future:
        """As the pool does, counted."""
        self._count(1)
        try:
            future = super().submit(job, *args, **kwargs)
        except RuntimeError:  # shut down
            self._count(-1)
            raise
        future.add_done_callback(lambda _: self._count(-1))
        return future

    def _count(self, more: int) -> None:
        with self._counted:
            self._jobs += more

    @property
    def jobs(self) -> int:
        """Jobs that wait or run."""
        return self._jobs


class _Solvers(Workers):
    """Those that figures wait for: how long they wait is measured."""

    def submit(self, job: Callable, /, *args, **kwargs) -> Future:
        asked = time.monotonic()

        def begun():
            metrics.WAITED.add(time.monotonic() - asked)
            return job(*args, **kwargs)

        return super().submit(begun)


_pools: dict[str, Workers] = {}
_pools_lock = threading.Lock()


def _pool(name: str, make: Callable[[], Workers]) -> Workers:
    with _pools_lock:
        if name not in _pools:
            _pools[name] = make()
        return _pools[name]


def pool(name: str, threads: int, initializer: Callable[[], None] | None = None) -> Workers:
    """The pool of this name, made when it is first wanted; ``initializer`` is called once in each of its threads."""
    return _pool(name, lambda: Workers(name, threads, initializer))


def workers() -> Workers:
    """The threads that solve what figures wait for."""
    return _pool(_SOLVER, lambda: _Solvers(_SOLVER, in_force().threads))


def patient_worker() -> Workers:
    """One thread for what may wait, explanations, so that many of them never keep the figures of others waiting."""
    return pool("patient", 1)


def jobs() -> int:
    """Figures that wait or are solved now."""
    return _pools[_SOLVER].jobs if _SOLVER in _pools else 0


def end(seconds: float) -> int:
    """Drop what has not begun, of all pools, and wait so long for what has; returns how many jobs still run.

    Nothing can be submitted afterwards. What can be withdrawn is to be withdrawn before: the interpreter, ending, waits
    for every thread as long as it takes, and those that start threads of their own then fail.
    """
    limit = time.monotonic() + seconds
    pools = list(_pools.values())
    for each in pools:
        each.shutdown(wait=False, cancel_futures=True)
    while (left := sum(each.jobs for each in pools)) and time.monotonic() < limit:
        time.sleep(0.02)
    return left


metrics.QUEUE.read = lambda: {name: each.jobs for name, each in sorted(_pools.items())}
