"""Work against precision: every solver of both problems over its own accuracy setting, interleaved in one process.

    .venv/bin/python benchmarks/work_precision.py --write       (some minutes; heyoka takes part where it is installed)

Prints a table for each problem; --write renews assets/speed/work-precision.json and .svg.

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

import _figure
import _peers
import numpy as np
from vibroscope.app.performance import bench, peers
from vibroscope.engine import ExactPenalty, Newmark

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
RIGHT = 1e-6  # a larger error means lost events
SLOW_EVERY = 5  # SciPy takes part in each so manieth round
SLOW_PERIODS = 10


@dataclass
class Point:
    """One setting of one solver; ``periods`` are those that are timed, ``lanes`` the runs done at once."""

    series: str
    setting: str
    contender: bench.Contender
    periods: int = bench.PERIODS
    lanes: int = 1
    spent: list = field(default_factory=list)
    error: float | None = None

    def time(self):
        self.spent.append(bench.timed(self.contender, self.periods) / self.periods / self.lanes * 1e6)

    @property
    def cost(self):
        return float(np.median(self.spent))


def ours(series, setting, eta, method):
    return Point(series, setting, bench.of_engine(series, eta, method))


def theirs(series, setting, run, **more):
    return Point(series, setting, bench.of_peer(series, run), **more)


def first_lane(run):
    """The batch's first lane as its state: that at the problem's own η."""
    return lambda periods: run(periods)[0]


def scipy_points(solve):
    for method, rtols in RTOLS.items():
        for care in (True, False):
            for rtol in rtols:
                setting = f"{rtol:.0e}" + (f", h ≤ {_peers.CARE:g}" if care else "")

                def run(periods, rtol=rtol, method=method, care=care):
                    try:
                        return solve(periods, rtol, method, care)
                    except ArithmeticError:
                        return _peers.NOTHING

                yield theirs(f"SciPy {method}", setting, run, periods=SLOW_PERIODS)


def reference_points(eta):
    system, d3, threshold = bench.SYSTEM, bench.SYSTEM.derived_joint_damping, bench.REFERENCE.threshold
    yield ours("reference", "", eta, bench.REFERENCE)
    if peers.heyoka_version():
        import _heyoka_batch as batch

        for tolerance in TOLERANCES:
            run = peers.heyoka_reference(system, eta, d3, threshold, tolerance)
            yield theirs("heyoka", f"{tolerance:.0e}" if tolerance else "eps", run)
        run = batch.reference_batch(system, [eta + 1e-3 * lane for lane in range(LANES)], threshold)
        yield theirs("heyoka, batch", f"{LANES} lanes, per lane", first_lane(run), lanes=LANES)
    yield from scipy_points(lambda *options: _peers.scipy_reference(system, eta, d3, threshold, *options))


def penalty_points(eta, stiffness, damping):
    system = bench.SYSTEM
    yield ours("exact penalty", "", eta, ExactPenalty(stiffness, damping))
    for n in STEPS:
        yield theirs("Newmark, plain loop", f"T/{n}", peers.plain_loop(system, eta, stiffness, damping, n))
        yield ours("Newmark, every step", f"T/{n}", eta, Newmark(stiffness, damping, n, every_step=True))
        yield ours("Newmark", f"T/{n}", eta, Newmark(stiffness, damping, n))
    for n in LOCATED_STEPS:
        yield ours("Newmark, located", f"T/{n}", eta, Newmark(stiffness, damping, n, located=True))
    if peers.heyoka_version():
        import _heyoka_batch as batch

        for tolerance in TOLERANCES:
            run = peers.heyoka_penalty(system, eta, stiffness, damping, tolerance)
            yield theirs("heyoka", f"{tolerance:.0e}" if tolerance else "eps", run)
        run = batch.penalty_batch(system, [eta + 1e-3 * lane for lane in range(LANES)], stiffness, damping)
        yield theirs("heyoka, batch", f"{LANES} lanes, per lane", first_lane(run), lanes=LANES)
    yield from scipy_points(lambda *options: _peers.scipy_penalty(system, eta, stiffness, damping, *options))


def measure(points, right, rounds):
    """Errors first, which compiles everything; then rounds in which all take turns."""
    points = list(points)
    for point in points:
        point.error = bench.error(point.contender, right)
    for turn in range(rounds):
        for point in points:
            if point.periods == bench.PERIODS or turn % SLOW_EVERY == 0:
                point.time()
    return points


def print_table(title, points):
    base = points[0]
    print(f"\n{title}\n{'solver':22}{'setting':22}{'us/period':>12}{'error':>10}   cost relative to {base.series}")
    for p in points:
        wrong = "fails" if p.error is None else f"{p.error:.1e}"
        print(f"{p.series:22}{p.setting:22}{p.cost:12.3f}{wrong:>10}{p.cost / base.cost:12.1f} x", flush=True)
    right = [p for p in points if p.error is not None and base.error <= p.error < RIGHT]
    for series in dict.fromkeys(p.series for p in points[1:] if not p.series.startswith("Newmark")):
        dearer = [p.cost / base.cost for p in right if p.series == series]
        found = f"{min(dearer):.1f} x {base.series}" if dearer else "none"
        print(f"  {series}, cheapest with an error no smaller than ours and below {RIGHT:g}: {found}")


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
            bench.truth(eta, bench.REFERENCE),
            reference_points(eta),
        )
    for name, (eta, stiffness, damping) in PENALTIES.items():
        title = f"Penalty, η = {eta:.2f} [{name}], K = {stiffness:g}, D = {damping:g}"
        right = bench.truth(eta, ExactPenalty(stiffness, damping))
        yield f"penalty-{name}", title, right, penalty_points(eta, stiffness, damping)


def main():
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--write", action="store_true", help="renew assets/speed/work-precision.json and .svg")
    options = parser.parse_args()
    with_heyoka = peers.heyoka_version()
    print(f"{bench.processor()}, {os.cpu_count()} cores; heyoka {with_heyoka or 'not installed: pip install heyoka'}")
    print("Siconos: no wheel, and Debian's package serves the system's Python alone: not among the peers")
    found = []
    for key, title, right, points in problems():
        if right is None:
            sys.exit(f"{title}: no 60-digit solution in assets/truth")
        points = measure(points, right, options.rounds)
        print_table(title, points)
        found.append(as_json(key, title, points))
    data = {
        "about": __doc__.split("\n\n")[-1].strip(),
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
        (ASSETS / "speed" / "work-precision.svg").write_text(_figure.draw(data))


if __name__ == "__main__":
    main()
