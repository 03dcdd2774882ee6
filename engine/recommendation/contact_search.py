"""Search for the best K and D at a given number of steps per period n.

For each n there is a best K: a softer contact lasts too long, and the steps miss a larger fraction of a stiffer one.
Formulas say where to look. A contact should take 1.5 to a hundred steps (:func:`..contact.stiffness_for`), and D should
be near that of equal restitution, D = ζ(e)√(Kμ/(1 + μ)), or what another contact law needs for that at the mean closing
speed of the reference. Less and more damping is tried too, since it can compensate in part for what the model lacks.
The best settings of this grid are judged with their neighbours (:mod:`.trials`), and the best of these is improved by
ever smaller moves in log K and log D.

Located steps resolve any contact. Then n does not bound K, and the grid covers all K.

Of all that were tried the front of error against cost is kept: settings that no other setting beats in both (Pareto).

The cheapest setting that a search finds lies at the edge of what works, and which edge point it finds is a matter of
chance. So K and D are moved, one after the other, to the middle of the range in which each alone keeps to the
tolerances, and rounded to as few digits as leave them there. Where there is no room on both sides, more steps make
some.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
from vibroscope.engine.contact import damping_for, damping_ratio, equal_damping, stiffness_for
from vibroscope.engine.law_table import RATIO_LAWS, ratio_of_restitution
from vibroscope.engine.methods import DAMPING_RANGE, STIFFNESS_RANGE
from vibroscope.engine.model import System
from vibroscope.engine.recommendation.question import Limits
from vibroscope.engine.recommendation.tolerances import WELL
from vibroscope.engine.recommendation.trials import NEIGHBOURS, NewmarkSetting, RangeTrials, Trial
from vibroscope.engine.wording import rounded_to, rounded_up

RANGE_STRIDE = 1.05  # from point to point of a range, a factor
CONFIRMED_PER_STRIDE, RANGE_MISS_IN = 6, 20  # points to a stride that confirm a range; one in so many of them may miss
POINTS_EACH_SIDE = 10  # points on each side: a factor of 1.6
POINTS_AT_ONCE = 4  # points that are tried side by side
SPARE = (1.0, 1.1, 1.2, 1.35, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0)  # times the least number of steps
MIDDLE_DIGITS = (2, 3)  # of K and D
CONTACT_STEPS = (1.5, 100.0)  # steps in a contact that are worth a trial
FORCE_STEPS = 0.8  # the least of them for a tolerance of the peak force, times that: a strong damper makes up for few
SOFTEST = 10.0  # K that is worth a trial
RATIO, LOCATED_RATIO = 2.0, 4.0  # between neighbouring K of the grid
DAMPING_FACTORS = (0.2, 0.4, 0.7, 0.85, 1.0, 1.15, 1.4, 2.5)  # ζ of the grid, in units of ζ(e)
LEAST_DAMPING = 0.01  # the unit, if e is so near to 1 that ζ(e) is less
LIKELY, FEW_NEIGHBOURS = 16, 2  # settings of the grid that are tried with a few of their neighbours, and how few …
JUDGED = 6  # … and settings that are judged with all of them
CONTACTS_AT_ONCE = 4  # settings whose contacts are looked at side by side
MOVES = ((1.4, 1.12), (1.15, 1.05))  # factors of K and D, round by round


def pareto_front(trials: Iterable[Trial]) -> list[Trial]:
    """Return the trials that no other trial beats in both cost and robust error, cheapest first."""
    front: list[Trial] = []
    for trial in sorted(trials, key=lambda trial: (trial.cost, trial.robust)):
        if not front or trial.robust < front[-1].robust:
            front.append(trial)
    return front


def monotone_front(front: list[Trial], through: Trial) -> list[Trial]:
    """Return the longest part of a front through a trial along which n rises and the own error falls.

    ``through`` takes the place of a trial of the front with the same cost. A trial that is left out had a small own
    error by chance, or cheaper steps (if they are located) but more of them.
    """
    before = [trial for trial in front if trial.cost < through.cost and _follows(trial, through)]
    after = [trial for trial in front if trial.cost > through.cost and _follows(through, trial)]
    return [*_longest_chain(before), through, *_longest_chain(after)]


def _longest_chain(front: list[Trial]) -> list[Trial]:
    """Return the longest chain in which each trial follows the one before; of several, one that ends early."""
    chains: list[list[Trial]] = []  # the longest chain that ends with each trial
    for trial in front:
        earlier = (chain for chain in chains if _follows(chain[-1], trial))
        chains.append([*max(earlier, key=len, default=[]), trial])
    return max(chains, key=len, default=[])


def _follows(one: Trial, other: Trial) -> bool:
    """Whether the other trial has more steps and a smaller own error."""
    return other.setting.steps > one.setting.steps and other.error < one.error


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
        here = math.log(own, RANGE_STRIDE)  # the points are powers, so that they are the same from any start
        before, after = math.ceil(here) - 1, math.floor(here) + 1
        powers = range(before, before - POINTS_EACH_SIDE, -1), range(after, after + POINTS_EACH_SIDE)
        allowed = ([RANGE_STRIDE**i for i in side if least <= RANGE_STRIDE**i <= most] for side in powers)
        return tuple(self._last_that_meets(setting, name, points) for points in allowed)

    def _last_that_meets(self, setting: NewmarkSetting, name: str, points: list[float]) -> float:
        last = getattr(setting, name)
        for begin in range(0, len(points), POINTS_AT_ONCE):
            some = points[begin : begin + POINTS_AT_ONCE]
            tried = self._all_meet([setting._replace(**{name: point}) for point in some])
            for point, meets in zip(some, tried, strict=True):
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


@dataclass
class ContactSearch:
    """Search for K and D for one system and η, or for several η; it remembers what it has judged.

    Of two settings that meet the tolerance the cheaper one is better; otherwise the one with the smaller error.

    Attributes
    ----------
    judged : list of Trial
        Settings that were judged with all their neighbours.
    """

    trials: RangeTrials
    system: System
    limits: Limits
    tolerance: float
    force_tolerance: float | None = None
    judged: list[Trial] = field(default_factory=list)
    _best: dict[int, Trial] = field(default_factory=dict)
    _equal: dict[float, float] = field(default_factory=dict)

    @property
    def best(self) -> list[Trial]:
        """The best setting found with each number of steps."""
        return list(self._best.values())

    def best_with(self, steps: int, cost: float = math.inf) -> Trial | None:
        """Return the best setting found with so many steps; None if all diverge.

        Settings of the grid that cost more than ``cost`` are skipped.
        """
        best = self._judge(self._from_other_steps(steps), None)
        grid = [trial for trial in self.trials.screen(self._grid(steps)) if trial.cost <= cost]
        grid = self.trials.screen(_first(LIKELY, grid, self._by_error), FEW_NEIGHBOURS)
        grid = self._with_contacts(grid, enough=JUDGED)
        best = self._judge(_first(JUDGED, grid, self.by_robust_error), best)
        for factors in MOVES:
            if best is not None:
                best = self._judge(self._around(best.setting, *factors), best)
        if best is not None:
            self._best[steps] = best
        return best

    def is_worth(self, steps: int) -> bool:
        """Whether so many steps resolve a contact that is worth a trial."""
        return self.limits.stiffness is not None or self.trials.located or self._ends(steps)[1] >= SOFTEST

    def by_robust_error(self, trial: Trial) -> tuple[float, float, float, float]:
        """Sort key: smaller for the better one of two trials."""
        return max(trial.robust, self.tolerance), max(trial.excess, WELL), trial.cost, trial.robust

    def _by_error(self, trial: Trial) -> tuple[float, float, float]:
        return max(trial.error, self.tolerance), trial.cost, trial.error

    def _judge(self, settings: list[NewmarkSetting], best: Trial | None) -> Trial | None:
        """Judge settings with all their neighbours; return the best of them and of the best one before."""
        bound = math.inf if best is None else max(best.robust, self.tolerance)
        trials = self.trials.screen(settings, NEIGHBOURS, bound)
        good = self._with_contacts([trial for trial in trials if math.isfinite(trial.robust)])
        self.judged += good
        return min(good + ([] if best is None else [best]), key=self.by_robust_error, default=None)

    def _with_contacts(self, trials: list[Trial], enough: int | None = None) -> list[Trial]:
        """Look at the contacts of those whose displacements keep to the tolerance, until enough of them do well."""
        trials, well = sorted(trials, key=self.by_robust_error), 0
        for i in range(0, len(trials), CONTACTS_AT_ONCE):
            some = [one for one in trials[i : i + CONTACTS_AT_ONCE] if one.robust <= self.tolerance]
            found = self.trials.excesses(one.setting for one in some)
            some = [one._replace(excess=excess) for one, excess in zip(some, found, strict=True)]
            trials[i : i + len(some)] = some
            well += sum(one.excess <= 1.0 for one in some)
            if well >= (enough or len(trials)):
                return trials[: i + len(some)]
        return trials

    def _grid(self, steps: int) -> list[NewmarkSetting]:
        grid = (
            self._setting(stiffness, factor * self._centre(stiffness), steps)
            for stiffness in self._stiffnesses(steps)
            for factor in DAMPING_FACTORS
        )
        return list(dict.fromkeys(grid))  # once each, where D is held

    def _centre(self, stiffness: float) -> float:
        """ζ = D/√(Kμ/(1 + μ)) of equal restitution, which only a spring and a damper have the same of for all K."""
        equal, scheme = ratio_of_restitution(self.system.restitution), self.trials.scheme
        if not scheme.linear:
            if stiffness not in self._equal:
                self._equal[stiffness] = equal_damping(self.system, scheme, stiffness, self.trials.closing_speed)
            if math.isfinite(self._equal[stiffness]):
                equal = damping_ratio(self.system, stiffness, self._equal[stiffness])
        return max(equal, LEAST_DAMPING)

    def _stiffnesses(self, steps: int) -> np.ndarray:
        if self.limits.stiffness is not None:
            return np.array([self.limits.stiffness])
        softest, stiffest, ratio = SOFTEST, self.limits.stiffness_max, LOCATED_RATIO
        if not self.trials.located:
            softest, stiffest = self._ends(steps)
            ratio = RATIO
        stiffest = max(STIFFNESS_RANGE[0], min(stiffest, self.limits.stiffness_max))
        softest = min(max(softest, SOFTEST), stiffest)
        return np.geomspace(softest, stiffest, 1 + round(math.log(stiffest / softest, ratio)))

    def _ends(self, steps: int) -> tuple[float, float]:
        """The softest and the stiffest K whose contacts so many steps resolve well enough."""
        fewest, most = CONTACT_STEPS
        if self.force_tolerance is not None:
            fewest = min(max(fewest, FORCE_STEPS / self.force_tolerance), most / RATIO)
        return tuple(stiffness_for(self.system, self.trials.eta, steps, contact) for contact in (most, fewest))

    def _from_other_steps(self, steps: int) -> list[NewmarkSetting]:
        """Start from the best settings at the two nearest n: with the same K, and K scaled with n and with n².

        With n² the contact takes as many steps as before.
        """
        nearest = sorted(self._best, key=lambda n: abs(math.log(n / steps)))[:2]
        settings = []
        for n in nearest:
            stiffness, damping, _ = self._best[n].setting
            ratio = damping_ratio(self.system, stiffness, damping)
            power = 0.5 if self.trials.scheme.law in RATIO_LAWS else 0.0  # of K, which ζ grows with
            scales = (1.0, steps / n, (steps / n) ** 2)
            settings += [self._setting(stiffness * scale, ratio * scale**power, steps) for scale in scales]
        return list(dict.fromkeys(settings))

    def _around(self, setting: NewmarkSetting, stiffness_factor: float, damping_factor: float) -> list[NewmarkSetting]:
        """Return the eight settings with K and ζ changed by these factors, up or down."""
        ratio = damping_ratio(self.system, setting.stiffness, setting.damping)
        around = (
            self._setting(setting.stiffness * stiffness_factor**i, ratio * damping_factor**j, setting.steps)
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
        )
        return [other for other in dict.fromkeys(around) if other != setting]

    def _setting(self, wanted: float, ratio: float, steps: int) -> NewmarkSetting:
        """Return a setting with K and D of three digits, few enough to read, or with those that are held."""
        stiffness, damping = self.limits.stiffness, self.limits.damping
        if stiffness is None:
            stiffness = rounded_to(min(max(wanted, STIFFNESS_RANGE[0]), self.limits.stiffness_max), 3)
        if damping is None:
            damping = rounded_to(damping_for(self.system, stiffness, ratio), 3)
        return NewmarkSetting(stiffness, damping, steps)


def _first(count: int, trials: list[Trial], key: Callable[[Trial], tuple]) -> list[NewmarkSetting]:
    """Return the settings of the best trials, without those that diverged."""
    return [trial.setting for trial in sorted(trials, key=key)[:count] if math.isfinite(trial.error)]
