"""Prints the time of branches of periodic motions beside a sweep and beside shooting with SciPy.

    .venv/bin/python benchmarks/branches.py [--rounds 3]

- *Branch of period one* of the paper's system over η 0.5 … 4, all points located.
- *A sweep* shows a bifurcation between two neighbouring cells: its seconds are those of 2,000 cells, and of as many as
  the same resolution of the points, 1e-10 of the range, would take. It sees stable motions only.
- *Shooting with SciPy* follows the same branch over 2.70 … 2.78: solve_ivp (DOP853, 1e-10) with events, fsolve from the
  orbit before, one η after the other; its cost for each orbit stands beside ours over the same range.
- *A curve in two parameters*: the first period doubling over K, or over the restitution; seconds for 200 points.
"""

import argparse
import statistics
import time

import numpy as np
from _scipy_peers import Solver, motions
from scipy.optimize import fsolve
from vibroscope.engine import (
    BranchQuestion,
    Cells,
    ExactPenalty,
    Reference,
    System,
    continue_branch,
    continue_point,
    run_cells,
)

SYSTEM, RANGE = System(), (0.5, 4.0)
SHOOTING = np.linspace(2.70, 2.78, 9)


def main():
    """A line for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    rounds = parser.parse_args().rounds
    whole = {"low": RANGE[0], "high": RANGE[1], "max_period": 1}
    branch, seconds = median(rounds, lambda: continue_branch(BranchQuestion(SYSTEM, 0.8, Reference(), **whole)))
    print(f"reference, eta 0.5 to 4, period one: {seconds:.3f} s, {counts(branch)}")
    print(f"    ends: {branch.ends[0]}; {branch.ends[1]}")
    exact = ExactPenalty(12_000.0, 18.0)
    smooth, seconds = median(
        rounds, lambda: continue_branch(BranchQuestion(SYSTEM, 2.76, exact, low=1.6, high=4.0, max_period=1))
    )
    print(f"exact penalty, eta 1.6 to 4: {seconds:.3f} s, {counts(smooth)}")
    cells = Cells(SYSTEM, np.linspace(*RANGE, 2000), Reference())
    _, sweep = median(rounds, lambda: run_cells(cells, transient=400, sample=50))
    print(f"a sweep of 2000 cells: {sweep:.2f} s; with 1e10 cells {sweep / 2000 * 1e10 / 86_400:.0f} days")
    _, peer = median(1, shoot)
    ours, mine = median(
        rounds, lambda: continue_branch(BranchQuestion(SYSTEM, 2.76, Reference(), low=2.7, high=2.78, max_period=1))
    )
    each, other = mine / len(ours.values), peer / len(SHOOTING)
    print(f"an orbit over 2.70 to 2.78: {1e3 * each:.2f} ms, by SciPy {1e3 * other:.0f} ms: {other / each:.0f} times")
    for method, along, low, high in ((Reference(), "restitution", 0.3, 0.8), (exact, "K", 2000.0, 100_000.0)):
        first = continue_branch(BranchQuestion(SYSTEM, 2.76, method, low=2.7, high=2.8, max_period=1))
        point = next(p for p in first.points if p.kind == "period doubling")
        question = BranchQuestion(SYSTEM, 2.76, method, low=2.2, high=3.4)
        reach = {"along": along, "along_low": low, "along_high": high}
        curve, seconds = median(rounds, lambda q=question, p=point, r=reach: continue_point(q, p, **r))
        count = len(curve.values)
        print(f"period doubling over eta and {along}: {count} points, {200 / count * seconds:.2f} s for 200")


def counts(branch):
    """How many orbits and points a branch has."""
    return f"{len(branch.values)} orbits, {len(branch.points)} points"


def median(rounds, call):
    """What a call returns, after one that is not measured, and the median of its seconds."""
    call()
    taken = []
    for _ in range(rounds):
        begin = time.perf_counter()
        found = call()
        taken.append(time.perf_counter() - begin)
    return found, statistics.median(taken)


def shoot():
    """The orbits of one impact by SciPy, from one η to the next."""
    solver = Solver("DOP853", 1e-10, False)
    flight, load = motions(SYSTEM)
    gap = np.array([-1.0, 0.0, 1.0, 0.0])
    start = continue_branch(BranchQuestion(SYSTEM, 2.76, Reference(), low=2.7, high=2.78, max_period=1)).sections[0, 0]
    share = SYSTEM.mass_ratio / (1 + SYSTEM.mass_ratio) * (1 + SYSTEM.restitution)
    found = []
    for eta in SHOOTING:

        def map_once(y, eta=eta):
            now, end = 0.0, 2 * np.pi / eta
            while now < end - 1e-12:
                now, y, hit = solver.phase(flight, load * eta**2, eta, gap, -1, now, end, y)
                if hit:
                    rate = y[3] - y[1]
                    y = y + np.array([0, share * rate, 0, -share * rate / SYSTEM.mass_ratio])
            return y

        start = fsolve(lambda y: map_once(y) - y, start, xtol=1e-10)
        found.append(start)
    return np.array(found)


if __name__ == "__main__":
    main()
