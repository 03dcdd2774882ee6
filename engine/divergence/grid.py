"""One grid for several solutions: Newmark's own instants, period by period.

Newmark's solution exists at its steps alone, so that a comparison takes its instants and asks the solvers in closed
form for theirs there: nothing is interpolated. A run is never repeated for that. Its kept periods are run again from
its checkpoint, bit for bit, with samples; of a motion that repeats itself one cycle is enough.
"""

from dataclasses import replace

import numpy as np

from ..methods import Newmark
from ..result import Record, Response
from ..simulate import simulate

PER_PERIOD = 100  # samples; more change the fourth digit of an rms of displacements (tests/engine/test_error.py)


def sampled_again(response: Response, record: Record) -> Response:
    """The first ``record.periods`` of the kept periods once more, all of them sampled.

    Raises
    ------
    ValueError
        If the run ended early.
    """
    if not response.ok:
        raise ValueError(response.ending)
    return simulate(
        response.system,
        response.eta,
        response.method,
        periods=record.periods,
        keep=record.periods,
        initial=response.checkpoint,
        record=record,
    )


def on_grid(response: Response, record: Record) -> np.ndarray:
    """ξ₁, ξ₂, ξ₁′, ξ₂′ of the first ``record.periods`` kept periods, (4, periods, m) at the record's phases."""
    return by_period(sampled_again(response, record))


def by_period(response: Response) -> np.ndarray:
    """ξ₁, ξ₂, ξ₁′, ξ₂′ of a response's samples, (4, periods, m); the last instant is left out.

    Raises
    ------
    ValueError
        If nothing was sampled.
    """
    sampled = response.trajectory
    if sampled is None:
        raise ValueError("the response holds no samples: give simulate a Record")
    periods = round((sampled.time[-1] - sampled.time[0]) / response.period)
    rows = np.concatenate([sampled.displacement, sampled.velocity])[:, :-1]
    return rows.reshape(4, periods, -1)


def grid_of(response: Response) -> Record:
    """The record that samples one period of another solution at the instants of this one."""
    sampled = response.trajectory
    m = by_period(response).shape[2]
    if isinstance(response.method, Newmark):
        return Record(1, m, response.method.steps)
    spacing = (sampled.time[1] - sampled.time[0]) / response.period
    if abs(spacing * m - 1) > 1e-9:
        raise ValueError("the samples are not spread evenly over a period: sample this solver without record.steps")
    return Record(1, m)


def repeated(cycle: np.ndarray, periods: int, shift: int = 0) -> np.ndarray:
    """A cycle (…, p, m) that begins ``shift`` periods later, for so many periods: (…, periods, m)."""
    p = cycle.shape[-2]
    if shift % p == 0 and periods == p:
        return cycle
    return cycle[..., (np.arange(periods) + shift) % p, :]


def best_shift(cycle: np.ndarray, fixed: np.ndarray) -> int:
    """Periods by which a cycle (2, p, m) is to begin later to come closest to displacements (2, periods, m).

    A motion of p periods can run in p ways that differ by whole excitation periods, and each is as right as the other.
    """
    p, periods = cycle.shape[1], fixed.shape[1]
    if p == 1:
        return 0
    return min(range(p), key=lambda shift: rms(repeated(cycle, periods, shift) - fixed))


def laid_over(response: Response, period: int, fixed: np.ndarray, grid: Record) -> tuple[np.ndarray, int]:
    """A run on the grid of another solution, moved by whole periods to where it is closest.

    Parameters
    ----------
    response : Response
    period : int
        After which it repeats itself, so that one cycle is sampled and moved; 0: all is sampled, nothing moved.
    fixed : (4, periods, m) ndarray
        The other solution.
    grid : Record
        Of one period of it.

    Returns
    -------
    (4, periods, m) ndarray
        ξ₁, ξ₂, ξ₁′, ξ₂′; nan if the run ended early.
    int
        Excitation periods by which it was moved.
    """
    if not response.ok:
        return np.full_like(fixed, np.nan), 0
    periods = fixed.shape[1]
    sampled = on_grid(response, replace(grid, periods=period or periods))
    shift = best_shift(sampled[:2], fixed[:2]) if period else 0
    return repeated(sampled, periods, shift), shift


def rms(values: np.ndarray) -> float:
    """Root mean square of all numbers."""
    return float(np.sqrt(np.mean(np.square(values))))
