"""The search over K, D and the time step, each alone, everything else as it is, and over the choices.

A curve marks the value of equal restitution, D_e(K) or K_e(D) (:mod:`.conditions`), and the largest K, or the least
number of steps, with RESOLVED steps in a contact. Steps are halved and doubled; their limit is the solution without a
step. The choices that codes differ in are changed alone, too: the contact status, the integrator, and a law without the
damper's jump at touch.

Where no number alone does, two and three are changed together: K with D at equal restitution, and both with a step that
resolves the contact.

The search over one number: K or D on a grid, coarse, then finer about the lowest points; the steps by doubling.

A value of K or D is on a grid of ratio FINE. A single run may be close to the reference by chance, since a constant
step makes a section scatter and errors can cancel. So a value counts by the median of itself and NEAR_PLACES values on
each side. What is proposed is the middle of the range where the number works, not the lowest point, which depends on
the last digits of the input.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import numpy as np
from vibroscope.engine.contact import damping_for, equal_damping, equal_stiffness, ratio_of_method
from vibroscope.engine.divergence.alone import Alone, Change, Curve
from vibroscope.engine.divergence.compare import Comparison
from vibroscope.engine.divergence.conditions import conditions, with_equal_damping
from vibroscope.engine.divergence.remaining import Remaining
from vibroscope.engine.divergence.tolerances import AMPLE, LEAST_IN_CONTACT, LESS, RESOLVED, WORKS
from vibroscope.engine.integrators import NewmarkBeta
from vibroscope.engine.law_table import LAWS
from vibroscope.engine.methods import STEPS_RANGE, TimeStepping, contact_ranges, with_located_steps
from vibroscope.engine.model import System
from vibroscope.engine.wording import percent, rounded_to, rounded_up

FINE = 1.05  # ratio of neighbours on the grid of K and D
COARSE_PLACES = 8  # of its places from one point of the first search to the next: six in a decade
COARSER_PLACES = 12  # where steps are not skipped
NEAR_PLACES = 2  # places on each side that count with a value
NEIGHBOURS = f"those within {percent(FINE**NEAR_PLACES - 1.0)}"  # of it, as all texts say it
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


STIFFNESS_DECADES = 6  # of K above the stiffer of both springs
DAMPING_DECADES = 3  # of D on each side of equal restitution
MOST_TIMES_THE_STEPS = 64  # times as many steps as the penalty solution has are tried at most


def search_alone(
    comparison: Comparison, remaining: Remaining, progress: Callable[[Alone], None] = lambda found: None
) -> Alone:
    """Change every number alone.

    Parameters
    ----------
    comparison : Comparison
        With ``parts``.
    remaining : Remaining
        Makes the runs; may raise `Cancelled`.
    progress : callable, optional
        Called with the coarse curves, one more each time, and with each curve whose lowest point is known.
    """
    total, floor = comparison.difference.total, joint_damping_part(comparison)
    searches, curves = _searches(comparison, remaining), {}
    for name, search in searches.items():
        search.run_coarse()
        curves[name] = search.curve()
        progress(Alone(total, floor, dict(curves)))
    for name, search in searches.items():
        best = search.best()
        curves[name] = replace(search.curve(), best=best if best and best.left < LESS * total else None)
        progress(Alone(total, floor, dict(curves)))
    return Alone(total, floor, curves, tuple(_choices(comparison, remaining)), done=True)


def search_together(comparison: Comparison, remaining: Remaining, with_step: bool = False) -> Change | None:
    """Change K with D at equal restitution, and ``with_step`` with a step that takes AMPLE steps in a contact.

    None where the law takes its damper from the restitution.
    """
    run, speed = comparison.runs.penalty, comparison.closing_speed
    if run.method.damping is None:
        return None

    def make(stiffness: float) -> TimeStepping:
        fitting = with_equal_damping(run.system, run.method, stiffness, speed)
        if not with_step:
            return fitting
        steps = conditions(run.system, run.eta, fitting, speed).steps
        enough = fitting.steps * AMPLE / steps if steps > 0 else math.inf
        most = min(MOST_TIMES_THE_STEPS * fitting.steps, STEPS_RANGE[1])
        return replace(fitting, steps=math.ceil(rounded_up(min(max(fitting.steps, enough), most))))

    name = "K, D and the step" if with_step else "K and D"
    search = TogetherSearch(name, make, remaining, stiffness_ends(comparison))
    found = search.search(comparison.difference.total)
    return found and (replace(found, changed="K and D") if found.method.steps == run.method.steps else found)


def joint_damping_part(comparison: Comparison) -> float:
    """The part of the joint damping, which neither K nor D nor the step has; 0 if there is none, or it is not known."""
    return comparison.difference.parts.get("joint_damping", 0.0)


def enough_steps(comparison: Comparison, remaining: Remaining, most_left: float) -> Change | None:
    """The least doubled number of steps with which, and with twice as many, no more is left; None if there is none."""
    search = StepSearch(comparison.runs.penalty.method, remaining, math.nan)
    return search.enough(most_left)


def stiffness_ends(comparison: Comparison) -> tuple[float, float]:
    """The range of K that is searched: from the stiffer spring of the bodies on, and about the present one.

    Between two stops no contact is shorter than LEAST_IN_CONTACT steps: one of a step or two gains energy without a
    bound, since the play never grows, and crosses it at every step.
    """
    run, speed = comparison.runs.penalty, comparison.closing_speed
    system, present = run.system, run.method.stiffness
    soft = system.stiffer_spring
    ends = min(soft, present / 10.0), max(soft * 10.0**STIFFNESS_DECADES, present * 10.0)
    if system.two_stops and not run.method.located:
        steps = conditions(system, run.eta, run.method, speed).steps
        ends = ends[0], min(ends[1], max(present, _stiffness_with(LEAST_IN_CONTACT, system, run.method, steps)))
    least, most = contact_ranges(run.method.law)[0]
    return max(ends[0], least), min(ends[1], most)


def _searches(comparison: Comparison, remaining: Remaining) -> dict[str, "GridSearch | StepSearch"]:
    run = comparison.runs.penalty
    system, method, speed = run.system, run.method, comparison.closing_speed

    def holds(changed: TimeStepping) -> bool:
        return conditions(system, run.eta, changed, speed).hold

    equal = equal_stiffness(system, method, speed)
    steps = conditions(system, run.eta, method, speed).steps
    resolved = math.nan if method.located else _stiffness_with(RESOLVED, system, method, steps)
    searches: dict[str, GridSearch | StepSearch] = {
        "K": GridSearch(
            "K", lambda k: replace(method, stiffness=k), remaining, stiffness_ends(comparison), holds, equal, resolved
        )
    }
    if method.damping is not None:
        equal = equal_damping(system, method, method.stiffness, speed)
        middle = equal if equal > 0 else damping_for(system, method.stiffness, 1.0)
        ends = [middle * 10.0**power for power in (-DAMPING_DECADES, DAMPING_DECADES)]
        if method.damping > 0:
            ends = min(ends[0], method.damping), max(ends[1], method.damping)
        ends = max(ends[0], 1e-9), min(ends[1], contact_ranges(method.law)[1][1])
        searches["D"] = GridSearch("D", lambda d: replace(method, damping=d), remaining, ends, holds, equal)
    least = math.nan if method.located else method.steps * RESOLVED / steps
    return searches | {"steps": StepSearch(method, remaining, least)}


def _stiffness_with(wanted: float, system: System, method: TimeStepping, steps: float) -> float:
    """The K with as many steps in a contact as are wanted, where the present one has ``steps``.

    A contact of the force Kδⁿ lasts as K^(-1/(n + 1)), a damped one of a linear spring as (K - D²/m)^(-1/2).
    """
    ratio = ratio_of_method(system.mass_share, method)
    damped = method.stiffness * ratio**2 if method.spring_exponent == 1.0 and ratio < 1.0 else 0.0
    return damped + (method.stiffness - damped) * (steps / wanted) ** (method.spring_exponent + 1.0)


# --- choices ----------------------------------------------------------------------------------------------------------


def changed_choices(method: TimeStepping) -> Iterator[tuple[str, TimeStepping]]:
    """Yield the name of a choice that codes differ in, and the method with this choice changed."""
    if not method.located:
        yield "status", with_located_steps(method)
        if not method.integrator.explicit:
            yield "status", replace(method, status="start" if method.status == "end" else "end")
    if method.integrator != NewmarkBeta():
        yield "integrator", replace(method, integrator=NewmarkBeta())
    if (smooth := without_jump(method)) is not None:
        yield "law", smooth


def without_jump(method: TimeStepping) -> TimeStepping | None:
    """Return a method with a contact law whose damper does not jump where the bodies touch; None if there is none."""
    law = LAWS[method.law].without_jump
    if method.located or not law or not method.damping:
        return None
    return replace(method, law=law)


def _choices(comparison: Comparison, remaining: Remaining) -> Iterator[Change]:
    changed = list(changed_choices(comparison.runs.penalty.method))
    remaining.run_ahead((method for _, method in changed), whole=True)
    remaining.run_ahead(each for _, method in changed for each in _beside(method))
    for name, method in changed:
        left, around = remaining.whole(method), [remaining(each) for each in _beside(method)]
        if math.isfinite(left):
            yield Change(name, left, float(np.median([left, *around])), method)
    if "joint_damping" in comparison.part_names:
        left = remaining.without_joint_damping()
        yield Change("joint damping", left, left)


def _beside(method: TimeStepping) -> list[TimeStepping]:
    """The method with neighbours of its K."""
    least, most = contact_ranges(method.law)[0]
    beside = (min(max(method.stiffness * FINE**step, least), most) for step in (-1, 1))
    return [replace(method, stiffness=stiffness) for stiffness in beside]
