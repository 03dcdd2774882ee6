"""Prints what skipping steps saves with every integrator, contact status and law, at the paper's motions [A] to [D].

    .venv/bin/python benchmarks/integrators.py               # all; or some scenes and steps: integrators.py A C 2000

All runs of a line take turns in one process, and each is the best of TURNS; the times are seconds in compiled code.
``plain`` takes every step with that contact status; ``ratio`` is what skipping saves of it. Located steps are all
taken; they are judged by the loop that takes every step with the status from the start, since a user has the choice
between the two.
"""

import sys
from dataclasses import replace

from vibroscope.engine import (
    CONTACT_LAWS,
    INTEGRATORS,
    Newmark,
    NewmarkBeta,
    System,
    TimeStepping,
    simulate,
    with_located_steps,
)
from vibroscope.engine.law_table import numbers_of

SCENES = {"A": (1.08, 2500.0, 8.0), "B": (1.70, 12000.0, 18.0), "C": (2.76, 12000.0, 18.0), "D": (3.25, 12000.0, 18.0)}
TURNS = 4
PERIODS = 2000, 100  # of a run with skips, as many as runs have by default, and of the plain loop
PENETRATION = 1e-3  # of the law "impact"
LAWS = CONTACT_LAWS[:2]  # with every integrator; the others with Newmark's method


def microseconds(eta, methods, periods):
    """Per period, of each method; ``periods`` of each run."""
    best = [float("inf")] * len(methods)
    for _ in range(TURNS):
        for i, (method, count) in enumerate(zip(methods, periods, strict=True)):
            found = simulate(System(), eta, method, periods=count, keep=1)
            best[i] = min(best[i], found.cost.seconds / count * 1e6) if found.ok else float("nan")
    return best


def methods_of(stiffness, damping, steps):
    """Name, method with skips, and the plain loop that it is judged by."""
    for kind in INTEGRATORS.values():
        for status in ("start", "end", "located"):
            for law in LAWS:
                if status != "end" or not kind.explicit:
                    method = TimeStepping(stiffness, damping, steps, kind(), status, "keep", law)
                    judge = "start" if status == "located" else status
                    yield f"{kind.name}, {status}, {law}", method, replace(method, status=judge, every_step=True)
    for law in CONTACT_LAWS[2:]:
        numbers = {"penetration": PENETRATION} if "penetration" in numbers_of(law) else {}
        for status in ("start", "end", "located"):
            method = TimeStepping(stiffness, damping, steps, NewmarkBeta(), status, "keep", law, **numbers)
            judge = "start" if status == "located" else status
            yield f"{NewmarkBeta.name}, {status}, {law}", method, replace(method, status=judge, every_step=True)
    newmark = Newmark(stiffness, damping, steps)
    yield "Newmark", newmark, replace(newmark, every_step=True)
    yield "Newmark located", with_located_steps(newmark), replace(newmark, every_step=True)


def main(asked):
    """Print the table."""
    scenes = [name for name in asked if name in SCENES] or list(SCENES)
    numbers = [int(name) for name in asked if name.isdigit()] or [2000]
    print(f"{'scene':6}{'steps':>6}  {'integrator, status, law':44}{'skips µs':>9}{'plain µs':>10}{'ratio':>7}")
    for steps in numbers:
        for name in scenes:
            eta, *contact = SCENES[name]
            for what, method, plain in methods_of(*contact, steps):
                skipped, taken = microseconds(eta, (method, plain), PERIODS)
                print(f"[{name}]   {steps:6}  {what:44}{skipped:9.2f}{taken:10.1f}{taken / skipped:7.1f}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
