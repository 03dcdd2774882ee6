"""How wide the band of a Poincaré section is about the points of a cycle."""

import numpy as np


def band_width(section: np.ndarray, period: int = 1) -> float:
    """Standard deviation of ξ₁ and ξ₂ together about the ``period`` points of a cycle, in base amplitudes."""
    cycles = len(section) // period
    points = section[len(section) - cycles * period :, [0, 2]].reshape(cycles, period, 2)
    return float(np.sqrt(np.mean(np.var(points, axis=0).sum(axis=-1))))


def scatter(section: np.ndarray, period: int, body: int) -> float:
    """Standard deviation of a body's displacement about the ``period`` points of a cycle, in units of length."""
    cycles = len(section) // period
    points = section[len(section) - cycles * period :, 2 * body - 2].reshape(cycles, period)
    return float(np.sqrt(np.mean(np.var(points, axis=0))))
