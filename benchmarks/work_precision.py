"""Prints cost and error of every solver of both problems at each of its accuracy settings, interleaved in one process.

    .venv/bin/python benchmarks/work_precision.py --write       (some minutes; heyoka takes part where it is installed)

--write renews assets/speed/work-precision.json and .svg.

Cost: microseconds per period over 200 periods from rest (SciPy: 10), processor time, medians of rounds in which all
take turns, without what is prepared once. Error: largest of the four state components after 10 periods, against
60-digit solutions.
"""

import argparse
import json
import os
import platform
import sys
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path

import _scipy_peers
import _svg
import numpy as np
from vibroscope.app.performance import bench, peers
from vibroscope.app.performance.bench import (
    PERIODS,
    SYSTEM,
    Contender,
    engine_contender,
    peer_contender,
    run_seconds,
    state_error,
    true_state,
)
from vibroscope.engine import ExactPenalty, Newmark
from vibroscope.engine.sweeps.digest import solver_digest

ASSETS = Path(__file__).resolve().parents[1] / "assets"
ETAS = {"A": 1.08, "B": 1.70, "C": 2.76, "D": 3.25}
PENALTIES = {"C": (2.76, 12000.0, 18.0), "A": (1.08, 2500.0, 8.0)}
STEPS = (500, 1000, 2000, 4000, 8000, 16000, 32000, 64000)
LOCATED_STEPS = (100, 200, 500, 1000, 2000, 4000, 8000)
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 0.0)  # heyoka's; 0 is the accuracy of a double
RTOLS = {
    "DOP853": (1e-3, 1e-5, 1e-7, 1e-9, 1e-11),
    "LSODA": (1e-3, 1e-5, 1e-7, 1e-9, 1e-11),
    "Radau": (1e-3, 1e-5, 1e-7),
}
LANES = 8
ROUNDS = 15
ACCURATE = 1e-6  # a larger error means lost events
SLOW_EVERY = 5  # SciPy takes part in every fifth round
SLOW_PERIODS = 10


@dataclass
class WorkPoint:
    """One setting of one solver: the periods that are timed, and how many runs it does at once (``lanes``)."""

    series: str
    setting: str
    contender: Contender
    periods: int = PERIODS
    lanes: int = 1
    spent: list = field(default_factory=list)
    error: float | None = None

    def time(self):
        self.spent.append(run_seconds(self.contender, self.periods) / self.periods / self.lanes * 1e6)

    @property
    def cost(self):
        return float(np.median(self.spent))


def engine_point(series, setting, eta, method):
    return WorkPoint(series, setting, engine_contender(series, eta, method))


def peer_point(series, setting, run, **more):
    return WorkPoint(series, setting, peer_contender(series, run), **more)


def first_lane(run):
    """A run whose state is that of the batch's first lane, which has the problem's own η."""
    return lambda periods: run(periods)[0]


def scipy_points(solve):
    for method, rtols in RTOLS.items():
        for limited in (True, False):
            for rtol in rtols:
                setting = f"{rtol:.0e}" + (f", h ≤ {_scipy_peers.MAX_STEP:g}" if limited else "")

                def run(periods, rtol=rtol, method=method, limited=limited):
                    try:
                        return solve(periods, rtol, method, limited)
                    except ArithmeticError:
                        return _scipy_peers.NO_STATE

                yield peer_point(f"SciPy {method}", setting, run, periods=SLOW_PERIODS)


def reference_points(eta):
    system, d3, threshold = SYSTEM, SYSTEM.derived_joint_damping, bench.REFERENCE.threshold
    yield engine_point("reference", "", eta, bench.REFERENCE)
    if peers.heyoka_version():
        import _heyoka_batch as batch

        for tolerance in TOLERANCES:
            run = peers.heyoka_reference(system, eta, d3, threshold, tolerance)
            yield peer_point("heyoka", f"{tolerance:.0e}" if tolerance else "eps", run)
        run = batch.reference_batch(system, [eta + 1e-3 * lane for lane in range(LANES)], threshold)
        yield peer_point("heyoka, batch", f"{LANES} lanes, per lane", first_lane(run), lanes=LANES)
    yield from scipy_points(lambda *options: _scipy_peers.scipy_reference(system, eta, d3, threshold, *options))


def penalty_points(eta, stiffness, damping):
    system = SYSTEM
    yield engine_point("exact penalty", "", eta, ExactPenalty(stiffness, damping))
    for n in STEPS:
        yield peer_point("Newmark, plain loop", f"T/{n}", peers.plain_loop(system, eta, stiffness, damping, n))
        yield engine_point("Newmark, every step", f"T/{n}", eta, Newmark(stiffness, damping, n, every_step=True))
        yield engine_point("Newmark", f"T/{n}", eta, Newmark(stiffness, damping, n))
    for n in LOCATED_STEPS:
        yield engine_point("Newmark, located", f"T/{n}", eta, Newmark(stiffness, damping, n, located=True))
    if peers.heyoka_version():
        import _heyoka_batch as batch

        for tolerance in TOLERANCES:
            run = peers.heyoka_penalty(system, eta, stiffness, damping, tolerance)
            yield peer_point("heyoka", f"{tolerance:.0e}" if tolerance else "eps", run)
        run = batch.penalty_batch(system, [eta + 1e-3 * lane for lane in range(LANES)], stiffness, damping)
        yield peer_point("heyoka, batch", f"{LANES} lanes, per lane", first_lane(run), lanes=LANES)
    yield from scipy_points(lambda *options: _scipy_peers.scipy_penalty(system, eta, stiffness, damping, *options))


def measure(points, truth, rounds):
    """Errors first, which compiles everything; then rounds in which all take turns."""
    points = list(points)
    for point in points:
        point.error = state_error(point.contender, truth)
    for turn in range(rounds):
        for point in points:
            if point.periods == PERIODS or turn % SLOW_EVERY == 0:
                point.time()
    return points


def print_table(title, points):
    base = points[0]
    print(f"\n{title}\n{'solver':22}{'setting':22}{'us/period':>12}{'error':>10}   cost relative to {base.series}")
    for p in points:
        error = "fails" if p.error is None else f"{p.error:.1e}"
        print(f"{p.series:22}{p.setting:22}{p.cost:12.3f}{error:>10}{p.cost / base.cost:12.1f} x", flush=True)
    accurate = [p for p in points if p.error is not None and base.error <= p.error < ACCURATE]
    for series in dict.fromkeys(p.series for p in points[1:] if not p.series.startswith("Newmark")):
        ratios = [p.cost / base.cost for p in accurate if p.series == series]
        found = f"{min(ratios):.1f} x {base.series}" if ratios else "none"
        print(f"  {series}, cheapest with an error no smaller than ours and below {ACCURATE:g}: {found}")


def as_json(key, title, points):
    series = {}
    for p in points:
        row = {"setting": p.setting, "us_per_period": p.cost, "error": p.error}
        series.setdefault(p.series, []).append(row)
    return {"key": key, "title": title, "series": [{"name": name, "points": rows} for name, rows in series.items()]}


def problems():
    """Key, title, truth and points of each problem."""
    for name, eta in ETAS.items():
        yield (
            f"reference-{name}",
            f"Reference, η = {eta:.2f} [{name}]",
            true_state(eta, bench.REFERENCE),
            reference_points(eta),
        )
    for name, (eta, stiffness, damping) in PENALTIES.items():
        title = f"Penalty, η = {eta:.2f} [{name}], K = {stiffness:g}, D = {damping:g}"
        truth = true_state(eta, ExactPenalty(stiffness, damping))
        yield f"penalty-{name}", title, truth, penalty_points(eta, stiffness, damping)


def main():
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--write", action="store_true", help="renew assets/speed/work-precision.json and .svg")
    options = parser.parse_args()
    with_heyoka = peers.heyoka_version()
    print(f"{bench.processor()}, {os.cpu_count()} cores; heyoka {with_heyoka or 'not installed: pip install heyoka'}")
    print("Siconos takes no part: it has no wheel, and Debian's package works with the system's Python only")
    found = []
    for key, title, truth, points in problems():
        if truth is None:
            sys.exit(f"{title}: no 60-digit solution in assets/truth")
        points = measure(points, truth, options.rounds)
        print_table(title, points)
        found.append(as_json(key, title, points))
    data = {
        "about": __doc__.split("\n\n")[-1].strip(),
        "solvers": solver_digest(),
        "processor": bench.processor(),
        "versions": {
            "python": platform.python_version(),
            "heyoka": with_heyoka,
            **{p: version(p) for p in ("numba", "scipy")},
        },
        "problems": found,
    }
    if options.write:
        (ASSETS / "speed" / "work-precision.json").write_text(
            json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        )
        (ASSETS / "speed" / "work-precision.svg").write_text(_svg.draw(data))


if __name__ == "__main__":
    main()
