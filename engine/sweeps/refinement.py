"""Refinement halves each interval at whose ends the motion differs, level by level."""

import numpy as np

from .codes import MISSING
from .tolerances import SAME_IMPACTS


def midpoints(over: str, found: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The values at which cells are to be inserted.

    Parameters
    ----------
    over : str
        Name of the axis; between two ``steps`` there is a midpoint only if they are not neighbours.
    found : dict
        The axis and the variables of all cells so far, ascending along the axis.

    Returns
    -------
    left : (m,) ndarray of int
        The cells at the lower ends of the intervals.
    middle : (m,) ndarray
        Values of the axis between them and the next.
    """
    axis = found[over]
    left = np.flatnonzero(changed_intervals(found))
    middle = 0.5 * (axis[left] + axis[left + 1])
    if over == "steps":
        middle = np.floor(middle)
    inside = (middle > axis[left]) & (middle < axis[left + 1])
    return left[inside], middle[inside]


def changed_intervals(found: dict[str, np.ndarray]) -> np.ndarray:
    """Between which neighbours the motion changes: another period, other impacts in it, or one of them ended early.

    Returns
    -------
    (n − 1,) ndarray of bool
    """
    status, period, impacts = found["status"], found["period"], found["impacts_per_period"]
    periodic = period > 0
    other_impacts = periodic[1:] & periodic[:-1] & ~(np.abs(np.diff(impacts)) <= SAME_IMPACTS)
    ended = (status != 0) & (status != MISSING)
    both = ended[1:] & ended[:-1]
    return ~both & ((np.diff(status) != 0) | (np.diff(period) != 0) | other_impacts)
