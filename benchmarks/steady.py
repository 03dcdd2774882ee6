"""Prints periods run and time of finding a steady motion, beside the run of 2,050 periods that it replaces.

    .venv/bin/python benchmarks/steady.py

Times are medians of whole calls, tables included; "left" is the distance of the long run from the steady motion.
"""

import statistics
import time

import numpy as np
from vibroscope.engine import ExactPenalty, Reference, System, simulate, steady

SYSTEM = System()
CASES = (
    *((eta, Reference()) for eta in (1.08, 1.70, 2.76, 3.25)),
    (1.08, Reference(threshold=0.0)),
    (1.08, ExactPenalty(2500.0, 8.0)),
    (2.76, ExactPenalty(12000.0, 18.0)),
)
ROUNDS = 15
SWEEP = np.linspace(0.5, 4.0, 100)


def timed(function, *arguments):
    """The result, and milliseconds."""
    begin = time.perf_counter()
    out = function(*arguments)
    return out, 1e3 * (time.perf_counter() - begin)


def compare(eta, method):
    """Periods and time of both, interleaved."""
    rounds = [(timed(steady, SYSTEM, eta, method), timed(simulate, SYSTEM, eta, method)) for _ in range(ROUNDS)]
    (found, _), (long, _) = rounds[-1]
    ours, theirs = (statistics.median(pair[k][1] for pair in rounds) for k in (0, 1))
    return found, long, ours, theirs


def left(found, long):
    """Largest distance of the long run's last cycle from the steady one."""
    p = found.period
    cycle = np.roll(found.response.section, -(long.periods % p), axis=0)
    return np.abs(cycle - long.section[-p:]).max()


def main():
    """Print the table, and a sweep in one line."""
    print("eta   method                          period  |multiplier|  periods run  of 2050   ms  long ms  left")
    for eta, method in CASES:
        found, long, ours, theirs = compare(eta, method)
        name = f"{method.name} {tuple(vars(method).values())}"
        cycle = "not periodic"
        if found.periodic:
            largest = abs(found.multipliers[0])
            cycle = f"{found.period:6d}  {largest:12.4f}"
        share = found.periods / long.periods
        away = f"{left(found, long):.1e}" if found.periodic else "-"
        cost = f"{found.periods:11d}  {share:7.3f}  {ours:3.1f}  {theirs:7.1f}"
        print(f"{eta:4.2f}  {name:30s}  {cycle:20s}  {cost}  {away}")
    runs = [steady(SYSTEM, float(eta), Reference()) for eta in SWEEP]
    periods = [run.periods for run in runs if run.periodic]
    median, mean = statistics.median(periods), statistics.mean(periods)
    print(f"{len(SWEEP)} eta from 0.5 to 4, reference: {len(periods)} periodic")
    print(f"periods run for each of them: median {median:g}, mean {mean:.0f}, most {max(periods)}, of 2050")


if __name__ == "__main__":
    main()
