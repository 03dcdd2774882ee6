"""From a setting that meets the tolerances to the middle of where they are met.

The cheapest setting that a search finds lies at the edge of what works, and which edge point it finds is a matter of
chance. So K and D are moved, one after the other, to the middle of the range in which each alone keeps to the
tolerances, and rounded to as few digits as leave them there. Where there is no room on both sides, more steps make
some.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from ..methods import DAMPING_RANGE, STIFFNESS_RANGE
from .limits import Limits
from .range_trials import RangeTrials
from .trials import NewmarkSetting, Trial, Trials

STRIDE = 1.04  # from point to point of a range, a factor
FARTHEST = 12  # points on each side: a factor of 1.6
AT_ONCE = 4  # points that are tried side by side
SPARE = (1.0, 1.08, 1.16, 1.25, 1.5, 2.0, 3.0)  # times the least number of steps
DIGITS = (2, 3)  # of K and D


@dataclass(frozen=True)
class Middle:
    """A setting, and the ranges of K and D in which it keeps to the tolerances.

    Attributes
    ----------
    setting : NewmarkSetting
    ranges : dict
        Of "stiffness" and "damping", without those that are held: the least and the largest value tried that keep to
        the tolerances, with all between, where the other number stays.
    """

    setting: NewmarkSetting
    ranges: dict[str, tuple[float, float]]


class MiddleSearch:
    """Finds the middle for settings of one search.

    Parameters
    ----------
    trials : Trials or RangeTrials
    limits : Limits
        What is held is not moved.
    tolerance : float
        Of the displacements.

    Attributes
    ----------
    ranges : dict
        By each verified setting: :attr:`Middle.ranges`.
    """

    def __init__(self, trials: Trials | RangeTrials, limits: Limits, tolerance: float):
        self.trials, self.limits, self.tolerance = trials, limits, tolerance
        self.ranges: dict[NewmarkSetting, dict[str, tuple[float, float]]] = {}
        self.free = [name for name in ("stiffness", "damping") if getattr(limits, name) is None]

    def verified(self, met: list[Trial], verify: Callable[[NewmarkSetting], Trial]) -> Iterator[Trial]:
        """Yield a verified middle for each of several settings that meet the tolerances, and keep its ranges.

        Parameters
        ----------
        met : list of Trial
        verify : callable
            :meth:`.trials.Trials.verify` of the question as it is.
        """
        for trial in met:
            for steps in spare_steps(trial.setting.steps, self.limits.steps_max):
                found = self.find(trial.setting._replace(steps=steps))
                if found is None or found.setting in self.ranges:
                    continue
                verified = verify(found.setting)
                if verified.meets(self.tolerance):
                    self.ranges[found.setting] = found.ranges
                    yield verified
                    break

    def find(self, setting: NewmarkSetting) -> Middle | None:
        """Return the middle with the steps of a setting; None if one of its ranges has no middle."""
        if not self._meets(setting):
            return None
        for name in self.free:
            low, high = self._range(setting, name)
            middle = _few_digits(low, high)
            setting = setting._replace(**{name: setting._asdict()[name] if middle is None else middle})
        ranges = {name: self._range(setting, name) for name in self.free}
        inside = all(self._has_room(name, getattr(setting, name), *ends) for name, ends in ranges.items())
        return Middle(setting, ranges) if inside else None

    def _has_room(self, name: str, own: float, low: float, high: float) -> bool:
        """Whether a range leaves room on both sides, but for what a limit takes."""
        least, most = self._bounds(name)
        return (low < own or own / STRIDE < least) and (high > own or own * STRIDE > most)

    def _meets(self, setting: NewmarkSetting) -> bool:
        return self.trials.meets_one(setting, self.tolerance)

    def _range(self, setting: NewmarkSetting, name: str) -> tuple[float, float]:
        """Return how far one number goes down and up; its own value where it does not."""
        own, bounds = getattr(setting, name), self._bounds(name)
        ends = []
        for direction in (-1, 1):
            points = [own * STRIDE ** (direction * i) for i in range(1, FARTHEST + 1)]
            points = [point for point in points if bounds[0] <= point <= bounds[1]]
            ends.append(self._last_that_meets(setting, name, points))
        return ends[0], ends[1]

    def _last_that_meets(self, setting: NewmarkSetting, name: str, points: list[float]) -> float:
        last = getattr(setting, name)
        for begin in range(0, len(points), AT_ONCE):
            some = points[begin : begin + AT_ONCE]
            settings = [setting._replace(**{name: point}) for point in some]
            for point, meets in zip(some, self.trials.all_meet(settings, self.tolerance), strict=True):
                if not meets:
                    return last
                last = point
        return last

    def _bounds(self, name: str) -> tuple[float, float]:
        return (STIFFNESS_RANGE[0], self.limits.stiffness_max) if name == "stiffness" else DAMPING_RANGE


def _few_digits(low: float, high: float) -> float | None:
    """Return a number of few digits in the middle half of a range, on a logarithmic scale; None if there is none."""
    centre, quarter = math.sqrt(low * high), (high / low) ** 0.25
    numbers = (float(f"{centre:.{digits}g}") for digits in DIGITS)
    return next((number for number in numbers if centre / quarter <= number <= centre * quarter), None)


def spare_steps(steps: int, most: int) -> list[int]:
    """Return the numbers of steps of two digits to try, from ``steps`` on."""
    return list(dict.fromkeys(min(most, steps_of_two_digits(steps * factor)) for factor in SPARE))


def steps_of_two_digits(steps: float) -> int:
    """Round up to two significant digits."""
    unit = 10 ** max(0, math.floor(math.log10(steps)) - 1)
    return unit * math.ceil(steps / unit * (1 - 1e-12))
