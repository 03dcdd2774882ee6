"""Prints how the cost of a run grows: linearly in periods and events, and in flight not with the number of steps.

    .venv/bin/python benchmarks/slopes.py

Each line is a fit of log cost over log of what is varied: a slope of 1 is linear, of 0 independent. Beside it is the
straight line through the same numbers: with Newmark over the steps its constant is the cost of flight, which does not
depend on the step, and its slope the cost of the steps in contact, which are all taken (η = 3.25 has the fewest, 1.08
the most). Costs are processor seconds in compiled code, the least of several interleaved runs, since a disturbance can
only lengthen a run.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from vibroscope.app.performance.bench import SYSTEM, engine_seconds
from vibroscope.engine import ExactPenalty, Newmark, Reference, System, simulate

PERIODS = (1000, 2000, 4000, 8000, 16000, 32000)
STEPS = (2000, 4000, 8000, 16000, 32000, 64000)
THRESHOLDS = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)  # the smaller, the more impacts before permanent contact
ROUNDS = 9


@dataclass(frozen=True)
class Run:
    """One run, and the number that is varied."""

    varied: float
    eta: float
    method: Any
    periods: int
    system: System = SYSTEM

    def solve(self):
        """Processor seconds in compiled code and events."""
        seconds, response = engine_seconds(
            lambda: simulate(self.system, self.eta, self.method, periods=self.periods, keep=1)
        )
        if not response.ok:
            raise ArithmeticError(f"{self}: {response.message}")
        return seconds, response.cost.events


def seconds(runs):
    """Least seconds of each run, over rounds in which all take turns."""
    for run in runs:
        run.solve()  # compiles
    return np.min([[run.solve()[0] for run in runs] for _ in range(ROUNDS)], axis=0)


def slope(x, y):
    """Slope of log y over log x, and the largest deviation from the line, as a factor."""
    x, y = np.log(x), np.log(y)
    line = np.polyfit(x, y, 1)
    return line[0], np.exp(np.abs(y - np.polyval(line, x)).max())


def show(name, over, runs, per):
    """Measure, fit, print; ``per`` divides the seconds (periods, or 1)."""
    cost = seconds(runs) / [per(run) for run in runs]
    x = [run.varied for run in runs]
    rise, off = slope(x, cost)
    values = "  ".join(f"{value:g}: {us:.3g}" for value, us in zip(x, cost * 1e6, strict=True))
    more, fixed = np.polyfit(x, cost * 1e6, 1)
    print(f"{name:34}{over:10}slope {rise:6.3f}, within {100 * (off - 1):3.0f} %; us = {fixed:.3g} + {more:.3g} n")
    print(f"{'':34}us  {values}", flush=True)


def main():
    """Print every slope."""
    total, each = (lambda run: 1), (lambda run: run.periods)
    scenes = {"1.08": (1.08, 2500, 8), "2.76": (2.76, 12000, 18)}
    for name, (eta, k, d) in scenes.items():
        methods = {
            "reference": Reference("derived"),
            "exact penalty": ExactPenalty(k, d),
            "Newmark T/2000": Newmark(k, d, 2000),
            "Newmark T/200, located": Newmark(k, d, 200, located=True),
        }
        for method, chosen in methods.items():
            share = 8 if "located" in method else 1  # its steps cost most
            runs = [Run(n // share, eta, chosen, n // share) for n in PERIODS]
            show(f"{method}, eta {name}", "periods", runs, total)
    scenes["3.25"] = (3.25, 12000, 18)
    for name, (eta, k, d) in scenes.items():
        for every, periods in ((False, 2000), (True, 50)):
            method = "Newmark, every step" if every else "Newmark"
            runs = [Run(n, eta, Newmark(k, d, n, every_step=every), periods) for n in STEPS]
            show(f"{method}, eta {name}", "steps", runs, each)
    bouncy = System(restitution=0.7)
    runs = [Run(0, 1.08, Reference("derived", threshold), 1000, bouncy) for threshold in THRESHOLDS]
    runs = [replace(run, varied=run.solve()[1] / run.periods) for run in runs]
    show("reference, eta 1.08, e 0.7, by ε", "events", runs, each)


if __name__ == "__main__":
    main()
