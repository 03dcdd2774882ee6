"""The period that a Poincaré section settles to, and how wide its band is about the points of a cycle."""

from collections.abc import Callable

import numpy as np
from vibroscope.engine.drivers.section import periods_of
from vibroscope.engine.model import DISPLACEMENTS
from vibroscope.engine.motions.tolerances import DYING


def settled_periods(sections: np.ndarray) -> np.ndarray:
    """Smallest periods that sections, (n, rows, 4), have or tend to, (n,) of int; 0 where one does not repeat itself.

    What is left of a transient returns most nearly after the periods that its own frequency chooses, so that the
    section seems to repeat itself after as many. But the difference between its points fades from the first half to the
    second, where that of a cycle stays.
    """
    return periods_of(sections, dying=DYING)


def settled_period(section: np.ndarray) -> int:
    """The result of :func:`settled_periods` for one section."""
    return int(settled_periods(section[None])[0])


def band_widths(sections: np.ndarray, periods: np.ndarray, columns: slice = DISPLACEMENTS) -> np.ndarray:
    """Standard deviation of ξ₁ and ξ₂ together about the points of a cycle, in base amplitudes.

    Parameters
    ----------
    sections : (n, rows, 4) ndarray
    periods : (n,) ndarray of int
        Points of each cycle.
    columns : slice, optional
        Of the coordinates that count.

    Returns
    -------
    (n,) ndarray
    """
    return _by_period(sections[..., columns], periods, lambda points: np.var(points, axis=1).sum(axis=-1).mean(axis=-1))


def cycle_spreads(sections: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Standard deviation of ξ₁ and ξ₂ together among the points of a cycle; arguments as of :func:`band_widths`."""
    shown = sections[..., DISPLACEMENTS]
    return _by_period(shown, periods, lambda points: np.var(points.mean(axis=1), axis=1).sum(axis=-1))


def band_width(section: np.ndarray, period: int = 1, columns: slice = DISPLACEMENTS) -> float:
    """The result of :func:`band_widths` for one section."""
    return float(band_widths(section[None], np.array([period]), columns)[0])


def _by_period(sections: np.ndarray, periods: np.ndarray, variance: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Roots of the variances of sections, taken together where they have as many points: (m, cycles, period, k)."""
    found, rows = np.empty(len(sections)), sections.shape[1]
    for period in np.unique(periods).tolist():
        chosen, cycles = np.flatnonzero(periods == period), rows // period
        points = sections[chosen, rows - cycles * period :]
        found[chosen] = np.sqrt(variance(points.reshape(len(chosen), cycles, period, points.shape[-1])))
    return found


def scatter(section: np.ndarray, period: int, body: int) -> float:
    """Standard deviation of a body's displacement about the ``period`` points of a cycle, in units of length."""
    return band_width(section, period, slice(2 * body - 2, 2 * body - 1))
