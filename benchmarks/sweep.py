"""Prints cost of sweeps and planes beside plain loops and heyoka, what an early stop changes, and how cost grows.

    .venv/bin/python benchmarks/sweep.py

The plain loops run 1/PART of the periods and heyoka 1/PART of the η; the table extrapolates to the whole. heyoka's
events are Python functions and so take turns on one core: compare it by processor seconds, which also depend least on
what else the machine does. It is left out where it is not installed. All take turns in one process.
"""

import importlib.util
import math
import os
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from vibroscope.app.performance.peers import plain_newmark
from vibroscope.engine import Cells, ExactPenalty, Newmark, Reference, System, run_cells, simulate

SYSTEM = System()
ETA = 2.76
SIDE, STEPS, TRANSIENT, SAMPLE = 64, 2000, 450, 50  # the section of the last 50 periods, as in the paper
THREADS = os.cpu_count()
PART = 25
ROUNDS = 5
LANES = 8


def plane(method, side=SIDE):
    """K from 100 to 60,000 and D from 1 to 100, logarithmic."""
    k, d = (a.ravel() for a in np.meshgrid(np.geomspace(1e2, 6e4, side), np.geomspace(1, 100, side)))
    return Cells(SYSTEM, np.full(k.size, ETA), method, stiffness=k, damping=d)


def line(count):
    """η from 0.5 to 4."""
    return Cells(SYSTEM, np.linspace(0.5, 4, count), Reference("derived"))


def ours(cells, transient=TRANSIENT, sample=SAMPLE, **options):
    """A call that runs the cells."""
    return lambda: run_cells(cells, transient=transient, sample=sample, coordinates=(2,), **options)


def every_step(cells, periods):
    """A call that takes every step of every cell in the engine's own loop."""

    def one(i):
        method = Newmark(cells.stiffness[i], cells.damping[i], STEPS, every_step=True)
        simulate(SYSTEM, ETA, method, periods=periods, keep=1)

    return lambda: _on_threads(one, len(cells))


def plain(cells, periods):
    """A call that takes every step of every cell in the plain loop."""
    h, cosines = 2 * math.pi / ETA / STEPS, np.cos(2 * np.pi * np.arange(STEPS + 1) / STEPS)
    pendulums = SYSTEM.d1, SYSTEM.d2, SYSTEM.kappa, SYSTEM.mass_ratio

    def one(i):
        plain_newmark(h, cosines, periods, ETA, pendulums, (cells.stiffness[i], cells.damping[i]))

    return lambda: _on_threads(one, len(cells))


def _on_threads(one, count):
    with ThreadPoolExecutor(THREADS) as pool:
        list(pool.map(one, range(count)))


def heyoka(etas, periods):
    """A call that runs the reference at every PART-th group of η; solvers are built outside."""
    from _heyoka_batch import reference_batch

    groups = etas.reshape(-1, LANES)[::PART]
    runs = [reference_batch(SYSTEM, group, Reference().threshold) for group in groups]

    def run():
        for solver in runs:
            solver(periods)

    return run, len(etas) / groups.size


def seconds(call):
    """Wall and processor seconds of a call."""
    begin, busy = time.perf_counter(), time.process_time()
    call()
    return np.array([time.perf_counter() - begin, time.process_time() - busy])


def table():
    """Print each sweep and its peers."""
    newmark, exact, etas = plane(Newmark(1, 1, STEPS)), plane(ExactPenalty(1, 1)), line(1000)
    periods = TRANSIENT + SAMPLE
    part = periods // PART
    calls = {
        "eta": (ours(etas, 400, 100), 1),
        "eta, no early stop": (ours(etas, 400, 100, recurrence=0), 1),
        "plane": (ours(newmark), 1),
        "plane, no early stop": (ours(newmark, recurrence=0), 1),
        "exact plane": (ours(exact), 1),
        "coarse plane, 16 x 16, 80 + 20": (ours(plane(Newmark(1, 1, STEPS), 16), 80, 20), 1),
        "coarse exact plane": (ours(plane(ExactPenalty(1, 1), 16), 80, 20), 1),
        "plane, every_step": (every_step(newmark, part), periods / part),
        "plane, plain loop": (plain(newmark, part), periods / part),
    }
    if importlib.util.find_spec("heyoka"):
        calls["eta, heyoka"] = heyoka(etas.eta, 500)
    for call, _ in calls.values():
        call()  # compiles
    took = {name: [] for name in calls}
    for _ in range(ROUNDS):
        for name, (call, factor) in calls.items():
            took[name].append(seconds(call) * factor)
    median = {name: np.median(values, axis=0) for name, values in took.items()}
    print(f"{'':34}{'wall ms':>12}{'cpu ms':>12}{'ratios':>18}")
    for name, value in median.items():
        base = "eta" if name.startswith("eta") else "plane"
        wall, busy = value / median[base]
        print(f"{name:34}{value[0] * 1e3:12.1f}{value[1] * 1e3:12.1f}{wall:9.2f}{busy:9.2f} x {base}", flush=True)


def agreement():
    """Print for how many cells an early stop changes the result, and by how much."""
    for name, cells in (("plane", plane(Newmark(1, 1, STEPS))), ("exact plane", plane(ExactPenalty(1, 1)))):
        full, early = ours(cells, recurrence=0)(), ours(cells)()
        other = (full.period != early.period) | (full.near_period != early.near_period) | (full.status != early.status)
        apart = np.abs(full.section - early.section).max() / np.abs(full.section).max()
        print(
            f"{name}: early stop in {np.sum(early.periods < TRANSIENT + SAMPLE)} of {len(cells)} cells; other period "
            f"or status in {other.sum()}; sections differ by at most {apart:.1e} of their size"
        )


def slope(name, x, y):
    """Print the slope of log y over log x."""
    rise = np.polyfit(np.log(x), np.log(y), 1)[0]
    print(f"{name:40}slope {rise:6.3f}   " + "  ".join(f"{a:g}: {b * 1e3:.1f} ms" for a, b in zip(x, y, strict=True)))


def growth():
    """Print cost over cells and periods, in processor seconds, and over threads, in wall seconds."""
    method = Newmark(1, 1, STEPS)
    sides, lengths, cores = (16, 32, 64), (200, 400, 800, 1600), sorted({1, THREADS})
    runs = {
        "cells": (np.square(sides), [ours(plane(method, side)) for side in sides]),
        "periods (no early stop)": (lengths, [ours(plane(method, 16), n, 20, recurrence=0) for n in lengths]),
        "threads": (cores, [ours(plane(method, 32), threads=n) for n in cores]),
    }
    for name, (x, calls) in runs.items():
        took = [[seconds(call)[0 if name == "threads" else 1] for call in calls] for _ in range(ROUNDS)]
        if len(x) > 1:
            slope(name, x, np.median(took, axis=0))


if __name__ == "__main__":
    table()
    agreement()
    growth()
