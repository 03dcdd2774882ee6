"""Both solvers for one setting: kept runs, worker threads, and the latest move wins.

The kernels release the GIL, so plain threads serve many sessions. No panel import.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from vibroscope.app.explorer.state import Explorer, Setting
from vibroscope.app.runtime import logs, metrics
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.workers import workers
from vibroscope.engine import (
    Cancelled,
    Motion,
    Newmark,
    Record,
    Reference,
    Response,
    System,
    Trajectory,
    motion,
    simulate,
)

# Periods drawn in the phase plots, at most: all of a shorter cycle, or so many of a motion that does not repeat.
ORBIT_PERIODS = 12
_ORBIT_SAMPLES = 1000
TRACE_PERIODS = 2
# Samples per period. The reference is smooth between its events, which it lists.
# The penalty's shortest contact (half a period of √(K(1+1/μ)) at K = 10⁵, η = 0.5)
# lasts T/1850: so many leave four samples in it even there, and its peak within 8 %.
_SAMPLES = {Reference: 1000, Newmark: 8000}
# A run holds up to 1.5 MB of samples; two runs make a frame.
_CACHED_RUNS = 48


@dataclass(frozen=True, eq=False)
class Run:
    """What one solver found: the kept periods, the last two sampled finely, the orbit for the phase plots.

    ``motion``, ``trace`` and ``orbit`` are None where the run diverged.
    """

    response: Response
    motion: Motion | None
    trace: Trajectory | None
    orbit: Trajectory | None


@dataclass(frozen=True, eq=False)
class Frame:
    """Everything the views need for one setting."""

    setting: Setting
    reference: Run
    penalty: Run


Method = Reference | Newmark


_CACHE = Cache(_CACHED_RUNS)


def frame_of(setting: Setting, cancelled: Callable[[], bool] | None = None, cache: Cache = _CACHE) -> Frame:
    """Both runs for ``setting``, from the cache where they are in it."""
    return Frame(setting, *(_cached_run(setting, method, cancelled, cache) for method in _methods(setting)))


def kept_frame(setting: Setting, cache: Cache = _CACHE) -> Frame | None:
    """The frame for ``setting`` if both runs are in the cache: it costs nothing."""
    runs = [cache.get(_key(setting, method)) for method in _methods(setting)]
    return None if None in runs else Frame(setting, *runs)


def _methods(setting: Setting) -> tuple[Reference, Newmark]:
    return setting.reference, setting.penalty


def _key(setting: Setting, method: Method) -> object:
    return setting.system, setting.eta, method


def _cached_run(setting: Setting, method: Method, cancelled: Callable[[], bool] | None, cache: Cache) -> Run:
    key = _key(setting, method)
    run = cache.get(key)
    if run is None:
        run = _solve(*key, cancelled)
        cache.put(key, run)
    return run


def _solve(system: System, eta: float, method: Method, cancelled: Callable[[], bool] | None) -> Run:
    record = Record(TRACE_PERIODS, _SAMPLES[type(method)])
    response = simulate(system, eta, method, record=record, cancelled=cancelled)
    if not response.ok:
        return Run(response, None, None, None)
    found = motion(response)
    trace, response = response.trajectory, replace(response, trajectory=None)
    return Run(response, found, trace, _orbit(response, trace, found.period, cancelled))


def _orbit(response: Response, trace: Trajectory, period: int, cancelled: Callable[[], bool] | None) -> Trajectory:
    """The last cycle, of which most are within the trace; longer ones are gone through once more."""
    periods = min(period or ORBIT_PERIODS, ORBIT_PERIODS)
    if periods <= TRACE_PERIODS:
        per_period = (len(trace.time) - 1) // TRACE_PERIODS
        return _last(trace, periods * per_period, max(1, per_period // _ORBIT_SAMPLES))
    again = simulate(
        response.system,
        response.eta,
        response.method,
        periods=response.keep,
        keep=response.keep,
        initial=response.checkpoint,
        record=Record(periods, _ORBIT_SAMPLES),
        cancelled=cancelled,
    )
    return again.trajectory


def _last(sampled: Trajectory, count: int, stride: int) -> Trajectory:
    """The last ``count`` intervals, each ``stride``-th sample from the end; copied, so that it can be freed."""
    begin = len(sampled.time) - 1 - count // stride * stride
    return Trajectory(
        *(
            np.ascontiguousarray(values[..., begin::stride])
            for values in (sampled.time, sampled.displacement, sampled.velocity, sampled.force)
        )
    )


class Latest:
    """One session's jobs: at most one runs and one waits, the newest.

    A job that is overtaken is still delivered if it ends within ``grace`` seconds,
    or a long drag would show nothing until it stops; after that it is cancelled.
    ``deliver(move, result)`` is called in a worker thread, in the order of the
    moves, with a `Frame` or with the exception that the job ended in.
    """

    def __init__(
        self,
        deliver: Callable[[int, Frame | Exception], None],
        *,
        solve: Callable[..., Frame] = frame_of,
        pool: ThreadPoolExecutor | None = None,
        grace: float = 0.4,
        what: str = "computed",
        measure: metrics.Durations = metrics.SOLVED,
    ) -> None:
        self._deliver = deliver
        self._solve = solve
        self._pool = pool or workers()
        self._grace = grace
        self._what, self._measure = what, measure  # as the log and the metrics name it
        self._lock = threading.Lock()
        self._waiting: tuple[int, Setting] | None = None
        self._busy = False
        self._closed = False
        self._session = logs.session.get()

    def submit(self, move: int, setting: Setting) -> None:
        """Ask for ``setting``; one that still waits is dropped."""
        with self._lock:
            self._waiting = (move, setting)
            if self._busy or self._closed:
                return
            self._busy = True
        self._pool.submit(self._work)

    def withdraw(self) -> None:
        """What waits is wanted no more; what runs goes on."""
        with self._lock:
            self._waiting = None

    def close(self) -> None:
        """Nothing is wanted any more; a running job is cancelled, nothing is delivered."""
        with self._lock:
            self._closed = True
            self._waiting = None

    def _work(self) -> None:
        with logs.in_session(self._session):
            while (job := self._next()) is not None:
                self._run(*job)

    def _run(self, move: int, setting: Setting) -> None:
        begun = time.monotonic()
        patience = begun + self._grace
        try:
            result: Frame | Exception = self._solve(setting, cancelled=lambda: self._overtaken(patience))
        except Cancelled:
            return
        except Exception as error:  # told on the page; a worker must not die of it
            result = error
            logs.event(f"not {self._what}", logging.ERROR, error=error, move=move)
        else:
            seconds = time.monotonic() - begun
            self._measure.add(seconds)
            logs.event(self._what, move=move, seconds=seconds)
        if self._closed:
            return
        try:
            self._deliver(move, result)
        except Exception as error:  # else the session would wait for this job for ever
            logs.event("not delivered", logging.ERROR, error=error, move=move)

    def _overtaken(self, patience: float) -> bool:
        return self._closed or (self._waiting is not None and time.monotonic() > patience)

    def _next(self) -> tuple[int, Setting] | None:
        with self._lock:
            job, self._waiting = self._waiting, None
            self._busy = job is not None
            return job


def warm() -> None:
    """Compile or load the kernels and keep the default frame, ahead of the first visitor."""
    workers().submit(frame_of, Explorer().setting())
