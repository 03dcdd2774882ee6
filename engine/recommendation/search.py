"""Recommend K, D and the time step: the setting that meets the tolerances at the least cost, at one η or at several.

The error is that of :class:`..divergence.error.Target`: the rms difference of the displacements from the reference,
relative to it, in phase with the excitation. A setting must also deliver the restitution of the system, and the peak
force that it would have without a time step (:mod:`.contacts`). :mod:`.step_search` searches the least number of steps
per period n, :mod:`.contact_search` the best K and D for each n, and from the least n the middle of where the
tolerances are met. No setting is recommended by a formula: every one that is returned was run from rest by Newmark's
method, and so were its neighbours, so that it does not meet the tolerances by chance (:mod:`.trials`). With several η
each setting is tried at all of them, and the one with the largest error counts (:mod:`.trials`). What meets the
tolerances there is tried between them, too: an η that misses them joins the others, and the search begins again.

The search sees the question with ten digits (`.question.round_numbers`), so that a further one does not change the
answer; the answer is verified for the question as it is.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import islice, pairwise
from typing import NamedTuple

from vibroscope.engine.arguments import Poll
from vibroscope.engine.divergence.compare import ComparisonQuestion, compare
from vibroscope.engine.divergence.parts import PART_NAMES
from vibroscope.engine.drivers.threads import thread_count
from vibroscope.engine.facts import ETA, Statement, equation, joined, stated
from vibroscope.engine.methods import TimeStepping
from vibroscope.engine.motions.description import describe
from vibroscope.engine.motions.motion import motion
from vibroscope.engine.motions.steady import Steady, steady
from vibroscope.engine.motions.words import difference_in_kind
from vibroscope.engine.one_impact.of_system import ContactAlone, contact_alone
from vibroscope.engine.recommendation.contact_search import ContactSearch, MiddleSearch, monotone_front
from vibroscope.engine.recommendation.question import (
    STEPS_MAX_RANGE,
    Recommendation,
    Served,
    SettingQuestion,
    round_numbers,
)
from vibroscope.engine.recommendation.reasons import (
    aperiodic_reference_reason,
    error_without_time_step,
    idle_reason,
    joint_damping_error,
    unmet_tolerance_reason,
)
from vibroscope.engine.recommendation.step_search import StepSearch
from vibroscope.engine.recommendation.tolerances import ENOUGH, OTHERWISE
from vibroscope.engine.recommendation.trials import (
    NewmarkSetting,
    RangeTrials,
    Trial,
    Trials,
    steps_at,
    verification,
    with_setting,
)
from vibroscope.engine.simulate import simulate
from vibroscope.engine.wording import percent

KINDS = 3  # settings whose kind of motion is looked at: evidence for one takes some tenths of a second
# Of the progress, before each search of a range and after the last. There are three at most: after each but the last,
# an η between the others that misses the tolerances joins them.
_SHARES = (0.05, 0.6, 0.8, 0.95)


class _Part(NamedTuple):
    """The trials at one η: of the question with ten digits, which the search sees, and of the question as it is."""

    near: Trials
    exact: Trials


class Search:
    """A search over the settings for a list of η that may grow.

    Parameters
    ----------
    question : SettingQuestion
    pool : ThreadPoolExecutor
        Makes the runs.
    cancelled : callable, optional
    """

    def __init__(self, question: SettingQuestion, pool: ThreadPoolExecutor, cancelled: Poll | None):
        self.question = question
        self._pool, self._cancelled = pool, cancelled
        self._parts: list[_Part] = []
        self._left_out: list[float] = []
        self._idle: dict[float, str] = {}  # why K and D have no effect, where they have none
        self._found: dict[float, Steady] = {}
        self._between: list[Trials] = []  # η between the others at which the last setting meets the tolerances
        self._best: Trial | None = None  # what the last search recommends; None if nothing meets the tolerances

    def run(self, progress: Callable[[float], None], partial: Callable[[list[Trial], float], None]) -> Recommendation:
        """Search until what is found holds between the η, too; see :func:`.search.recommend`."""
        self._add(self.question.etas)
        if not self._parts:
            return self._nothing()
        for begin, end in pairwise(_SHARES if self.question.is_range else (0.0, 1.0)):
            self._search(lambda done, b=begin, e=end: progress(b + done * (e - b)), partial)
            if self._best is None or not (missed := self._missed_between()):
                break
            self._add(missed)
        return self._result()

    # -- the η -------------------------------------------------------------------------

    def _add(self, etas: Sequence[float]) -> None:
        """Try settings at these η, too, where the reference repeats itself."""
        self._parts = sorted([*self._parts, *self._new_parts(etas)], key=lambda part: part.exact.eta)

    def _new_parts(self, etas: Sequence[float]) -> list[_Part]:
        new = [eta for eta in etas if eta not in self._found]
        self._found |= dict(zip(new, self._pool.map(self._steady, new), strict=True))
        reasons = {eta: idle_reason(self._found[eta]) for eta in new if self._found[eta].periodic}
        self._idle |= {eta: reason for eta, reason in reasons.items() if reason}
        self._left_out += [eta for eta in new if eta not in reasons or eta in self._idle]
        return [self._part(self._found[eta]) for eta in etas if eta not in self._left_out]

    def _part(self, found: Steady) -> _Part:
        asked = self.question
        how = asked.scheme, self._pool, asked.tolerances, self._cancelled
        exact, own = Trials(found, *how), (asked.system, found.response.eta, asked.reference)
        rounded = tuple(map(round_numbers, own))
        near = found if rounded == own else steady(*rounded, cancelled=self._cancelled)
        return _Part(exact if near is found or not near.periodic else Trials(near, *how), exact)

    def _steady(self, eta: float) -> Steady:
        return steady(self.question.system, eta, self.question.reference, cancelled=self._cancelled)

    def _missed_between(self) -> list[float]:
        """Return the η halfway between two others at which the setting misses the tolerances."""
        etas = [part.exact.eta for part in self._parts]
        new = self._new_parts([(one + other) / 2 for one, other in pairwise(etas)])
        self._between = [part.exact for part in new]
        return [one.eta for one in self._served(self._best.setting, self._between) if not self._meets(one)]

    # -- the search --------------------------------------------------------------------

    def _search(self, progress: Callable[[float], None], partial: Callable[[list[Trial], float], None]) -> None:
        """Search for the setting that meets the tolerances at all η."""
        trials = RangeTrials([part.near for part in self._parts], self._pool)
        self._trials = RangeTrials([part.exact for part in self._parts], self._pool)
        asked, tolerance, eta = self.question, self.question.tolerances.displacement, self._trials.eta
        most = max(math.floor(asked.limits.steps_max * trials.parts[0].eta / trials.eta), STEPS_MAX_RANGE[0])
        contact = ContactSearch(trials, asked.system, asked.limits, tolerance, asked.tolerances.force)
        search = StepSearch(contact, tolerance, most, progress, lambda front: partial(front, eta))
        search.run()
        middles = MiddleSearch(trials, replace(asked.limits, steps_max=most), tolerance)
        near = all(part.near is part.exact for part in self._parts)
        verified = search.verified(middles, verification(trials, trials if near else self._trials, tolerance))
        founds = [self._found[part.exact.eta] for part in self._parts]
        self._best, self._kind = of_same_kind(founds, verified, asked.scheme, self._cancelled)
        self._front, self._ranges = search.front(), middles.ranges

    # -- the result --------------------------------------------------------------------

    def _result(self) -> Recommendation:
        """What is recommended, with the η that limits it."""
        parts, tolerance = [part.exact for part in self._parts], self.question.tolerances.displacement
        best = self._best or self._described(cheapest_near_least(self._front))
        if best is None:
            reason = unmet_tolerance_reason(parts[0], [], math.nan, self.question, self._cancelled)
            return self._recommendation(met=False, ranges={}, reason=reason)
        parts += self._between if self._best else []
        served = sorted(self._served(best.setting, parts), key=lambda one: one.eta)
        worst = max(served, key=lambda one: (max(one.excess, 1.0), one.robust))
        is_met = self._best is not None and self._meets(worst)
        error, robust = (
            max(getattr(best, name), *(getattr(one, name) for one in served)) for name in ("error", "robust")
        )
        largest = best._replace(error=error, robust=robust, contacts=worst.contacts, excess=worst.excess)
        front = [one for one in self._front if one.robust > tolerance or one.cost > best.cost]
        part = next(part for part in parts if part.eta == worst.eta)
        joint_damping = joint_damping_error(part.target, self.question.reference, self._cancelled)
        return self._recommendation(
            met=is_met,
            best=largest,
            ranges=self._ranges[best.setting] if is_met else {},
            front=tuple(monotone_front(front if is_met else self._front, largest)),
            served=tuple(served),
            joint_damping=joint_damping,
            alone=self._alone(best.setting),
            limit=self._limit(worst, part, best) if self.question.is_range else "",
            reason="" if is_met else self._reason(worst, served, part, joint_damping, best),
            kind=self._kind if self._best else "",
        )

    def _nothing(self) -> Recommendation:
        """The result where no error exists at any η."""
        etas = self.question.etas
        if len(self._idle) == len(etas):
            reason = self._idle[etas[0]]
        elif self.question.is_range:
            reason = _nowhere_periodic(etas)
        else:
            reason = aperiodic_reference_reason(self._found[etas[0]])
        return self._recommendation(met=False, ranges={}, reason=reason)

    def _recommendation(self, **found) -> Recommendation:
        eta = max((part.exact.eta for part in self._parts), default=self.question.etas[0])
        return Recommendation(question=self.question, eta=eta, left_out=tuple(sorted(self._left_out)), **found)

    def _described(self, trial: Trial | None) -> Trial | None:
        """A trial that does not meet the tolerances with what a run from rest says of its contacts."""
        if trial is None:
            return None
        verified = self._trials.verify_alone(trial.setting)
        robust = max(trial.robust, verified.error)
        return trial._replace(error=verified.error, contacts=verified.contacts, excess=verified.excess, robust=robust)

    def _meets(self, served: Served) -> bool:
        return served.robust <= self.question.tolerances.displacement and served.excess <= 1.0

    def _served(self, setting: NewmarkSetting, parts: Sequence[Trials]) -> list[Served]:
        trials = [part.verify_alone(self._trials.at(part, setting)) for part in parts]
        return [
            Served(part.eta, one.setting.steps, one.error, one.robust, one.contacts, one.excess)
            for part, one in zip(parts, trials, strict=True)
        ]

    def _alone(self, setting: NewmarkSetting) -> ContactAlone | None:
        """What a contact alone gives with a setting at the η to which its steps belong."""
        part, method = self._parts[-1].exact, with_setting(self.question.scheme, setting)
        return contact_alone(self.question.system, part.eta, method, part.closing_speed)

    def _limit(self, worst: Served, part: Trials, best: Trial) -> Statement:
        """Say at which η the robust error is largest, and what makes most of it."""
        asked = self.question
        method = with_setting(asked.scheme, best.setting._replace(steps=worst.steps))
        error, robust = (percent(value, asked.tolerances.displacement) for value in (worst.error, worst.robust))
        where = stated("the range is limited at {}: an error of {} there", equation("eta", worst.eta), error)
        if robust != error:
            where += f", {robust} with half the step or numbers nearby"
        left = error_without_time_step(part.target, method, self._cancelled)
        if left > OTHERWISE * worst.error:
            return f"{where}, which has no parts: without a time step the motion is another one, {percent(left)} off"
        compared = compare(
            ComparisonQuestion(asked.system, worst.eta, method, reference=asked.reference), cancelled=self._cancelled
        )
        difference = compared.difference if compared.parts is not None else None
        if difference is not None and difference.parts:
            name = difference.largest
            part = percent(difference.parts[name])
            return stated("{}, the largest part by {} ({})", where, difference.name(name), part)
        # the steps scatter the motion: no exact split
        name = "time_step" if left < worst.error / 2 else "regularisation"
        return where + f", most of it by {PART_NAMES[name]}: {percent(left)} are left without a time step"

    def _reason(self, worst: Served, served: Sequence[Served], part: Trials, joint_damping: float, best: Trial) -> str:
        """Say where the tolerances are met and where not, and why not at the worst η."""
        if not self.question.is_range:
            return unmet_tolerance_reason(part, self._front, joint_damping, self.question, self._cancelled)
        setting = best.setting._replace(steps=worst.steps)
        front = [best._replace(setting=setting, excess=worst.excess, error=worst.error, robust=worst.robust)]
        why = unmet_tolerance_reason(part, front, joint_damping, self.question, self._cancelled)
        good = [equation("eta", one.eta) for one in served if self._meets(one)]
        where = stated("met at {} only", joined(", ", good)) if good else stated("met at no {} of the range", ETA)
        return stated("{}; at {} {}", where, equation("eta", worst.eta), why)


def of_same_kind(
    found: Sequence[Steady], trials: Iterable[Trial], scheme: TimeStepping, cancelled: Poll | None
) -> tuple[Trial | None, str]:
    """Return the first of a few trials whose motion is of the reference's kind, and ""; else the first, and why not.

    With several motions of the reference, the setting of a trial holds at the highest η, and is that of a range. None
    if there is no trial.
    """
    highest, first, kinds = max(one.response.eta for one in found), None, []
    for trial in islice(trials, KINDS):
        first, setting = first or trial, trial.setting
        methods = (
            with_setting(scheme, setting._replace(steps=steps_at(one.response.eta, highest, setting.steps)))
            for one in found
        )
        kinds.append([_kind(one, method, cancelled) for one, method in zip(found, methods, strict=True)])
        if not any(kinds[-1]):
            return trial, ""
    if first is None:
        return None, ""
    different = [(one.response.eta, kind) for one, kind in zip(found, kinds[0], strict=True) if kind]
    if len(found) == 1:
        return first, joined("; ", (kind for _, kind in different))
    return first, joined("; ", (stated("at {} {}", equation("eta", eta, 4), kind) for eta, kind in different))


def _kind(found: Steady, method: TimeStepping, cancelled: Poll | None) -> str:
    """How the motion of a setting differs from the reference's in kind, in words; empty if it does not."""
    reference, run = describe(found.response, found.period), found.response
    penalty = describe(simulate(run.system, run.eta, method, cancelled=cancelled))
    if penalty.near_period != reference.near_period:  # a time step may scatter the section
        penalty = motion(run.system, run.eta, method, cancelled=cancelled)
    return difference_in_kind(reference, penalty)


def cheapest_near_least(front: list[Trial]) -> Trial | None:
    """Return the cheapest trial whose robust error is hardly above the least."""
    least = min((trial.robust for trial in front), default=math.inf)
    return next((trial for trial in front if trial.robust <= ENOUGH * least), None)


def _nowhere_periodic(etas: Sequence[float]) -> Statement:
    return stated(
        "the reference repeats itself nowhere from {} to {}, so no error exists at each instant: give another range, "
        "and compare statistics (motion type, impacts per period, section)",
        equation("eta", etas[0]),
        equation("eta", etas[-1]),
    )


def recommend(
    question: SettingQuestion,
    *,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
    partial: Callable[[list[Trial], float], None] | None = None,
    cancelled: Poll | None = None,
) -> Recommendation:
    """Find K, D and steps per period that meet the tolerances at the least cost, at all η of the question and between.

    Parameters
    ----------
    question : SettingQuestion
    threads : int, optional
        To try settings side by side; by default one for each core.
    progress : callable, optional
        Called in the calling thread with the fraction that is done at least, 0 to 1.
    partial : callable, optional
        Called in the calling thread with the front of the settings found so far, whenever some were tried with another
        n, and the η to which their steps per period belong. Those that meet the tolerance are confirmed.
    cancelled : callable, optional
        Polled many times a second, by several threads; when it returns true the search is cancelled.

    Returns
    -------
    Recommendation
        The same for the same question, however many threads there are.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Limits, SettingQuestion, System, Tolerances, recommend
    >>> held = Limits(stiffness=12000, steps_max=4000)
    >>> found = recommend(SettingQuestion(System(), 2.76, Tolerances(0.2), held))
    >>> found.met, found.best.setting.stiffness, found.best.robust <= 0.2
    (True, 12000.0, True)
    """
    progress = progress or _ignore
    with ThreadPoolExecutor(thread_count(threads)) as pool:
        found = Search(question, pool, cancelled).run(progress, partial or _ignore)
    progress(1.0)
    return found


def design_curve(
    question: SettingQuestion, etas: Sequence[float], *, progress: Callable[[float], None] | None = None, **how: object
) -> list[Recommendation]:
    """Return a recommendation for each of several η alone: how K, D and n change with η.

    Parameters
    ----------
    question : SettingQuestion
        Its own η have no effect.
    etas : sequence of float
        Excitation frequencies η = Ω/ω₁.
    progress : callable, optional
        Called with the fraction that is done at least, 0 to 1.
    **how
        Those of :func:`recommend`, whose exceptions are raised, too.
    """
    return _one_after_the_other([replace(question, etas=eta) for eta in etas], progress, how)


def recommend_schemes(
    question: SettingQuestion,
    schemes: Sequence[TimeStepping],
    *,
    progress: Callable[[float], None] | None = None,
    **how: object,
) -> list[Recommendation]:
    """Return a recommendation for each of several schemes, such as the integrators of a code, best first.

    First come those that meet the tolerance, by solves per period (:attr:`Recommendation.solves`), and where these are
    equal by the error that they keep to; then the others by that error.

    Parameters
    ----------
    question : SettingQuestion
        Its scheme has no effect.
    schemes : sequence of Newmark or TimeStepping
        Their K, D and n have no effect.
    **how
        Those of :func:`recommend`.

    Raises
    ------
    ValueError
        If there is no scheme.
    Cancelled
        If ``cancelled`` returned true.
    """
    if not schemes:
        raise ValueError("schemes is empty: give the methods to search over")
    return sorted(_one_after_the_other([replace(question, scheme=each) for each in schemes], progress, how), key=_rank)


def _one_after_the_other(questions: list[SettingQuestion], progress, how: dict) -> list[Recommendation]:
    progress = progress or _ignore
    return [
        recommend(question, progress=lambda fraction, i=i: progress((i + fraction) / len(questions)), **how)
        for i, question in enumerate(questions)
    ]


def _rank(found: Recommendation) -> tuple[float, ...]:
    """The sort key of recommendations."""
    if found.best is None:
        return (2.0,)
    robust = found.best.robust
    return (0.0, found.solves, robust) if found.met else (1.0, robust)


def _ignore(*_: object) -> None:
    """Nobody wants the progress, or what is found so far."""
