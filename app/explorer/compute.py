"""Both solutions for one setting, in worker threads; a newer request replaces the one that waits.

The kernels release the GIL, so plain threads serve many sessions. No panel import.
"""

import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
from vibroscope.app.explorer.presets import opening_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime import logs, metrics
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.compilation import compilation
from vibroscope.app.runtime.workers import Workers, ahead_of_jobs, give_way, own_time, workers
from vibroscope.engine import (
    Cancelled,
    Compiled,
    Motion,
    Record,
    Reference,
    Response,
    System,
    TimeStepping,
    Trajectory,
    free_length,
    motion,
    simulate,
)
from vibroscope.engine.arguments import Poll

# Periods in the phase plots, at most: the whole cycle of a shorter motion, or so many of one that does not repeat.
ORBIT_PERIODS = 12
_ORBIT_SAMPLES = 1000
SHOWN_PERIODS = 2  # in the figures over time: the last ones of a motion that lasts
# Samples per period. The reference is smooth between its events, which it lists.
# The shortest contact of the penalty model (half a period of √(K(1+1/μ)) at K = 10⁵, η = 0.5) lasts T/1850: this number
# leaves four samples in it even there, and finds its peak within 8 %.
_SAMPLES, _SAMPLES_OF_STEPS = 1000, 8000
_FEWEST_SAMPLES = 100  # where so many periods are shown that there are fewer in each

Start = tuple[float, float, float, float]  # ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0


# ---- the runs of one setting ----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class SolverRun:
    """The result of one solver.

    Attributes
    ----------
    response : Response
        The kept periods.
    motion : Motion or None
        The kind of motion; None, like the trajectories, where the run diverged.
    trace : Trajectory or None
        Fine samples of the last `window` periods.
    orbit : Trajectory or None
        The cycle that the phase plots show.
    """

    response: Response
    motion: Motion | None
    trace: Trajectory | None
    orbit: Trajectory | None

    @property
    def window(self) -> int:
        """Periods in the figures over time, the last ones: of a free vibration all that are kept and compared."""
        return SHOWN_PERIODS if self.response.system.excitation.drives else self.response.keep


@dataclass(frozen=True, eq=False)
class RunPair:
    """The runs of both solvers for one setting: everything that the figures need."""

    setting: Setting
    reference: SolverRun
    penalty: SolverRun


_CACHE = Cache(48)  # runs of up to 1.5 MB of samples


def compute_runs(setting: Setting, cancelled: Poll | None = None, cache: Cache = _CACHE) -> RunPair:
    """Both runs for ``setting``, each from the cache if it is there."""
    keys = setting.run_keys.values()
    return RunPair(setting, *(cache.get_or(key, partial(_compute_run, *key, cancelled)) for key in keys))


def cached_runs(setting: Setting, cache: Cache = _CACHE) -> RunPair | None:
    """Both runs for ``setting`` if they are in the cache, else None; nothing is computed."""
    runs = [cache.get(key) for key in setting.run_keys.values()]
    return None if None in runs else RunPair(setting, *runs)


def run_length(system: System, eta: float, initial: Start) -> dict[str, int]:
    """Periods to run and to keep: of a free vibration up to its second contact, as `compare` does, else no others."""
    return {} if system.excitation.drives else dict(_free_length(system, eta, initial))


def shown_periods(setting: Setting) -> int:
    """`SolverRun.window` of the runs of a setting."""
    return run_length(setting.system, setting.eta, setting.initial).get("keep", SHOWN_PERIODS)


@lru_cache(maxsize=64)
def _free_length(system: System, eta: float, initial: Start) -> dict[str, int]:
    return free_length(system, eta, initial)


def free_text(system: System, eta: float, initial: Start) -> str:
    """Which periods of a free vibration are shown."""
    length = run_length(system, eta, initial)
    periods, keep = length["periods"], length["keep"]
    return f"the first {keep} periods" if periods == keep else f"periods {periods - keep + 1} to {periods}"


def _compute_run(
    system: System,
    eta: float,
    method: Reference | TimeStepping,
    initial: Start,
    cancelled: Poll | None,
) -> SolverRun:
    length = run_length(system, eta, initial)
    window = length.get("keep", SHOWN_PERIODS)
    samples = (_SAMPLES_OF_STEPS if method.has_step else _SAMPLES) * SHOWN_PERIODS // window
    record = Record(window, max(_FEWEST_SAMPLES, samples))
    options = length | {"initial": initial, "record": record, "cancelled": cancelled}
    response = simulate(system, eta, method, **options)
    if not response.ok:
        return SolverRun(response, None, None, None)
    found = motion(response)
    trace, response = response.trajectory, replace(response, trajectory=None)
    run = SolverRun(response, found, trace, None)
    return replace(run, orbit=_orbit(run, cancelled))


def _orbit(run: SolverRun, cancelled: Poll | None) -> Trajectory:
    """The last cycle, or all of a free vibration. Most are part of the trace; a longer one is computed again."""
    response, trace, window = run.response, run.trace, run.window
    periods = window
    if response.system.excitation.drives:
        periods = min(run.motion.period or ORBIT_PERIODS, ORBIT_PERIODS, response.keep)
    if periods <= window:
        per_period = (len(trace.time) - 1) // window
        return _tail(trace, periods * per_period, max(1, per_period // _ORBIT_SAMPLES))
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


def _tail(trajectory: Trajectory, intervals: int, stride: int) -> Trajectory:
    """Each ``stride``-th sample of the last ``intervals``, copied so that the whole trajectory can be freed."""
    begin = len(trajectory.time) - 1 - intervals // stride * stride
    return Trajectory(
        *(
            np.ascontiguousarray(values[..., begin::stride])
            for values in (trajectory.time, trajectory.displacement, trajectory.velocity, trajectory.force)
        )
    )


def needed(setting: Setting, first: Compiled) -> Compiled:
    """What must be compiled: ``first`` suffices for the solvers that the explorer opens with, which come first."""
    return first if setting.penalty.has_step and not setting.penalty.has_choices else Compiled.ALL


def warm() -> None:
    """Cache the runs of the opening scene before the first visitor comes; compile the kernels if that is not done."""
    compilation.start()
    compilation.when_done(lambda: workers().submit(compute_runs, opening_setting()), Compiled.MOTIONS)


# ---- the requests of one session ------------------------------------------------------------------------------------


class JobQueue:
    """The figures of one session: at most one computation runs and at most one waits, that of the newest move.

    One that is overtaken by a newer one is still delivered if it ends within ``grace`` seconds, or a long drag would
    show nothing until it stops. After that time it is cancelled. After each its thread is free for other sessions.

    Parameters
    ----------
    deliver : callable
        ``deliver(move, result)`` is called in a worker thread, in the order of the moves, with the result of ``solve``
        or with the exception that it raised.
    solve : callable
        ``solve(setting, cancelled=...)``.
    pool : Workers or None
        Threads to use. None: those that compute figures.
    """

    def __init__(
        self,
        deliver: Callable[[int, Any], None],
        *,
        solve: Callable[..., Any] = compute_runs,
        pool: Workers | None = None,
        grace: float = 0.4,
    ) -> None:
        self._deliver = deliver
        self._solve = solve
        self._pool = pool or workers()
        self._grace = grace
        self._lock = threading.Lock()
        self._waiting: tuple[int, Setting] | None = None
        self._busy = False
        self._closed = False
        self._session = logs.session.get()

    def submit(self, move: int, setting: Setting) -> None:
        """Request a computation; it replaces the one that waits."""
        with self._lock:
            self._waiting = (move, setting)
            if self._busy or self._closed:
                return
            self._busy = True
        act = partial(self._pool.submit, self._work, session=self._session)
        compilation.when_done(act, needed(setting, Compiled.MOTIONS))

    def close(self) -> None:
        """The session has ended: cancel the running job and deliver nothing more."""
        with self._lock:
            self._closed = True
            self._waiting = None

    def _work(self) -> None:
        """Do one job; the next one waits behind those of other sessions, or a session that moves would stop theirs."""
        with self._lock:
            job, self._waiting = self._waiting, None
        if job is not None:
            with logs.in_session(self._session), ahead_of_jobs():
                self._run(*job)
        with self._lock:
            self._busy = again = self._waiting is not None
        if again:
            self._pool.submit(self._work, session=self._session)

    def _run(self, move: int, setting: Setting) -> None:
        begin = own_time()

        def cancelled() -> bool:
            give_way()
            return self._is_overtaken(begin + self._grace)

        try:
            result = self._solve(setting, cancelled=cancelled)
        except Cancelled:
            return
        except Exception as error:  # the page shows it; it must not end the worker thread
            result = error
            logs.event("not computed", logging.ERROR, error=error, move=move)
        else:
            seconds = own_time() - begin
            metrics.SOLVED.add(seconds)
            logs.event("computed", move=move, seconds=seconds)
        if self._closed:
            return
        try:
            self._deliver(move, result)
        except Exception as error:  # without this, the session would wait for the job for ever
            logs.event("not delivered", logging.ERROR, error=error, move=move)

    def _is_overtaken(self, deadline: float) -> bool:
        return self._closed or (self._waiting is not None and own_time() > deadline)
