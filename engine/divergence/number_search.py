"""The search over one number: K or D on a grid, coarse, then finer about the lowest points; the steps by doubling.

A value of K or D is on a grid of ratio FINE. A single run may be close to the reference by chance, since a constant
step makes a section scatter and errors can cancel. So a value counts by the median of the five values within 10 % of
it. What is proposed is the middle of the range where the number works, not the lowest point, which depends on the last
digits of the input.
"""

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from vibroscope.engine.divergence.alone import Change, Curve
from vibroscope.engine.divergence.remaining import Remaining
from vibroscope.engine.divergence.tolerances import WORKS
from vibroscope.engine.methods import STEPS_RANGE, TimeStepping
from vibroscope.engine.wording import rounded_to

FINE = 1.05  # ratio of neighbours on the grid of K and D
COARSE_PLACES = 8  # of its places from one point of the first search to the next: six in a decade
COARSER_PLACES = 12  # where steps are not skipped
NEAR_PLACES = 2  # places on each side that count with a value: within 10 %
STEP_HALVINGS, STEP_DOUBLINGS = 4, 6  # of the steps
STEP_DOUBLINGS_WHOLE = 4  # where steps are not skipped, so that a run takes the longer the more there are


class GridSearch:
    """Search over K or D, or K with what follows from it, on the grid of ratio FINE.

    Parameters
    ----------
    name : str
        What :class:`Change` calls it.
    make : callable
        The method with a value.
    remaining : Remaining
    ends : (float, float)
        Range of the values.
    holds : callable, optional
        Whether a method's contact rebounds as asked and is resolved: of values that work as well such are proposed.
    equal, resolved : float
        Marks of the :class:`Curve`; the first is tried in any case.
    """

    def __init__(self, name, make, remaining, ends, holds=lambda method: True, equal=math.nan, resolved=math.nan):
        self.name, self._make, self._remaining, self._holds = name, make, remaining, holds
        self.equal, self.resolved = equal, resolved
        first, last = math.ceil(math.log(ends[0], FINE)), math.floor(math.log(ends[1], FINE))
        marked = [round(math.log(equal, FINE))] if ends[0] <= equal <= ends[1] else []
        self._stride = COARSE_PLACES if remaining.quick else COARSER_PLACES
        self._coarse = sorted({*range(first, last + 1, self._stride), *marked})
        self._ends, self._marked = (first, last), marked
        self._left: dict[int, float] = {}

    def run_coarse(self) -> None:
        """Run the places of the first search."""
        self._run(self._coarse)

    def curve(self) -> Curve:
        """All that was run by now."""
        places = sorted(self._left)
        values, left = [_value(place) for place in places], [self._left[place] for place in places]
        present = float(self._remaining.method.numbers[self.name])
        return Curve(self.name, present, np.array(values), np.array(left), None, self.equal, self.resolved)

    def best(self) -> Change | None:
        """The value to propose; None if no run reaches its end."""
        lowest = self._lowest()
        if not math.isfinite(self._robust(lowest)):
            return None
        place = self._middle(lowest)
        near = [self._make(_value(each)) for each in self._around(place)]
        measure = self._remaining.whole if self._remaining.quick else self._remaining
        self._remaining.run_ahead(near, whole=self._remaining.quick)
        typical = sorted(near, key=measure)[NEAR_PLACES]
        robust = measure(typical)
        if not math.isfinite(robust):
            return None
        for method in (self._make(rounded_to(_value(place), 2)), self._make(_value(place)), typical):
            left = self._remaining.whole(method)
            if robust / WORKS <= left <= WORKS * robust:  # what is said of it is no luck
                break
        return Change(self.name, left, max(robust, left / WORKS), method) if math.isfinite(left) else None

    def _run(self, places: Iterable[int]) -> None:
        new = {place: self._make(_value(place)) for place in places if place not in self._left}
        self._remaining.run_ahead(new.values())
        self._left |= {place: self._remaining(method) for place, method in new.items()}

    def _robust(self, place: int) -> float:
        around = self._around(place)
        self._run(around)
        return float(np.median([self._left[each] for each in around]))

    def _most_robust(self, places: Iterable[int]) -> int:
        """The place with the least median, the first one of equals."""
        places = list(places)
        self._run(each for place in places for each in self._around(place))
        return min(places, key=self._robust)

    def _around(self, place: int) -> list[int]:
        """The places that count with one, at an end of the range the last one more than once."""
        return [min(max(place + step, self._ends[0]), self._ends[1]) for step in range(-NEAR_PLACES, NEAR_PLACES + 1)]

    def _lowest(self) -> int:
        """The place with the least median: the best of the lowest of the first search, then step by step downhill."""
        rows = [self._left[place] for place in self._coarse]
        low = [place for i, place in enumerate(self._coarse) if rows[i] <= min(rows[max(i - 1, 0) : i + 2])]
        tried = {*sorted(low, key=self._left.__getitem__)[:3], *self._marked}
        lowest = self._most_robust(sorted(tried))
        for step in (self._stride // 2, self._stride // 4, 1):
            around = (lowest, lowest - step, lowest + step)
            lowest = self._most_robust(place for place in around if self._ends[0] <= place <= self._ends[1])
        return lowest

    def _middle(self, lowest: int) -> int:
        """The middle of the range about the lowest place that works as well, and of that where the contact holds."""
        enough, works = WORKS * self._robust(lowest), [lowest]
        for side in ([p for p in self._coarse if p > lowest], [p for p in self._coarse[::-1] if p < lowest]):
            for place in side:
                if not self._left[place] <= enough:
                    break
                works.append(place)
        for good in ([place for place in works if self._holds(self._make(_value(place)))], works):
            middle = (min(good) + max(good)) // 2 if good else lowest
            if good and self._robust(middle) <= enough:
                return middle
        return lowest


class TogetherSearch(GridSearch):
    """Search over K with what follows from it: the softest contact that does, which needs the fewest steps."""

    def search(self, total: float) -> Change | None:
        """The change that leaves a quarter of the difference at most, or else the least; None if all runs end early."""
        self._enough = total / 4.0
        self.run_coarse()
        return self.best()

    def _middle(self, lowest: int) -> int:
        """The softest place that leaves little enough, not at the edge of those."""
        enough = max(WORKS * self._robust(lowest), self._enough)
        for place in self._coarse:
            inside = min(place + self._stride // 2, self._ends[1])
            if self._left[place] <= enough and self._robust(inside) <= enough:
                return inside
        return lowest


class StepSearch:
    """Search over the number of steps, which is halved and doubled, and its limit."""

    def __init__(self, method: TimeStepping, remaining: Remaining, resolved: float) -> None:
        self._method, self._remaining, self._resolved = method, remaining, resolved
        powers = range(-STEP_HALVINGS, (STEP_DOUBLINGS if remaining.skips else STEP_DOUBLINGS_WHOLE) + 1)
        numbers = (round(method.steps * 2.0**power) for power in powers)
        self._steps = [steps for steps in numbers if STEPS_RANGE[0] <= steps <= STEPS_RANGE[1]]
        self._left: dict[int, float] = {}

    def run_coarse(self) -> None:
        """Run all halved and doubled numbers."""
        self._remaining.run_ahead(map(self._with, self._steps))
        for steps in self._steps:
            self._at(steps)

    def curve(self) -> Curve:
        """All that was run by now."""
        steps = sorted(self._left)
        left = [self._left[n] for n in steps]
        return Curve("steps", self._method.steps, np.array(steps, float), np.array(left), None, resolved=self._resolved)

    def best(self) -> Change | None:
        """The limit without a step, or a number of steps that leaves clearly less; None if all end early.

        Fewer steps count only if they resolve a contact: what they leave less is errors that cancel.
        """
        limit = self._remaining.whole(self._method.limit)
        best = Change("steps", limit, limit, self._method.limit)
        for steps in self._steps:
            fewer = steps <= self._method.steps and not steps >= self._resolved
            if steps != self._method.steps and not fewer and self._left[steps] * WORKS < best.robust:
                robust = self._robust(steps)
                change = _confirmed(Change("steps", self._left[steps], robust, self._with(steps)), self._remaining)
                if change is not None and change.robust * WORKS < best.robust:
                    best = change
        return best if math.isfinite(best.robust) else None

    def enough(self, most_left: float) -> Change | None:
        """See :func:`.search.enough_steps`."""
        more = [steps for steps in self._steps if steps > self._method.steps]
        for i, steps in enumerate(more):
            if max(self._at(n) for n in more[i : i + 2]) <= most_left and (robust := self._robust(steps)) <= most_left:
                change = _confirmed(Change("steps", self._at(steps), robust, self._with(steps)), self._remaining)
                if change is not None and change.robust <= most_left:
                    return change
        return None

    def _with(self, steps: int) -> TimeStepping:
        return replace(self._method, steps=steps)

    def _at(self, steps: int) -> float:
        if steps not in self._left:
            self._left[steps] = self._remaining(self._with(steps))
        return self._left[steps]

    def _robust(self, steps: int) -> float:
        near = {round(steps * FINE**step) for step in range(-NEAR_PLACES, NEAR_PLACES + 1)}
        around = [min(max(n, STEPS_RANGE[0]), STEPS_RANGE[1]) for n in sorted(near)]
        self._remaining.run_ahead(map(self._with, around))
        return float(np.median([self._at(n) for n in around]))


def _value(place: int) -> float:
    """The value at a place of the grid, in digits that a user can repeat."""
    return rounded_to(FINE**place, 3)


def _confirmed(change: Change | None, remaining: Remaining) -> Change | None:
    """The change with what is left after all periods; None if that run ends early."""
    if change is None:
        return None
    left = remaining.whole(change.method)
    robust = change.robust if left <= WORKS * change.robust else left
    return replace(change, left=left, robust=robust) if math.isfinite(left) else None
