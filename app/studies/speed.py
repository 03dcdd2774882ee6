"""Speed against error of the present setting, measured while a user watches. No panel import.

Error and cost are those of the shipped figure (`app.performance.bench`), from the start that is set: the largest
difference of the four state components after 10 periods, and processor time per period over 200 periods. The penalty
solution is the one that is set: its integrator, contact status and law. The error of its fixed and its located step is
that against the exact penalty model, to which both tend as Δτ → 0. The reference and the exact penalty model have no
time step and do not approximate one another: here they have a cost alone, and their errors stand in the shipped figure.
Where K follows the step, each n has a K of its own, and its error is that against the exact penalty model of that K.

All solvers take turns, and medians over the turns count: a machine that is slower for a while is slower for all.
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from vibroscope.app.performance.bench import CHECKED, PERIODS, engine_seconds
from vibroscope.app.performance.peers import plain_loop
from vibroscope.app.studies.time_step import question_as_dict
from vibroscope.engine import (
    NEWMARK_LAWS,
    Cancelled,
    Method,
    Reference,
    System,
    TimeStepping,
    simulate,
    stiffness_of_step,
    with_located_steps,
)
from vibroscope.engine.arguments import Poll

FACTORS = (0.25, 0.5, 1.0, 2.0, 4.0)  # of the n that is set
SWEPT = ("fixed", "plain", "located")  # have a time step
KINDS = ("reference", "exact", *SWEPT)
ROUNDS = (1, 3, 6, 10, 15)  # turns after which there is a partial result; the last ends the measurement
_FEWEST = 4  # steps that Newmark takes


@dataclass(frozen=True)
class SpeedQuestion:
    """A measurement to make: a class, since a tuple would equal another study's of the same numbers."""

    system: System
    eta: float
    method: TimeStepping  # with steps that are not located
    reference: Reference
    initial: tuple[float, float, float, float] | None = None  # rest
    stiffness_of_step: float | None = None  # s, where K follows the step: that of the method is K of its own n

    def method_at(self, steps: int) -> TimeStepping:
        """The method with another n, and the K that goes with it."""
        method = replace(self.method, steps=steps)
        if self.stiffness_of_step is None or steps == self.method.steps:
            return method
        return replace(method, stiffness=stiffness_of_step(self.system, self.eta, steps, self.stiffness_of_step))

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of `KINDS` that exist for the method: not every contact law has skipped steps."""
        return tuple(kind for kind in KINDS if kind != "plain" or self.method.law in NEWMARK_LAWS)


class SolverKey(NamedTuple):
    """A solver: one of `KINDS`, and n, which is 0 where there is no time step."""

    kind: str
    steps: int


class TimedRun(NamedTuple):
    """Processor seconds, the last state (4,) (nan where it diverged), and solves: one for each stage of a step."""

    seconds: float
    state: np.ndarray
    solves: int


Solve = Callable[[int, Poll], TimedRun]  # of so many periods, and whether it was cancelled


@dataclass(frozen=True, eq=False)
class PartialSpeed:
    """A measurement after some turns, by solver: error, solves per period, µs per period of each turn."""

    question: SpeedQuestion
    errors: dict[SolverKey, float]
    solves: dict[SolverKey, float]
    turns: dict[SolverKey, tuple[float, ...]]

    @property
    def rounds(self) -> int:
        """Turns that are done."""
        return len(next(iter(self.turns.values())))

    @property
    def share(self) -> float:
        """The share of the turns that are done."""
        return self.rounds / ROUNDS[-1]

    def cost(self, key: SolverKey) -> float:
        """Microseconds per period, the median of the turns."""
        return float(np.median(self.turns[key]))

    def stepless(self, kind: str) -> float:
        """Microseconds per period of ``reference`` or ``exact``, which have no time step."""
        return self.cost(SolverKey(kind, 0))

    def curve(self, kind: str) -> list[SolverKey]:
        """Solvers of one kind that did not diverge, by ascending n."""
        return sorted(key for key in self.errors if key.kind == kind and math.isfinite(self.errors[key]))

    def times(self, dear: SolverKey, cheap: SolverKey) -> float:
        """How many times as long ``dear`` takes: the median of the turns' own ratios."""
        return float(np.median(np.divide(self.turns[dear], self.turns[cheap])))

    def data(self) -> dict[str, object]:
        """The results so far, for a file: columns over the solvers, and the question."""
        question, keys = question_as_dict(self.question), list(self.turns)
        if self.question.stiffness_of_step is not None:
            of_each = (self.question.method_at(key.steps) if key.steps else self.question.method for key in keys)
            question |= {"solver_K": [method.stiffness for method in of_each]}
        return question | {
            "periods": PERIODS,
            "error_after_periods": CHECKED,
            "rounds": self.rounds,
            "solver": [key.kind for key in keys],
            "solver_steps": [key.steps for key in keys],
            "us_per_period": [self.cost(key) for key in keys],
            "solves_per_period": [self.solves[key] for key in keys],
            "error": np.array([self.errors.get(key, math.nan) for key in keys]),
        }


def steps_around(steps: int) -> list[int]:
    """n/4 to 4n, whole and at least 4, ascending."""
    return sorted({max(_FEWEST, round(factor * steps)) for factor in FACTORS})


def solvers(question: SpeedQuestion) -> dict[SolverKey, Solve]:
    """All solvers, in the order of their turns; those that are compared stand next to each other."""
    found = {
        SolverKey("reference", 0): _engine_solver(question, question.reference),
        SolverKey("exact", 0): _engine_solver(question, question.method.limit),
    }
    for n in steps_around(question.method.steps):
        method = question.method_at(n)
        found[SolverKey("fixed", n)] = _engine_solver(question, method)
        if "plain" in question.kinds:
            found[SolverKey("plain", n)] = _plain_solver(question, method)
        if "located" in question.kinds:
            found[SolverKey("located", n)] = _engine_solver(question, with_located_steps(method))
    return found


def _engine_solver(question: SpeedQuestion, method: Method) -> Solve:
    problem, start = (question.system, question.eta, method), {"keep": 1, "initial": question.initial}
    stages = method.stages

    def solve(periods, cancelled):
        seconds, response = engine_seconds(lambda: simulate(*problem, periods=periods, cancelled=cancelled, **start))
        if response.ok:
            return TimedRun(seconds, response.section[-1], stages * response.cost.steps)
        gone = np.full(4, math.nan)
        if (taken := response.cost.steps) and not method.located:  # the cost of a period is that of its steps
            return TimedRun(seconds * periods * method.steps / taken, gone, stages * periods * method.steps)
        return TimedRun(seconds, gone, stages * taken)

    return solve


def _plain_solver(question: SpeedQuestion, method: TimeStepping) -> Solve:
    """The loop of an FE code; that of Newmark's method runs to its end once begun, a third of a second at the most.

    The latter shows the cost of a step, and runs from rest and without clearance or forces, wherever the others do.
    """
    if not (method.plain and method.linear):
        return _engine_solver(question, replace(method, every_step=True))
    steps = method.steps
    run = plain_loop(question.system, question.eta, method.stiffness, method.damping, steps)

    def solve(periods, cancelled):
        if cancelled():
            raise Cancelled
        begin = time.thread_time()
        state = run(periods)
        return TimedRun(time.thread_time() - begin, state, steps * periods)

    return solve


def grow_speed(question: SpeedQuestion, last: PartialSpeed | None, cancelled: Poll) -> Iterator[PartialSpeed]:
    """Partial results from ``last`` on: errors and one turn first, then more turns. Raises `Cancelled`."""
    if last is not None:
        yield last
    done = 0 if last is None else last.rounds
    if done >= ROUNDS[-1]:
        return
    by_key = solvers(question)
    errors = _errors(question, by_key, cancelled) if last is None else last.errors
    turns = {key: () if last is None else last.turns[key] for key in by_key}
    for wanted in (count for count in ROUNDS if count > done):
        for _ in range(wanted - done):
            runs = {key: _timed(solve, cancelled) for key, solve in by_key.items()}
            turns = {key: (*turns[key], runs[key].seconds / PERIODS * 1e6) for key in by_key}
        done = wanted
        yield PartialSpeed(question, errors, {key: run.solves / PERIODS for key, run in runs.items()}, turns)


def _timed(solve: Solve, cancelled: Poll) -> TimedRun:
    """One run; a short one before it brings code and tables into the caches."""
    solve(CHECKED, cancelled)
    return solve(PERIODS, cancelled)


def _errors(question: SpeedQuestion, by_key: dict[SolverKey, Solve], cancelled: Poll) -> dict[SolverKey, float]:
    """Largest difference from the exact penalty model after `CHECKED` periods; nan where either gave up.

    The plain loop takes the steps that the fixed step skips: of the same system and start, the same solution.
    """
    exact = {question.method.limit: by_key[SolverKey("exact", 0)](CHECKED, cancelled).state}

    def error(key):
        limit = question.method_at(key.steps).limit
        if limit not in exact:
            exact[limit] = _engine_solver(question, limit)(CHECKED, cancelled).state
        return float(np.abs(by_key[key](CHECKED, cancelled).state - exact[limit]).max())

    found = {key: error(key) for key in by_key if key.kind in ("fixed", "located")}
    found |= {key: found[SolverKey("fixed", key.steps)] for key in by_key if key.kind == "plain"}
    return {key: error if math.isfinite(error) else math.nan for key, error in found.items()}
