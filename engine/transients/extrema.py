"""Largest values between samples, from the cubic that has the values and the slopes of both ends of an interval."""

import numpy as np
from vibroscope.engine.result import Impacts, Trajectory


def largest(time: np.ndarray, value: np.ndarray, slope: np.ndarray, smooth: np.ndarray) -> float:
    """The largest |f| of samples f and f′ at instants τ, (n,) each.

    ``smooth``, (n − 1,): the intervals within which f′ does not jump. The error is that of a cubic, of fourth order.
    """
    h, found = np.diff(time), float(np.abs(value).max(initial=0.0))
    turning = np.flatnonzero(smooth & (h > 0.0) & (slope[:-1] * slope[1:] < 0.0))
    if not len(turning):
        return found
    h, first, begin, end = h[turning], value[turning], slope[turning], slope[turning + 1]
    mean = (value[turning + 1] - first) / h
    square, cube = (3.0 * mean - 2.0 * begin - end) / h, (begin + end - 2.0 * mean) / (h * h)
    # f′ = begin + 2 square s + 3 cube s² has one root within; the form that does not cancel
    root = np.sqrt(np.maximum(square * square - 3.0 * cube * begin, 0.0))
    turn = -(square + np.copysign(root, square))
    with np.errstate(divide="ignore", invalid="ignore"):
        s, other = begin / turn, turn / (3.0 * cube)
    s = np.where((s >= 0.0) & (s <= h), s, np.clip(other, 0.0, h))
    extreme = first + s * (begin + s * (square + s * cube))
    return max(found, float(np.nanmax(np.abs(extreme))))


def without_impacts(sampled: Trajectory, impacts: Impacts) -> np.ndarray:
    """The intervals between samples, (n − 1,) of bool, in which no impact falls."""
    places = np.searchsorted(impacts.time, sampled.time, side="right")
    return np.diff(places) == 0
