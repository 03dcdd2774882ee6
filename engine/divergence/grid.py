"""One time grid for several solutions: the instants of Newmark's steps, period by period.

Newmark's solution exists at its steps only. A comparison therefore takes these instants, and the closed-form solvers
are evaluated there: nothing is interpolated. No run is repeated for that. The kept periods start again from their
checkpoint, with the same bits, and are sampled; of a motion that repeats itself one cycle is enough.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from vibroscope.engine.divergence.tolerances import EVEN_SAMPLES
from vibroscope.engine.model import System
from vibroscope.engine.result import Record, Response
from vibroscope.engine.simulate import simulate

PER_PERIOD = 100  # samples; more change the fourth digit of an rms of displacements (tests/engine/test_error.py)


def about_rest(displacement: np.ndarray, system: System) -> np.ndarray:
    """ξ₁ and ξ₂, (2, …), from the static equilibrium: relative differences are relative to what moves."""
    rest = np.array(system.rest[::2])
    return displacement - rest.reshape(2, *[1] * (displacement.ndim - 1))


def rms(values: np.ndarray) -> float:
    """Return the root mean square of all numbers."""
    return float(np.sqrt(np.mean(np.square(values))))


def relative_to(difference: float, size: float) -> float:
    """Return a difference relative to a size; inf if the size alone is zero."""
    return difference / size if size > 0 else np.inf if difference > 0 else 0.0


def run_again(response: Response, **changed: Any) -> Response:
    """Simulate a run again, with other arguments of :func:`engine.simulate` or with other ``keep`` and ``method``."""
    names = "system", "eta", "method", "periods", "keep"
    return simulate(**{name: getattr(response, name) for name in names} | changed)


def simulate_samples(response: Response, record: Record, cancelled: Callable[[], bool] | None = None) -> Response:
    """Simulate the first ``record.periods`` of the kept periods again, all of them sampled.

    Raises
    ------
    ValueError
        If the run ended early.
    """
    if not response.ok:
        raise ValueError(response.ending)
    kept = {"periods": record.periods, "keep": record.periods, "record": record}
    return run_again(response, initial=response.checkpoint, cancelled=cancelled, **kept)


def samples_on_grid(response: Response, record: Record, cancelled: Callable[[], bool] | None = None) -> np.ndarray:
    """Return ξ₁, ξ₂, ξ₁′, ξ₂′ of the first ``record.periods`` kept periods, (4, periods, m), at the record's phases."""
    return samples_by_period(simulate_samples(response, record, cancelled))


def samples_by_period(response: Response) -> np.ndarray:
    """Return ξ₁, ξ₂, ξ₁′, ξ₂′ of a response's samples, (4, periods, m), without the last instant.

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
    """Return the record that samples one period of another solution at the same phases as this response."""
    sampled = response.trajectory
    m = samples_by_period(response).shape[2]
    if response.method.has_step:
        return Record(1, m, response.method.steps)
    spacing = (sampled.time[1] - sampled.time[0]) / response.period
    if abs(spacing * m - 1) > EVEN_SAMPLES:
        raise ValueError("the samples are not spread evenly over a period: sample this solver without record.steps")
    return Record(1, m)


def repeat_cycle(cycle: np.ndarray, periods: int, shift: int = 0) -> np.ndarray:
    """Repeat a cycle (…, p, m) to (…, periods, m), starting with its period number ``shift``."""
    p = cycle.shape[-2]
    if shift % p == 0 and periods == p:
        return cycle
    return cycle[..., (np.arange(periods) + shift) % p, :]


def best_shift(cycle: np.ndarray, displacement: np.ndarray) -> int:
    """Return the ``shift`` with which a repeated cycle (2, p, m) is closest to displacements (2, periods, m).

    A motion of p periods can run in p ways that differ by whole excitation periods; all are solutions of equal right.
    """
    p, periods = cycle.shape[1], displacement.shape[1]
    if p == 1:
        return 0
    return min(range(p), key=lambda shift: rms(repeat_cycle(cycle, periods, shift) - displacement))


def closest_repetition(cycle: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Repeat a cycle (2, p, m) to be closest to displacements (2, periods, m)."""
    return repeat_cycle(cycle, displacement.shape[1], best_shift(cycle, displacement))


def samples_beside(
    response: Response,
    period: int,
    other: np.ndarray,
    grid: Record,
    cancelled: Callable[[], bool] | None = None,
) -> tuple[np.ndarray, int]:
    """Sample a run on the grid of another solution, shifted by whole periods to be closest to it.

    Parameters
    ----------
    response : Response
    period : int
        Excitation periods after which it repeats itself; 0 if it does not: then nothing is shifted.
    other : (4, periods, m) ndarray
        The other solution.
    grid : Record
        Of one period of the other solution.

    Returns
    -------
    (4, periods, m) ndarray
        ξ₁, ξ₂, ξ₁′, ξ₂′; nan if the run ended early.
    int
        Excitation periods by which it was shifted.
    """
    if not response.ok:
        return np.full_like(other, np.nan), 0
    periods = other.shape[1]
    cycle = samples_on_grid(response, replace(grid, periods=period or periods), cancelled)
    shift = best_shift(cycle[:2], other[:2]) if period else 0
    return repeat_cycle(cycle, periods, shift), shift
