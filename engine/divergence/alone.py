"""The difference over K, D and the time step, each alone, everything else as it is, and what each leaves at best.

A value of K or D is on a grid of ratio FINE, coarse first, then finer about the lowest points. A single run may be
close to the reference by chance, since a constant step makes a section scatter and errors can cancel. So a value counts
by the median of the five values within 10 % of it. What is proposed is the middle of the range where the number works,
not the lowest point, which depends on the last digits of the input.

A curve marks the value of equal restitution, D_e(K) or K_e(D) (:mod:`.conditions`), and the largest K, or the least
number of steps, with RESOLVED steps in a contact. Steps are halved and doubled; their limit is the solution without a
step. The choices that codes differ in are changed alone, too: the contact status, the integrator, and a law without the
damper's jump at touch.

Where no number alone does, two and three are changed together: K with D at equal restitution, and both with a step that
resolves the contact.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from ..integrators import NewmarkBeta
from ..law_table import LAWS
from ..methods import (
    DAMPING_RANGE,
    METHOD_NUMBERS,
    STEPS_RANGE,
    STIFFNESS_RANGE,
    ExactPenalty,
    Newmark,
    TimeStepping,
    integrator_name,
    is_located,
    skips_steps,
    spring_exponent,
    status_of,
)
from ..wording import finite_or_none
from .compare import Comparison
from .conditions import RESOLVED, conditions, equal_damping, equal_stiffness, with_equal_damping
from .encounters import mean_closing_speed
from .remaining import Remaining
from .time_step import with_located_steps

FINE = 1.05  # ratio of neighbours on the grid of K and D
COARSE = 8  # of its places from one point of the first search to the next: six in a decade
COARSER = 12  # where steps are not skipped
NEAR = 2  # places on each side that count with a value: within 10 %
STIFFNESS_DECADES = 6  # of K above the stiffer of both springs
DAMPING_DECADES = 3  # of D on each side of equal restitution
HALVINGS, DOUBLINGS = 4, 6  # of the steps
DOUBLINGS_WHOLE = 4  # where steps are not skipped, so that a run takes the longer the more there are
WORKS = 1.25  # times the least: a value that leaves no more works as well
MOST_STEPS = 64  # times as many steps as the penalty solution has are tried at most
AMPLE = 5 * RESOLVED  # steps in a contact where K, D and the step are changed together
WITHOUT_JUMP = "limited"  # the law of the same spring and damper without the damper's jump


@dataclass(frozen=True)
class Change:
    """A changed number or choice, or several, and what it leaves.

    Attributes
    ----------
    changed : str
        "K", "D", "steps", "status", "integrator", "law", "joint damping"; "K and D", "K, D and the step" for several.
    left : float
        What the run with exactly this change leaves of the difference, relative to the reference.
    robust : float
        The median of what values within 10 % leave, by which the change counts; ``left`` for a choice.
    method : Newmark, TimeStepping, ExactPenalty or None
        What was run: the exact penalty solution stands for no time step, None for no joint damping of its own.
    """

    changed: str
    left: float
    robust: float
    method: Newmark | TimeStepping | ExactPenalty | None = None

    @property
    def value(self) -> float:
        """The changed number; inf steps for no time step, nan for a choice or several numbers."""
        if self.changed == "steps" and isinstance(self.method, ExactPenalty):
            return math.inf
        name = METHOD_NUMBERS.get(self.changed)
        return float(getattr(self.method, name)) if name else math.nan


@dataclass(frozen=True)
class Curve:
    """What is left of the difference over one number alone.

    Attributes
    ----------
    name : {"K", "D", "steps"}
    present : float
        The present value.
    values, left : (n,) ndarray
        Ascending values, and what each leaves; inf where the run ends early.
    best : Change or None
        What it leaves at best; None as long as it is not known, and if no run reaches its end.
    equal : float
        The value of equal restitution; nan for the steps, and where there is none.
    resolved : float
        Largest K, or least number of steps, with RESOLVED steps in a contact; nan for D, and where it is not known.
    """

    name: str
    present: float
    values: np.ndarray = field(repr=False)
    left: np.ndarray = field(repr=False)
    best: Change | None = None
    equal: float = math.nan
    resolved: float = math.nan


@dataclass(frozen=True)
class Alone:
    """The search over each number alone.

    Attributes
    ----------
    total : float
        The difference as it is.
    floor : float
        What neither K nor D nor the step mends: the part of the joint damping, 0 if there is none.
    curves : dict of str to Curve
        Of "K", of "D" unless the law takes it from the restitution, and of "steps".
    choices : tuple of Change
        Status, integrator and law, each changed alone, and no joint damping of its own for the reference.
    done : bool
        Whether all of them are known.
    """

    total: float
    floor: float
    curves: dict[str, Curve]
    choices: tuple[Change, ...] = ()
    done: bool = False

    @property
    def changes(self) -> list[Change]:
        """The best change of each number, and the choices, the one that leaves least first; none that ends early."""
        best = [curve.best for curve in self.curves.values() if curve.best is not None]
        known = [each for each in (*best, *self.choices) if math.isfinite(each.robust)]
        return sorted(known, key=lambda each: each.robust)

    def as_dict(self) -> dict:
        """Return plain numbers and lists for scripts; None for what is not known or ends early."""
        return {
            "total": self.total,
            "floor": self.floor,
            "curves": {name: _plain_curve(curve) for name, curve in self.curves.items()},
            "choices": [_plain_change(each) for each in self.choices],
        }


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
        curves[name] = replace(search.curve(), best=search.best())
        progress(Alone(total, floor, dict(curves)))
    return Alone(total, floor, curves, tuple(_choices(comparison, remaining)), done=True)


def search_pair(comparison: Comparison, remaining: Remaining) -> Change | None:
    """Change K with D at equal restitution; None where the law takes its damper from the restitution."""
    method, system = comparison.runs.penalty.method, comparison.runs.penalty.system
    speed = mean_closing_speed(comparison.runs.reference)
    if method.damping is None:
        return None

    def make(stiffness: float) -> Newmark | TimeStepping:
        return with_equal_damping(system, method, stiffness, speed)

    return _TogetherSearch("K and D", make, remaining, stiffness_ends(comparison)).search(comparison.difference.total)


def search_all_three(comparison: Comparison, remaining: Remaining) -> Change | None:
    """Change K with D at equal restitution, and with a step that takes AMPLE steps in a contact."""
    run, speed = comparison.runs.penalty, mean_closing_speed(comparison.runs.reference)
    if run.method.damping is None:
        return None

    def make(stiffness: float) -> Newmark | TimeStepping:
        fitting = with_equal_damping(run.system, run.method, stiffness, speed)
        steps = conditions(run.system, run.eta, fitting, speed).steps
        enough = fitting.steps * AMPLE / steps if steps > 0 else math.inf
        most = min(MOST_STEPS * fitting.steps, STEPS_RANGE[1])
        return replace(fitting, steps=_rounded_up(min(max(fitting.steps, enough), most)))

    search = _TogetherSearch("K, D and the step", make, remaining, stiffness_ends(comparison))
    found = search.search(comparison.difference.total)
    return found and (replace(found, changed="K and D") if found.method.steps == run.method.steps else found)


def joint_damping_part(comparison: Comparison) -> float:
    """The part of the joint damping, which neither K nor D nor the step has; 0 if there is none, or it is not known."""
    return comparison.difference.parts.get("joint_damping", 0.0)


def enough_steps(comparison: Comparison, remaining: Remaining, most_left: float) -> Change | None:
    """The least doubled number of steps with which, and with twice as many, no more is left; None if there is none."""
    search = _StepSearch(comparison.runs.penalty.method, remaining, math.nan)
    return search.enough(most_left)


def stiffness_ends(comparison: Comparison) -> tuple[float, float]:
    """The range of K that is searched: from the stiffer spring of the bodies on, and about the present one."""
    system, present = comparison.runs.penalty.system, comparison.runs.penalty.method.stiffness
    soft = system.stiffer_spring
    ends = min(soft, present / 10.0), max(soft * 10.0**STIFFNESS_DECADES, present * 10.0)
    return max(ends[0], STIFFNESS_RANGE[0]), min(ends[1], STIFFNESS_RANGE[1])


def _confirmed(change: Change | None, remaining: Remaining) -> Change | None:
    """The change with what is left after all periods; None if that run ends early."""
    if change is None:
        return None
    left = remaining.whole(change.method)
    robust = change.robust if left <= WORKS * change.robust else left
    return replace(change, left=left, robust=robust) if math.isfinite(left) else None


def _rounded_up(steps: float) -> int:
    """A number of steps in two digits, no less; whole numbers up to a hundred."""
    digit = 10 ** max(0, math.floor(math.log10(steps)) - 1)
    return math.ceil(steps / digit) * digit


# --- the three numbers ------------------------------------------------------------------------------------------------


def _searches(comparison: Comparison, remaining: Remaining) -> dict[str, "_GridSearch | _StepSearch"]:
    run = comparison.runs.penalty
    system, method, speed = run.system, run.method, mean_closing_speed(comparison.runs.reference)

    def holds(changed: Newmark | TimeStepping) -> bool:
        return conditions(system, run.eta, changed, speed).hold

    equal = equal_stiffness(system, method, speed)
    steps = conditions(system, run.eta, method, speed).steps
    # a contact of the force Kδⁿ lasts as K^(-1/(n + 1))
    resolved = (
        math.nan if is_located(method) else method.stiffness * (steps / RESOLVED) ** (spring_exponent(method) + 1)
    )
    searches: dict[str, _GridSearch | _StepSearch] = {
        "K": _GridSearch(
            "K", lambda k: replace(method, stiffness=k), remaining, stiffness_ends(comparison), holds, equal, resolved
        )
    }
    if method.damping is not None:
        equal = equal_damping(system, method, speed)
        middle = equal if equal > 0 else math.sqrt(method.stiffness * system.mass_share)
        ends = [middle * 10.0**power for power in (-DAMPING_DECADES, DAMPING_DECADES)]
        if method.damping > 0:
            ends = min(ends[0], method.damping), max(ends[1], method.damping)
        ends = max(ends[0], 1e-9), min(ends[1], DAMPING_RANGE[1])
        searches["D"] = _GridSearch("D", lambda d: replace(method, damping=d), remaining, ends, holds, equal)
    least = math.nan if is_located(method) else method.steps * RESOLVED / steps
    return searches | {"steps": _StepSearch(method, remaining, least)}


class _GridSearch:
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
        self._stride = COARSE if remaining.quick else COARSER
        self._coarse = sorted({*range(first, last + 1, self._stride), *marked})
        self._ends, self._marked = (first, last), marked
        self._left: dict[int, float] = {}

    def run_coarse(self) -> None:
        """Run the places of the first search."""
        for place in self._coarse:
            self._at(place)

    def curve(self) -> Curve:
        """All that was run by now."""
        places = sorted(self._left)
        values, left = [_value(place) for place in places], [self._left[place] for place in places]
        present = float(getattr(self._remaining.method, METHOD_NUMBERS[self.name]))
        return Curve(self.name, present, np.array(values), np.array(left), None, self.equal, self.resolved)

    def best(self) -> Change | None:
        """The value to propose; None if no run reaches its end."""
        lowest = self._lowest()
        if not math.isfinite(self._robust(lowest)):
            return None
        place = self._middle(lowest)
        near = [self._make(_value(each)) for each in self._around(place)]
        measure = self._remaining.whole if self._remaining.quick else self._remaining
        typical = sorted(near, key=measure)[NEAR]
        robust = measure(typical)
        if not math.isfinite(robust):
            return None
        for method in (self._make(rounded_to(_value(place), 2)), self._make(_value(place)), typical):
            left = self._remaining.whole(method)
            if robust / WORKS <= left <= WORKS * robust:  # what is said of it is no luck
                break
        return Change(self.name, left, max(robust, left / WORKS), method) if math.isfinite(left) else None

    def _at(self, place: int) -> float:
        if place not in self._left:
            self._left[place] = self._remaining(self._make(_value(place)))
        return self._left[place]

    def _robust(self, place: int) -> float:
        return float(np.median([self._at(each) for each in self._around(place)]))

    def _around(self, place: int) -> list[int]:
        """The places that count with one, at an end of the range the last one more than once."""
        return [min(max(place + step, self._ends[0]), self._ends[1]) for step in range(-NEAR, NEAR + 1)]

    def _lowest(self) -> int:
        """The place with the least median: the best of the lowest of the first search, then step by step downhill."""
        rows = [self._left[place] for place in self._coarse]
        low = [place for i, place in enumerate(self._coarse) if rows[i] <= min(rows[max(i - 1, 0) : i + 2])]
        tried = {*sorted(low, key=self._left.__getitem__)[:3], *self._marked}
        lowest = min(sorted(tried), key=self._robust)
        for step in (self._stride // 2, self._stride // 4, 1):
            around = (lowest, lowest - step, lowest + step)
            lowest = min((place for place in around if self._ends[0] <= place <= self._ends[1]), key=self._robust)
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


class _TogetherSearch(_GridSearch):
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


class _StepSearch:
    """Search over the number of steps, which is halved and doubled, and its limit."""

    def __init__(self, method: Newmark | TimeStepping, remaining: Remaining, resolved: float) -> None:
        self._method, self._remaining, self._resolved = method, remaining, resolved
        powers = range(-HALVINGS, (DOUBLINGS if skips_steps(method) else DOUBLINGS_WHOLE) + 1)
        numbers = (round(method.steps * 2.0**power) for power in powers)
        self._steps = [steps for steps in numbers if STEPS_RANGE[0] <= steps <= STEPS_RANGE[1]]
        self._left: dict[int, float] = {}

    def run_coarse(self) -> None:
        """Run all halved and doubled numbers."""
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
        """See :func:`enough_steps`."""
        more = [steps for steps in self._steps if steps > self._method.steps]
        for i, steps in enumerate(more):
            if max(self._at(n) for n in more[i : i + 2]) <= most_left and (robust := self._robust(steps)) <= most_left:
                change = _confirmed(Change("steps", self._at(steps), robust, self._with(steps)), self._remaining)
                if change is not None and change.robust <= most_left:
                    return change
        return None

    def _with(self, steps: int) -> Newmark | TimeStepping:
        return replace(self._method, steps=steps)

    def _at(self, steps: int) -> float:
        if steps not in self._left:
            self._left[steps] = self._remaining(self._with(steps))
        return self._left[steps]

    def _robust(self, steps: int) -> float:
        around = {round(steps * FINE**step) for step in range(-NEAR, NEAR + 1)}
        return float(np.median([self._at(min(max(n, STEPS_RANGE[0]), STEPS_RANGE[1])) for n in sorted(around)]))


def _value(place: int) -> float:
    """The value at a place of the grid, in digits that a user can repeat."""
    return rounded_to(FINE**place, 3)


def rounded_to(value: float, digits: int) -> float:
    """Round to so many significant digits."""
    return float(f"{value:.{digits}g}")


# --- choices ----------------------------------------------------------------------------------------------------------


def changed_choices(method: Newmark | TimeStepping) -> Iterator[tuple[str, Newmark | TimeStepping]]:
    """Yield the name of a choice that codes differ in, and the method with this choice changed."""
    own = _as_time_stepping(method)
    if not is_located(method):
        yield "status", with_located_steps(method)
        if not own.integrator.explicit:
            yield "status", replace(own, status="start" if own.status == "end" else "end")
    if own.integrator != NewmarkBeta():
        yield "integrator", replace(own, integrator=NewmarkBeta())
    if (smooth := without_jump(method)) is not None:
        yield "law", smooth


def without_jump(method: Newmark | TimeStepping) -> TimeStepping | None:
    """Return a method with a contact law whose damper does not jump where the bodies touch; None if there is none."""
    if is_located(method) or not LAWS[method.law].jumps or not method.damping:
        return None
    return replace(_as_time_stepping(method), law=WITHOUT_JUMP)


def _as_time_stepping(method: Newmark | TimeStepping) -> TimeStepping:
    """Return the method itself, or the same steps as Newmark's under the name that has all choices."""
    if isinstance(method, TimeStepping):
        return method
    return TimeStepping(method.stiffness, method.damping, method.steps, law=method.law, every_step=method.every_step)


def _choices(comparison: Comparison, remaining: Remaining) -> Iterator[Change]:
    for name, method in changed_choices(comparison.runs.penalty.method):
        left = remaining.whole(method)
        beside = (min(max(method.stiffness * FINE**step, STIFFNESS_RANGE[0]), STIFFNESS_RANGE[1]) for step in (-1, 1))
        around = [remaining(replace(method, stiffness=stiffness)) for stiffness in beside]
        if math.isfinite(left):
            yield Change(name, left, float(np.median([left, *around])), method)
    if "joint_damping" in comparison.part_names:
        left = remaining.without_joint_damping()
        yield Change("joint damping", left, left)


# --- for scripts ------------------------------------------------------------------------------------------------------


def _plain_curve(curve: Curve) -> dict:
    return {
        "present": curve.present,
        "values": curve.values.tolist(),
        "left": [finite_or_none(value) for value in curve.left.tolist()],
        "best": curve.best and _plain_change(curve.best),
        "equal_restitution": finite_or_none(curve.equal),
        "resolved": finite_or_none(curve.resolved),
    }


def _plain_change(change: Change) -> dict:
    method = change.method
    numbers = {} if method is None else {"K": method.stiffness, "D": method.damping}
    if method is not None and not isinstance(method, ExactPenalty):
        numbers |= {"steps": method.steps, "status": status_of(method), "integrator": integrator_name(method)}
    left, robust = finite_or_none(change.left), finite_or_none(change.robust)
    law = {} if method is None else {"law": method.law}
    return {"changed": change.changed, "left": left, "median_of_neighbours": robust, **numbers, **law}
