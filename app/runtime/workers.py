"""The thread pools of one process, shared by all sessions; threads suffice because the kernels release the GIL.

Sessions take turns. The next job of a pool is one of the session that has had least of its threads lately, whatever
came first, and a long job that calls `give_way` now and then lets such jobs run at once, and rests while they run in
other threads. So a session pays for its expensive jobs with its own waiting time. Jobs in the background rest, too,
while a page is built or figures are on their way (`ahead_of_jobs`).

Every pool is created here, so that a server that stops knows which jobs are still running.
"""

import contextlib
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

from vibroscope.app.runtime import metrics
from vibroscope.app.runtime.settings import current_settings

_SOLVER = "solver"
_NICE = 10  # added to the niceness of the process for background threads; on Linux each thread has its own
_HALF_LIFE = 10.0  # s after which half of what a session has had is forgotten
SHORT, LONG = 0.1, 2.0  # margins of pools whose jobs take tenths of a second, and seconds: see `Workers`
_REST = 0.05  # s after which a job that rests looks again
LONGEST_REST = 1.0  # s for which a job waits for Python code of higher priority; then it works for as long
_MOST_NESTED = 4  # jobs that give way to each other in one thread; each may have started threads that still run
_FORGOTTEN = 1e-3  # s: a session that has had less is forgotten


@dataclass(eq=False)
class _Job:
    session: str
    work: Callable[[], object]
    future: Future
    submitted: float
    begun: float = 0.0  # by `own_time`
    since: float = 0.0  # when it began to run, after it last gave way


class _Thread(threading.local):
    """The state of one thread: its pool, and the jobs that run in it, each interrupting the one before."""

    def __init__(self) -> None:
        self.pool: Workers | None = None
        self.running: list[_Job] = []
        self.given = 0.0  # s for which jobs interrupted others, or rested for work of higher priority
        self.works_until = 0.0  # when a job of this thread may rest again for work of higher priority


_thread = _Thread()
_ahead = threading.Condition()
_count_ahead = 0


@contextlib.contextmanager
def ahead_of_jobs() -> Iterator[None]:
    """Let the jobs that call `stand_aside` rest while this runs.

    For Python code that a visitor waits for: beside jobs of Python code it would have the interpreter's lock only in
    its turn.
    """
    global _count_ahead
    with _ahead:
        _count_ahead += 1
    try:
        yield
    finally:
        with _ahead:
            _count_ahead -= 1
            _ahead.notify_all()


def give_way() -> None:
    """Let jobs of sessions run that have had less time than that of the job which calls this.

    Those that wait run in its place; those that run in other threads have the processors, since the job rests.

    Call it from a job that runs long, in the job's own thread, many times a second, and hold no lock that another job
    may wait for.
    """
    if _thread.running:
        _thread.pool.run_lighter_jobs()


def stand_aside() -> None:
    """Rest while what is `ahead_of_jobs` runs, at most half of the time: for a job that no figure waits for.

    Call it as `give_way`.
    """
    begun = time.monotonic()
    if not (_count_ahead and _thread.running) or begun < _thread.works_until:
        return
    with _ahead:
        _ahead.wait_for(lambda: not _count_ahead, LONGEST_REST)
    rested = time.monotonic() - begun
    _thread.given += rested
    _thread.works_until = begun + 2 * rested


def own_time() -> float:
    """Seconds of a clock that stands still while this thread's job gives way.

    Differences count between two calls of a job in one thread.
    """
    return time.monotonic() - _thread.given


class Workers(ThreadPoolExecutor):
    """A thread pool in which sessions take turns.

    Parameters
    ----------
    name : str
        Name of its threads.
    threads : int
        Number of threads.
    initializer : callable, optional
        Runs once in each thread.
    waited : metrics.Durations, optional
        Where the time goes for which jobs wait for a thread.
    margin : float
        Seconds that a running job's session must have had more than another for the job to give way. The job goes on
        only after what ran in its place, so that first results should take no longer than this.
    """

    def __init__(
        self,
        name: str,
        threads: int,
        initializer: Callable[[], None] | None = None,
        waited: metrics.Durations | None = None,
        margin: float = SHORT,
    ) -> None:
        super().__init__(max_workers=threads, thread_name_prefix=name, initializer=initializer)
        self._waited, self._margin = waited, margin
        self._lock = threading.Lock()
        self._ended = threading.Condition(self._lock)  # a job has
        self._waiting: list[_Job] = []
        self._running = 0
        self._active: list[_Job] = []  # those that run and do not give way
        self._had: dict[str, float] = {}  # s of this pool's threads by session
        self._counted = time.monotonic()  # when the last part of that was forgotten

    def submit(self, job: Callable, /, *args, session: str = "", **kwargs) -> Future:
        """See `concurrent.futures.Executor.submit`; ``session`` is the one that the job belongs to.

        After the end of the pool the job is cancelled as those are that wait then: a page may still be built, or a job
        go on, in a thread of its own while the server stops.
        """
        entry = _Job(session, partial(job, *args, **kwargs), Future(), time.monotonic())
        with self._lock:
            self._waiting.append(entry)
        try:
            super().submit(self._run_next)
        except RuntimeError:  # the pool is shut down
            with self._lock:
                self._waiting.remove(entry)
            entry.future.cancel()
        return entry.future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """See `concurrent.futures.Executor.shutdown`."""
        if cancel_futures:
            with self._lock:
                cancelled, self._waiting = self._waiting, []
            for entry in cancelled:
                entry.future.cancel()
        super().shutdown(wait, cancel_futures=cancel_futures)

    @property
    def jobs(self) -> int:
        """Number of jobs that wait or run."""
        return len(self._waiting) + self._running

    def run_lighter_jobs(self) -> None:
        """See `give_way`."""
        if len(_thread.running) > _MOST_NESTED or self.jobs == len(_thread.running):
            return
        running, given, begun = _thread.running[-1], _thread.given, time.monotonic()
        more = own_time() - running.begun - self._margin
        self._set_active(running, False)
        while True:
            if (entry := self._next_job(running.session, more)) is not None:
                self._run(entry)
            elif not self._rest(running.session, more):
                break
        self._set_active(running, True)
        _thread.given = given + time.monotonic() - begun  # with what those gave in their turn

    def _set_active(self, job: _Job, active: bool) -> None:
        with self._lock:
            job.since = time.monotonic()
            self._active.append(job) if active else self._active.remove(job)

    def _rest(self, session: str, more: float) -> bool:
        """Wait a moment if a job of a session runs that has had less, with ``more`` to this one's; whether it did."""
        with self._lock:
            now, had = time.monotonic(), self._had.get(session, 0.0) + more
            lighter = any(
                job.session != session and self._had.get(job.session, 0.0) + now - job.since < had
                for job in self._active
            )
            if lighter:
                self._ended.wait(_REST)
        return lighter

    def _run_next(self) -> None:
        entry = self._next_job()
        if entry is not None:  # else another job gave way to the one that this call was submitted for
            _thread.pool = self
            self._run(entry)

    def _next_job(self, session: str | None = None, more: float = 0.0) -> _Job | None:
        """The next job, where a session is given only if that has had more than the job's own, with ``more`` to it."""
        with self._lock:
            self._forget()
            entry = min(self._waiting, key=lambda entry: self._had.get(entry.session, 0.0), default=None)
            if entry is None:
                return None
            if session is not None and self._had.get(entry.session, 0.0) >= self._had.get(session, 0.0) + more:
                return None
            self._waiting.remove(entry)
            self._running += 1
        return entry

    def _run(self, entry: _Job) -> None:
        entry.begun = own_time()
        if self._waited is not None:
            self._waited.add(time.monotonic() - entry.submitted)
        _thread.running.append(entry)
        self._set_active(entry, True)
        try:
            if entry.future.set_running_or_notify_cancel():
                try:
                    result = entry.work()
                except BaseException as error:  # as in `concurrent.futures`: it belongs to who asked
                    entry.future.set_exception(error)
                else:
                    entry.future.set_result(result)
        finally:
            _thread.running.pop()
            seconds = own_time() - entry.begun
            self._set_active(entry, False)
            with self._lock:
                self._running -= 1
                self._ended.notify_all()
                self._forget()  # what is older than this job
                self._had[entry.session] = self._had.get(entry.session, 0.0) + seconds

    def _forget(self) -> None:
        now = time.monotonic()
        kept = 0.5 ** ((now - self._counted) / _HALF_LIFE)
        self._counted = now
        self._had = {name: had * kept for name, had in self._had.items() if had * kept > _FORGOTTEN}


_pools: dict[str, Workers] = {}
_pools_lock = threading.Lock()


def pool(
    name: str,
    threads: int,
    initializer: Callable[[], None] | None = None,
    waited: metrics.Durations | None = None,
    margin: float = SHORT,
) -> Workers:
    """Return the pool of this name, created on first use: see `Workers`."""
    with _pools_lock:
        if name not in _pools:
            _pools[name] = Workers(name, threads, initializer, waited, margin)
        return _pools[name]


def workers() -> Workers:
    """Return the pool that solves what figures wait for."""
    return pool(_SOLVER, current_settings().threads, waited=metrics.WAITED)


def background_worker() -> Workers:
    """Return a thread for explanations: beside two of them figures would have a third of the interpreter's lock.

    One that takes seconds keeps no other session waiting, since it gives way.
    """
    return pool("patient", 1, lower_priority)


def jobs() -> int:
    """Number of figures that wait for a thread or are being solved."""
    return _pools[_SOLVER].jobs if _SOLVER in _pools else 0


def lower_priority() -> None:
    """Give this thread, and those that it starts, a lower priority than the solvers of the figures (on Linux)."""
    if sys.platform == "linux":
        own = os.getpriority(os.PRIO_PROCESS, os.getpid())
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), own + _NICE)  # the system takes at most 19


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
