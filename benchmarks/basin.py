"""Prints the time of a basin of attraction beside that of the plain loop, which runs each start for 2,050 periods.

    .venv/bin/python benchmarks/basin.py [--cells 256] [--plain 24]

Both in turns, the motions and their trapping regions found anew each time. The plain loop takes a coarser lattice of
the same plane and is scaled to as many cells; "alike" is the share of its cells whose motion is the same.
"""

import argparse
import statistics
import time

import numpy as np
from vibroscope.engine import BasinStudy, ExactPenalty, Reference, System, run_cells, sweep
from vibroscope.engine.cells import Cells
from vibroscope.engine.motions.section import same_cycle
from vibroscope.engine.sweeps.basin_motions import basin_search

SYSTEM, ETA, REACH = System(), 3.2, 8.0
SPANS = {"xi2, v2": ("xi2", "v2"), "v1, v2": ("v1", "v2")}
COARSE = 8  # stride of the picture that comes first
TRANSIENT, SAMPLE = 1800, 256


def basin(method, axes, cells):
    """The basin of a plane of cells × cells, and seconds."""
    basin_search.cache_clear()
    begin = time.perf_counter()
    values = np.linspace(-REACH, REACH, cells)
    found = sweep(BasinStudy.over(SYSTEM, method, ETA, dict(zip(axes, (values, values), strict=True))))
    return found, time.perf_counter() - begin


def plain(method, axes, cells, motions):
    """The motion of each cell that its own long run shows, and seconds."""
    values = np.linspace(-REACH, REACH, cells)
    starts = np.zeros((cells * cells, 4))
    columns = [("xi1", "v1", "xi2", "v2").index(name) for name in axes]
    starts[:, columns[0]], starts[:, columns[1]] = np.repeat(values, cells), np.tile(values, cells)
    allowed = starts[:, 2] >= starts[:, 0] if isinstance(method, Reference) else np.ones(len(starts), bool)
    begin = time.perf_counter()
    run = run_cells(
        Cells(SYSTEM, np.full(allowed.sum(), ETA), method, initial=starts[allowed]),
        transient=TRANSIENT,
        sample=SAMPLE,
        recurrence=0,
    )
    seconds = time.perf_counter() - begin
    labels = np.full(len(starts), -1)
    labels[allowed] = [next((k for k, m in enumerate(motions) if same_cycle(*m[:1], s, m[1])), -2) for s in run.section]
    return labels.reshape(cells, cells), seconds


def main():
    """One line for each solver and plane."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cells", type=int, default=256)
    parser.add_argument("--plain", type=int, default=24)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    print("plane     solver     coarse   whole  plain loop  ratio  alike  boundary dimension  shares")
    for name, axes in SPANS.items():
        for method in (Reference(), ExactPenalty(12000.0, 18.0)):
            coarse, whole, long, alike = [], [], [], []
            for _ in range(options.rounds):
                coarse.append(basin(method, axes, options.cells // COARSE)[1])
                found, seconds = basin(method, axes, options.cells)
                whole.append(seconds)
                few, _ = basin(method, axes, options.plain)
                sections = few.motion_section.values
                motions = [
                    (s[np.isfinite(s).all(axis=1)], p) for s, p in zip(sections, few.motion_period.values, strict=True)
                ]
                labels, seconds = plain(method, axes, options.plain, motions)
                long.append(seconds * (options.cells / options.plain) ** 2)
                known = labels != -1
                alike.append((labels[known] == few.motion.values[known]).mean())
            times = [statistics.median(each) for each in (coarse, whole, long)]
            shares = ", ".join(
                f"period {p}: {100 * s:.1f} %"
                for p, s in zip(found.motion_period.values, found.motion_share.values, strict=True)
            )
            edge = f"{float(found.boundary_dimension):.3f} ± {float(found.boundary_dimension_error):.3f}"
            line = f"{times[0]:6.2f}  {times[1]:6.2f}  {times[2]:10.1f}  {times[2] / times[1]:5.1f}  {min(alike):5.3f}"
            print(f"{name:8s}  {method.name:9s}  {line}  {edge:18s}  {shares}")


if __name__ == "__main__":
    main()
