"""What a Poincaré section says: its period and band, averages, whether it is regular, whether two motions are the same.

Two kinds of averages are used. For *irregular* motion, batch means: the mean over each of several long batches scatters
as independent numbers do, so that their spread gives the standard error of the mean. For *regular* (periodic or
quasi-periodic) motion, an average with smooth weights, which converges faster than any power of 1/n.
Two runs of **one solver** that tend to the same cycle agree to rounding, but for what a time step scatters; two
irregular motions are the same if their averages agree within their standard errors.

Motions of **two solvers** are never equal: K, D and the time step move a cycle. They count as the same if they repeat
after equally many periods, or neither does, and if their sections lie within BETWEEN_SOLVERS of the size of the larger
one, after the shift by whole periods that brings cycles together; of irregular motions, mean and standard deviation of
the section. The tolerance lies above what a penalty model moves a motion and below what separates coexisting motions of
equal period; `tests/engine/test_sameness.py` measures both on the paper's system.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from vibroscope.engine.drivers.section import TOLERANCE, period_of, periods_of, sizes_of
from vibroscope.engine.model import DISPLACEMENTS, System
from vibroscope.engine.motions.tolerances import BETWEEN_SOLVERS, DYING, NOISY, SAME_AVERAGES, SAME_CYCLE, THIN

SECTION_BATCHES = 16
MOST_TUBES = 4  # of a torus, which the motion visits in turn


def batch_means(values: np.ndarray, batches: int) -> np.ndarray:
    """Return the mean of each of ``batches`` consecutive batches of rows, (batches, …)."""
    if len(values) % batches == 0:
        return values.reshape(batches, -1, *values.shape[1:]).mean(axis=1)
    return np.array([batch.mean(axis=0) for batch in np.array_split(values, batches)])


def standard_error(means: np.ndarray) -> np.ndarray:
    """Return the standard error of the overall mean, from the means of independent batches (n, …)."""
    return np.std(means, axis=0, ddof=1) / np.sqrt(len(means))


@lru_cache(maxsize=32)
def smooth_weights(n: int) -> np.ndarray:
    """Return n weights ∝ exp(−1/(s(1 − s))), 0 < s < 1, of sum 1, which vanish with all derivatives at both ends.

    The average of a smooth function along a quasi-periodic motion then converges faster than any power of 1/n. Along a
    chaotic motion it converges as 1/√n, as with equal weights (Das, Saiki, Sander and Yorke, Nonlinearity 30 (2017)
    4111).
    """
    s = np.arange(1, n + 1) / (n + 1)
    weights = np.exp(-1 / (s * (1 - s)))
    weights /= weights.sum()
    weights.flags.writeable = False  # all callers share them
    return weights


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


def same_motion(known: np.ndarray, section: np.ndarray, period: int, blurred: bool = False, least: float = 0.0) -> bool:
    """Whether a section is that of a known motion of the same solver; arguments as of :func:`same_cycle`.

    ``period`` 0: the known motion does not repeat itself.
    """
    if period:
        return same_cycle(known, section, period, blurred, least)
    return not period_of(section) and same_averages(known, section)


def same_cycle(known: np.ndarray, section: np.ndarray, period: int, blurred: bool = False, least: float = 0.0) -> bool:
    """Whether two sections of one solver are the same cycle of points but for time-step scatter, wherever they begin.

    Parameters
    ----------
    known, section : (n, 4), (m, 4) ndarray
        Of one cycle, or of at least two.
    period : int
        Of the known one.
    blurred : bool
        Whether a time step scatters the known one: from another start it may lock the scatter, so that the widths of
        thin bands may differ by any factor.
    least : float
        Size below which a motion counts as rest (:func:`least_size`).
    """
    if len(section) != period and len(section) < 2 * period:
        return False
    points, others = cycle_points(known, period), cycle_points(section, period)
    widths = band_width(known, period), band_width(section, period)
    size = max(np.abs(known).max(), least)
    if max(widths) > max(NOISY * min(widths) + TOLERANCE * size, THIN * size if blurred else 0.0):
        return False
    return shifted_distance(points, others) <= SAME_CYCLE * size + NOISY * max(widths)


def least_size(system: System, starts: np.ndarray) -> float:
    """Size below which a motion from one of these starts, (n, 4), counts as rest.

    What is left of a free vibration has no size of its own; a driven motion has.
    """
    return 0.0 if system.excitation.drives else float(np.abs(starts).max())


def cycle_points(section: np.ndarray, period: int) -> np.ndarray:
    """The mean point of each period of a cycle, (period, 4)."""
    cycles = len(section) // period
    return section[len(section) - cycles * period :].reshape(cycles, period, 4).mean(axis=0)


def same_averages(known: np.ndarray, section: np.ndarray) -> bool:
    """Whether the averages of coordinates and their squares agree within their standard errors."""
    if len(known) != len(section):
        return False
    means = [batch_means(np.hstack([rows, rows**2]), SECTION_BATCHES) for rows in (known, section)]
    average, other = (each.mean(axis=0) for each in means)
    error = np.hypot(*(standard_error(each) for each in means))
    return bool((np.abs(average - other) <= SAME_AVERAGES * error + TOLERANCE * np.abs(average).max()).all())


def same_between_solvers(one: np.ndarray, period: int, other: np.ndarray, other_period: int) -> bool:
    """Whether two solvers have the same motion, by their sections and the periods after which they repeat themselves.

    Parameters
    ----------
    one, other : (n, 4), (m, 4) ndarray
        Whole cycles, or any rows of motions that do not repeat.
    period, other_period : int
        0: the motion does not repeat.
    """
    return period == other_period and distance_between_solvers(one, other, period) <= BETWEEN_SOLVERS


def distance_between_solvers(one: np.ndarray, other: np.ndarray, period: int) -> float:
    """How far the sections of two solvers are apart, relative to the size of the larger one.

    Parameters
    ----------
    one, other : (n, 4), (m, 4) ndarray
        Whole cycles, or any rows of motions that do not repeat.
    period : int
        Of both; 0: they do not repeat.
    """
    if not period:  # mean and standard deviation, as a cycle of one point of eight coordinates
        one, other = (np.concatenate([rows.mean(axis=0), rows.std(axis=0)])[None] for rows in (one, other))
    else:
        one, other = cycle_points(one, period), cycle_points(other, period)
    return shifted_distance(one, other) / max(np.abs(one).max(), np.abs(other).max(), 1e-300)


def shifted_distance(points: np.ndarray, others: np.ndarray) -> float:
    """Largest difference of two cycles of as many points, after the shift that makes it smallest."""
    return min(float(np.abs(points - np.roll(others, shift, axis=0)).max()) for shift in range(len(points)))


def irregularity(section: np.ndarray) -> float:
    """Largest difference between smoothly weighted averages over the two halves of a section.

    Averaged are the four coordinates and their squares, in units of the largest standard deviation. The difference is
    of the order of 1/√n for chaotic motion and many orders of magnitude less for periodic and quasi-periodic motion
    (Sander and Meiss, Physica D 411 (2020) 132569). A transient makes it large, too.

    Parameters
    ----------
    section : (n, 4) ndarray
        Thousands of rows; a hundred do not suffice to separate the two cases.
    """
    half = len(section) // 2
    size = max(section.std(axis=0).max(), TOLERANCE * sizes_of(section[None])[0])
    scaled = (section - section.mean(axis=0)) / size
    observed = np.hstack([scaled, scaled**2])
    return float(np.abs(smooth_weights(half) @ (observed[:half] - observed[half : 2 * half])).max())


def rotation_number(section: np.ndarray) -> float:
    """Strongest frequency of a quasi-periodic section, in turns per excitation period, from 0 to ½.

    A torus may consist of several tubes, up to MOST_TUBES, that the motion visits in turn. Their common period is
    removed first: from the rows of each visit the mean of these rows is subtracted. The peak of the weighted spectrum
    is then interpolated between its lines, which lie 1/n apart, by a parabola through the logarithms of three values.

    Parameters
    ----------
    section : (n, 4) ndarray
    """
    deviation = section - section.mean(axis=0)
    visits = np.lcm.reduce(np.arange(1, MOST_TUBES + 1))
    for first in range(visits):
        tube = deviation[first::visits]
        tube -= smooth_weights(len(tube)) @ tube
    power = (np.abs(np.fft.rfft(deviation * smooth_weights(len(deviation))[:, None], axis=0)) ** 2).sum(axis=1)
    line = int(np.clip(power.argmax(), 1, len(power) - 2))
    left, top, right = np.log(np.maximum(power[line - 1 : line + 2], 1e-300))
    curvature = left - 2 * top + right
    return float((line + (0.5 * (left - right) / curvature if curvature < 0 else 0.0)) / len(section))
