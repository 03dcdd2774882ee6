"""Where a penalty solution leaves the reference, as numbers."""

from dataclasses import dataclass

import numpy as np

from .motion import Motion, motion
from .result import Response

GRID = 1000  # instants per period at which displacements are compared


@dataclass(frozen=True)
class Comparison:
    """A penalty response beside the reference.

    Attributes
    ----------
    reference, penalty : Motion
    pointwise : bool
        Whether both motions repeat, but for scatter, after the same number of periods, and so many were sampled. Only
        then do they stay in step, and a difference at each instant means something (MODEL.md, "What the difference is
        made of").
    rms : float
        Root mean square difference of the displacements over the last cycle, relative to that of the reference; nan
        unless ``pointwise``.
    shift : int
        Excitation periods by which the penalty solution was moved: a motion of period p can run in p ways that differ
        by whole excitation periods, and each is as right as the other.
    """

    reference: Motion
    penalty: Motion
    pointwise: bool
    rms: float
    shift: int


def compare(reference: Response, penalty: Response) -> Comparison:
    """Compare two responses that hold samples.

    Raises
    ------
    ValueError
        If a run ended early or holds no samples.
    """
    first, second = motion(reference), motion(penalty)
    period = first.near_period if first.near_period == second.near_period else 0
    one, other = last_cycle(reference, period), last_cycle(penalty, period)
    if period == 0 or one is None or other is None:
        return Comparison(first, second, False, float("nan"), 0)
    rms = [np.sqrt(np.mean((np.roll(other, GRID * k, axis=1) - one) ** 2)) for k in range(period)]
    shift = int(np.argmin(rms))
    return Comparison(first, second, True, float(rms[shift] / np.sqrt(np.mean(one**2))), shift)


def last_cycle(response: Response, period: int) -> np.ndarray | None:
    """Displacements at GRID instants a period over the last ``period`` periods, (2, n); None if fewer were sampled.

    Raises
    ------
    ValueError
        If nothing was sampled.
    """
    sampled = response.trajectory
    if sampled is None:
        raise ValueError("the response holds no samples: give simulate a Record")
    time = (sampled.time - sampled.time[-1]) / response.period + period
    if time[0] > 1e-9:
        return None
    grid = np.arange(GRID * period) / GRID
    return np.stack([np.interp(grid, time, row) for row in sampled.displacement])
