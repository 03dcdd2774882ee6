"""Trial runs of a method with a setting K, D and n: its error, and whether that error is robust.

The method is the paper's, or what a code has (:class:`engine.TimeStepping`); its K, D and n are those of the setting. A
run that stops at a step without a solution has an infinite error, as one that diverges.

With a constant step the error is partly a matter of chance. Where in a step a contact begins and ends decides how much
of it is missed, and one more step per period, or another last digit of K, changes that (paper, Figure 14). A search
through thousands of settings would find the lucky ones first. So a setting is judged by its *robust* error, the largest
of three:

- its own error;
- its error with half the step, since a time-step error that happens to cancel another one is no merit;
- the error that nine in ten of its neighbours do not exceed, whose n, K and D differ by one or two per cent.

Beside the displacements its contacts are judged (:mod:`.contacts`).

The neighbours by which a setting was chosen are no independent test of it. Therefore 19 new ones confirm it. If more
than a third of the neighbourhood missed the tolerance, at most one of 19 would miss it with a probability below 0.005
only (C(19, 0) (2/3)¹⁹ + C(19, 1) (1/3) (2/3)¹⁸).

Most of these runs begin on the reference's motion, from which only a short transient is left. What is recommended is
verified by runs that all begin at rest and last as long as the paper's, as those of a user do: itself, with and without
steps skipped, with half the step, and 120 neighbours, of which four may miss one of the tolerances. If a tenth of the
neighbourhood missed them, at most four of 120 would with a probability of 0.006 only.

Of several excitation frequencies the one with the largest error counts. A setting names the steps per period at the
highest frequency, n, and so its time step Δτ = 2π/(η_max n). At a lower frequency a period takes more of these steps, n
η_max/η, rounded up to a whole number: the step of a run is Δτ or less, by a fraction of a step per period.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from vibroscope.engine.arguments import Poll, require
from vibroscope.engine.divergence.encounters import mean_closing_speed
from vibroscope.engine.divergence.error import SampledRuns, Target
from vibroscope.engine.divergence.grid import PER_PERIOD
from vibroscope.engine.methods import STEPS_RANGE, Method, TimeStepping
from vibroscope.engine.model import check_eta
from vibroscope.engine.motions.steady import Steady
from vibroscope.engine.recommendation.contacts import MORE_PEAK_SAMPLES, Contacts, Tolerances, contacts_of, peak_of
from vibroscope.engine.recommendation.tolerances import AROUND, FORGOTTEN, STEPS_AROUND, WHOLE_STEPS
from vibroscope.engine.result import Record, Response
from vibroscope.engine.simulate import KEEP, LONG, simulate

KEEP_LOCATED = 12  # periods of a short run that are kept: located steps leave no scatter
SHORTEST_TRANSIENT = 50  # periods of transient
TRIAL_SAMPLES, NEIGHBOUR_SAMPLES = 32, 64  # samples per period, sufficient to choose by, and to confirm by neighbours
NEIGHBOUR_MISS_IN = 10  # one in so many neighbours may miss
NEIGHBOURS = 10  # to choose by
NEW_NEIGHBOURS = 19  # to confirm by …
EVERY_NTH_FROM_REST = 7  # … of which every seventh begins at rest
NEIGHBOURS_AT_ONCE = 6  # runs that are made side by side before it is looked at what they say
VERIFIED, MISSES = 120, 4  # neighbours that verify what is recommended, and how many of them may miss a tolerance
# Multiples of this vector, modulo 1, fill the unit cube evenly, however many are taken (M. Roberts's R₃; ρ⁴ = ρ + 1)
_RHO = 1.2207440846057596
_EVENLY = np.array([_RHO**-1, _RHO**-2, _RHO**-3])


class NewmarkSetting(NamedTuple):
    """K, D and steps per period."""

    stiffness: float
    damping: float
    steps: int


class Trial(NamedTuple):
    """Outcome of trying a setting.

    Attributes
    ----------
    setting : NewmarkSetting
    error : float
        Rms difference of displacements from the reference, relative to it (:meth:`..divergence.error.Target.error`).
    robust : float
        The error that the setting, the same with half the step, and nine in ten of its neighbours do not exceed; inf if
        it exceeds the bound.
    cost : float
        Solves per period: n with constant steps, more with located steps.
    contacts : Contacts or None
        What its contacts do; None as long as nobody has asked.
    excess : float
        Largest deviation of restitution and peak force, its own and with half the step, in units of the tolerance.
    """

    setting: NewmarkSetting
    error: float
    robust: float
    cost: float
    contacts: Contacts | None = None
    excess: float = 0.0

    def meets(self, tolerance: float) -> bool:
        """Whether it keeps to all tolerances; that of the displacements is given."""
        return self.robust <= tolerance and self.excess <= 1.0


class Trials:
    """Runs of a method against one target; a pool of threads verifies (kernels release the GIL).

    Parameters
    ----------
    found : Steady
        The reference's motion; periodic.
    scheme : TimeStepping
        The method; its own K, D and n have no effect.
    pool : Executor
    tolerances : Tolerances, optional
        Those of restitution and peak force count; the other one is a bound that each question has of its own.
    cancelled : callable, optional
        Polled by every run; when it returns true, Cancelled is raised.
    """

    def __init__(
        self,
        found: Steady,
        scheme: TimeStepping,
        pool: Executor,
        tolerances: Tolerances | None = None,
        cancelled: Poll | None = None,
    ):
        self.target = Target(found.response, found.period)
        self.tolerances = tolerances or Tolerances()
        self.eta = found.response.eta
        self._system = found.response.system
        self.scheme, self.located = scheme, scheme.located
        self.closing_speed = mean_closing_speed(found.response)
        self._pool = pool
        self._cancelled = cancelled
        self._start = tuple(found.state.tolist())
        self._transient = transient_of(found)
        self._keep = KEEP_LOCATED if self.located else KEEP
        self._runs = SampledRuns(self._system, self.eta)
        for name in ("excess", "verify", "verify_alone", "_run_short", "_peak_of"):  # many are needed again
            setattr(self, name, cache(getattr(self, name)))

    def error_of_every_step(self, setting: NewmarkSetting) -> float:
        """Return the error of the run from rest that computes every step, as an FE code must, and skips none.

        It differs from the trial's by rounding alone, which shows in the scatter of a constant step.
        """
        return self.run(setting, self._system.rest, LONG, KEEP, PER_PERIOD, every_step=True)[0]

    def screen(self, setting: NewmarkSetting, neighbours: int = 0, bound: float = math.inf) -> Trial:
        """Try a setting by a short run that begins on the reference's motion, to choose by."""
        error, cost = self._run_short(setting, TRIAL_SAMPLES)
        if neighbours == 0:
            return Trial(setting, error, math.inf, cost)
        around = (
            self._run_short(other, TRIAL_SAMPLES)[0] for other in neighbourhood(setting, range(1, neighbours + 1))
        )
        return Trial(setting, error, self._robust(setting, error, around, neighbours, bound), cost)

    def meets(self, setting: NewmarkSetting, bound: float) -> bool:
        """Whether a setting seems to keep to all tolerances, by short runs."""
        return self.screen(setting, NEIGHBOURS, bound).robust <= bound and self.excess(setting) <= 1.0

    def excess(self, setting: NewmarkSetting) -> float:
        """Return :attr:`Trial.excess` of a short run, without that of half the step."""
        run = self._simulate(with_setting(self.scheme, setting), self._start)
        if not run.ok:
            return math.inf
        peak = self._peak_without_step(setting, self._start)
        return contacts_of(run, peak, self.target, self._cancelled).excess(self.tolerances)

    def confirm(self, setting: NewmarkSetting, bound: float = math.inf) -> Trial:
        """Try a setting by a run of 2,050 periods from rest, with neighbours that it was not chosen by."""
        error, cost = self._run_from_rest(setting, PER_PERIOD)
        others = neighbourhood(setting, range(NEIGHBOURS + 1, NEIGHBOURS + NEW_NEIGHBOURS + 1))
        around = (
            (self._run_short if i % EVERY_NTH_FROM_REST else self._run_from_rest)(other, NEIGHBOUR_SAMPLES)[0]
            for i, other in enumerate(others)
        )
        robust = self._robust(setting, error, around, NEW_NEIGHBOURS, bound, NEIGHBOUR_SAMPLES)
        return Trial(setting, error, robust, cost, excess=self.excess(setting))

    def verify(self, setting: NewmarkSetting) -> Trial:
        """Try a setting by runs from rest, as a user makes them; its robust error is inf if its neighbours miss.

        For the calling thread of a search: the pool makes the runs.
        """
        trial = self.verify_alone(setting)
        if trial.meets(self.tolerances.displacement):
            trial = trial._replace(robust=max(trial.robust, self._robust_from_rest(setting)))
        return trial

    def verify_alone(self, setting: NewmarkSetting) -> Trial:
        """Try a setting as :meth:`verify` does, but for its neighbours: the same with half the step counts as well."""
        peak = self._peak_without_step(setting, None)
        error, contacts = self._from_rest(setting, peak)
        halved, of_half = self._from_rest(setting._replace(steps=2 * setting.steps), peak)
        robust = max(error, halved, 0.0 if self.located else self.error_of_every_step(setting))
        excess = max((math.inf if one is None else one.excess(self.tolerances)) for one in (contacts, of_half))
        cost = float(setting.steps)
        if self.located:
            cost = self.run(setting, self._system.rest, LONG, KEEP, TRIAL_SAMPLES)[1]
        return Trial(setting, error, robust, cost, contacts, excess)

    def _robust_from_rest(self, setting: NewmarkSetting) -> float:
        """Return the error that nine in ten neighbours do not exceed, inf if too many miss a tolerance."""
        peak, errors, missed = self._peak_without_step(setting, None), [], 0
        for first in range(1, VERIFIED + 1, NEIGHBOURS_AT_ONCE):
            others = neighbourhood(setting, range(first, first + NEIGHBOURS_AT_ONCE))
            for error, contacts in self._pool.map(lambda other: self._from_rest(other, peak), others):
                errors.append(error)
                missed += not self._holds(error, contacts)
            if missed > MISSES:
                return math.inf
        return tolerant_maximum(errors, VERIFIED)

    def holds(self, setting: NewmarkSetting) -> bool:
        """Whether a run from rest keeps to all tolerances."""
        return self._holds(*self._from_rest(setting, self._peak_without_step(setting, None)))

    def _holds(self, error: float, contacts: Contacts | None) -> bool:
        well = contacts is not None and contacts.excess(self.tolerances) <= 1.0
        return well and error <= self.tolerances.displacement

    def _from_rest(self, setting: NewmarkSetting, peak: float) -> tuple[float, Contacts | None]:
        """Return error and contacts of a run from rest, as a user makes it; inf and None if it ends early."""
        run = self._simulate(with_setting(self.scheme, setting), None, Record(KEEP, PER_PERIOD, setting.steps))
        contacts = contacts_of(run, peak, self.target, self._cancelled, MORE_PEAK_SAMPLES) if run.ok else None
        return self.target.error(run, self._cancelled), contacts

    def _simulate(self, method: Method, start: tuple | None, record: Record | None = None) -> Response:
        """Run from rest as long as the paper, or as short as may be from another start."""
        periods = LONG if start is None else self._transient + KEEP
        options = {"periods": periods, "keep": KEEP, "initial": start, "cancelled": self._cancelled, "record": record}
        return simulate(self._system, self.eta, method, **options)

    def _peak_without_step(self, setting: NewmarkSetting, start: tuple | None) -> float:
        return self._peak_of(with_setting(self.scheme, setting).limit, start)

    def _peak_of(self, limit: Method, start: tuple | None) -> float:
        exact = self._simulate(limit, start)
        return peak_of(exact, self.target.period, self._cancelled) if exact.ok else math.nan

    def _robust(
        self,
        setting: NewmarkSetting,
        error: float,
        around: Iterator[float],
        count: int,
        bound: float,
        per_period: int = TRIAL_SAMPLES,
    ) -> float:
        """Return the robust error, inf as soon as it exceeds the bound."""
        if error > bound:
            return math.inf
        halved = self._run_short(setting._replace(steps=2 * setting.steps), per_period)[0]
        return max(error, halved, tolerant_maximum(around, count, bound)) if halved <= bound else math.inf

    def _run_short(self, setting: NewmarkSetting, per_period: int) -> tuple[float, float]:
        return self.run(setting, self._start, self._transient + self._keep, self._keep, per_period)

    def _run_from_rest(self, setting: NewmarkSetting, per_period: int) -> tuple[float, float]:
        return self.run(setting, self._system.rest, LONG, KEEP, per_period)

    def run(
        self, setting: NewmarkSetting, start: tuple, periods: int, keep: int, per_period: int, every_step: bool = False
    ) -> tuple[float, float]:
        """Return error and solves per period."""
        method, record = with_setting(self.scheme, setting), Record(keep, per_period, setting.steps)
        return self._runs.error(self.target, method, start, periods, record, self._cancelled, every_step)


def with_setting(scheme: TimeStepping, setting: NewmarkSetting) -> TimeStepping:
    """Return the method with K, D and n of a setting."""
    return replace(scheme, **setting._asdict())


def neighbourhood(setting: NewmarkSetting, numbers: Iterable[int]) -> Iterator[NewmarkSetting]:
    """Yield the neighbours of a setting with these numbers, evenly spread: a number always gives the same neighbour."""
    most = max(1, round(STEPS_AROUND * setting.steps))
    for number in numbers:
        n, k, d = 2 * (number * _EVENLY % 1.0) - 1
        steps = max(STEPS_RANGE[0], setting.steps + math.floor(n * most + 0.5))
        yield NewmarkSetting(setting.stiffness * (1 + AROUND * k), setting.damping * (1 + AROUND * d), steps)


def transient_of(found: Steady) -> int:
    """Return the periods after which a disturbance of the reference's motion has died away to FORGOTTEN."""
    per_period = np.abs(found.multipliers).max() ** (1 / found.period)
    if per_period >= 1:
        return LONG - KEEP
    needed = math.log(FORGOTTEN) / math.log(max(per_period, FORGOTTEN))
    return min(max(SHORTEST_TRANSIENT, math.ceil(needed)), LONG - KEEP)


def tolerant_maximum(errors: Iterable[float], count: int, bound: float = math.inf) -> float:
    """Return the largest of ``count`` errors without the largest tenth; inf as soon as it must exceed the bound.

    ``errors`` is consumed no further than needed.
    """
    allowed, seen, missed = count // NEIGHBOUR_MISS_IN, [], 0
    for error in errors:
        seen.append(error)
        missed += error > bound
        if missed > allowed:
            return math.inf
    return sorted(seen)[-1 - allowed]


def verification(near: Trials, exact: Trials, tolerance: float) -> Callable[[NewmarkSetting], Trial]:
    """Return a function that verifies a setting for a question as it is, with the neighbours of one near to it.

    Neighbours decide by how many of them miss a tolerance, which rounding must not change from question to question.
    """

    def verify(setting: NewmarkSetting) -> Trial:
        trial = near.verify(setting)
        if near is exact or not trial.meets(tolerance):
            return trial
        own = exact.verify_alone(setting)
        return own._replace(robust=max(own.robust, trial.robust), excess=max(own.excess, trial.excess))

    return verify


class RangeTrials:
    """The trials at one or several excitation frequencies.

    Parameters
    ----------
    parts : sequence of Trials
        One for each excitation frequency.
    pool : Executor

    Attributes
    ----------
    eta : float
        The highest of the frequencies.
    """

    def __init__(self, parts: Sequence[Trials], pool: Executor):
        self.parts = tuple(parts)
        self.located = parts[0].located
        self.eta = max(part.eta for part in parts)
        self._pool = pool
        self._order = list(parts)  # the part that a setting failed at last comes first: most fail there again

    @property
    def scheme(self) -> TimeStepping:
        """The method, the same at all frequencies."""
        return self.parts[0].scheme

    @property
    def closing_speed(self) -> float:
        """The mean over the frequencies."""
        return sum(part.closing_speed for part in self.parts) / len(self.parts)

    def screen(self, settings: Iterable[NewmarkSetting], neighbours: int = 0, bound: float = math.inf) -> list[Trial]:
        """Try settings by short runs on the reference's motion, to choose by: :meth:`.trials.Trials.screen`."""
        return list(self._pool.map(lambda one: self._worst(one, bound, "screen", neighbours, bound), settings))

    def meets(self, setting: NewmarkSetting, bound: float) -> bool:
        """Whether a setting seems to keep to all tolerances at all frequencies, by short runs."""
        for part in tuple(self._order):
            if not part.meets(self.at(part, setting), bound):
                self._order = [part, *(other for other in self.parts if other is not part)]
                return False
        return True

    def excesses(self, settings: Iterable[NewmarkSetting]) -> list[float]:
        """The largest :meth:`.trials.Trials.excess` of each of several settings."""
        return list(self._pool.map(lambda one: max(part.excess(self.at(part, one)) for part in self.parts), settings))

    def all_meet(self, settings: Iterable[NewmarkSetting], bound: float) -> list[bool]:
        """Whether each of several settings seems to keep to all tolerances."""
        return list(self._pool.map(lambda setting: self.meets(setting, bound), settings))

    def all_hold(self, settings: Iterable[NewmarkSetting]) -> list[bool]:
        """Whether each of several settings keeps to all tolerances at all frequencies, by runs from rest."""
        return list(
            self._pool.map(lambda setting: all(part.holds(self.at(part, setting)) for part in self.parts), settings)
        )

    def verify(self, setting: NewmarkSetting) -> Trial:
        """See :meth:`.trials.Trials.verify`; the contacts are those of the part where they are furthest off."""
        return self._worst(setting, math.inf, "verify")

    def verify_alone(self, setting: NewmarkSetting) -> Trial:
        """See :meth:`.trials.Trials.verify_alone`, and :meth:`verify`."""
        return self._worst(setting, math.inf, "verify_alone")

    def confirm(self, settings: Iterable[NewmarkSetting], bound: float = math.inf) -> list[Trial]:
        """Try settings by runs from rest, with further neighbours: :meth:`.trials.Trials.confirm`."""
        return list(self._pool.map(lambda one: self._worst(one, bound, "confirm", bound), settings))

    def at(self, part: Trials, setting: NewmarkSetting) -> NewmarkSetting:
        """Return the setting with its steps per period at the frequency of one part."""
        return setting._replace(steps=steps_at(part.eta, self.eta, setting.steps))

    def _worst(self, setting: NewmarkSetting, bound: float, method: str, *arguments) -> Trial:
        """Return the largest error, robust error and cost; all infinite as soon as a robust error exceeds the bound."""
        trials, costs = [], []
        for part in tuple(self._order) if math.isfinite(bound) else self.parts:
            trial = getattr(part, method)(self.at(part, setting), *arguments)
            if math.isfinite(bound) and not trial.robust <= bound:
                self._order = [part, *(other for other in self.parts if other is not part)]
                return Trial(setting, math.inf, math.inf, math.inf)
            trials.append(trial)
            costs.append(trial.cost * part.eta / self.eta)
        error, robust = (max(getattr(trial, name) for trial in trials) for name in ("error", "robust"))
        worst = max(trials, key=lambda trial: trial.excess)
        cost = max(costs) if self.located else float(setting.steps)
        return Trial(setting, error, robust, cost, worst.contacts, worst.excess)


def steps_at(eta: float, highest: float, steps: int) -> int:
    """Return the steps per period at η of the time step that has so many at the highest frequency.

    Examples
    --------
    >>> from vibroscope.engine import steps_at
    >>> steps_at(1.08, 2.76, 500)  # at η = 1.08, of the step that is T/500 at 2.76
    1278
    """
    eta, highest = check_eta(eta), check_eta(highest)
    steps = require("steps", steps, *STEPS_RANGE, "give the steps per period at the highest frequency")
    return math.ceil(steps * highest / eta * (1 - WHOLE_STEPS))
