"""OpenSees' materials of Hertz, Hertzdamp and JankowskiImpact, beside ours: laws that are not linear in contact."""

import math
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from vibroscope.app.export.decks import DeckProblem, deck
from vibroscope.engine import CONTACT_LAWS, System, TimeStepping, simulate
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.drivers.time_stepping import as_steps_see, linear_scheme
from vibroscope.engine.kernels.equations.contact_law import gain_at
from vibroscope.engine.kernels.time_stepping.linear_step import FORCE, GAIN, STATE_ROWS, WORK, LinearScheme, take_step

from tools.other_codes import AGREE, CASES, PERIODS, STEPS, distance, from_bodies, run_opensees, to_bodies

MATERIALS = {"jankowski": "JankowskiImpact", "hunt-crossley": "Hertzdamp", "flores": "Hertzdamp"}


def is_offered() -> bool:
    """Whether this version has their laws."""
    return set(MATERIALS) <= set(CONTACT_LAWS)


def law_problems() -> list[DeckProblem]:
    """Newmark's method at four η and K, the damper by the formula of each law."""
    return [
        DeckProblem(System(), eta, method_of(law, K, n), periods=PERIODS, keep=1)
        for law in MATERIALS
        for n in STEPS
        for eta, K, _ in CASES
    ]


def method_of(law: str, stiffness: float, steps: int) -> TimeStepping:
    """Newmark's method with a law of Hertz."""
    return TimeStepping(stiffness, None, steps, status="end", law=law, initial_acceleration="zero")


class Growth(NamedTuple):
    """What becomes of the difference of single steps."""

    steps: int
    own: float  # largest difference of a step of theirs from ours from the same beginning
    disturbed: float  # what our last state differs by, if each of our steps is off by as much, at random


def growth(problem: DeckProblem, states: np.ndarray) -> Growth:
    """Ours beside their states, (steps + 1, 6), step by step."""
    after, random = partial(step_of, scheme_of(problem), problem.method.steps), np.random.default_rng(1)
    own = max(distance(after(state, k), states[k + 1]) for k, state in enumerate(states[:-1]))
    state = moved = states[0]
    for k in range(len(states) - 1):
        state, moved = after(state, k), after(moved, k)
        moved[:4] += own * random.uniform(-1.0, 1.0, 4)
    return Growth(len(states) - 1, own, distance(state, moved))


def scheme_of(problem: DeckProblem) -> LinearScheme:
    """What our steps are made of."""
    parameters = as_steps_see(parameters_of(problem.system, problem.eta, problem.method))
    return linear_scheme(parameters, problem.method)


def step_of(scheme: LinearScheme, steps: int, state: np.ndarray, k: int) -> np.ndarray:
    """The end of our step k from a state of bodies that touch at rest."""
    x, *ends = np.zeros((3, WORK))
    ends, angle = np.array(ends), 2.0 * math.pi * k / steps
    x[:FORCE], x[STATE_ROWS : STATE_ROWS + 3] = from_bodies(state), (math.cos(angle), math.sin(angle), 1.0)
    x[GAIN] = gain_at(scheme.system.law, 0.0)
    status, _, _ = take_step(scheme, 0, int(state[1] <= state[0]), x, ends)
    return to_bodies(ends[status, :FORCE])


def closing_speeds(states: np.ndarray) -> np.ndarray:
    """Of each step in contact: the closing speed at the end of the first step of its contact; 0 apart."""
    gap, rate = states[:, 1] - states[:, 0], states[:, 3] - states[:, 2]
    found = np.zeros(len(states))
    for k in range(1, len(states)):
        if gap[k] < 0.0:
            found[k] = found[k - 1] if gap[k - 1] < 0.0 and found[k - 1] > 0.0 else max(-rate[k], 0.0)
    return found


class Force(NamedTuple):
    """OpenSees' contact force beside the formula of Hertzdamp."""

    fault: float  # largest difference from it, or from the spring alone, relative to the largest force
    undamped: float  # share of the steps in contact in which it is that of the spring alone


def hertz_force(problem: DeckProblem, states: np.ndarray) -> Force:
    """Compare what body 1 lacks for its equation of motion at the end of each step, which is the contact force.

    The closing speed of the formula is that at the end of the first step in contact.
    """
    from vibroscope.engine.law_table import damper_of

    system, method, steps = problem.system, problem.method, np.arange(len(states))
    load = problem.eta**2 * np.cos(2.0 * math.pi * steps / method.steps)
    force = load - states[:, 0] - 2.0 * system.d1 * states[:, 2] - states[:, 4]
    depth, speed, first = states[:, 0] - states[:, 1], states[:, 2] - states[:, 3], closing_speeds(states)
    ratio, _ = damper_of(system, method)
    spring = method.stiffness * np.maximum(depth, 0.0) ** method.exponent
    law = spring * (1.0 + ratio * speed / np.where(first > 0.0, first, math.inf))
    faults = np.abs([force - law, force - spring])[:, 1:] / spring.max()
    lost = (faults[1] < faults[0])[depth[1:] > 0.0]
    return Force(float(faults.min(axis=0).max()), float(lost.mean()))


class LawRow(NamedTuple):
    """One run of both."""

    problem: DeckProblem
    stopped: int | None  # the step that stopped theirs
    periods: int  # that both have done
    apart: float  # difference after these
    growth: Growth | None  # of JankowskiImpact
    force: Force | None  # of Hertzdamp

    @property
    def words(self) -> str:
        """What is found."""
        stop = f"; it stops in step {self.stopped}" if self.stopped is not None else ""
        if self.force:
            return (
                f"{self.apart:.0e} apart; its formula to {self.force.fault:.0e}, without damper in "
                f"{100.0 * self.force.undamped:.0f} % of the contact{stop}"
            )
        if self.apart <= AGREE:
            return f"agree to {self.apart:.0e}{stop}"
        if self.apart > 10.0 * self.growth.disturbed or self.growth.own > AGREE:
            return "unexplained"
        return f"{self.growth.own:.0e} a step grows to {self.apart:.0e}, ours to {self.growth.disturbed:.0e}{stop}"


def compare_law(problem: DeckProblem, folder: Path) -> LawRow:
    """Run a problem in both."""
    method = problem.method
    states, stopped = run_opensees(deck("opensees", problem), folder)
    ours = simulate(problem.system, problem.eta, method, periods=PERIODS, keep=PERIODS, initial=problem.start).section
    theirs = states[method.steps :: method.steps]
    last = min(len(ours), len(theirs)) - 1
    apart, damped = distance(ours[last, [0, 2, 1, 3]], theirs[last]), MATERIALS[method.law] == "Hertzdamp"
    found = (None, hertz_force(problem, states)) if damped else (growth(problem, states), None)
    return LawRow(problem, stopped, last + 1, apart, *found)


def law_cells(row: LawRow) -> list[str]:
    """A row of the table: η, K, law, material, steps, what is found."""
    method = row.problem.method
    numbers = f"{row.problem.eta:g}", f"{method.stiffness:g}"
    return [*numbers, method.law, f"`{MATERIALS[method.law]}`", f"T/{method.steps}", row.words]
