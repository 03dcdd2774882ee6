"""The settled periods of two solutions: everything that a comparison states is of them.

A transient can be long: a reference may move irregularly for ten thousand periods and then repeat itself for ever. So a
solution that does not repeat itself runs longer, up to LONGEST times as many periods, before it is compared. Of motions
that never repeat, SECTION periods are kept, which counts and distributions need; of others those asked for.

A motion that never repeats is settled if its section no longer changes: that of half as many periods differs from it by
no more than halves of either differ from each other.
"""

import math
from collections.abc import Callable
from itertools import combinations

import numpy as np
from vibroscope.engine.divergence.grid import rms
from vibroscope.engine.divergence.tolerances import BURSTS, DRAWS_NEARER, NARROW, NOTICED, SECTION_DRIFT
from vibroscope.engine.drivers.section import period_of
from vibroscope.engine.law_table import LAWS
from vibroscope.engine.model import DISPLACEMENTS
from vibroscope.engine.motions.sameness import cycle_points, shifted_distance
from vibroscope.engine.motions.section import band_width
from vibroscope.engine.result import Response

LONGER = (4, 16)  # times the periods asked for
AFFORDED = 100_000_000  # steps of the longest run of a penalty solution whose steps are not skipped
AFFORDED_PERIODS = {True: math.inf, False: 10_000}  # of the same, by whether its law is linear by pieces
SECTION = 1000  # periods: quick to compute, and their distribution is known to about 1/√SECTION
BLOCKS = 8  # of a section, whose distances show what chance does


def settled_length(run: Callable[[str, int, int], Response], periods: int, keep: int) -> tuple[int, int]:
    """How many periods to run, and how many of them to keep, until both solutions are settled, as far as is afforded.

    Parameters
    ----------
    run : callable
        ``run(name, periods, keep)``: the "reference", "penalty" or "exact" solution.
    periods, keep : int
        At least.
    """
    first = [run(name, periods, keep) for name in ("reference", "penalty")]
    if not all(each.ok for each in first):
        return periods, keep
    method, longer = first[1].method, max(periods, SECTION // 2)  # so that all of them have a section to keep
    most = (
        math.inf
        if skips_steps(first[1])
        else min(AFFORDED / method.steps, AFFORDED_PERIODS[LAWS[method.law].closed_form])
    )
    lengths = [periods, *(factor * longer for factor in LONGER if factor * longer <= most)]
    settled, kept = lengths[0], keep
    for name, found in zip(("reference", "penalty"), first, strict=True):
        for length in lengths[lengths.index(settled) :]:
            if length > periods:
                found = run(name, length, SECTION)
            if not found.ok or repeats(found.section, keep):
                settled = length
                break
            if name == "penalty" and _is_blurred(found.section, run("exact", length, found.keep)):
                settled = length
                break
        else:
            settled = lengths[-1]
        if name == "reference" and found.ok and not repeats(found.section, keep):
            kept = SECTION
    return settled, kept


def skips_steps(run: Response) -> bool:
    """Whether a run skips steps in which contact does not change: between two stops none is skipped."""
    return run.method.skips_steps and not run.system.two_stops


def repeats(section: np.ndarray, keep: int) -> bool:
    """Whether a section repeats itself within half of ``keep`` periods, and is not on its way to a shorter cycle."""
    period = period_of(section)
    return 0 < period <= keep // 2 and not _approaches_shorter_cycle(section, period)


def _approaches_shorter_cycle(section: np.ndarray, period: int) -> bool:
    """Whether the points of a cycle draw nearer to each other: a spiral comes back by chance after some turns."""
    for part in range(1, period // 2 + 1):
        if period % part == 0:
            apart = np.abs(section[part:] - section[:-part]).max(axis=1)
            if apart[period:].max(initial=0.0) < DRAWS_NEARER * apart[:-period].max(initial=0.0):
                return True
    return False


def _is_blurred(section: np.ndarray, limit: Response) -> bool:
    """Whether a section is a narrow band about the points of its limit without a time step, which repeats itself."""
    period = period_of(limit.section) if limit.ok else 0
    if not 0 < 2 * period <= len(section):
        return False
    points, others = (cycle_points(rows, period)[:, DISPLACEMENTS] for rows in (section, limit.section))
    width, size = band_width(section, period), float(np.abs(others).max())
    return width <= NARROW * size and shifted_distance(points, others) <= BURSTS * width


def change_between(before: np.ndarray, section: np.ndarray) -> float:
    """How far a section, (n, 2), has moved since an earlier one, relative to its size: 0 if chance may explain it.

    Chance is that of halves of either: a motion whose blocks are correlated over hundreds of periods has much of it.
    """
    size = rms(section)
    moved = wasserstein_distance(before, section)
    by_chance = max(wasserstein_distance(*np.array_split(rows, 2)) for rows in (before, section))
    return moved / size if size > 0 and moved > max(SECTION_DRIFT * by_chance, NOTICED * size) else 0.0


def chance_distance(section: np.ndarray) -> float:
    """Distance that chance alone causes between two sections of this length, (n, 2), by its blocks and halves.

    The distance of blocks falls as one over the root of their length, unless they are correlated, which halves show.
    """
    blocks = np.array_split(section[: len(section) // BLOCKS * BLOCKS], BLOCKS)
    of_blocks = np.mean([wasserstein_distance(one, other) for one, other in combinations(blocks, 2)])
    return max(float(of_blocks) / math.sqrt(BLOCKS), wasserstein_distance(*np.array_split(section, 2)) / math.sqrt(2))


def wasserstein_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Return the mean of the Wasserstein distances between the columns of two (n, k) arrays."""
    return float(np.mean(np.abs(np.sort(one, axis=0) - np.sort(other, axis=0))))
