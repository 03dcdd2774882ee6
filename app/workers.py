"""The threads that solve, shared by all sessions of a process. The kernels release the GIL, so threads are enough."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

from app import metrics
from app.settings import in_force


class Workers(ThreadPoolExecutor):
    """A pool that knows how many jobs wait or run."""

    def __init__(self, threads: int) -> None:
        super().__init__(max_workers=threads, thread_name_prefix="solver")
        self._jobs = 0
        self._counted = threading.Lock()

    def submit(self, job: Callable, /, *args, **kwargs) -> Future:
        """As the pool does, counted."""
        self._count(1)
        asked = time.monotonic()

        def begun():
            metrics.WAITED.add(time.monotonic() - asked)
            return job(*args, **kwargs)

        try:
            future = super().submit(begun)
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


_pool: Workers | None = None
_patient: ThreadPoolExecutor | None = None
_pool_lock = threading.Lock()


def workers() -> Workers:
    """The pool, made when it is first wanted."""
    global _pool
    with _pool_lock:
        if _pool is None:
            _pool = Workers(in_force().threads)
        return _pool


def patient_worker() -> ThreadPoolExecutor:
    """One thread for what may wait, explanations, so that many of them never keep the figures of others waiting."""
    global _patient
    with _pool_lock:
        if _patient is None:
            _patient = ThreadPoolExecutor(1, thread_name_prefix="patient")
        return _patient


def jobs() -> int:
    """Jobs that wait or run now."""
    return _pool.jobs if _pool is not None else 0


metrics.QUEUE.read = jobs
