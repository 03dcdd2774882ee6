"""Outliers of a record: samples that no body can have been at, such as a sensor's dropout or an overflow."""

import numpy as np
from vibroscope.engine.measurement.tolerances import COMMON, FAR_OUT, JUMP, TOO_FAST


def first_outlier(time: np.ndarray, values: np.ndarray) -> tuple[int, float] | None:
    """Find the first sample that lies too far out to belong to the motion.

    A body moves on and does not jump: a sample is an outlier if it lies FAR_OUT sizes of the motion from its middle and
    the body got there between two samples, or if the body moved to it and back with TOO_FAST times the speed that it
    has in all but few of the other intervals. An impact turns a velocity and moves no body between two samples.

    Parameters
    ----------
    time, values : (n,) ndarray

    Returns
    -------
    (int, float) or None
        Its number, and its distance from the middle in sizes of the motion.
    """
    low, middle, high = np.quantile(values, [(1 - COMMON) / 2, 0.5, (1 + COMMON) / 2])
    size = max(high - middle, middle - low)
    if size == 0.0:
        return None
    distance = np.abs(values - middle) / size
    slopes = np.diff(values) / np.diff(time)
    fast = np.abs(slopes) > TOO_FAST * np.quantile(np.abs(slopes), COMMON)
    spike = np.zeros(len(values), bool)
    spike[1:-1] = fast[:-1] & fast[1:] & (slopes[:-1] * slopes[1:] < 0)
    found = np.flatnonzero(_beyond_a_jump(values, distance > FAR_OUT, distance * size) | (spike & (distance > 1)))
    return (int(found[0]), float(distance[found[0]])) if len(found) else None


def _beyond_a_jump(values: np.ndarray, far: np.ndarray, excursion: np.ndarray) -> np.ndarray:
    """Which of the samples that lie far out, (n,) of bool, belong to a row of such that begins or ends with a jump."""
    found = np.zeros(len(values), bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], far, [False]]).astype(int)))
    for start, end in edges.reshape(-1, 2):
        sides = [pair for pair in ((start - 1, start), (end, end - 1)) if 0 <= pair[0] < len(values)]
        found[start:end] = any(abs(values[out] - values[into]) > JUMP * excursion[into] for out, into in sides)
    return found
