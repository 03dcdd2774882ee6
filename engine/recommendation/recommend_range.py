"""Recommend one K, D and time step for a range of excitation frequencies.

The search is that of :mod:`.recommend`. Each setting is tried at several η, and the one with the largest error counts
(:mod:`.range_trials`). What meets the tolerance there is tried between them, too: an η that misses it joins the others,
and the search begins again.
"""

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

from ..divergence.compare import compare
from ..divergence.difference import PART_NAMES
from ..drivers.threads import thread_count
from ..methods import Newmark, Reference, TimeStepping, is_located
from ..model import System, check_eta
from ..motions.steady import Steady, steady
from ..wording import percent
from .contact_search import ContactSearch
from .contacts import Contacts, Tolerances
from .front import monotone_front
from .limits import STEPS_MAX_RANGE, Limits
from .middle import MiddleSearch
from .range_trials import RangeTrials, steps_at
from .reasons import error_without_time_step, idle_reason, joint_damping_error, unmet_tolerance_reason
from .recommend import Suggested, cheapest_near_least, described, no_progress, of_same_kind, scheme_of
from .rounded import round_numbers
from .step_search import StepSearch
from .trials import NewmarkSetting, Trial, Trials, verification, with_setting

MOST_ETAS = 50
OTHERWISE = 2.0  # times the error: further off, the motion without a time step is another one
# Of the progress, before each search and after the last. There are three at most: after each but the last, an η between
# the others that misses the tolerance joins them.
_SHARES = (0.05, 0.6, 0.8, 0.95)


@dataclass(frozen=True)
class Served:
    """The result of the recommended setting at one η.

    Attributes
    ----------
    eta : float
    steps : int
        Steps per period of the recommended time step, rounded up.
    error, robust, contacts, excess
        See :class:`.trials.Trial`.
    """

    eta: float
    steps: int
    error: float
    robust: float
    contacts: Contacts | None
    excess: float


@dataclass(frozen=True, kw_only=True)
class RangeRecommendation(Suggested):
    """Outcome of :func:`recommend_range`.

    Attributes
    ----------
    system, reference, tolerances, located
        The arguments; the tolerances are those of the displacements, the restitution and the peak force.
    eta : float
        The highest excitation frequency at which the reference repeats itself.
    met : bool
        Whether the tolerances are met at all ``served``; each is judged as by :func:`.recommend.recommend`.
    best : Trial or None
        As there, its steps per period those at ``eta``, its errors the largest of the range, its contacts those that
        are furthest off.
    ranges : dict
        As there.
    front : tuple of Trial
        Settings that no other one beats, cheapest first.
    served : tuple of Served
        What ``best`` does at each η, lowest first; those between the η asked for are here if the tolerance is met.
    left_out : tuple of float
        The η at which no error exists, since the reference does not repeat itself, or K and D have no effect.
    limit : str
        At which η the error is largest, and which part of it: what limits the range.
    reason : str
        Why nothing meets the tolerance and what to do; empty if ``met``.
    kind : str
        At which η the motion of ``best`` and the reference's differ in kind, in words; empty if they do not.
    scheme : Newmark or TimeStepping
        What the settings were tried with; its own K, D and n have no effect.
    """

    system: System
    reference: Reference
    tolerances: Tolerances
    located: bool
    eta: float
    met: bool
    best: Trial | None
    ranges: dict[str, tuple[float, float]]
    front: tuple[Trial, ...]
    served: tuple[Served, ...]
    left_out: tuple[float, ...]
    limit: str
    reason: str
    kind: str
    scheme: Newmark | TimeStepping | None = None

    @property
    def time_step(self) -> float:
        """Δτ, in units of 1/ω₁; nan if there is no setting."""
        return math.nan if self.best is None else 2 * math.pi / (self.eta * self.best.setting.steps)

    def method(self, eta: float) -> Newmark | TimeStepping | None:
        """Return the recommended setting at an η as a method to simulate with; None if there is none."""
        if self.best is None:
            return None
        setting = self.best.setting
        return self.with_setting(setting._replace(steps=steps_at(eta, self.eta, setting.steps)))


def recommend_range(
    system: System,
    etas: Sequence[float],
    *,
    tolerance: float = 0.05,
    restitution_tolerance: float | None = 0.1,
    force_tolerance: float | None = 0.2,
    located: bool = False,
    scheme: Newmark | TimeStepping | None = None,
    reference: Reference | None = None,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
    partial: Callable[[list[Trial], float], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
    **limits: float | None,
) -> RangeRecommendation:
    """Find one K, one D and one time step that meet the tolerance at all these η, and between them, at the least cost.

    Parameters
    ----------
    system : System
    etas : sequence of float
        Excitation frequencies at which settings are tried, at least two.
    tolerance, restitution_tolerance, force_tolerance, located, scheme, reference, threads, progress, cancelled, \
    limits
        As for :func:`.recommend.recommend`; ``steps_max`` holds for the lowest η, where a period has the most steps.
    partial : callable, optional
        As there, with the η at which the steps per period of the front count: the highest that has an error.

    Returns
    -------
    RangeRecommendation

    Raises
    ------
    ValueError
        If a number is out of range, or fewer than two or more than MOST_ETAS frequencies are given.
    Cancelled
        If ``cancelled`` returned true.
    """
    etas = sorted({check_eta(eta) for eta in etas})
    if not 2 <= len(etas) <= MOST_ETAS:
        raise ValueError(
            f"{len(etas)} different eta are outside [2, {MOST_ETAS}]: give the ends of the range and some between"
        )
    scheme = scheme_of(scheme, located)
    asked = {
        "system": system,
        "reference": reference or Reference(),
        "tolerances": Tolerances(tolerance, restitution_tolerance, force_tolerance),
        "located": is_located(scheme),
    }
    limited, progress, partial = Limits(**limits).of(system), progress or no_progress, partial or no_partial
    with ThreadPoolExecutor(thread_count(threads)) as pool:
        search = _RangeSearch(asked, scheme, limited, pool, cancelled)
        search.add(etas)
        if not search.parts:
            reason = "" if len(search.idle) < len(etas) else search.idle[etas[0]]
            reason, left_out = reason or _nowhere_periodic(etas), tuple(search.left_out)
            return RangeRecommendation(
                **asked,
                eta=math.nan,
                met=False,
                best=None,
                ranges={},
                front=(),
                served=(),
                left_out=left_out,
                limit="",
                reason=reason,
                kind="",
                scheme=scheme,
            )
        for begin, end in pairwise(_SHARES):
            search.run(lambda done, b=begin, e=end: progress(b + done * (e - b)), partial)
            if search.best is None or not (missed := search.missed_between()):
                break
            search.add(missed)
        found = search.result()
    progress(1.0)
    return found


def no_partial(front: list[Trial], eta: float) -> None:
    """Ignore what is found so far."""


class _Part(NamedTuple):
    """The trials at one η: of the question with ten digits, which the search sees, and of the question as it is."""

    near: Trials
    exact: Trials


class _RangeSearch:
    """A search over the settings for a list of η that may grow.

    Attributes
    ----------
    best : Trial or None
        What the last search recommends; None if nothing meets the tolerances.
    """

    def __init__(self, asked: dict, scheme, limits: Limits, pool: ThreadPoolExecutor, cancelled):
        self.scheme = scheme
        self._asked = asked
        self.system, self.reference, self.tolerances, self.located = asked.values()
        self.limits, self._pool, self._cancelled = limits, pool, cancelled
        self.parts: list[_Part] = []
        self.left_out: list[float] = []
        self.idle: dict[float, str] = {}  # why K and D have no effect, where they have none
        self._found: dict[float, Steady] = {}
        self._between: list[Trials] = []  # η between the others at which the last setting meets the tolerance

    def add(self, etas: Sequence[float]) -> None:
        """Try settings at these η, too, where the reference repeats itself."""
        self.parts = sorted([*self.parts, *self._new_parts(etas)], key=lambda part: part.exact.eta)

    def run(self, progress: Callable[[float], None], partial: Callable[[list[Trial], float], None]) -> None:
        """Search for the setting that meets the tolerances at all η."""
        trials = RangeTrials([part.near for part in self.parts], self._pool)
        self._trials_of_range = RangeTrials([part.exact for part in self.parts], self._pool)
        tolerance, eta = self.tolerances.displacement, self._trials_of_range.eta
        most = max(math.floor(self.limits.steps_max * trials.parts[0].eta / trials.eta), STEPS_MAX_RANGE[0])
        contact = ContactSearch(trials, self.system, self.limits, tolerance, self.tolerances.force)
        search = StepSearch(contact, tolerance, most, progress, lambda front: partial(front, eta))
        search.run()
        middles = MiddleSearch(trials, replace(self.limits, steps_max=most), tolerance)
        near = all(part.near is part.exact for part in self.parts)
        verify = verification(trials, trials if near else self._trials_of_range, tolerance)
        verified = search.verified(middles, verify)
        founds = [self._found[part.exact.eta] for part in self.parts]
        self.best, self._kind = of_same_kind(founds, verified, self.scheme, self._cancelled)
        self._front, self._ranges = search.front(), middles.ranges

    def missed_between(self) -> list[float]:
        """Return the η halfway between two others at which the setting misses the tolerances."""
        etas = [part.exact.eta for part in self.parts]
        new = self._new_parts([(one + other) / 2 for one, other in pairwise(etas)])
        self._between = [part.exact for part in new]
        return [one.eta for one in self._served(self.best.setting, self._between) if not self._meets(one)]

    def result(self) -> RangeRecommendation:
        """Return what is recommended, with the η that limits it."""
        parts = [part.exact for part in self.parts]
        best = self.best or described(cheapest_near_least(self._front), self._trials_of_range)
        if best is None:
            reason = unmet_tolerance_reason(parts[0], [], math.nan, self.tolerances, self.limits)
            return self._recommendation(False, None, (), (), "", reason)
        parts += self._between if self.best else []
        served = sorted(self._served(best.setting, parts), key=lambda one: one.eta)
        worst = max(served, key=lambda one: (max(one.excess, 1.0), one.robust))
        is_met = self.best is not None and self._meets(worst)
        error, robust = (max(getattr(one, name) for one in served) for name in ("error", "robust"))
        largest = best._replace(error=error, robust=robust, contacts=worst.contacts, excess=worst.excess)
        front = [one for one in self._front if one.robust > self.tolerances.displacement or one.cost > best.cost]
        front = monotone_front(front if is_met else self._front, largest)
        reason = "" if is_met else self._reason(worst, served, parts, best)
        return self._recommendation(is_met, largest, front, served, self._limit(worst, parts, best), reason)

    def _meets(self, served: Served) -> bool:
        return served.robust <= self.tolerances.displacement and served.excess <= 1.0

    def _recommendation(self, met, best, front, served, limit, reason) -> RangeRecommendation:
        highest, left_out = self._trials_of_range.eta, tuple(sorted(self.left_out))
        return RangeRecommendation(
            **self._asked,
            eta=highest,
            met=met,
            best=best,
            ranges=self._ranges[best.setting] if met else {},
            front=tuple(front),
            served=tuple(served),
            left_out=left_out,
            limit=limit,
            reason=reason,
            kind=self._kind if self.best else "",
            scheme=self.scheme,
        )

    def _new_parts(self, etas: Sequence[float]) -> list[_Part]:
        new = [eta for eta in etas if eta not in self._found]
        self._found |= dict(zip(new, self._pool.map(self._steady, new), strict=True))
        reasons = {eta: idle_reason(self._found[eta]) for eta in new if self._found[eta].periodic}
        self.idle |= {eta: reason for eta, reason in reasons.items() if reason}
        self.left_out += [eta for eta in new if eta not in reasons or eta in self.idle]
        return [self._part(self._found[eta]) for eta in etas if eta not in self.left_out]

    def _part(self, found: Steady) -> _Part:
        how = self.scheme, self._pool, self.tolerances, self._cancelled
        exact, question = Trials(found, *how), (self.system, found.response.eta, self.reference)
        rounded = tuple(map(round_numbers, question))
        near = found if rounded == question else steady(*rounded, cancelled=self._cancelled)
        return _Part(exact if near is found or not near.periodic else Trials(near, *how), exact)

    def _steady(self, eta: float) -> Steady:
        return steady(self.system, eta, self.reference, cancelled=self._cancelled)

    def _served(self, setting: NewmarkSetting, parts: Sequence[Trials]) -> list[Served]:
        trials = [part.verify_alone(self._trials_of_range.at(part, setting)) for part in parts]
        return [
            Served(part.eta, one.setting.steps, one.error, one.robust, one.contacts, one.excess)
            for part, one in zip(parts, trials, strict=True)
        ]

    def _limit(self, worst: Served, parts: Sequence[Trials], best: Trial) -> str:
        """Say at which η the robust error is largest, and what makes most of it."""
        method = with_setting(self.scheme, best.setting._replace(steps=worst.steps))
        error, robust = (percent(value, self.tolerances.displacement) for value in (worst.error, worst.robust))
        where = f"the range is limited at eta = {worst.eta:.6g}: an error of {error} there"
        if robust != error:
            where += f", {robust} with half the step or numbers nearby"
        part = next(part for part in parts if part.eta == worst.eta)
        left = error_without_time_step(part.target, method, self._cancelled)
        if left > OTHERWISE * worst.error:
            return f"{where}, which has no parts: without a time step the motion is another one, {percent(left)} off"
        compared = compare(self.system, worst.eta, method, reference=self.reference, cancelled=self._cancelled)
        difference = compared.difference if compared.parts is not None else None
        if difference is not None and difference.parts:
            name = difference.largest
            return f"{where}, the largest part by {difference.name(name)} ({percent(difference.parts[name])})"
        # the steps scatter the motion: no exact split
        name = "time_step" if left < worst.error / 2 else "regularisation"
        return f"{where}, most of it by {PART_NAMES[name]}: {percent(left)} are left without a time step"

    def _reason(self, worst: Served, served: Sequence[Served], parts: Sequence[Trials], best: Trial) -> str:
        """Say where the tolerance is met and where not, and why not at the worst η."""
        part = next(part for part in parts if part.eta == worst.eta)
        joint = joint_damping_error(part.target, self.reference, self._cancelled)
        front = [
            best._replace(
                setting=best.setting._replace(steps=worst.steps),
                excess=worst.excess,
                error=worst.error,
                robust=worst.robust,
            )
        ]
        why = unmet_tolerance_reason(part, front, joint, self.tolerances, self.limits, self._cancelled)
        good = [f"eta = {one.eta:.6g}" for one in served if self._meets(one)]
        where = f"met at {', '.join(good)} only" if good else "met at no eta of the range"
        return f"{where}; at eta = {worst.eta:.6g} {why}"


def _nowhere_periodic(etas: Sequence[float]) -> str:
    return (
        f"the reference repeats itself nowhere from eta = {etas[0]:.6g} to eta = {etas[-1]:.6g}, so no error exists "
        "at each instant: give another range, and compare statistics (motion type, impacts per period, section)"
    )
