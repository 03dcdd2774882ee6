"""The way up a ladder of steps per period: the best K and D of each rung, confirmed, and what lies between two."""

import math
from collections.abc import Callable

from .front import front_of
from .search import Search
from .trials import Trial

FIRST_STEPS, FIRST_STEPS_LOCATED = 16, 8  # the lowest rung
MEANINGFUL, MEANINGFUL_LOCATED = 512, 32  # from here on, rungs that bring nothing end the climb …
PATIENCE = 2  # … so many of them
GAIN = 0.95  # a rung that leaves more of the error than this brings nothing
BEYOND = 1  # rungs above the first that meets the tolerance, for the front
BISECTIONS = 4  # which leave 2^(1/16), 4 %, of n open
CONFIRMED = 8  # settings of a rung that may try to be confirmed
SHOWN = 3  # and those that are for the front, whatever their error …
LUCK = 2.0  # … but for those whose neighbours' error is so many times as large


class Climb:
    """From rung to rung of n, and then between two of them."""

    def __init__(self, search: Search, tolerance: float, steps_max: int, told: Callable[[float], None]):
        self.search = search
        self.tolerance = tolerance
        located = search.trials.located
        first = min(FIRST_STEPS_LOCATED if located else FIRST_STEPS, steps_max)
        self.rungs = [first * 2**k for k in range(1 + math.floor(math.log2(steps_max / first)))]
        if self.rungs[-1] < steps_max:
            self.rungs.append(steps_max)
        self._meaningful = MEANINGFUL_LOCATED if located else MEANINGFUL
        self._confirmed: dict = {}
        self._told, self._done = told, 0

    @property
    def met(self) -> list[Trial]:
        """Confirmed settings that meet the tolerance, cheapest first."""
        good = [trial for trial in self._confirmed.values() if trial.robust <= self.tolerance]
        return sorted(good, key=lambda trial: (trial.cost, trial.robust))

    def up(self) -> None:
        """Rung by rung, until a little above the first that meets the tolerance, or nothing more is gained."""
        least, idle, above = math.inf, 0, 0
        for n in self.rungs:
            best = self._reached(n)
            above += bool(self.met)
            if above > BEYOND:
                return
            if best is None or n < self._meaningful:
                continue
            idle = 0 if best.robust < GAIN * least else idle + 1
            least = min(least, best.robust)
            if idle >= PATIENCE and not self.met:
                return

    def between(self) -> None:
        """Bisect n, in its logarithm, between the cheapest setting that meets the tolerance and the rung below."""
        if not self.met:
            return
        high = self.met[0].setting.steps
        low = max((n for n in self.rungs if n < high), default=high)
        for _ in range(BISECTIONS):
            middle = round(math.sqrt(low * high))
            if not low < middle < high:
                return
            self._reached(middle)
            low, high = (low, middle) if self._meets(middle) else (middle, high)

    def complete(self) -> None:
        """Confirm the best of every rung, for the front."""
        for n in self.rungs:
            self._confirm(self._promising(n)[:SHOWN])

    def walk(self) -> None:
        """Walk the cheapest step by step, and the next one if it misses the tolerance then."""
        while not self.search.trials.located and self.met:
            cheapest = self.met[0]
            walked = self.search.trials.walked(cheapest.setting)
            self._confirmed[cheapest.setting] = cheapest._replace(robust=max(cheapest.robust, walked))
            if walked <= self.tolerance:
                return

    def front(self) -> list[Trial]:
        """The front of all that is confirmed."""
        return front_of(trial for trial in self._confirmed.values() if not self._lucky(trial))

    def _lucky(self, trial: Trial) -> bool:
        """Whether its own error is no measure of what its neighbours, or half the step, do."""
        return trial.robust > self.tolerance >= trial.error or trial.robust > max(self.tolerance, LUCK * trial.error)

    def _promising(self, n: int) -> list[Trial]:
        """What was found with n steps, best first."""
        return sorted((t for t in self.search.found if t.setting.steps == n), key=self.search.by_robust)

    def _reached(self, n: int) -> Trial | None:
        """The best setting with n steps; those that seem to meet the tolerance are confirmed or not."""
        best = self.search.level(n, self.met[0].cost if self.met else math.inf)
        self._confirm([t for t in self._promising(n) if t.robust <= self.tolerance][:CONFIRMED], self.tolerance)
        self._done += 1
        self._told(self._done / (len(self.rungs) + BISECTIONS + 1))
        return best

    def _meets(self, n: int) -> bool:
        return any(trial.setting.steps == n for trial in self.met)

    def _confirm(self, trials: list[Trial], bound: float = math.inf) -> None:
        """Confirm those that have not been; beyond the bound it is given up, and has to be done again without."""
        settings = dict.fromkeys(trial.setting for trial in trials if trial.setting not in self._confirmed)
        confirmed = self.search.trials.confirm(settings, bound)
        self._confirmed |= {trial.setting: trial for trial in confirmed if math.isfinite(trial.robust)}
