"""Trials of one K, D and Δτ at several excitation frequencies: what counts is the frequency with the largest error.

A setting names the steps per period at the highest frequency, n, and so its time step Δτ = 2π/(η_max n). At a lower
frequency a period takes more of these steps, n η_max/η, rounded up to a whole number: the step of a run is Δτ or less,
by a fraction of a step per period.
"""

import math
from collections.abc import Iterable, Sequence
from concurrent.futures import Executor

from vibroscope.engine.checks import require
from vibroscope.engine.methods import STEPS_RANGE, TimeStepping
from vibroscope.engine.model import check_eta
from vibroscope.engine.recommendation.tolerances import WHOLE_STEPS
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trial, Trials


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
