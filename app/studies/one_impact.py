"""One impact of the contact that is set: the answer first, then the band over steps and the table. No panel import."""

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.impact_words import schemes
from vibroscope.app.runtime.cache import Cache
from vibroscope.engine import (
    ForceCourse,
    Impact,
    LargestStep,
    MoreauJean,
    OverMotion,
    Reference,
    System,
    TimeStepping,
    WithStep,
    force_courses,
    free_length,
    impact,
    largest_step,
    over_motion,
    simulate,
    stiffness_for,
)
from vibroscope.engine.arguments import Poll
from vibroscope.engine.one_impact.choose import CLOSE_TO_ASKED
from vibroscope.engine.one_impact.instants import OUTLINE

STEPS = np.geomspace(0.5, 100.0, 64)  # in a contact, of the band
_AT_ONCE = 8  # of these, and of the rows of the table, between two pictures
_FOUND, _FOLLOWED, _SEARCHED, _BAND = 0.05, 0.1, 0.3, 0.7  # of the work is done then
_CLOSING = Cache(32)  # speeds of the reference


class Run(NamedTuple):
    """A run of the reference, whose impacts say with which speed the bodies meet."""

    system: System
    eta: float
    reference: Reference
    initial: tuple[float, float, float, float]

    def closing_speeds(self, cancelled: Poll | None = None) -> np.ndarray:
        """Of its impacts, (n,); raises `Cancelled`."""
        free = not self.system.excitation.drives
        how = free_length(self.system, self.eta, self.initial, contacts=1) if free else {}
        how |= {"initial": self.initial, "cancelled": cancelled}
        run = partial(simulate, self.system, self.eta, self.reference, **how)
        return _CLOSING.get_or(self, lambda: run().impacts.closing_speed)


class ImpactQuestion(NamedTuple):
    """A contact, and how it is solved; without dimension."""

    method: TimeStepping
    time_step: float
    mass: float
    restitution: float  # that is asked for
    speed: float | Run  # a run: the median of its impacts
    permitted: float | None = None  # deepest penetration for which K is sought

    def at(self, speed: float) -> Impact:
        """With this closing speed; raises ValueError where there is no such contact."""
        return Impact(self.method, speed, self.mass, self.time_step, restitution=self.restitution)


@dataclass(frozen=True, eq=False)
class PartialImpact:
    """What is known so far.

    Attributes
    ----------
    impact : Impact
    impacts : int
        Of the reference, of which the closing speed is the median; 0 where it is typed, or there are none.
    damping : float
        D with which the contact gives what is asked for, without a step; nan where none does.
    softer : Impact or None
        With the K that gives the permitted penetration without a step, and the restitution that is asked for.
    found : WithStep
        With the step that is set.
    forces : dict of str to ForceCourse
        Of the best touch, the worst and the contact without a step.
    motion : OverMotion or None
        With the closing speeds of all impacts of the reference; None without any.
    searched : bool
        Whether `largest` is known: None then says that no step is small enough.
    band : tuple of (float, WithStep)
        Over steps in a contact, the first of `STEPS`.
    schemes : tuple of (Impact or MoreauJean, WithStep)
        Of integrators and contact statuses, and of an impact law.
    share : float
    """

    question: ImpactQuestion
    impact: Impact
    impacts: int
    damping: float
    softer: Impact | None
    found: WithStep
    forces: dict[str, ForceCourse] = field(default_factory=dict)
    motion: OverMotion | None = None
    largest: LargestStep | None = None
    searched: bool = False
    band: tuple[tuple[float, WithStep], ...] = ()
    schemes: tuple[tuple[Impact | MoreauJean, WithStep], ...] = ()
    share: float = _FOUND

    def instants(self) -> dict[str, np.ndarray]:
        """The restitution over the instant of touch: piece after piece, with nan between two."""
        gap = np.full((len(self.found.instant), 1), np.nan)
        columns = {"instant": self.found.instant, "restitution": self.found.restitutions}
        return {name: np.hstack([values, gap]).ravel() for name, values in columns.items()}

    def over_steps(self) -> dict[str, np.ndarray]:
        """The restitution over steps in a contact, and shares of the touches."""
        steps, found = zip(*self.band, strict=True) if self.band else ((), ())
        return {"steps_per_contact": np.array(steps)} | columns_of(found)

    def of_schemes(self) -> dict[str, np.ndarray]:
        """The same of integrators and contact statuses."""
        names = np.array([one.scheme for one, _ in self.schemes]).reshape(-1, 2)
        return {"integrator": names[:, 0], "status": names[:, 1]} | columns_of([found for _, found in self.schemes])

    def over_time(self) -> dict[str, dict[str, np.ndarray]]:
        """The force over time of each of `forces`."""
        return {name: {"tau": each.time, "force": each.force} for name, each in self.forces.items()}

    def data(self) -> dict[str, object]:
        """The numbers so far, without dimension."""
        one, largest = self.impact, self.largest
        return {
            "mass": one.mass,
            "closing_speed": one.speed,
            "time_step": one.time_step,
            "steps_per_contact": one.steps_per_contact,
            "restitution_asked": one.restitution,
            "without_step": one.without_step._asdict(),
            "restitution": self.found.restitution._asdict(),
            "largest_step": np.nan if largest is None else largest.step,
            "over_instants": self.instants(),
            "force_over_time": self.over_time(),
            "over_steps": self.over_steps(),
            "schemes": self.of_schemes(),
        }


def columns_of(found: list[WithStep] | tuple[WithStep, ...]) -> dict[str, np.ndarray]:
    """Least, mean and greatest restitution, and the shares of touches without a solution and blown up."""
    spans = {
        f"restitution_{n}": [getattr(each.restitution, n) for each in found] for n in ("least", "mean", "greatest")
    }
    shares = {n: [getattr(each, n) for each in found] for n in ("without_solution", "two_solutions", "blown_up")}
    return {name: np.array(column) for name, column in (spans | shares).items()}


def grow_impact(question: ImpactQuestion, last: PartialImpact | None, cancelled: Poll) -> Iterator[PartialImpact]:
    """The answer, the forces and all closing speeds, the largest step, the band, the table; ends if cancelled.

    Raises as `_answer`.
    """
    result = last or _answer(question, cancelled)
    yield result
    if not result.forces:
        forces = force_courses(result.impact, question.restitution, result.found)
        result = replace(result, forces=forces, motion=_over_motion(result, cancelled), share=_FOLLOWED)
        yield result
    if not result.searched:
        largest = largest_step(result.impact, CLOSE_TO_ASKED, question.restitution, cancelled)
        result = replace(result, largest=largest, searched=True, share=_SEARCHED)
        yield result
    for steps in STEPS[len(result.band) :]:
        if cancelled():
            return
        more = float(steps), impact(result.impact.with_steps_per_contact(steps), OUTLINE)
        result = replace(result, band=(*result.band, more))
        if (known := len(result.band)) % _AT_ONCE == 0:
            result = replace(result, share=_SEARCHED + (_BAND - _SEARCHED) * known / len(STEPS))
            yield result
    if result.share < 1:
        rows = []
        for row in schemes(result.impact, question.restitution):
            rows.append(row)
            if cancelled():
                return
            if len(rows) % _AT_ONCE == 0:
                yield replace(result, schemes=tuple(rows))
        yield replace(result, schemes=tuple(rows), share=1.0)


def _answer(question: ImpactQuestion, cancelled: Poll) -> PartialImpact:
    speed, count = question.speed, 0
    if isinstance(speed, Run):
        speeds = speed.closing_speeds(cancelled)
        speed, count = (float(np.median(speeds)), len(speeds)) if len(speeds) else (1.0, 0)
    one = question.at(speed)
    _ = one.without_step  # is kept with the question: the page, which shows it, has no time for it
    damping, softer = math.nan, None
    with suppress(ValueError):  # no damper of this law gives what is asked for, or no K what is permitted
        asked = one.with_restitution(one.restitution)
        damping = asked.method.damping
        sought = one if one.method.damping is None else asked
        softer = question.permitted and stiffness_for(sought, penetration=question.permitted)
    return PartialImpact(question, one, count, damping, softer, impact(one))


def _over_motion(result: PartialImpact, cancelled: Poll) -> OverMotion | None:
    if not result.impacts:
        return None
    with suppress(ValueError):  # at one of the speeds the constant force or the law leaves no contact
        return over_motion(result.impact, result.question.speed.closing_speeds(cancelled))
    return None
