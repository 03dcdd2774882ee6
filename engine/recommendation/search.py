"""The search for K, D and n: where formulas lead it, and what it tries.

For a given n there is a best K. A softer contact lasts too long; a stiffer one is missed by a larger part of its few
steps. Formulas say where to look: a contact should take between one and a hundred steps
(:func:`..divergence.contact.stiffness_for`), and D should be near that of equal restitution, D = ζ(e)√(Kμ/(1 + μ));
less and more are tried too, since damping can make up in part for what the model lacks. The best of this grid are
judged with their neighbours (:mod:`.trials`), and the best of these is improved by ever smaller moves in log K and
log D.

Steps that are cut at the contact changes resolve any contact. Then n does not bound K, and the grid is that of all K.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..divergence.contact import damping_for, damping_ratio, damping_ratio_for, stiffness_for
from ..methods import STIFFNESS_RANGE
from ..model import System
from .trials import NEIGHBOURS, Setting, Trial, Trials

CONTACT_STEPS = (1.5, 100.0)  # steps in a contact that are worth a try
SOFTEST = 10.0  # K that is worth a try
RATIO, LOCATED_RATIO = 2.0, 4.0  # from K to K of the grid
SHARES = (0.2, 0.4, 0.7, 0.85, 1.0, 1.15, 1.4, 2.5)  # ζ of the grid, in units of ζ(e)
LEAST_DAMPING = 0.01  # the unit, if e is so near to 1 that ζ(e) is less
LIKELY, FEW = 16, 2  # settings of the grid that are looked at with some of their neighbours …
JUDGED = 6  # … and those that are judged with all of them
MOVES = ((1.4, 1.12), (1.15, 1.05))  # factors of K and D, round by round


@dataclass
class Search:
    """All that was judged so far, for one system and η.

    Of two settings the one with less error is better; of two that meet the tolerance, the cheaper one.

    Attributes
    ----------
    found : list of Trial
        Settings that were judged with all their neighbours.
    """

    trials: Trials
    system: System
    eta: float
    stiffness_max: float
    tolerance: float
    found: list[Trial] = field(default_factory=list)
    _best: dict[int, Trial] = field(default_factory=dict)

    def level(self, steps: int, cost: float = math.inf) -> Trial | None:
        """The best setting found with so many steps; None if all blow up.

        What costs more than ``cost`` is tried only near to the best of other levels.
        """
        best = self._judge(self._seeds(steps), None)
        grid = [trial for trial in self.trials.quick(self._grid(steps)) if trial.cost <= cost]
        grid = self.trials.quick(_first(LIKELY, grid, self._by_error), FEW)
        best = self._judge(_first(JUDGED, grid, self.by_robust), best)
        for factors in MOVES:
            if best is not None:
                best = self._judge(self._around(best.setting, *factors), best)
        if best is not None:
            self._best[steps] = best
        return best

    def _judge(self, settings: list[Setting], best: Trial | None) -> Trial | None:
        """The best of those, if better than the one before; they are found now."""
        bound = math.inf if best is None else max(best.robust, self.tolerance)
        good = [t for t in self.trials.quick(settings, NEIGHBOURS, bound) if math.isfinite(t.robust)]
        self.found += good
        return min(good + ([] if best is None else [best]), key=self.by_robust, default=None)

    def by_robust(self, trial: Trial) -> tuple[float, float, float]:
        """What the better one of two trials has less of."""
        return max(trial.robust, self.tolerance), trial.cost, trial.robust

    def _by_error(self, trial: Trial) -> tuple[float, float, float]:
        return max(trial.error, self.tolerance), trial.cost, trial.error

    def _grid(self, steps: int) -> list[Setting]:
        centre = max(damping_ratio_for(self.system.restitution), LEAST_DAMPING)
        return [self._setting(k, share * centre, steps) for k in self._stiffnesses(steps) for share in SHARES]

    def _stiffnesses(self, steps: int) -> np.ndarray:
        soft, stiff, ratio = SOFTEST, self.stiffness_max, LOCATED_RATIO
        if not self.trials.located:
            stiff, soft = (stiffness_for(self.system, self.eta, steps, contact) for contact in CONTACT_STEPS)
            ratio = RATIO
        stiff = max(STIFFNESS_RANGE[0], min(stiff, self.stiffness_max))
        soft = min(max(soft, SOFTEST), stiff)
        return np.geomspace(soft, stiff, 1 + round(math.log(stiff / soft, ratio)))

    def _seeds(self, steps: int) -> list[Setting]:
        """The best of the nearest levels: the same K, and the K whose contact takes as many steps."""
        nearest = sorted(self._best, key=lambda n: abs(math.log(n / steps)))[:2]
        seeds = []
        for n in nearest:
            k, d, _ = self._best[n].setting
            ratio = damping_ratio(self.system, k, d)
            seeds += [self._setting(k * scale, ratio, steps) for scale in (1.0, steps / n, (steps / n) ** 2)]
        return list(dict.fromkeys(seeds))

    def _around(self, setting: Setting, stiffer: float, damper: float) -> list[Setting]:
        ratio = damping_ratio(self.system, setting.stiffness, setting.damping)
        return [
            self._setting(setting.stiffness * stiffer**i, ratio * damper**j, setting.steps)
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
            if (i, j) != (0, 0)
        ]

    def _setting(self, stiffness: float, ratio: float, steps: int) -> Setting:
        """Three digits of K and D are enough for people, and what is tried is what is told."""
        k = rounded(min(max(stiffness, STIFFNESS_RANGE[0]), self.stiffness_max))
        return Setting(k, rounded(damping_for(self.system, k, ratio)), steps)


def _first(count: int, trials: list[Trial], key: Callable[[Trial], tuple]) -> list[Setting]:
    """Settings of the best trials, those that blew up left out."""
    return [trial.setting for trial in sorted(trials, key=key)[:count] if math.isfinite(trial.error)]


def rounded(value: float) -> float:
    """To three significant digits."""
    return float(f"{value:.3g}")
