"""Runs of other codes beside ours: the decks of `vibroscope export`, step by step.

OpenSees is run where openseespy can be imported, CalculiX where there is a command ccx.
"""

import math
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, replace
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np
from vibroscope.app.export.decks import DeckProblem, deck
from vibroscope.engine import HHT, NewmarkBeta, System, TimeStepping, simulate
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.drivers.step_maps import bodies_of, spectral_radius, stage_ends, stage_maps
from vibroscope.engine.integrators import TRBDF2, GeneralisedAlpha, HHTInterpolated

PERIODS = 10
CASES = ((1.08, 2500, 8), (2.76, 12000, 18), (3.25, 12000, 18), (2.2, 40000, 30))  # eta, K, D
STEPS = (500, 2000)
INTEGRATORS = (NewmarkBeta(), NewmarkBeta(0.3025, 0.6), HHTInterpolated(-0.1), GeneralisedAlpha(0.8), TRBDF2())
AGREE = 1e-8
DISTURBANCES = 5  # of our steps, to see how far they carry: some end in a step without a solution
TOLERANCE = 1e-13  # of OpenSees' iterations here
FORCE, GAP = 6, 7  # rows of the end of a stage

_RECORD = """
import runpy, sys
import numpy as np
import openseespy.opensees as ops
states, analyze = [], ops.analyze
def state():
    return [get(node, 1) for get in (ops.nodeDisp, ops.nodeVel, ops.nodeAccel) for node in (1, 2)]
def recorded(*arguments):
    if not states:
        states.append(state())
    failed = analyze(*arguments)
    if not failed:
        states.append(state())
    return failed
ops.analyze = recorded
try:
    runpy.run_path(sys.argv[1])
finally:
    np.save(sys.argv[2], states)
"""


# ---- OpenSees -------------------------------------------------------------------------------------------------------


def opensees_version() -> str | None:
    """Its version, None where it cannot be imported."""
    if find_spec("openseespy") is None:
        return None
    program = "import openseespy.opensees"  # a library that it needs may be missing
    done = subprocess.run([sys.executable, "-c", program], capture_output=True)
    return version("openseespy") if done.returncode == 0 else None


def run_opensees(text: str, folder: Path) -> tuple[np.ndarray, int | None]:
    """Displacements, velocities and accelerations at each step, (steps, 6); the step that stopped the run."""
    (folder / "deck.py").write_text(re.sub("(?m)^TOLERANCE = [^ ]+", f"TOLERANCE = {TOLERANCE}", text))
    call = [sys.executable, "-c", _RECORD, str(folder / "deck.py"), str(folder / "states.npy")]
    done = subprocess.run(call, capture_output=True, text=True)
    stopped = re.search(r"step (\d+)", done.stderr) if done.returncode else None
    if done.returncode and not stopped:
        raise RuntimeError(done.stderr)
    halves = int(re.search(r"(?m)^SUBSTEPS = (\d+)", text)[1])
    return np.load(folder / "states.npy")[::halves], int(stopped[1]) if stopped else None


class Walk(NamedTuple):
    """Our steps beside those of another code."""

    steps: int  # that theirs took
    own: float  # largest difference of a step of theirs from the nearest solution that we find from its beginning
    stops: bool  # whether, where theirs stops, no solution is found from its state
    alike: bool  # nor from ours
    followed: float  # difference at the end, if we take their solution wherever there are two, or where we have none
    disturbed: float  # the largest difference at the end, if each of our steps is off by as much as theirs are
    other: list[int]  # steps with two solutions in which they take the one that we would not


@dataclass(frozen=True)
class Steps:
    """All solutions of a step, from our step matrices."""

    problem: DeckProblem

    def __post_init__(self):
        method = self.problem.method
        bodies = bodies_of(parameters_of(self.problem.system, self.problem.eta, method))
        maps = stage_maps(bodies, method.integrator, 2.0 * math.pi / self.problem.eta / method.steps)
        object.__setattr__(self, "maps", maps)
        object.__setattr__(self, "contact", bodies.contact)

    def solutions(self, state: np.ndarray, k: int) -> dict[tuple[int, ...], np.ndarray]:
        """The ends of step k that agree with their contact status, by the status of each stage."""
        angle = 2.0 * math.pi * k / self.problem.method.steps
        x = np.concatenate([from_bodies(state), [0.0, math.cos(angle), math.sin(angle), 1.0]])
        stages = [()]
        found = {}
        count = len(self.maps)
        for stage in range(count):
            stages = [(*former, status) for former in stages for status in (0, 1)]
            kept = []
            for statuses in stages:
                forces = [self.contact if status else None for status in statuses]
                *_, (_, _, _, end) = stage_ends(self.maps[: stage + 1], forces)
                end = end @ x
                if (end[GAP] <= 0.0) == (statuses[-1] == 1):
                    kept.append(statuses)
                    if stage == count - 1:
                        found[statuses] = to_bodies(end[:FORCE])
            stages = kept
        return found

    def walk(self, theirs: np.ndarray, stopped: int | None) -> Walk:
        """Beside the states of another code, which begin where ours do."""
        last = len(theirs) - 1
        nearest = (
            min((distance(end, theirs[k + 1]) for end in self.solutions(theirs[k], k).values()), default=math.inf)
            for k in range(last)
        )
        own = max(nearest, default=0.0)
        states, other = self.follow(theirs)
        stops = stopped is None or not self.solutions(theirs[-1], last)
        alike = stopped is None or (len(states) > last and not self.solutions(states[-1], last))
        followed = distance(states[-1], theirs[len(states) - 1])
        seeds = range(1, 1 + (DISTURBANCES if followed > AGREE else 1))
        paths = (self.follow(theirs, own, seed)[0] for seed in seeds)
        ends = ((path, min(len(path), len(states)) - 1) for path in paths)
        moved = max(distance(path[k], states[k]) for path, k in ends)
        return Walk(last, own, stops, alike, followed, moved, other)

    def follow(self, theirs: np.ndarray, noise: float = 0.0, seed: int = 1) -> tuple[list[np.ndarray], list[int]]:
        """Our states, and the steps in which theirs takes the one of two solutions that we would not.

        Where there are two, theirs is taken. ``noise``: by how much displacements and velocities are disturbed in each
        step, at random by the ``seed``. The states end where there is no solution.
        """
        states, other, state, former, random = [theirs[0]], [], theirs[0], 1, np.random.default_rng(seed)
        for k, after in enumerate(theirs[1:]):
            ours = self.solutions(state, k)
            if not ours:
                break
            kept = former
            usual = min(ours, key=lambda each: (each[0] != kept, each[-1] != each[0]))
            chosen = min(ours, key=lambda each: distance(ours[each], after))
            if chosen != usual:
                other.append(k + 1)
            state, former = ours[chosen].copy(), chosen[-1]
            state[:4] += noise * random.uniform(-1.0, 1.0, 4)
            states.append(state)
        return states, other


def from_bodies(state: np.ndarray) -> np.ndarray:
    """Displacements, velocities and accelerations of body 1 and of the gap from those of bodies that touch at rest."""
    return state - np.array([0.0, 1.0] * 3) * np.repeat(state[::2], 2)


def to_bodies(state: np.ndarray) -> np.ndarray:
    """The reverse."""
    return state + np.array([0.0, 1.0] * 3) * np.repeat(state[::2], 2)


def distance(one: np.ndarray, other: np.ndarray) -> float:
    """Between displacements and velocities of two states."""
    return float(np.abs(one[:4] - other[:4]).max())


class Row(NamedTuple):
    """One run of both."""

    problem: DeckProblem
    theirs: int | None  # the step that stopped it
    ours: int | None
    difference: float  # of displacements and velocities at the end
    walk: Walk

    @property
    def cause(self) -> str:
        """What explains the difference; "agree" where there is none to explain."""
        walk = self.walk
        if not walk.stops or walk.own > AGREE:
            return "unexplained"
        if self.theirs is not None and self.theirs == self.ours:
            return f"both stop in step {self.theirs}"
        if self.theirs is self.ours is None and self.difference <= AGREE:
            return "agree"
        if walk.other:
            found = f"other solution of step {walk.other[0]}"
            if self.theirs is None:
                return f"{found}, then {self.grown(walk.followed)}"
            if walk.alike:
                return f"{found}, then both stop in step {self.theirs}"
            return f"{found}, then {self.grown(walk.followed)}; theirs has none of step {self.theirs}"
        if self.theirs is self.ours is None:
            return self.grown(self.difference)
        grown = self.grown(walk.followed)
        if self.theirs is None and grown != "unexplained":
            return f"{grown}; ours has none of step {self.ours}"
        return "unexplained"

    def grown(self, difference: float) -> str:
        """Whether a difference is what becomes of that of single steps."""
        if difference <= AGREE:
            return "they agree"
        if difference <= 10.0 * self.walk.disturbed:
            return f"{self.walk.own:.0e} a step grows to {difference:.0e}, ours to {self.walk.disturbed:.0e}"
        return "unexplained"


def compare_opensees(problem: DeckProblem, folder: Path) -> Row:
    """Run a problem in both."""
    theirs, stopped = run_opensees(deck("opensees", problem), folder)
    method = problem.method
    ours = simulate(problem.system, problem.eta, method, periods=problem.periods, keep=1, initial=problem.initial)
    both = ours.ok and stopped is None
    difference = distance(ours.section[-1], theirs[-1][[0, 2, 1, 3]]) if both else math.nan
    own_stop = re.search(r"step (\d+)", ours.message)
    return Row(
        problem, stopped, int(own_stop[1]) if own_stop else None, difference, Steps(problem).walk(theirs, stopped)
    )


def problems() -> list[DeckProblem]:
    """What is compared with OpenSees, whose accelerations are zero at the start unless they are given."""
    return [
        DeckProblem(
            System(), eta, TimeStepping(k, d, n, i, "end", initial_acceleration="zero"), periods=PERIODS, keep=1
        )
        for n in STEPS
        for eta, k, d in CASES
        for i in INTEGRATORS
    ]


def repeated(row: Row, folder: Path) -> str | None:
    """Where OpenSees stops with Newton's iterations alone, if that is not where it stops with others after them."""
    if row.problem.integrator.name == "tr-bdf2":
        return None
    alone = deck("opensees", row.problem).replace('("Newton", "KrylovNewton")', '("Newton",)')
    _, stopped = run_opensees(alone, folder)
    return None if stopped == row.theirs else f"step {stopped}"


@dataclass(frozen=True)
class EndInertia(GeneralisedAlpha):
    """What OpenSees' GeneralizedAlpha does from its second iteration on: the inertia is that of the end of the step."""

    @property
    def stages(self):
        """The same coefficients but for the inertia's."""
        return (super().stages[0]._replace(alpha_m=0.0),)


class Inertia(NamedTuple):
    """OpenSees' GeneralizedAlpha beside two methods of ours."""

    proper: float  # largest difference of a step from generalised-α
    end: float  # and from the same with the inertia at the end of the step
    radii: tuple[float, float]  # spectral radii of the latter without dampers: apart, in contact


def end_inertia(folder: Path) -> Inertia:
    """What GeneralizedAlpha does at η = 2.76, T/2000, for ρ∞ = 0.8."""
    proper = next(
        p for p in problems() if (p.eta, p.method.steps, p.integrator.name) == (2.76, 2000, "generalised-alpha")
    )
    rho = proper.integrator.rho
    text = deck("opensees", proper)
    own = text.replace(
        f'"HHTGeneralized", {rho!r}', f'"GeneralizedAlpha", {(2.0 - rho) / (1.0 + rho)!r}, {1.0 / (1.0 + rho)!r}'
    )
    theirs, stopped = run_opensees(own, folder)
    end = replace(proper, method=replace(proper.method, integrator=EndInertia(rho)))
    bodies = bodies_of(parameters_of(System(d1=0.0, d2=0.0), end.eta, replace(end.method, damping=0.0)))
    maps = stage_maps(bodies, end.integrator, 2.0 * math.pi / end.eta / end.method.steps)
    radii = tuple(spectral_radius(maps, force) for force in (None, bodies.contact))
    return Inertia(*(Steps(each).walk(theirs, stopped).own for each in (proper, end)), radii)


# ---- CalculiX -------------------------------------------------------------------------------------------------------


def calculix_version() -> str | None:
    """Its version, None where there is no command ccx."""
    if shutil.which("ccx") is None:
        return None
    done = subprocess.run(["ccx", "-v"], capture_output=True, text=True)
    return re.search(r"[\d.]+", done.stdout)[0].strip(".")


def run_calculix(problem: DeckProblem, folder: Path, change=str) -> np.ndarray:
    """Time, ξ₁ and ξ₂ of the samples, as the command in the deck makes them; fewer where the run stopped.

    ``change``: a function of the text of the deck.
    """
    text = change(deck("calculix", problem))
    (folder / f"{problem.name}.inp").write_text(text)
    convert = next(line.removeprefix("** ") for line in text.splitlines() if line.startswith("** awk"))
    one_thread = os.environ | {"OMP_NUM_THREADS": "1"}
    with (folder / "log").open("w") as log:
        subprocess.run(["ccx", problem.name], cwd=folder, stdout=log, stderr=log, env=one_thread)
    subprocess.run(convert, shell=True, cwd=folder, check=True)
    return np.loadtxt(folder / f"{problem.name}.csv", delimiter=",", skiprows=1, ndmin=2)


def default_tolerance(text: str) -> str:
    """A deck of CalculiX without its tolerances."""
    return re.sub(r"\*CONTROLS.*\n.*\n", "", text)


def as_spring2(text: str) -> str:
    """A deck of CalculiX whose nonlinear spring is SPRING2, which counts its length in the other direction."""
    _, *rows, _ = re.split(r"(?s)ELSET=TOUCH, NONLINEAR\n(.*?), (.*?)\n0., (.*?)\n0., (.*?)\n", text)
    push, deep, touch, apart = (f"{-float(row):.13E}" for row in rows)
    turned = f"ELSET=TOUCH, NONLINEAR\n1, 1\n0., {apart}\n0., {touch}\n{push}, {deep}\n"
    text = re.sub(r"(?s)ELSET=TOUCH, NONLINEAR\n.*?\n.*?\n.*?\n", turned, text)
    return text.replace("TYPE=SPRINGA, ELSET=TOUCH", "TYPE=SPRING2, ELSET=TOUCH")


def compare_calculix(problem: DeckProblem, folder: Path, change=str) -> tuple[float, float]:
    """Periods that it ran, and the largest difference of displacements at the ends of periods, in units of length."""
    theirs, every = run_calculix(problem, folder, change), problem.method.steps // problem.every
    ours = simulate(problem.system, problem.eta, problem.method, periods=problem.periods, keep=problem.keep)
    ends = theirs[every - 1 :: every, 1:] / problem.length
    difference = np.abs(ends - ours.section[: len(ends), [0, 2]]).max() if len(ends) else math.nan
    return len(theirs) / every, float(difference)


def calculix_problems() -> list[DeckProblem]:
    """What is compared with CalculiX; it finds the accelerations at the start itself."""
    numbers = (
        (0.0, 500, 3, NewmarkBeta()),
        (0.0, 500, 3, HHT()),
        (18.0, 2000, 2, NewmarkBeta()),
        (18.0, 2000, 2, HHT()),
    )
    stopped = ((18.0, 500, 2, NewmarkBeta()),)
    return [
        DeckProblem(System(), 2.76, TimeStepping(12000.0, d, n, i, "end"), periods=periods, keep=periods)
        for d, n, periods, i in (*numbers, *stopped)
    ]
