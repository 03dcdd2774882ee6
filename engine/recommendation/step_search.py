"""Search for the least number of steps per period n that meets the tolerance, with the best K and D for each n.

n is doubled from level to level until the tolerance is met. Between the last level that misses it and the first that
meets it, n is bisected. Whatever seems to meet the tolerance is confirmed by new runs (:mod:`.trials`).

The error of located steps falls steeply where they are few, from tens of per cent to a few between n = 8 and 24. So
there the levels lie closer.
"""

import math
from collections.abc import Callable, Iterator

from vibroscope.engine.recommendation.contact_search import ContactSearch, MiddleSearch, pareto_front
from vibroscope.engine.recommendation.tolerances import GAIN, LUCK, STARTS_APART
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trial

FIRST_STEPS, FIRST_STEPS_LOCATED = 16, 8  # the lowest level
MEANINGFUL, MEANINGFUL_LOCATED = 512, 32  # from this n on, levels without gain end the search …
CLOSER = 1.5  # located: below that n there is a level so many times each, too
DENSE, DENSER = 128, 4  # constant steps: up to that n so many levels to a doubling, since what few steps do is luck
LEVELS_WITHOUT_GAIN = 2  # … after so many of them
LEVELS_BEYOND = 1  # levels above the first that meets the tolerance, for the front
BISECTIONS = 3  # they leave n uncertain by 2^(1/8), 9 %
MOST_CONFIRMED = 9  # settings of a level that are confirmed if they seem to meet the tolerance, until some do
SHOWN_AT_ONCE = (
    2  # … so many at a time; and best settings of a level that are confirmed for the front, whatever their error …
)
MIDDLE_STARTS = 3  # settings from which a middle is looked for, and how far apart their K are, a factor


class StepSearch:
    """Search over the levels of n, and between two of them.

    Parameters
    ----------
    contact : ContactSearch
    tolerance : float
    steps_max : int
        Largest n.
    progress : callable
        Called with the fraction of the levels that are done.
    partial : callable
        Called before it, with the front so far.
    """

    def __init__(
        self,
        contact: ContactSearch,
        tolerance: float,
        steps_max: int,
        progress: Callable[[float], None],
        partial: Callable[[list[Trial]], None],
    ):
        self.contact = contact
        self.tolerance = tolerance
        located = contact.trials.located
        first = min(FIRST_STEPS_LOCATED if located else FIRST_STEPS, steps_max)
        doubled = [first * 2**i for i in range(1 + math.floor(math.log2(steps_max / first)))]
        if located:
            between = [round(CLOSER * n) for n in doubled if n < MEANINGFUL_LOCATED]
        else:
            between = [round(n * 2 ** (i / DENSER)) for n in doubled if n < DENSE for i in range(1, DENSER)]
        levels = sorted({*doubled, *(n for n in between if n < steps_max), steps_max})
        self.levels = [n for n in levels if contact.is_worth(n)] or levels[-1:]
        self._meaningful = MEANINGFUL_LOCATED if located else MEANINGFUL
        self._confirmed: dict[NewmarkSetting, Trial] = {}
        self._given_up: dict[NewmarkSetting, float] = {}  # the bound that each exceeds
        self._progress, self._partial, self._done = progress, partial, 0

    @property
    def met(self) -> list[Trial]:
        """Confirmed settings that meet the tolerance, cheapest first."""
        good = [trial for trial in self._confirmed.values() if trial.meets(self.tolerance)]
        return sorted(good, key=lambda trial: (trial.cost, trial.robust))

    def run(self) -> None:
        """Search the levels and between two of them, and confirm what is shown and recommended."""
        self._search_levels()
        self._bisect()
        self._confirm_best_of_levels()

    def front(self) -> list[Trial]:
        """Return the Pareto front of all confirmed settings.

        Lucky ones, and those whose contacts exceed a tolerance, are left out where others meet the tolerance. Where
        none does, the robust error alone counts.
        """
        met, confirmed = bool(self.met), self._confirmed.values()
        return pareto_front(one for one in confirmed if not (met and (one.excess > 1.0 or self._is_lucky(one))))

    def verified(self, middles: MiddleSearch, verify: Callable[[NewmarkSetting], Trial]) -> Iterator[Trial]:
        """Yield what can be recommended: see :meth:`.contact_search.MiddleSearch.verified`."""
        if self.met:
            yield from middles.verified(self.met[0].setting.steps, self._starts, verify)

    def _starts(self, n: int) -> list[NewmarkSetting]:
        """The best settings with n steps that seem to meet the tolerances, with K well apart."""
        self.contact.best_with(n)
        starts: list[NewmarkSetting] = []
        for trial in self._judged_with(n):
            apart = (abs(math.log(trial.setting.stiffness / one.stiffness)) > math.log(STARTS_APART) for one in starts)
            if trial.meets(self.tolerance) and all(apart):
                starts.append(trial.setting)
        return starts[:MIDDLE_STARTS]

    def _search_levels(self) -> None:
        """Go up the levels to a little above the first that meets the tolerance, or until nothing is gained."""
        least, without_gain, above = math.inf, 0, 0
        for n in self.levels:
            best = self._search(n)
            above += bool(self.met)
            if above > LEVELS_BEYOND:
                return
            if best is None or n < self._meaningful or best.robust <= self.tolerance:
                continue
            without_gain = 0 if best.robust < GAIN * least else without_gain + 1
            least = min(least, best.robust)
            if without_gain >= LEVELS_WITHOUT_GAIN and not self.met:
                return

    def _bisect(self) -> None:
        """Bisect log n between the cheapest setting that meets the tolerance and the level below it."""
        if not self.met:
            return
        high = self.met[0].setting.steps
        low = max((n for n in self.levels if n < high), default=high)
        for _ in range(BISECTIONS):
            middle = round(math.sqrt(low * high))
            if not low < middle < high:
                return
            self._search(middle)
            low, high = (low, middle) if self._meets(middle) else (middle, high)

    def _confirm_best_of_levels(self) -> None:
        """Confirm the best settings of every level, for the front, but for those that a cheaper one beats."""
        for n in self.levels:
            shown = self._judged_with(n)[:SHOWN_AT_ONCE]  # best first
            shown = [one for i, one in enumerate(shown) if all(one.cost <= better.cost for better in shown[:i])]
            cost = min((trial.cost for trial in shown), default=0.0)
            cheaper = [trial.robust for trial in self.front() if trial.cost < cost]
            self._confirm(shown, min(cheaper, default=math.inf))

    def _is_lucky(self, trial: Trial) -> bool:
        """Whether its own error says nothing about that of its neighbours, or of half the step."""
        return trial.robust > self.tolerance >= trial.error or trial.robust > max(self.tolerance, LUCK * trial.error)

    def _search(self, n: int) -> Trial | None:
        """Return the best setting with n steps, and confirm those that seem to meet the tolerance until some do."""
        best = self.contact.best_with(n, self.met[0].cost if self.met else math.inf)
        promising = [trial for trial in self._judged_with(n) if trial.meets(self.tolerance)]
        for begin in range(0, len(promising[:MOST_CONFIRMED]), SHOWN_AT_ONCE):
            if not self._meets(n):
                self._confirm(promising[begin : begin + SHOWN_AT_ONCE], self.tolerance)
        self._done += 1
        self._partial(self._front_so_far())
        self._progress(self._done / (len(self.levels) + BISECTIONS + 1))
        return best

    def _front_so_far(self) -> list[Trial]:
        """Return the front of the best settings of each n; of those that seem to meet the tolerance, the confirmed."""
        return pareto_front([*self.met, *(trial for trial in self.contact.best if trial.robust > self.tolerance)])

    def _judged_with(self, n: int) -> list[Trial]:
        """Return the judged settings with n steps, best first."""
        judged = [trial for trial in self.contact.judged if trial.setting.steps == n]
        return sorted(judged, key=self.contact.by_robust_error)

    def _meets(self, n: int) -> bool:
        return any(trial.setting.steps == n for trial in self.met)

    def _confirm(self, trials: list[Trial], bound: float = math.inf) -> None:
        """Confirm settings. One that exceeds the bound is given up; with a larger bound it may be confirmed later."""
        settings = (trial.setting for trial in trials if self._given_up.get(trial.setting, 0.0) < bound)
        settings = [setting for setting in dict.fromkeys(settings) if setting not in self._confirmed]
        for setting, trial in zip(settings, self.contact.trials.confirm(settings, bound), strict=True):
            if math.isfinite(trial.robust):
                self._confirmed[setting] = trial
            else:
                self._given_up[setting] = bound
