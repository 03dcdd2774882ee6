"""Shares of a plane, and the dimension of the boundary between the basins.

The uncertainty exponent α (Grebogi, McDonald, Ott and Yorke, Physics Letters A 99 (1983) 415) says how the share f(ε)
of starts whose motion an error ε may change falls with that error, f ∝ ε^α. The boundary then has the dimension 2 − α
in a plane: 1 for a smooth curve, and the closer to 2 the less a smaller error helps. f(ε) is the share of the pairs of
cells ε apart along an axis that lead to different motions, and α the slope of log f over log ε. Its standard error has
two parts: that of the fit, since f of a fractal waves about the straight line, and that of a jackknife over the plane,
which leaves out one tile after the other.
"""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.sweeps.step_study import observed_order

SMALLEST_DISTANCE, LARGEST_DISTANCE = 1, 16  # cells between the two of a pair, doubled from one to the other
LARGEST_SHARE = 8  # of the shorter side: a larger distance compares the sides of the plane
TILES = 4  # along each side
FEWEST_DISTANCES = 3  # distances of a fit with an error


class Boundary(NamedTuple):
    """Uncertainty exponent α and dimension 2 − α of a boundary; nan where there is none, or too few cells.

    Attributes
    ----------
    exponent, dimension, error : float
        The standard error is that of both.
    """

    exponent: float
    dimension: float
    error: float


def share_error(share: float, cells: int) -> float:
    """Standard error of a share of so many starts: √(p(1 − p)/n), for a lattice an upper bound."""
    return float(np.sqrt(share * (1 - share) / cells)) if cells else np.nan


def boundary(motion: np.ndarray) -> Boundary:
    """The boundary between basins in a plane.

    Parameters
    ----------
    motion : (n, m) ndarray of int
        The motion of each cell; negative: none, and no pair.
    """
    distances = _distances(motion.shape)
    counts = np.array([_counts(motion, distance) for distance in distances]).reshape(-1, 2, TILES * TILES)
    slope, of_fit = _slope(distances, counts.sum(axis=2))
    without = [_slope(distances, np.delete(counts, tile, axis=2).sum(axis=2))[0] for tile in range(TILES * TILES)]
    of_plane = np.sqrt((len(without) - 1) * np.var(without)) if np.isfinite(without).all() else np.nan
    return Boundary(slope, 2 - slope, float(np.hypot(of_fit, of_plane)))


def _distances(shape: tuple[int, int]) -> list[int]:
    longest = min(LARGEST_DISTANCE, min(shape) // LARGEST_SHARE)
    return [2**k for k in range(LARGEST_DISTANCE.bit_length()) if SMALLEST_DISTANCE <= 2**k <= longest]


def _counts(motion: np.ndarray, distance: int) -> np.ndarray:
    """Pairs of cells so far apart that lead to different motions, and all pairs, by tile: (2, TILES²)."""
    found = np.zeros((2, TILES * TILES))
    tiles = np.add.outer(
        *(np.arange(n) * TILES // n * factor for n, factor in zip(motion.shape, (TILES, 1), strict=True))
    )
    for axis in range(2):
        near = np.take(motion, range(motion.shape[axis] - distance), axis)
        far = np.take(motion, range(distance, motion.shape[axis]), axis)
        tile = np.take(tiles, range(motion.shape[axis] - distance), axis)
        pairs = (near >= 0) & (far >= 0)
        for row, which in enumerate((pairs & (near != far), pairs)):
            found[row] += np.bincount(tile[which], minlength=TILES * TILES)
    return found


def _slope(distances: list[int], counts: np.ndarray) -> tuple[float, float]:
    """α and the standard error of the fit; ``counts`` (distances, 2): different pairs and all of them."""
    if (counts > 0).all(axis=1).sum() < FEWEST_DISTANCES:
        return np.nan, np.nan
    return observed_order(1 / np.array(distances), counts[:, 0] / np.maximum(counts[:, 1], 1))
