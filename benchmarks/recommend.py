"""Prints time and result of recommendations, and how close they come to the best that brute force finds.

    .venv/bin/python benchmarks/recommend.py

Brute force tries a fine grid of K and D with fewer steps than recommended, down to two thirds in steps of 5 %, and
applies the same rule: the setting itself, with half the step, and nine in ten of its neighbours meet the tolerance.
"fewest" is the least n for which it finds such a setting. Seconds are of the wall clock and of all processors, with the
kernels loaded.
"""

import math
import os
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from vibroscope.engine import (
    Newmark,
    Record,
    Reference,
    SettingQuestion,
    System,
    Tolerances,
    recommend,
    simulate,
    steady,
)
from vibroscope.engine.contact import damping_for, stiffness_for
from vibroscope.engine.divergence.error import Target
from vibroscope.engine.law_table import ratio_of_restitution
from vibroscope.engine.recommendation.trials import NewmarkSetting, RangeTrials, Trials

SYSTEM = System()
CASES = (
    (2.76, 0.1, False),
    (2.76, 0.05, False),
    (2.76, 0.05, True),
    (3.25, 0.05, False),
    (3.25, 0.05, True),
    (1.08, 0.08, False),
    (1.08, 0.08, True),
    (1.08, 0.05, False),
)
PAPER = {2.76: (12000.0, 18.0, 8000), 1.08: (2500.0, 8.0, 2000)}
FEWER = 0.95
TRIES = 8  # numbers of steps below the recommended one
RATIO = 1.25  # from K to K
SHARES = np.geomspace(0.3, 3.0, 24)  # of ζ(e)


def brute(trials, eta, tolerance, steps, stiffness_max):
    """Whether any promising setting of the fine grid is confirmed with so many steps."""
    ratio = ratio_of_restitution(SYSTEM.restitution)
    low, high = (10.0, stiffness_max) if trials.located else (stiffness_for(SYSTEM, eta, steps, c) for c in (150, 1.2))
    low, high = max(low, 3.0), min(high, stiffness_max)
    stiffnesses = np.geomspace(low, high, 2 + round(math.log(high / low, RATIO)))
    grid = [NewmarkSetting(k, damping_for(SYSTEM, k, ratio * share), steps) for k in stiffnesses for share in SHARES]
    seem = [trial.setting for trial in trials.screen(grid) if trial.error <= tolerance]
    good = [trial for trial in trials.screen(seem, 10, tolerance) if math.isfinite(trial.robust)]
    good = [trial.setting for trial in sorted(good, key=lambda trial: trial.robust)[:20]]
    return any(trial.robust <= tolerance for trial in trials.confirm(good, tolerance))


def fewest(found):
    """The least n at which brute force meets the tolerance, at most what was recommended."""
    motion = steady(SYSTEM, found.eta, Reference())
    best = found.best.setting.steps
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        trials = RangeTrials([Trials(motion, found.scheme, pool)], pool)
        for i in range(1, TRIES + 1):
            n = round(found.best.setting.steps * FEWER**i)
            if brute(trials, found.eta, found.tolerance, n, 1e6):
                best = n
    return best


def asked(eta, tolerance, located):
    """The question at one η."""
    return SettingQuestion(SYSTEM, eta, Tolerances(tolerance), scheme=Newmark(1, 0, 1000, located=located))


def paper(eta):
    """Error of the paper's own choice."""
    if eta not in PAPER:
        return "-"
    run = simulate(SYSTEM, eta, Newmark(*PAPER[eta]), record=Record(50, 200, PAPER[eta][2]))
    return f"{Target.find(SYSTEM, eta).error(run):.4f} n {PAPER[eta][2]}"


def main():
    """Print the table."""
    for located in (False, True):
        recommend(asked(2.76, 0.5, located))  # loads the kernels
    print(
        " eta   tol  steps are   met         K        D      n  solves   error  robust  wall s   cpu s  fewest  paper"
    )
    for eta, tolerance, located in CASES:
        wall, cpu = time.perf_counter(), time.process_time()
        found = recommend(asked(eta, tolerance, located))
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        k, d, n = found.best.setting
        least = fewest(found) if found.met else "-"
        print(
            f"{eta:4.2f} {tolerance:5.2f}  {'located' if located else 'constant':9s}  {found.met!s:5s} {k:9g} {d:8g} "
            f"{n:6d} {found.best.cost:7.0f}  {found.best.error:.4f}  {found.best.robust:.4f} {wall:7.2f} {cpu:7.2f} "
            f"{least:>7}  {paper(eta)}",
            flush=True,
        )


if __name__ == "__main__":
    main()
