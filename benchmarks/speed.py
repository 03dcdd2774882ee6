"""Cost of the two solvers beside a plain Numba loop and SciPy, interleaved in one process: medians and ratios.

    .venv/bin/python benchmarks/speed.py

Errors are the largest of the four state components after 10 periods from rest: against the 60-digit solutions of
assets/truth where there is one, else "-".
"""

import json
import math
import statistics
import time
from dataclasses import replace
from pathlib import Path

import _peers as peers
import numpy as np
from vibroscope.engine import Newmark, Reference, System, simulate

SYSTEM = System()
TRUTH = json.loads((Path(__file__).parents[1] / "assets" / "truth" / "truth.json").read_text())["cases"]
SCENES = {
    1.08: (2500.0, 8.0, 2000),
    1.70: (12000.0, 18.0, 2000),
    2.76: (12000.0, 18.0, 8000),
    3.25: (12000.0, 18.0, 8000),
}
ROUNDS = 5
PERIODS = 2050  # of ours and the plain loop; SciPy runs SCIPY_PERIODS, once
SCIPY_PERIODS = 10


def error(case, state):
    """Largest difference from the truth after 10 periods, or nan."""
    if case not in TRUTH:
        return math.nan
    return float(np.abs(np.array(state) - [float(x) for x in TRUTH[case]["states"]["10"]]).max())


def timed(call):
    """Seconds and result."""
    begin = time.perf_counter()
    result = call()
    return time.perf_counter() - begin, result


def plain(eta, stiffness, damping, n, periods):
    """The plain loop with its table of cosines made outside the measured time."""
    h = 2 * math.pi / eta / n
    cosines = np.cos(2 * np.pi * np.arange(n + 1) / n)
    pendulums = SYSTEM.d1, SYSTEM.d2, SYSTEM.kappa, SYSTEM.mass_ratio
    return lambda: peers.plain_newmark(h, cosines, periods, eta, pendulums, (stiffness, damping))


def measure(eta):
    """Seconds per period of each solver, and its error, for one scene."""
    stiffness, damping, n = SCENES[eta]
    method = Newmark(stiffness, damping, n)
    loop = plain(eta, stiffness, damping, n, PERIODS)
    peers.plain_newmark(1.0, np.ones(2), 1, eta, (0.1, 0.1, 2.0, 1.0), (1.0, 1.0))  # compile
    seconds = {"reference": [], "newmark": [], "newmark, every step": [], "plain loop": []}
    for _ in range(ROUNDS):
        seconds["reference"].append(simulate(SYSTEM, eta, Reference("derived"), periods=PERIODS, keep=1).cost.seconds)
        seconds["newmark"].append(simulate(SYSTEM, eta, method, periods=PERIODS, keep=1).cost.seconds)
        every = simulate(SYSTEM, eta, replace(method, every_step=True), periods=PERIODS, keep=1)
        seconds["newmark, every step"].append(every.cost.seconds)
        seconds["plain loop"].append(timed(loop)[0])
    cost = {name: statistics.median(values) / PERIODS for name, values in seconds.items()}
    d3 = SYSTEM.derived_joint_damping
    slow, state_reference = timed(lambda: peers.scipy_reference(SYSTEM, eta, d3, Reference().threshold, SCIPY_PERIODS))
    cost["scipy reference"] = slow / SCIPY_PERIODS
    slow, state_penalty = timed(lambda: peers.scipy_penalty(SYSTEM, eta, stiffness, damping, SCIPY_PERIODS))
    cost["scipy penalty"] = slow / SCIPY_PERIODS
    reference_case, penalty_case = f"ref|{eta:.2f}|derived", f"pen|{eta:.2f}|{stiffness:.0f},{damping:.0f}"
    errors = {
        "reference": error(reference_case, simulate(SYSTEM, eta, Reference("derived"), periods=10, keep=1).section[-1]),
        "newmark": error(penalty_case, simulate(SYSTEM, eta, method, periods=10, keep=1).section[-1]),
        "newmark, every step": error(
            penalty_case,
            simulate(SYSTEM, eta, replace(method, every_step=True), periods=10, keep=1).section[-1],
        ),
        "plain loop": error(penalty_case, plain(eta, stiffness, damping, n, 10)()),
        "scipy reference": error(reference_case, state_reference),
        "scipy penalty": error(penalty_case, state_penalty),
    }
    return cost, errors


def main():
    """Print one table a scene."""
    for eta, (stiffness, damping, n) in SCENES.items():
        cost, errors = measure(eta)
        print(f"\neta = {eta:g}; penalty K = {stiffness:g}, D = {damping:g}, T/{n}")
        print(f"{'solver':20}{'us/period':>12}{'ns/step':>10}{'error at 10 T':>15}{'cost relative to':>20}")
        for name, seconds in cost.items():
            step = f"{seconds / n * 1e9:.2f}" if "newmark" in name or name == "plain loop" else "-"
            ours = "reference" if "reference" in name else "newmark"
            wrong = "-" if math.isnan(errors[name]) else f"{errors[name]:.1e}"
            print(f"{name:20}{seconds * 1e6:12.2f}{step:>10}{wrong:>15}{seconds / cost[ours]:12.1f} x {ours}")


if __name__ == "__main__":
    main()
