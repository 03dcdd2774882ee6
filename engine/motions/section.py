"""What a Poincaré section tells by itself: whether it repeats, nearly repeats, or is regular without repeating."""

import numpy as np

TOLERANCE = 1e-5  # of the section's size: points that differ by less count as the same
# A constant step mislocates every contact change, so a penalty section is rarely a point: what recurs within this
# share of its size (root mean square) nearly repeats. Only short cycles are worth the name.
SCATTER = 0.03
MOST_NEARLY = 4
MOST_TUBES = 4


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


def band(section: np.ndarray, period: int = 1) -> float:
    """Standard deviation of ξ₁ and ξ₂ together about the ``period`` points of a cycle, in base amplitudes."""
    cycles = len(section) // period
    points = section[len(section) - cycles * period :, [0, 2]].reshape(cycles, period, 2)
    return float(np.sqrt(np.mean(np.var(points, axis=0).sum(axis=-1))))


def bump(n: int) -> np.ndarray:
    """Weights exp(−1/(s(1 − s))), s from 0 to 1, of sum 1: averages over n rows to which the ends add nothing.

    The average of a smooth function along a quasi-periodic motion then converges faster than any power of 1/n, that
    along a chaotic one as 1/√n all the same (Das, Saiki, Sander and Yorke, Nonlinearity 30 (2017) 4111).
    """
    s = np.arange(1, n + 1) / (n + 1)
    weights = np.exp(-1 / (s * (1 - s)))
    return weights / weights.sum()


def irregularity(section: np.ndarray) -> float:
    """Largest difference between the weighted averages over the halves of a section, of the coordinates and squares.

    In standard deviations of each. Some 1/√n in chaotic motion, and many orders less in a periodic or quasi-periodic
    one (Sander and Meiss, Physica D 411 (2020) 132569, tell them so); a transient shows as well.

    Parameters
    ----------
    section : (n, 4) ndarray
        Thousands of rows; a hundred tell little.
    """
    half = len(section) // 2
    size = max(section.std(axis=0).max(), TOLERANCE * np.abs(section).max(), 1e-300)
    about = (section - section.mean(axis=0)) / size
    seen = np.hstack([about, about**2])
    return float(np.abs(bump(half) @ (seen[:half] - seen[half : 2 * half])).max())


def rotation(section: np.ndarray) -> float:
    """The strongest frequency of a section but for those of cycles, in turns per excitation period, from 0 to ½.

    A torus may consist of several tubes that the motion visits in turn, up to MOST_TUBES of them: what repeats with
    them is taken out first. The spectrum of the weighted rows is read between its lines, 1/n apart.

    Parameters
    ----------
    section : (n, 4) ndarray
        Of a quasi-periodic motion.
    """
    about = section - section.mean(axis=0)
    visits = np.lcm.reduce(np.arange(1, MOST_TUBES + 1))
    for k in range(visits):
        about[k::visits] -= bump(len(about[k::visits])) @ about[k::visits]
    power = (np.abs(np.fft.rfft(about * bump(len(about))[:, None], axis=0)) ** 2).sum(axis=1)
    k = int(np.clip(power.argmax(), 1, len(power) - 2))
    low, top, high = np.log(np.maximum(power[k - 1 : k + 2], 1e-300))
    bend = low - 2 * top + high
    return float((k + (0.5 * (low - high) / bend if bend < 0 else 0.0)) / len(section))
