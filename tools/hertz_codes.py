"""OpenSees' materials of Hertz, Hertzdamp and JankowskiImpact, beside ours: laws that are not linear in contact."""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from vibroscope.app.export.decks import DeckProblem, deck
from vibroscope.engine import CONTACT_LAWS, System, TimeStepping, simulate

from tools.other_codes import AGREE, CASES, PERIODS, STEPS, distance, run_opensees

MATERIALS = {"jankowski": "JankowskiImpact", "hunt-crossley": "Hertzdamp", "flores": "Hertzdamp"}
NUDGE = 1e-11  # by which our own start is moved, to see how long two runs stay together


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


def sections(problem: DeckProblem, nudge: float = 0.0) -> np.ndarray:
    """Our states at the ends of periods, from a start at which both bodies are moved."""
    x1, v1, x2, v2 = problem.start
    start = (x1 + nudge, v1, x2 + nudge, v2)
    run = simulate(problem.system, problem.eta, problem.method, periods=PERIODS, keep=PERIODS, initial=start)
    return run.section[:, [0, 2, 1, 3]]


def together(one: np.ndarray, other: np.ndarray) -> int:
    """Periods for which two runs agree."""
    apart = [k for k, (a, b) in enumerate(zip(one, other, strict=False)) if distance(a, b) > AGREE]
    return apart[0] if apart else min(len(one), len(other))


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
    from vibroscope.engine.laws import damper_of

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


def law_cells(problem: DeckProblem, folder: Path) -> list[str]:
    """A row of the table: η, K, law, material, steps, what is found."""
    method = problem.method
    states, stopped = run_opensees(deck("opensees", problem), folder)
    ours = sections(problem)
    theirs = states[method.steps :: method.steps]
    last = min(len(ours), len(theirs)) - 1
    apart = distance(ours[last], theirs[last])
    if MATERIALS[method.law] == "Hertzdamp":
        found = hertz_force(problem, states)
        words = (
            f"{apart:.0e} apart after {last + 1} periods; its force is that of its formula to {found.fault:.0e}, but "
            f"without damper in {100.0 * found.undamped:.0f} % of the steps in contact"
        )
    else:
        own, alike = together(ours, sections(problem, NUDGE)), together(ours, theirs)
        words = f"agree to {AGREE:.0e} for {alike} periods; ours and ours from a start {NUDGE:.0e} off for {own}"
    if stopped is not None:
        words += f"; it stops in step {stopped}"
    numbers = f"{problem.eta:g}", f"{method.stiffness:g}"
    return [*numbers, method.law, f"`{MATERIALS[method.law]}`", f"T/{method.steps}", words]
