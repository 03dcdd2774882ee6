"""Prints what one body at a wall costs beside two bodies, and what skipping steps saves on a published wall (B2).

    .venv/bin/python benchmarks/wall.py              # all; or some kinds: wall.py reference cells

**Like with like.** A body at a wall moves as each of two equal bodies that opposite forces drive against each other:
the wall is their mirror. With twice the clearance and half of K and D between them, both systems have the same events
at the same instants, and the discrete solutions take the same steps. So the ratio is that of their arithmetic alone;
the events or contacts in a period stand beside it, for both. (The kernels know nothing of the mirror: two different
bodies take the same time for an event as two equal ones.)

Skipping steps is compared with the plain loop of the wall, and with that of the mirrored bodies: the paper's two are
what the asked ratios come from, and the plain loop of a wall has half of their arithmetic.

The cells are those of a diagram, and what is counted are the periods that it asks for. Cells stop once they repeat
themselves; a wall's do so sooner (`early_stop=False` would take the same steps), and a call of few cells takes much of
its time to begin.

The two take turns; the ratio is the median of the turns' own ratios, of processor seconds in compiled code.
"""

import statistics
import sys
import time
from dataclasses import replace

import numpy as np
from vibroscope.app.performance.contenders import engine_seconds
from vibroscope.app.validation.cases import cases
from vibroscope.engine import Cells, ExactPenalty, Excitation, Newmark, Reference, System, run_cells, simulate

TURNS = 15
TARGET = 0.02  # seconds that one measurement takes at least
AT_MOST = 0.7  # wall over two bodies
DRIVEN = Excitation(base=0.0, force1=1.0)
BODY = System(d1=0.0033, restitution=0.5, wall=True, excitation=DRIVEN)
B2 = {case.key: case for case in cases()}["B2"]
# η, K and D of the paper's scenes, and B2
SCENES = {"A": (BODY, 1.08, 2500.0, 8.0), "B": (BODY, 1.70, 12000.0, 18.0), "C": (BODY, 2.76, 12000.0, 18.0)}
SCENES |= {"D": (BODY, 3.25, 12000.0, 18.0), "B2": (B2.system, B2.eta, B2.method.stiffness, B2.method.damping)}
SHARES = {2000: 70, 8000: 250, 32000: 35}  # steps, and how often skipping is to be quicker than every step …
CELLS = {"transient": 400, "sample": 50, "threads": 1}
ETAS = np.linspace(0.6, 3.6, 480)  # as many as a diagram of the page has


def mirrored(wall):
    """The body at a wall beside its mirror image."""
    driven = wall.excitation
    opposite = {"force2": -driven.force1, "force2_phase": driven.force1_phase, "constant2": -driven.constant1}
    return System.from_mass_ratio(
        1.0,
        kappa=1.0,
        d1=wall.d1,
        d2=wall.d1,
        d3=None,
        restitution=wall.restitution,
        clearance=2 * wall.clearance,
        excitation=replace(driven, **opposite),
    )


def between_mirrored(method):
    """The contact of the mirrored bodies, whose gap and closing speed are twice those at the wall."""
    if isinstance(method, Reference):
        return replace(method, threshold=2 * method.threshold)
    return replace(method, stiffness=method.stiffness / 2, damping=method.damping / 2)


def kinds(stiffness, damping):
    """Solvers by name, and the periods of a run."""
    newmark = Newmark(stiffness, damping, 2000)
    return {
        "reference": (Reference("derived"), 2000),
        "exact": (ExactPenalty(stiffness, damping), 2000),
        "skipping": (newmark, 2000),
        "located": (replace(newmark, steps=200, located=True), 400),
        "every-step": (replace(newmark, every_step=True), 100),
    }


def run(system, eta, method, periods):
    """A function that returns the processor seconds of a run per period, and its contacts per period."""

    def solve():
        seconds, found = engine_seconds(lambda: simulate(system, eta, method, periods=periods, keep=1))
        if not found.ok:
            raise ArithmeticError(found.message)
        return seconds / periods, found.cost.events / periods if found.cost.events else len(found.contacts)

    return solve


def sweep(cells):
    """The same of the cells of a study."""

    def solve():
        begin = time.process_time()
        found = run_cells(cells, **CELLS)
        spent = time.process_time() - begin
        asked = len(found.periods) * (CELLS["transient"] + CELLS["sample"])
        return spent / asked, float(np.nanmean(found.contacts_per_period))

    return solve


def paired(wall, both):
    """Medians over turns: seconds of each, their ratio with its quartiles, and what each returns beside."""
    runs = wall, both
    each = [max(1, round(TARGET / timed(one))) for one in runs]
    found = [[0.0, 0.0] for _ in range(TURNS)]
    for turn in range(TURNS):
        for k in (0, 1) if turn % 2 else (1, 0):
            found[turn][k] = min(runs[k]()[0] for _ in range(each[k]))
    low, middle, high = statistics.quantiles([a / b for a, b in found], n=4)
    return (
        [statistics.median(column) for column in zip(*found, strict=True)],
        (low, middle, high),
        [one()[1] for one in runs],
    )


def timed(solve):
    """Seconds of a whole call, the second one: the first may compile."""
    solve()
    begin = time.perf_counter()
    solve()
    return time.perf_counter() - begin


def show(name, wall, both):
    """Measure and print a line."""
    (one, two), (low, ratio, high), (events, others) = paired(wall, both)
    mark = "" if ratio <= AT_MOST else f"  over {AT_MOST:g}"
    line = f"{name:26}{one * 1e6:10.3f}{two * 1e6:12.3f}{ratio:8.3f}  {low:.3f} to {high:.3f}"
    print(f"{line}{events:11.2f}{others:9.2f}{mark}", flush=True)


def compare_bodies(asked):
    """A wall beside two bodies: every solver on every scene, then cells."""
    print(f"{'':26}{'wall, us':>10}{'two, us':>12}{'ratio':>8}{'quartiles':>16}{'events':>11}{'two':>9}   a period")
    for kind in kinds(1.0, 1.0):
        for scene, (wall, eta, stiffness, damping) in SCENES.items() if kind in asked else ():
            method, periods = kinds(stiffness, damping)[kind]
            twin = run(mirrored(wall), eta, between_mirrored(method), periods)
            show(f"{kind} [{scene}]", run(wall, eta, method, periods), twin)
    if "cells" in asked:
        twin = mirrored(BODY)
        for kind in ("reference", "exact", "skipping"):
            method = kinds(12000.0, 18.0)[kind][0]
            cells = [Cells(BODY, ETAS, method), Cells(twin, ETAS, between_mirrored(method))]
            show(f"cells, {kind}", *map(sweep, cells))


def compare_skipping():
    """Skipping beside every step on B2, and beside every step of the same motion of two bodies."""
    heads = f"{'skip, us':>10}{'each, us':>12}{'times':>8}{'two, each':>12}{'times':>8}{'asked':>8}"
    print(f"\n{'B2, steps in a period':26}{heads}")
    for steps, least in SHARES.items():
        method, periods = Newmark(B2.method.stiffness, B2.method.damping, steps), max(4, 200_000 // steps)
        every, skipping = replace(method, every_step=True), run(B2.system, B2.eta, method, 1000)
        (one, each), (_, ratio, _), _ = paired(skipping, run(B2.system, B2.eta, every, periods))
        mirror = run(mirrored(B2.system), B2.eta, between_mirrored(every), periods)
        (_, both), (_, of_two, _), _ = paired(skipping, mirror)
        columns = f"{one * 1e6:10.3f}{each * 1e6:12.3f}{1 / ratio:8.1f}{both * 1e6:12.3f}{1 / of_two:8.1f}{least:8}"
        print(f"{steps:<26}{columns}", flush=True)


def main():
    """Print what is asked for on the command line."""
    known = (*kinds(1.0, 1.0), "cells", "B2")
    asked = sys.argv[1:] or known
    if not set(asked) <= set(known):
        raise SystemExit(f"{', '.join(set(asked) - set(known))}: unknown; known are {', '.join(known)}")
    compare_bodies(asked)
    if "B2" in asked:
        compare_skipping()


if __name__ == "__main__":
    main()
