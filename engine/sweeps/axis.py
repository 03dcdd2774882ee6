"""The values along an axis of a study, checked or evenly spaced, and the start of its runs."""

from collections.abc import Sequence

import numpy as np
from vibroscope.engine.arguments import shown
from vibroscope.engine.checks import require, whole

LARGEST_SWEPT = 1e300  # of a range


def ascending_values(name: str, values: Sequence[float]) -> np.ndarray:
    """The values of an axis, checked.

    Raises
    ------
    ValueError
        If there are none, or they do not ascend strictly.
    """
    try:
        array = np.array(values, dtype=float).reshape(-1)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"the values of {name} are not numbers: give at least one") from None
    if not len(array):
        raise ValueError(f"no value of {name}: give at least one")
    if not (np.isfinite(array).all() and (np.diff(array) > 0).all()):
        raise ValueError(f"the values of {name} do not ascend strictly: sort them, and give each once")
    if name == "steps" and (array != np.round(array)).any():
        raise ValueError(f"steps = {array[array != np.round(array)][0]:g} is not a whole number: give steps per period")
    return array


def start_of(initial: Sequence[float] | None) -> tuple[float, ...] | None:
    """ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, or None for rest.

    Raises
    ------
    ValueError
        If they are not four numbers.
    """
    if initial is None:
        return None
    try:
        start = np.asarray(initial, float)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"initial = {shown(initial)} are no numbers: give the four of the state") from None
    if start.shape != (4,):
        raise ValueError(f"initial has {start.size} numbers: give the four of the state, ξ₁, ξ₁′, ξ₂, ξ₂′")
    return tuple(start.tolist())


def spaced(name: str, low: float, high: float, count: float, *, logarithmic: bool = False) -> np.ndarray:
    """Values from low to high, evenly spaced or evenly in the logarithm; ``steps`` are rounded to whole numbers.

    Raises
    ------
    ValueError
        If the range is empty, not positive where it is logarithmic, or the count is no number of values.

    Examples
    --------
    >>> from vibroscope.engine import spaced
    >>> spaced("K", 100, 10000, 3, logarithmic=True).round(6).tolist()
    [100.0, 1000.0, 10000.0]
    """
    n = whole(f"count of {name}", count, 1, 10_000_000, "give the number of values")  # held in memory
    low, high = (
        require(name, end, -LARGEST_SWEPT, LARGEST_SWEPT, "give the ends of the range as numbers")
        for end in (low, high)
    )
    if not (low < high or (low == high and n == 1)):
        raise ValueError(f"{name} from {low:g} to {high:g} is an empty range: give the smaller number first")
    if logarithmic:
        require(name, low, 0, LARGEST_SWEPT, "a logarithmic axis begins above 0", open_low=True)
    values = (np.geomspace if logarithmic else np.linspace)(low, high, n)
    return np.unique(np.round(values)) if name == "steps" else values
