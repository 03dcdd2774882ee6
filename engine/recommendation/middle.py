"""From a setting that meets the tolerances to the middle of where they are met.

The cheapest setting that a search finds lies at the edge of what works, and which edge point it finds is a matter of
chance. So K and D are moved, one after the other, to the middle of the range in which each alone keeps to the
tolerances, and rounded to as few digits as leave them there. Where there is no room on both sides, more steps make
some.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np
from vibroscope.engine.methods import DAMPING_RANGE, STIFFNESS_RANGE
from vibroscope.engine.recommendation.limits import Limits
from vibroscope.engine.recommendation.range_trials import RangeTrials
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trial
from vibroscope.engine.wording import rounded_to, rounded_up

RANGE_STRIDE = 1.05  # from point to point of a range, a factor
CONFIRMED_PER_STRIDE, RANGE_MISS_IN = 6, 20  # points to a stride that confirm a range; one in so many of them may miss
POINTS_EACH_SIDE = 10  # points on each side: a factor of 1.6
POINTS_AT_ONCE = 4  # points that are tried side by side
SPARE = (1.0, 1.1, 1.2, 1.35, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0)  # times the least number of steps
MIDDLE_DIGITS = (2, 3)  # of K and D


class MiddleSearch:
    """Finds the middle for settings of one search.

    Parameters
    ----------
    trials : RangeTrials
    limits : Limits
        What is held is not moved.
    tolerance : float
        Of the displacements.

    Attributes
    ----------
    ranges : dict
        By each verified setting: of "stiffness" and "damping", without those that are held, the least and the largest
        value tried that keep to the tolerances, with nearly all between, where the other number stays.
    """

    def __init__(self, trials: RangeTrials, limits: Limits, tolerance: float):
        self.trials, self.limits, self.tolerance = trials, limits, tolerance
        self.ranges: dict[NewmarkSetting, dict[str, tuple[float, float]]] = {}
        self._known: dict[NewmarkSetting, bool] = {}
        self.free = [name for name in ("stiffness", "damping") if getattr(limits, name) is None]

    def verified(self, steps: int, starts: Callable[[int], list[NewmarkSetting]], verify) -> Iterator[Trial]:
        """Yield verified middles, from the least number of steps that seems to meet the tolerances on.

        Parameters
        ----------
        steps : int
        starts : callable
            Gives the settings with so many steps from which a middle is looked for.
        verify : callable
            :meth:`.trials.Trials.verify` of the question as it is.
        """
        edges: list[Trial] = []  # by runs from rest
        for n in spare_steps(steps, self.limits.steps_max):
            for found in dict.fromkeys(map(self.find, starts(n))):
                if found is None or not (trial := verify(found)).meets(self.tolerance):
                    continue
                self.ranges[found] = {name: self._confirmed(found, name) for name in self.free}
                if self._is_inside(found, self.ranges[found]):
                    yield trial
                else:
                    edges.append(trial)
        yield from edges

    def find(self, setting: NewmarkSetting) -> NewmarkSetting | None:
        """Return the middle with the steps of a setting; None if one of its ranges has no middle."""
        if not self._all_meet([setting])[0]:
            return None
        for name in self.free:
            middle = _few_digits(*self._range(setting, name))
            setting = setting if middle is None else setting._replace(**{name: middle})
        ranges = {name: self._range(setting, name) for name in self.free}
        return setting if self._is_inside(setting, ranges) else None

    def _is_inside(self, setting: NewmarkSetting, ranges: dict[str, tuple[float, float]]) -> bool:
        return all(self._has_room(name, getattr(setting, name), *ends) for name, ends in ranges.items())

    def _confirmed(self, setting: NewmarkSetting, name: str) -> tuple[float, float]:
        """Return the range of one number in which runs from rest keep to the tolerances, of more points than before.

        Short runs choose; where a step scatters the motion, a run from rest may have another peak force. A few points
        may miss, as neighbours may.
        """
        own, ends = getattr(setting, name), self._range(setting, name)
        found = []
        for end in ends:
            count = math.ceil(abs(math.log(end / own)) / math.log(RANGE_STRIDE) * CONFIRMED_PER_STRIDE)
            points = [own * (end / own) ** (i / count) for i in range(1, count + 1)]
            holds = self.trials.all_hold([setting._replace(**{name: point}) for point in points])
            misses = np.cumsum(np.logical_not(holds))
            kept = [p for i, p in enumerate(points) if holds[i] and misses[i] * RANGE_MISS_IN <= i + 1]
            found.append(kept[-1] if kept else own)
        return tuple(found)

    def _has_room(self, name: str, own: float, low: float, high: float) -> bool:
        """Whether a range leaves room on both sides, but for what a limit takes."""
        least, most = self._bounds(name)
        return (low < own or own / RANGE_STRIDE**2 < least) and (high > own or own * RANGE_STRIDE**2 > most)

    def _range(self, setting: NewmarkSetting, name: str) -> tuple[float, float]:
        """Return how far one number goes down and up; its own value where it does not."""
        own, (least, most) = getattr(setting, name), self._bounds(name)
        before = (
            math.ceil(math.log(own, RANGE_STRIDE)) - 1
        )  # the points are powers, so that they are the same from any start
        down = [RANGE_STRIDE**i for i in range(before, before - POINTS_EACH_SIDE, -1)]
        after = math.floor(math.log(own, RANGE_STRIDE)) + 1
        up = [RANGE_STRIDE**i for i in range(after, after + POINTS_EACH_SIDE)]
        allowed = ([point for point in points if least <= point <= most] for points in (down, up))
        return tuple(self._last_that_meets(setting, name, points) for points in allowed)

    def _last_that_meets(self, setting: NewmarkSetting, name: str, points: list[float]) -> float:
        last = getattr(setting, name)
        for begin in range(0, len(points), POINTS_AT_ONCE):
            some = points[begin : begin + POINTS_AT_ONCE]
            for point, meets in zip(
                some, self._all_meet([setting._replace(**{name: one}) for one in some]), strict=True
            ):
                if not meets:
                    return last
                last = point
        return last

    def _all_meet(self, settings: list[NewmarkSetting]) -> list[bool]:
        new = [setting for setting in settings if setting not in self._known]
        self._known |= dict(zip(new, self.trials.all_meet(new, self.tolerance), strict=True))
        return [self._known[setting] for setting in settings]

    def _bounds(self, name: str) -> tuple[float, float]:
        return (STIFFNESS_RANGE[0], self.limits.stiffness_max) if name == "stiffness" else DAMPING_RANGE


def _few_digits(low: float, high: float) -> float | None:
    """Return a number of few digits in the middle half of a range, on a logarithmic scale; None if there is none."""
    centre, quarter = math.sqrt(low * high), (high / low) ** 0.25
    numbers = (rounded_to(centre, digits) for digits in MIDDLE_DIGITS)
    return next((number for number in numbers if centre / quarter <= number <= centre * quarter), None)


def spare_steps(steps: int, most: int) -> list[int]:
    """Return the numbers of steps of two digits to try, from ``steps`` on."""
    return list(dict.fromkeys(min(most, math.ceil(rounded_up(steps * factor))) for factor in SPARE))
