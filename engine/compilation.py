"""Compilation of all kernels ahead of their first use: in what order, how far it is, and whether it has been done.

A kernel is compiled when it is first called, once for each processor and each version of the sources; the machine code
is kept in the cache folder. It takes minutes, most of it in a few kernels, into which everything is inlined that they
call. So progress is counted in compiled functions, not in kernels.

Several processes fill one cache folder. Each makes the calls that no other has begun, the first process from the first
call on and those that help it from the last: calls that share functions stand beside each other, so that one process
makes them. In the end the first process makes all calls: it loads what others have compiled, and compiles what is
missing. A process that helps reads nothing from its input, and ends where that ends: with the process that it helps,
however that ends.
"""

import itertools
import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from enum import IntEnum
from pathlib import Path
from typing import NamedTuple

import numpy as np
from vibroscope.engine.cells import Cells, run_cells
from vibroscope.engine.divergence.compare import ComparisonQuestion, compare
from vibroscope.engine.divergence.verdict import verdict
from vibroscope.engine.drivers.code_cache import CompileListener, compilable_functions, complete_mark, is_cache_private
from vibroscope.engine.drivers.event_driven import hybrid_state
from vibroscope.engine.drivers.orbit import OrbitEquations, event, numbers_of, steps
from vibroscope.engine.energy.balance import energy_balance
from vibroscope.engine.integrators import HHT
from vibroscope.engine.load import Load
from vibroscope.engine.methods import ExactPenalty, Method, Newmark, Reference, TimeStepping, with_located_steps
from vibroscope.engine.model import System
from vibroscope.engine.motions.lyapunov import lyapunov
from vibroscope.engine.motions.motion import motion
from vibroscope.engine.motions.section import settled_period
from vibroscope.engine.motions.steady import steady
from vibroscope.engine.one_impact.forward import impact
from vibroscope.engine.one_impact.question import Impact
from vibroscope.engine.result import Record
from vibroscope.engine.simulate import simulate
from vibroscope.engine.sweeps.plane_study import PlaneStudy
from vibroscope.engine.transients.run import transient

COMMAND = sys.executable, "-m", f"{__package__}.compilation"


class Claims:
    """Which calls have been begun by any process: each has a file in a folder that they share."""

    def __init__(self, folder: str | Path):
        self._folder = Path(folder)

    def take(self, call: int) -> bool:
        """Whether this process makes a call: it is the first to ask."""
        try:
            (self._folder / str(call)).touch(exist_ok=False)
        except FileExistsError:
            return False
        return True


class Helpers:
    """Processes that help this one, for the time of a block.

    Parameters
    ----------
    count : int
        How many.
    compiled : callable
        Called, in other threads, with the name of each function that one of them has compiled.
    command : sequence of str
        What starts one; the folder of the claims is added to it.

    Attributes
    ----------
    claims : Claims
        Those of all.
    """

    def __init__(self, count: int, compiled: Callable[[str], None], command: Sequence[str] = COMMAND):
        self._count, self._compiled, self._command = count, compiled, command
        self._changed = threading.Condition()
        self._done: set[int] = set()
        self._running = 0

    def __enter__(self) -> "Helpers":
        self._folder = tempfile.TemporaryDirectory(prefix="vibroscope-compile-")
        self.claims = Claims(self._folder.name)
        self._processes, self._listeners = [], []
        try:
            for _ in range(self._count):
                self._start()
        except OSError:  # there can be no more processes: this one compiles alone
            pass
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *error: object) -> None:
        for process in self._processes:
            process.stdin.close()  # which ends it
        for process, listener in zip(self._processes, self._listeners, strict=True):
            process.wait()
            listener.join()
            process.stdout.close()
        self._folder.cleanup()

    def wait(self, calls: Iterable[int]) -> None:
        """Wait until the calls are made by those who have begun them, unless one of the processes has failed."""
        calls = set(calls)
        with self._changed:
            self._changed.wait_for(lambda: self._done >= calls or self._running < self._count)

    def made(self, call: int) -> None:
        """Note that a call is made, by this process."""
        with self._changed:
            self._done.add(call)

    def _start(self) -> None:
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        process = subprocess.Popen([*self._command, self._folder.name], **pipes)
        self._processes.append(process)
        self._running += 1
        listener = threading.Thread(target=self._listen, args=(process,), name="compiles", daemon=True)
        self._listeners.append(listener)
        listener.start()

    def _listen(self, process: subprocess.Popen) -> None:
        try:
            for line in process.stdout:
                what = json.loads(line)
                if isinstance(what, int):
                    with self._changed:
                        self._done.add(what)
                        self._changed.notify_all()
                else:
                    self._compiled(what)
        finally:
            with self._changed:
                self._running -= 1
                self._changed.notify_all()


def report(what: str | int) -> None:
    """Report to the process that is helped which function is compiled, or which call is made."""
    print(json.dumps(what), flush=True)


def end_with_input() -> None:
    """Let this process end as soon as its input does."""

    def watch() -> None:
        sys.stdin.read()
        os._exit(0)

    threading.Thread(target=watch, name="input", daemon=True).start()


class Compiled(IntEnum):
    """How much of what is needed is compiled."""

    NOTHING = 0
    MOTIONS = 1  # by which the explorer shows the motions that it opens with, those of Newmark's method
    VERDICTS = 2  # by which it explains them
    ALL = 3


class CompileProgress(NamedTuple):
    """How far the compilation is.

    Attributes
    ----------
    share : float
        0 to 1; of the functions that may have to be compiled.
    what : str
        Which solver is being compiled.
    compiled : Compiled
    """

    share: float
    what: str
    compiled: Compiled = Compiled.NOTHING


_NEWMARK = Newmark(2500.0, 8.0, 2000)
_RUNS = {  # what is called, by what it solves
    "reference": Reference(),
    "Newmark": _NEWMARK,
    "exact penalty": ExactPenalty(2500.0, 8.0),
    "other contact laws": ExactPenalty(2500.0, 8.0, "cut"),
    "Newmark, located": with_located_steps(_NEWMARK),
    "Newmark, every step": replace(_NEWMARK, every_step=True),
    "other integrators": TimeStepping(2500.0, 8.0, 2000, HHT()),
    "other integrators, every step": TimeStepping(2500.0, 8.0, 2000, HHT(), every_step=True),
}
# What the explorer opens with, and what its verdict tries beside; those that share functions beside each other.
_OPENING = "reference", "exact penalty", "Newmark"
_TRIED = (
    "other contact laws",
    "other integrators",
    "Newmark, located",
    "Newmark, every step",  # of few steps all are taken
)
_SCENES = (1.08, 100.0, 50.0), (1.08, 2500.0, 8.0), (1.70, 12000.0, 18.0), (2.76, 12000.0, 18.0)  # η, K and D
_BATCHES = ("reference", "exact penalty", "Newmark")
_BEFORE = Compiled.NOTHING, Compiled.MOTIONS, Compiled.MOTIONS, Compiled.VERDICTS  # what is compiled as a stage begins
MOST_PROCESSES = 4  # each takes a gigabyte


def is_compiled() -> bool:
    """Whether `compile_kernels` has been through with these sources, on this processor and with this Numba."""
    return complete_mark().exists()


def compile_kernels(progress: Callable[[CompileProgress], None] | None = None, processes: int | None = 1) -> None:
    """Compile every kernel, or load it from the cache.

    Parameters
    ----------
    progress : callable, optional
        Called whenever a function is ready, by one thread at a time.
    processes : int, optional
        Processes that compile, this one included; None: one for each core, MOST_PROCESSES at most.
    """
    functions, ready, lock, solver, compiled = compilable_functions(), set(), threading.Lock(), "", Compiled.NOTHING

    def count(function: str | None) -> None:
        with lock:
            ready.update(functions & {function})
            if progress is not None:
                progress(CompileProgress(len(ready) / len(functions), solver, compiled))

    if processes is None:
        processes = min(os.cpu_count() or 1, MOST_PROCESSES)
    helping = 0 if is_cache_private() else processes - 1
    with Helpers(helping, count) as helpers, CompileListener(count):
        for compiled, stage in zip(_BEFORE, stages(), strict=True):  # noqa: B007 - `count` reports it
            for call in stage:
                if helpers.claims.take(call.number):
                    solver = call.what
                    count(None)
                    call.make()
                    helpers.made(call.number)
            helpers.wait(call.number for call in stage)
            if helping:
                for call in stage:
                    call.make()
    if progress is not None:
        progress(CompileProgress(1.0, solver, Compiled.ALL))
    mark = complete_mark()
    if mark.parent.exists():
        mark.touch()


def help_to_compile(folder: str) -> None:
    """Make calls that no other process has begun, the last first, and report each to the process that is helped."""
    end_with_input()
    claims, (opening, tried, _, others) = Claims(folder), stages()
    with CompileListener(report):
        for call in (*reversed(opening), *reversed(tried), *reversed(others)):
            if claims.take(call.number):
                call.make()
                report(call.number)


def _run(system: System, method: Method) -> None:
    """Run, record and describe a motion."""
    motion(simulate(system, 1.08, method, periods=4, keep=2, record=Record(1, 16)))


def _step(system: System) -> None:
    """Take a step of Newton's method to an orbit, and find what a branch needs at one."""
    problem, cycle, start, ones = (system, 1.08, Reference()), ((), 0, 1), np.zeros(4), np.ones(5)
    equations = OrbitEquations(*problem)
    hybrid_state(*problem, start)
    found = equations(cycle, start)
    equations.slope(problem, 1e-7, cycle, start, found.residual)
    equations.state_later(event.PART, start, 0.0, 0.1)
    equations.solve(cycle, start.copy(), 1.0)
    scales = steps.scales_of(start, 1.0)
    x, slope, step = np.zeros(5), found.residual.copy(), np.zeros((5, 1))
    steps.step_in_plane((found.residual, found.jacobian), scales, (ones, 1.0), x, slope, step)
    tangent = steps.tangent_of(found.jacobian, slope, scales)
    steps.branch_point_indicator(found.jacobian, slope, tangent)
    steps.doubling_indicator(found.jacobian)
    steps.neimark_sacker_indicator(found.jacobian)
    steps.interpolated(np.zeros(1), np.array([x]), np.array([ones]), ones, 0.1)
    conditions = np.zeros((2, 1), dtype=np.int64)
    steps.margin_values(found.facts, start[4:], 0.0, conditions)
    steps.monodromy_of(found.jacobian)
    steps.impact_that_may_stick(numbers_of((event.PART,)), found.facts, found.facts, 0.0, 0)
    steps.null_vector(np.eye(4, 5))


def _balance_and_load(system: System) -> None:
    """Balance the energy of a law whose contact is open in the end, and run under a pulse."""
    pressed = replace(system, clearance=-10.0)
    energy_balance(simulate(pressed, 1.08, _RUNS["other contact laws"], periods=4, keep=2))
    transient(system, Load.half_sine(1.0, 1.0), Reference())


def _meet() -> None:
    """Let two bodies meet, with a step and without."""
    for status in ("start", "located"):
        question = Impact(TimeStepping(1.0, 0.1, 4, status=status), 1.0, time_step=0.5)
        impact(question)
        question.touches.force(0.5, 4)
    _ = Impact(ExactPenalty(1.0, 0.1), 1.0).without_step  # which is computed when it is asked for


class Call(NamedTuple):
    """A call that loads kernels: its place among all, what it solves, in words, and how it is made."""

    number: int
    what: str
    make: Callable[[], object]


def stages() -> list[list[Call]]:
    """All calls, in stages that are made one after the other: solvers, twice, their differences, everything else.

    The differences need all solvers: no process makes them while another compiles one.
    """
    system, later = System(), [name for name in _RUNS if name not in (*_OPENING, *_TRIED)]
    run = {name: lambda method=method: _run(system, method) for name, method in _RUNS.items()}
    cells = {f"{name}, for studies": Cells(system, [1.08], _RUNS[name]) for name in _BATCHES}
    studies = {what: lambda some=some: run_cells(some, transient=1, sample=2) for what, some in cells.items()}
    found = [
        {name: run[name] for name in _OPENING},
        {name: run[name] for name in _TRIED},
        {
            "differences": lambda: [
                verdict(compare(ComparisonQuestion(system, eta, Newmark(*own, 2000)))) for eta, *own in _SCENES
            ]
        },
        {
            "steady motions": lambda: steady(system, 1.08, Reference()),
            "branches": lambda: _step(system),
            "Lyapunov exponents": lambda: settled_period(lyapunov(system, 1.08, Reference(), periods=256).section),
            **studies,
            "errors of studies": lambda: [
                PlaneStudy(system, method, 2.76, transient=1, sample=2, K=[2500.0], D=[8.0]).compute()
                for method in (_NEWMARK, replace(_NEWMARK, law="cut"))  # in batches, and one by one
            ],
            **{name: run[name] for name in later},
            "energy of other contact laws, and loads": lambda: _balance_and_load(system),
            "one impact": _meet,
        },
    ]
    number = itertools.count()
    return [[Call(next(number), *each) for each in stage.items()] for stage in found]


if __name__ == "__main__":
    help_to_compile(sys.argv[1])
