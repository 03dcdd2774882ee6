"""Settings of Newmark's method tried out: their error, and whether it is luck.

With a constant step the error is a matter of chance in part: where in a step a contact begins and ends decides how much
of it is missed, and one step more a period, or a K that differs in its last digits, throws the dice anew (paper,
Figure 14). A search through thousands of settings would find the lucky ones first. So a setting is judged by its
*robust* error, which three things keep to:

- itself;
- itself with half the step, since an error of the step that happens to cancel another is no merit;
- nine in ten of its neighbours, whose n, K and D differ by some per cent.

Neighbours that have served to choose a setting say too little, since it was chosen for them. It is confirmed by 29 new
ones. If more than a quarter of the neighbourhood missed a tolerance, so few of 29 would miss it in one case of 35
at most (Σ C(29, k) 0.25ᵏ 0.75²⁹⁻ᵏ over k ≤ 2 is 0.01).

Most runs begin on the reference's motion, where only a short transient is left. The run that is told of begins at rest,
as the paper's do, and so do some of the new neighbours: a setting that leads to another motion from there is no good.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor
from typing import NamedTuple

import numpy as np

from ..divergence.error import Target
from ..divergence.grid import PER_PERIOD
from ..methods import STEPS_RANGE, Newmark
from ..motions.steady import Steady
from ..result import Record
from ..simulate import simulate

LONG, KEEP = 2050, 50  # periods from rest, and kept: the paper's
FORGOTTEN = 1e-4  # what is left of a disturbance after the transient of a short run
KEEP_LOCATED = 12  # of a short run: steps that are cut at contact changes leave no scatter
SHORTEST = 50  # periods of transient
COARSE = 64  # samples per period, enough to choose by
STEPS_AROUND, AROUND = 0.02, 0.01  # half the width of the neighbourhood in n, and in K and D
MISSES = 10  # one in so many neighbours may miss
NEIGHBOURS = 10  # to choose by
WITNESSES = 29  # to confirm by, new ones …
FROM_REST = 7  # … of which every so-many-th begins at rest
REST = (0.0, 0.0, 0.0, 0.0)
# Multiples of it, modulo 1, fill the unit cube evenly, however many are taken (M. Roberts's R₃; ρ⁴ = ρ + 1)
_RHO = 1.2207440846057596
_EVENLY = np.array([_RHO**-1, _RHO**-2, _RHO**-3])


class Setting(NamedTuple):
    """K, D and steps per period."""

    stiffness: float
    damping: float
    steps: int


class Trial(NamedTuple):
    """What became of a setting.

    Attributes
    ----------
    setting : Setting
    error : float
        Rms difference of displacements from the reference, relative to it (:meth:`..divergence.error.Target.error`).
    robust : float
        The error that the setting, the same with half the step, and nine in ten of its neighbours keep to; inf if it
        passes the bound.
    cost : float
        Solves per period: n with constant steps, more if steps are cut at contact changes.
    """

    setting: Setting
    error: float
    robust: float
    cost: float


class Trials:
    """Runs of Newmark's method against one target, in a pool of threads (kernels release the GIL).

    Parameters
    ----------
    found : Steady
        The reference's motion; periodic.
    located : bool
        Whether steps are cut at contact changes.
    pool : Executor
    cancelled : callable, optional
        Polled by every run; when it returns true, Cancelled is raised.
    """

    def __init__(self, found: Steady, located: bool, pool: Executor, cancelled: Callable[[], bool] | None = None):
        self.target = Target(found.response, found.period)
        self.located = located
        self._pool = pool
        self._cancelled = cancelled
        self._start = tuple(found.state.tolist())
        self._transient = transient_of(found)
        self._keep = KEEP_LOCATED if located else KEEP

    def quick(self, settings: Iterable[Setting], neighbours: int = 0, bound: float = math.inf) -> list[Trial]:
        """Short runs that begin on the reference's motion, to choose by."""
        return list(self._pool.map(lambda setting: self._quick(setting, neighbours, bound), settings))

    def confirm(self, settings: Iterable[Setting], bound: float = math.inf) -> list[Trial]:
        """The run from rest, 2,050 periods, and neighbours that were not chosen by."""
        return list(self._pool.map(lambda setting: self._confirm(setting, bound), settings))

    def walked(self, setting: Setting) -> float:
        """Error of the run from rest that walks through every step, as an FE code must, instead of leaping.

        It differs by rounding alone, which shows in the scatter of a constant step.
        """
        return self._run(setting, REST, LONG, KEEP, PER_PERIOD, every_step=True)[0]

    def _quick(self, setting: Setting, neighbours: int, bound: float) -> Trial:
        error, cost = self._short(setting)
        if neighbours == 0:
            return Trial(setting, error, math.inf, cost)
        around = (self._short(other)[0] for other in neighbourhood(setting, range(1, neighbours + 1)))
        return Trial(setting, error, self._robust(setting, error, around, neighbours, bound), cost)

    def _confirm(self, setting: Setting, bound: float) -> Trial:
        error, cost = self._long(setting, PER_PERIOD)
        new = neighbourhood(setting, range(NEIGHBOURS + 1, NEIGHBOURS + WITNESSES + 1))
        around = ((self._short if i % FROM_REST else self._long)(other)[0] for i, other in enumerate(new))
        return Trial(setting, error, self._robust(setting, error, around, WITNESSES, bound), cost)

    def _robust(self, setting: Setting, error: float, around: Iterator[float], count: int, bound: float) -> float:
        if error > bound:
            return math.inf
        halved = self._short(setting._replace(steps=2 * setting.steps))[0]
        return max(error, halved, kept_to(around, count, bound)) if halved <= bound else math.inf

    def _short(self, setting: Setting) -> tuple[float, float]:
        return self._run(setting, self._start, self._transient + self._keep, self._keep, COARSE)

    def _long(self, setting: Setting, per_period: int = COARSE) -> tuple[float, float]:
        return self._run(setting, REST, LONG, KEEP, per_period)

    def _run(
        self, setting: Setting, start: tuple, periods: int, keep: int, per_period: int, every_step: bool = False
    ) -> tuple[float, float]:
        """Error and solves per period."""
        response = simulate(
            self.target.reference.system,
            self.target.reference.eta,
            Newmark(*setting, located=self.located, every_step=every_step),
            periods=periods,
            keep=keep,
            initial=start,
            record=Record(keep, per_period, setting.steps),
            cancelled=self._cancelled,
        )
        return self.target.error(response), response.cost.steps / periods


def neighbourhood(setting: Setting, numbers: Iterable[int]) -> Iterator[Setting]:
    """Neighbours of a setting by their numbers, spread evenly: the same ones whenever it is asked."""
    most = max(1, round(STEPS_AROUND * setting.steps))
    for number in numbers:
        n, k, d = 2 * (number * _EVENLY % 1.0) - 1
        steps = max(STEPS_RANGE[0], setting.steps + math.floor(n * most + 0.5))
        yield Setting(setting.stiffness * (1 + AROUND * k), setting.damping * (1 + AROUND * d), steps)


def transient_of(found: Steady) -> int:
    """Periods after which a disturbance of the reference's motion is forgotten."""
    per_period = np.abs(found.multipliers).max() ** (1 / found.period)
    if per_period >= 1:
        return LONG - KEEP
    needed = math.log(FORGOTTEN) / math.log(max(per_period, FORGOTTEN))
    return min(max(SHORTEST, math.ceil(needed)), LONG - KEEP)


def kept_to(errors: Iterable[float], count: int, bound: float = math.inf) -> float:
    """What nine in ten of ``count`` errors keep to; inf, and no more are asked for, once it passes the bound."""
    allowed, seen, missed = count // MISSES, [], 0
    for error in errors:
        seen.append(error)
        missed += error > bound
        if missed > allowed:
            return math.inf
    return sorted(seen)[-1 - allowed]
