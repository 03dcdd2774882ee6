"""Whether a Poincaré section repeats itself, exactly or nearly, and how wide its band is."""

import numpy as np

TOLERANCE = 1e-5  # of the section's size: points that differ by less count as the same
# A constant step mislocates every contact change, so a penalty section is rarely a point: what recurs within this
# share of its size (root mean square) nearly repeats. Only short cycles are worth the name.
SCATTER = 0.03
MOST_NEARLY = 4


def repeats_after(section: np.ndarray, tolerance: float = TOLERANCE) -> int:
    """Smallest p, at most half the rows, with section[i + p] = section[i] throughout; 0 if there is none.

    Parameters
    ----------
    section : (n, 4) ndarray
    tolerance : float
        Relative to the largest coordinate of the section.
    """
    allowed = tolerance * max(np.abs(section).max(initial=0.0), 1e-12)
    for p in range(1, len(section) // 2 + 1):
        # most p fail at their first row already
        if np.abs(section[p] - section[0]).max() <= allowed and np.abs(section[p:] - section[:-p]).max() <= allowed:
            return p
    return 0


def nearly_repeats_after(section: np.ndarray) -> int:
    """Smallest p ≤ MOST_NEARLY after which the section recurs but for scatter; 0 if there is none."""
    allowed = SCATTER * np.abs(section).max(initial=0.0)
    for p in range(1, min(MOST_NEARLY, len(section) // 2) + 1):
        if np.sqrt(np.mean((section[p:] - section[:-p]) ** 2)) <= allowed:
            return p
    return 0


def band_width(section: np.ndarray, period: int = 1) -> float:
    """Standard deviation of ξ₁ and ξ₂ together about the ``period`` points of a cycle, in base amplitudes."""
    cycles = len(section) // period
    points = section[len(section) - cycles * period :, [0, 2]].reshape(cycles, period, 2)
    return float(np.sqrt(np.mean(np.var(points, axis=0).sum(axis=-1))))
