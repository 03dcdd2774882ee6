"""``vibroscope bench``: what each solver costs and how wrong it is, beside a plain loop and heyoka.

All contenders of a scene take turns, in one process, and medians over many turns count; a ratio is the median of the
turns' own ratios. So a machine that is slower for a while is slower for all; and seconds are the processor's, so that
other programs do not count. A turn begins with a short run that is not timed: it brings code and tables back into the
caches. What is timed is the solving of 200 periods from rest, without what comes once per solver: for the engine its
tables, for heyoka the compilation, some hundred times as long. Errors are the largest of the four state components
after 10 periods, against 60-digit solutions (``assets/truth``); without these files they are null.
"""

from __future__ import annotations

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
from vibroscope.app.explorer.scenes import scenes
from vibroscope.app.performance import peers
from vibroscope.app.runtime.files import ASSETS
from vibroscope.engine import ExactPenalty, Newmark, Reference, Response, System, simulate

PERIODS = 200
CHECKED = 10  # periods after which a state is compared with the truth
ROUNDS = 25
STEPS = (2000, 8000)
SYSTEM = System()
REFERENCE = Reference("derived")  # what a penalty model tends to, and what other solvers' figures are given for
TRUTH = ASSETS / "truth"


@dataclass(frozen=True)
class Contender:
    """Something that solves one problem from rest: periods → seconds and the state at their end, (4,)."""

    name: str
    solve: Callable[[int], tuple[float, np.ndarray]]


def engine_seconds(solve: Callable[[], Response]) -> tuple[float, Response]:
    """Processor seconds in compiled code, from above, and the response.

    The response counts them by the clock on the wall, which goes on while another program has the processor; then the
    processor seconds of the whole call, its preparation included, are the closer bound.
    """
    begin = time.thread_time()
    response = solve()
    return min(response.cost.seconds, time.thread_time() - begin), response


def of_engine(name: str, eta: float, method: Reference | ExactPenalty | Newmark) -> Contender:
    """A solver of the engine."""

    def solve(periods):
        seconds, response = engine_seconds(lambda: simulate(SYSTEM, eta, method, periods=periods, keep=1))
        return seconds, response.section[-1] if response.ok else np.full(4, math.nan)

    return Contender(name, solve)


def of_peer(name: str, run: peers.Run) -> Contender:
    """Somebody else's solver, called with nothing left to prepare; processor seconds."""

    def solve(periods):
        begin = time.thread_time()
        state = run(periods)
        return time.thread_time() - begin, state

    return Contender(name, solve)


def interleaved(contenders: Iterable[Contender], periods: int, rounds: int) -> dict[str, np.ndarray]:
    """Microseconds per period of each contender in each of the rounds, in which all take turns; each (rounds,)."""
    contenders = list(contenders)
    for contender in contenders:  # compiles
        contender.solve(CHECKED)
    turns = [[timed(contender, periods) for contender in contenders] for _ in range(rounds)]
    seconds = dict(zip((contender.name for contender in contenders), np.array(turns).T, strict=True))
    return {name: spent / periods * 1e6 for name, spent in seconds.items()}


def timed(contender: Contender, periods: int) -> float:
    """Seconds of one run, its code and tables fresh in the caches."""
    if periods > CHECKED:
        contender.solve(CHECKED)
    return contender.solve(periods)[0]


def ratio(turns: dict[str, np.ndarray], theirs: str, ours: str) -> float | None:
    """How many times as long theirs takes: the median of the rounds' own ratios; None if it did not run."""
    return float(np.median(turns[theirs] / turns[ours])) if theirs in turns else None


@cache
def solutions() -> tuple[dict, ...]:
    """The 60-digit solutions that start from rest, in one form: η, method, the state after ``CHECKED`` periods."""
    found = []
    path = TRUTH / "truth.json"
    for key, case in json.loads(path.read_text())["cases"].items() if path.exists() else ():
        law, eta, numbers = key.split("|")
        if law == "ref":
            method = Reference({"published": "table"}.get(numbers, numbers))
        else:
            method = ExactPenalty(*map(float, numbers.split(",")))
        found.append({"eta": float(eta), "method": method, "state": case["states"].get(str(CHECKED))})
    path = TRUTH / "hard.json"
    for case in json.loads(path.read_text())["cases"].values() if path.exists() else ():
        if case["system"] or any(case["initial"]) or case["periods"] < CHECKED or case["status"] != "ok":
            continue
        numbers = dict(case["method"])
        kind = {Reference.name: Reference, ExactPenalty.name: ExactPenalty}[numbers.pop("name")]
        found.append({"eta": case["eta"], "method": kind(**numbers), "state": case["states"][CHECKED - 1]})
    return tuple(found)


def truth(eta: float, method: Reference | ExactPenalty) -> np.ndarray | None:
    """The state after ``CHECKED`` periods from rest, (4,), from a 60-digit solution; None where there is none."""
    for case in solutions():
        if case["eta"] == eta and case["method"] == method and case["state"] is not None:
            return np.array([float(x) for x in case["state"]])
    return None


def error(contender: Contender, right: np.ndarray | None) -> float | None:
    """Largest difference from the truth after ``CHECKED`` periods; None where there is no truth or no result."""
    if right is None:
        return None
    wrong = float(np.abs(contender.solve(CHECKED)[1] - right).max())
    return wrong if math.isfinite(wrong) else None


def contenders(eta: float, stiffness: float, damping: float) -> tuple[list[Contender], list[Contender]]:
    """Who solves the reference problem, and who the penalty problem, of one scene."""
    reference = [of_engine("reference", eta, REFERENCE)]
    penalty = [of_engine("exact", eta, ExactPenalty(stiffness, damping))]
    if peers.heyoka_version():  # next to what it is compared with, as the plain loop is
        d3 = SYSTEM.joint_damping(REFERENCE.joint_damping)
        run = peers.heyoka_reference(SYSTEM, eta, d3, REFERENCE.threshold)
        reference.append(of_peer("heyoka", run))
        penalty.append(of_peer("heyoka penalty", peers.heyoka_penalty(SYSTEM, eta, stiffness, damping)))
    for n in STEPS:
        penalty += [
            of_engine(f"every step {n}", eta, Newmark(stiffness, damping, n, every_step=True)),
            of_peer(f"plain {n}", peers.plain_loop(SYSTEM, eta, stiffness, damping, n)),
            of_engine(f"fast {n}", eta, Newmark(stiffness, damping, n)),
            of_engine(f"located {n}", eta, Newmark(stiffness, damping, n, located=True)),
        ]
    return reference, penalty


def measure(eta: float, stiffness: float, damping: float, periods: int, rounds: int) -> dict:
    """All figures of one scene, by the names that ``--json`` prints."""
    reference, penalty = contenders(eta, stiffness, damping)
    turns = interleaved([*reference, *penalty], periods, rounds)
    cost = {name: float(np.median(spent)) for name, spent in turns.items()}
    rights = truth(eta, REFERENCE), truth(eta, ExactPenalty(stiffness, damping))
    wrong = {c.name: error(c, right) for group, right in zip((reference, penalty), rights, strict=True) for c in group}

    def by_steps(values, name):
        return {str(n): values[f"{name} {n}"] for n in STEPS}

    def per_step(name):
        return sum(cost[f"{name} {n}"] / n * 1e3 for n in STEPS) / len(STEPS)

    return {
        "eta": eta,
        "K": stiffness,
        "D": damping,
        "reference_us_per_period": cost["reference"],
        "exact_us_per_period": cost["exact"],
        "newmark_plain_ns_per_step": per_step("plain"),
        "newmark_every_step_ns_per_step": per_step("every step"),
        "newmark_fast_us_per_period": by_steps(cost, "fast"),
        "newmark_located_us_per_period": by_steps(cost, "located"),
        "newmark_plain_over_fast": {str(n): ratio(turns, f"plain {n}", f"fast {n}") for n in STEPS},
        "heyoka_us_per_period": cost.get("heyoka"),
        "heyoka_over_reference": ratio(turns, "heyoka", "reference"),
        "heyoka_penalty_us_per_period": cost.get("heyoka penalty"),
        "heyoka_over_exact": ratio(turns, "heyoka penalty", "exact"),
        "errors": {
            "reference": wrong["reference"],
            "exact": wrong["exact"],
            "newmark_plain": by_steps(wrong, "plain"),
            "newmark_fast": by_steps(wrong, "fast"),
            "newmark_located": by_steps(wrong, "located"),
            "heyoka": wrong.get("heyoka"),
            "heyoka_penalty": wrong.get("heyoka penalty"),
        },
        "notes": _notes(rights),
    }


def _notes(rights: tuple) -> list[str]:
    """Why a figure is null."""
    problems = [name for name, right in zip(("reference", "penalty"), rights, strict=True) if right is None]
    why = "the files of assets/truth are not here" if not solutions() else "assets/truth has no such solution"
    notes = [f"errors of the {name} problem are null: {why}" for name in problems]
    if not peers.heyoka_version():
        notes.append("heyoka is not installed: pip install heyoka")
    return notes


def report() -> dict:
    """The whole report: the machine, the setting, and the four scenes [A] to [D]."""
    chosen = {key: scene for key, scene in scenes().items() if scene.group == "motion"}
    return {
        "machine": {"processor": processor(), "cores": os.cpu_count(), "python": platform.python_version()},
        "heyoka": peers.heyoka_version(),
        "periods": PERIODS,
        "rounds": ROUNDS,
        "error_after_periods": CHECKED,
        "scenes": {
            key: measure(scene.eta, float(scene.K), float(scene.D), PERIODS, ROUNDS) for key, scene in chosen.items()
        },
    }


def processor() -> str:
    """The processor's name, as far as the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()


def as_text(found: dict) -> str:
    """The report for people."""
    machine, version = found["machine"], found["heyoka"]
    lines = [
        f"{machine['processor']}, {machine['cores']} cores; heyoka {version or 'not installed'}; "
        f"{found['periods']} periods from rest, medians of {found['rounds']} rounds; error after "
        f"{found['error_after_periods']} periods"
    ]
    for key, scene in found["scenes"].items():
        wrong = scene["errors"]
        lines += [
            f"\n[{key}] eta = {scene['eta']:g}, K = {scene['K']:g}, D = {scene['D']:g}",
            f"  {'':34}{'us per period':>14}{'error':>12}",
            _row("reference", scene["reference_us_per_period"], wrong["reference"]),
            _row("heyoka", scene["heyoka_us_per_period"], wrong["heyoka"], scene["heyoka_over_reference"]),
            _row("exact penalty", scene["exact_us_per_period"], wrong["exact"]),
            _row(
                "heyoka, penalty",
                scene["heyoka_penalty_us_per_period"],
                wrong["heyoka_penalty"],
                scene["heyoka_over_exact"],
            ),
        ]
        for n in map(str, STEPS):
            fast, times = scene["newmark_fast_us_per_period"][n], scene["newmark_plain_over_fast"][n]
            lines += [
                _row(f"Newmark T/{n}", fast, wrong["newmark_fast"][n]),
                _row(f"Newmark T/{n}, plain loop", fast * times, wrong["newmark_plain"][n], times),
                _row(f"Newmark T/{n}, located", scene["newmark_located_us_per_period"][n], wrong["newmark_located"][n]),
            ]
        lines.append(
            f"  a step costs {scene['newmark_plain_ns_per_step']:.1f} ns in the plain loop, "
            f"{scene['newmark_every_step_ns_per_step']:.1f} ns in ours (--every-step)"
        )
        lines += [f"  {note}" for note in scene["notes"]]
    return "\n".join(lines)


def _row(name: str, cost: float | None, wrong: float | None, times: float | None = None) -> str:
    spent = "-" if cost is None else f"{cost:.3f}"
    missed = "-" if wrong is None else f"{wrong:.1e}"
    return f"  {name:34}{spent:>14}{missed:>12}" + ("" if times is None else f"{times:10.1f} x ours")
