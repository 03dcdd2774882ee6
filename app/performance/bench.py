"""Cost and error of each solver, beside a plain loop and heyoka: the numbers of ``vibroscope bench``.

Costs are those of 200 periods from rest; errors are the largest of the four state components after 10 periods, against
60-digit solutions. Without the solutions they are null.

The 60-digit solutions are those in ``assets/truth``.

All contenders take turns in one process, and medians over many turns count; a ratio is the median of the turns' own
ratios. A machine that is slower for a while is then slower for all, and since seconds are the processor's, other
programs do not count. Each timed run follows a short one that is not timed, which brings code and tables back into the
caches. Only solving is timed, not what a solver prepares once: the engine's tables, heyoka's compilation.
"""

import json
import math
import os
import platform
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.performance import peers
from vibroscope.app.performance.peers import PeerSolver
from vibroscope.app.runtime.files import ASSETS
from vibroscope.engine import ExactPenalty, Method, Newmark, Reference, Response, System, simulate

PERIODS = 200
CHECKED = 10  # periods after which a state is compared with the truth
SYSTEM = System()


@dataclass(frozen=True)
class Contender:
    """A solver of one problem from rest.

    Attributes
    ----------
    name : str
    solve : callable
        Takes the number of periods; returns processor seconds and the state at their end, (4,).
    """

    name: str
    solve: Callable[[int], tuple[float, np.ndarray]]


def engine_seconds(solve: Callable[[], Response]) -> tuple[float, Response]:
    """Processor seconds in compiled code, from above, and the response.

    The response counts them by the wall clock, which goes on while another program has the processor; then the
    processor seconds of the whole call, its preparation included, are the closer bound.
    """
    begin = time.thread_time()
    response = solve()
    return min(response.cost.seconds, time.thread_time() - begin), response


def engine_contender(name: str, eta: float, method: Method) -> Contender:
    """A solver of the engine; its state is nan where the run ended early."""

    def solve(periods):
        seconds, response = engine_seconds(lambda: simulate(SYSTEM, eta, method, periods=periods, keep=1))
        return seconds, response.section[-1] if response.ok else np.full(4, math.nan)

    return Contender(name, solve)


def peer_contender(name: str, run: PeerSolver) -> Contender:
    """A solver that is not the engine's, with nothing left to prepare."""

    def solve(periods):
        begin = time.thread_time()
        state = run(periods)
        return time.thread_time() - begin, state

    return Contender(name, solve)


def run_seconds(contender: Contender, periods: int) -> float:
    """Seconds of one run, its code and tables fresh in the caches."""
    if periods > CHECKED:
        contender.solve(CHECKED)
    return contender.solve(periods)[0]


def time_in_turns(contenders: Iterable[Contender], periods: int, rounds: int) -> dict[str, np.ndarray]:
    """Microseconds per period of each contender in each round, (rounds,); in a round all take turns."""
    contenders = list(contenders)
    for contender in contenders:  # compiles
        contender.solve(CHECKED)
    turns = [[run_seconds(contender, periods) for contender in contenders] for _ in range(rounds)]
    seconds = dict(zip((contender.name for contender in contenders), np.array(turns).T, strict=True))
    return {name: spent / periods * 1e6 for name, spent in seconds.items()}


def ratio(turns: dict[str, np.ndarray], theirs: str, ours: str) -> float | None:
    """How many times as long ``theirs`` takes as ``ours``; None if it did not run."""
    return float(np.median(turns[theirs] / turns[ours])) if theirs in turns else None


TRUTH = ASSETS / "truth"


@cache
def solutions() -> tuple[dict, ...]:
    """The 60-digit solutions from rest: ``eta``, ``method``, and the ``state`` after `CHECKED` periods or None.

    Empty where the files are missing.
    """
    found = []
    for key, case in _cases("truth.json").items():
        law, eta, numbers = key.split("|")
        if law == "ref":
            method = Reference({"published": "table"}.get(numbers, numbers))
        else:
            method = ExactPenalty(*map(float, numbers.split(",")))
        found.append({"eta": float(eta), "method": method, "state": case["states"].get(str(CHECKED))})
    for case in _cases("hard.json").values():
        if case["system"] or any(case["initial"]) or case["periods"] < CHECKED or case["status"] != "ok":
            continue
        numbers = dict(case["method"])
        kind = {Reference.name: Reference, ExactPenalty.name: ExactPenalty}[numbers.pop("name")]
        found.append({"eta": case["eta"], "method": kind(**numbers), "state": case["states"][CHECKED - 1]})
    return tuple(found)


def _cases(name: str) -> dict:
    path = TRUTH / name
    return json.loads(path.read_text(encoding="utf-8"))["cases"] if path.is_file() else {}


def true_state(eta: float, method: Reference | ExactPenalty) -> np.ndarray | None:
    """The state after `CHECKED` periods from rest, (4,); None where there is no 60-digit solution."""
    for case in solutions():
        if case["eta"] == eta and case["method"] == method and case["state"] is not None:
            return np.array([float(x) for x in case["state"]])
    return None


def state_error(contender: Contender, truth: np.ndarray | None) -> float | None:
    """Largest difference from the truth after `CHECKED` periods; None where there is no truth or no result."""
    if truth is None:
        return None
    error = float(np.abs(contender.solve(CHECKED)[1] - truth).max())
    return error if math.isfinite(error) else None


ROUNDS = 25
STEPS = (2000, 8000)
REFERENCE = Reference("derived")  # what a penalty model tends to, and what other solvers' figures are given for


def report(periods: int = PERIODS, rounds: int = ROUNDS) -> dict:
    """The whole report: the machine, the setting, and the four scenes [A] to [D]."""
    chosen = {key: scene for key, scene in scenes().items() if scene.group == "motion"}
    return {
        "machine": {"processor": processor(), "cores": os.cpu_count(), "python": platform.python_version()},
        "heyoka": peers.heyoka_version(),
        "periods": periods,
        "rounds": rounds,
        "error_after_periods": CHECKED,
        "scenes": {
            key: measure_scene(scene.setting.eta, float(scene.setting.K), float(scene.setting.D), periods, rounds)
            for key, scene in chosen.items()
        },
    }


def processor() -> str:
    """The processor's name, as far as the system gives it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()


def measure_scene(eta: float, stiffness: float, damping: float, periods: int, rounds: int) -> dict:
    """All figures of one scene, by the names that ``--json`` prints."""
    reference, penalty = _reference_contenders(eta), _penalty_contenders(eta, stiffness, damping)
    turns = time_in_turns([*reference, *penalty], periods, rounds)
    truths = true_state(eta, REFERENCE), true_state(eta, ExactPenalty(stiffness, damping))
    errors = {
        contender.name: state_error(contender, truth)
        for group, truth in zip((reference, penalty), truths, strict=True)
        for contender in group
    }
    return {
        "eta": eta,
        "K": stiffness,
        "D": damping,
        **_costs(turns),
        "errors": {
            "reference": errors["reference"],
            "exact": errors["exact"],
            "newmark_plain": _by_steps(errors, "plain"),
            "newmark_fast": _by_steps(errors, "fast"),
            "newmark_located": _by_steps(errors, "located"),
            "heyoka": errors.get("heyoka"),
            "heyoka_penalty": errors.get("heyoka penalty"),
        },
        "notes": _notes(truths),
    }


def _reference_contenders(eta: float) -> list[Contender]:
    contenders = [engine_contender("reference", eta, REFERENCE)]
    if peers.heyoka_version():
        d3 = SYSTEM.joint_damping(REFERENCE.joint_damping)
        run = peers.heyoka_reference(SYSTEM, eta, d3, REFERENCE.threshold)
        contenders.append(peer_contender("heyoka", run))
    return contenders


def _penalty_contenders(eta: float, stiffness: float, damping: float) -> list[Contender]:
    """Each peer stands next to the solver that it is compared with."""
    contenders = [engine_contender("exact", eta, ExactPenalty(stiffness, damping))]
    if peers.heyoka_version():
        contenders.append(peer_contender("heyoka penalty", peers.heyoka_penalty(SYSTEM, eta, stiffness, damping)))
    for n in STEPS:
        contenders += [
            engine_contender(f"every step {n}", eta, Newmark(stiffness, damping, n, every_step=True)),
            peer_contender(f"plain {n}", peers.plain_loop(SYSTEM, eta, stiffness, damping, n)),
            engine_contender(f"fast {n}", eta, Newmark(stiffness, damping, n)),
            engine_contender(f"located {n}", eta, Newmark(stiffness, damping, n, located=True)),
        ]
    return contenders


def _costs(turns: dict[str, np.ndarray]) -> dict:
    """Costs and their ratios."""
    cost = {name: float(np.median(spent)) for name, spent in turns.items()}

    def per_step(name):
        return sum(cost[f"{name} {n}"] / n * 1e3 for n in STEPS) / len(STEPS)

    return {
        "reference_us_per_period": cost["reference"],
        "exact_us_per_period": cost["exact"],
        "newmark_plain_ns_per_step": per_step("plain"),
        "newmark_every_step_ns_per_step": per_step("every step"),
        "newmark_fast_us_per_period": _by_steps(cost, "fast"),
        "newmark_located_us_per_period": _by_steps(cost, "located"),
        "newmark_plain_over_fast": {str(n): ratio(turns, f"plain {n}", f"fast {n}") for n in STEPS},
        "heyoka_us_per_period": cost.get("heyoka"),
        "heyoka_over_reference": ratio(turns, "heyoka", "reference"),
        "heyoka_penalty_us_per_period": cost.get("heyoka penalty"),
        "heyoka_over_exact": ratio(turns, "heyoka penalty", "exact"),
    }


def _by_steps(values: dict, name: str) -> dict:
    return {str(n): values[f"{name} {n}"] for n in STEPS}


def _notes(truths: tuple) -> list[str]:
    """Why a figure is null."""
    problems = [name for name, truth in zip(("reference", "penalty"), truths, strict=True) if truth is None]
    why = "the files of assets/truth are not here" if not solutions() else "assets/truth has no such solution"
    notes = [f"errors of the {name} problem are null: {why}" for name in problems]
    if not peers.heyoka_version():
        notes.append("heyoka is not installed: pip install heyoka")
    return notes
