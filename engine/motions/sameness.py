"""Whether two motions are the same one: of one solver from two starts, or of two solvers.

Two runs of **one solver** that tend to the same cycle agree to rounding, but for what a time step scatters; two
irregular motions are the same if their averages agree within their standard errors.

Motions of **two solvers** are never equal: K, D and the time step move a cycle. They count as the same if they repeat
after equally many periods, or neither does, and if their sections lie within BETWEEN_SOLVERS of the size of the larger
one, after the shift by whole periods that brings cycles together; of irregular motions, mean and standard deviation of
the section. The tolerance lies above what a penalty model moves a motion and below what separates coexisting motions of
equal period; `tests/engine/test_sameness.py` measures both on the paper's system.
"""

import numpy as np
from vibroscope.engine.drivers.section import TOLERANCE, period_of
from vibroscope.engine.model import System
from vibroscope.engine.motions.averages import batch_means, standard_error
from vibroscope.engine.motions.section import band_width
from vibroscope.engine.motions.tolerances import BETWEEN_SOLVERS, NOISY, SAME_AVERAGES, SAME_CYCLE, THIN

SECTION_BATCHES = 16


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
