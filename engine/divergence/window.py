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

from ..drivers.section import near_period_of, period_of
from ..result import Response

LONGER = (4, 16)  # times the periods asked for
AFFORDED = 3.0  # s of the longest run of the penalty solution
SECTION = 1000  # periods: quick to compute, and their distribution is known to about 1/√SECTION
BLOCKS = 8  # of a section, whose distances show what chance does
DRIFT = 4.0  # times the distance by chance: halves that differ by more belong to a motion that still changes
NOTICED = 0.02  # of the section's size: less is no change that matters


def settled_length(run: Callable[[str, int, int], Response], periods: int, keep: int) -> tuple[int, int]:
    """How many periods to run, and how many of them to keep, until both solutions are settled, as far as is afforded.

    Parameters
    ----------
    run : callable
        ``run(name, periods, keep)``: the "reference" or "penalty" solution.
    periods, keep : int
        At least.
    """
    first = [run(name, periods, keep) for name in ("reference", "penalty")]
    if not all(each.ok for each in first):
        return periods, keep
    afforded = AFFORDED / max(first[1].cost.seconds, 1e-9)
    lengths = [periods, *(factor * periods for factor in LONGER if factor <= afforded)]
    settled, kept = lengths[0], keep
    for name, found in zip(("reference", "penalty"), first, strict=True):
        for length in lengths[lengths.index(settled) :]:
            if length > periods:
                found = run(name, length, SECTION)
            if not found.ok or repeats(found.section, keep, name == "penalty"):
                settled = length
                break
        else:
            settled = lengths[-1]
        if name == "reference" and found.ok and not 0 < period_of(found.section) <= keep // 2:
            kept = SECTION
    return settled, kept


def repeats(section: np.ndarray, keep: int, scatters: bool) -> bool:
    """Whether a section repeats itself within half of ``keep`` periods, or ``scatters`` steadily about a cycle."""
    if 0 < period_of(section) <= keep // 2:
        return True
    near = near_period_of(section)
    return bool(scatters and near and not _narrows(section, near))


def _narrows(section: np.ndarray, period: int) -> bool:
    """Whether the second half of a band lies elsewhere than the first, or is clearly narrower, as a transient."""
    half = len(section) // 2 // period * period
    if half < period:
        return False
    first, second = (rows.reshape(-1, period, 4)[..., [0, 2]] for rows in (section[-2 * half : -half], section[-half:]))
    width = max(float(first.std(axis=0).max()), 1e-300)
    moved = float(np.abs(first.mean(axis=0) - second.mean(axis=0)).max())
    return moved > width or float(second.std(axis=0).max()) < width / 2


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
