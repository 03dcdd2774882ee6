"""The settled periods of two solutions: everything that a comparison states is of them.

A transient can be long: a reference may move irregularly for ten thousand periods and then repeat itself for ever. So a
solution that does not repeat itself runs longer, up to LONGEST times as many periods, before it is compared. Of motions
that never repeat, SECTION periods are kept, which counts and distributions need; of others those asked for.

A motion that never repeats is settled if its section no longer changes: the halves of it differ by no more than blocks
of the same motion do by chance.
"""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from ..drivers.section import period_of
from ..motions.sameness import cycle_points
from ..motions.section import band_width
from ..result import Response

LONGER = (4, 16)  # times the periods asked for
AFFORDED = 3.0  # s of the longest run of the penalty solution
SECTION = 1000  # periods: quick to compute, and their distribution is known to about 1/√SECTION
NARROW = 0.2  # of the cycle's size: the width of a band that a time step makes about it
BURSTS = 4.0  # of its widths: how far the middle of such a band may lie from the cycle
BLOCKS = 8  # of a section, whose distances show what chance does
DRIFT = 4.0  # times the distance by chance: halves that differ by more belong to a motion that still changes
NOTICED = 0.02  # of the section's size: less is no change that matters


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
    afforded = AFFORDED / max(first[1].cost.seconds, 1e-9)
    longer = max(periods, SECTION // 2)  # so that all of them have a section to keep
    lengths = [periods, *(factor * longer for factor in LONGER if factor * longer <= afforded * periods)]
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


def repeats(section: np.ndarray, keep: int) -> bool:
    """Whether a section repeats itself within half of ``keep`` periods."""
    return 0 < period_of(section) <= keep // 2


def _is_blurred(section: np.ndarray, limit: Response) -> bool:
    """Whether a section is a narrow band about the points of its limit without a time step, which repeats itself."""
    period = period_of(limit.section) if limit.ok else 0
    if not 0 < 2 * period <= len(section):
        return False
    points, others = (cycle_points(rows, period)[:, [0, 2]] for rows in (section, limit.section))
    width, size = band_width(section, period), float(np.abs(others).max())
    apart = min(float(np.abs(points - np.roll(others, shift, axis=0)).max()) for shift in range(period))
    return width <= NARROW * size and apart <= BURSTS * width


def change_of(section: np.ndarray) -> float:
    """How far a section, (n, 2), still moves, relative to its size: 0 if no more than chance explains.

    Chance is that of neighbouring blocks, which drift parts the least.
    """
    size = float(np.sqrt(np.mean(np.square(section))))
    halves = np.array_split(section, 2)
    moved = wasserstein_distance(*halves)
    by_chance = chance_distance(section) * math.sqrt(2)
    return moved / size if size > 0 and moved > max(DRIFT * by_chance, NOTICED * size) else 0.0


def chance_distance(section: np.ndarray) -> float:
    """Distance that chance alone causes between two sections of this length, (n, 2), by neighbouring blocks."""
    blocks = [block for block in np.array_split(section, BLOCKS) if len(block)]
    length = min(map(len, blocks))
    near = [wasserstein_distance(one[:length], other[:length]) for one, other in pairwise(blocks)]
    return float(np.mean(near)) / math.sqrt(BLOCKS) if near else 0.0


def wasserstein_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Return the mean of the Wasserstein distances between the columns of two (n, k) arrays."""
    return float(np.mean(np.abs(np.sort(one, axis=0) - np.sort(other, axis=0))))
