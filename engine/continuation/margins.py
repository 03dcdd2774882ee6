"""What keeps a solution of the equations an orbit with its sequence of events: margins.

Each is smooth along a curve of orbits with one sequence of events, and positive as long as the solution is an orbit
with this sequence. At its zero the sequence changes.
"""

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from vibroscope.engine.continuation.kinds import GRAZING, OPENS, STICKING_BEGINS, STICKING_ENDS
from vibroscope.engine.continuation.orbit import Orbit, at_stop_of, short_phase
from vibroscope.engine.drivers.orbit import Evaluation, event, numbers_of, steps
from vibroscope.engine.methods import ExactPenalty, Reference

if TYPE_CHECKING:
    from vibroscope.engine.continuation.curve import CurvePoint

LATER_SUM = "chatter summed later"  # no point of a branch: the orbit is the same
STAYS_SHUT = "contact no longer opens"  # OPENS from the other side
_MORE = {
    (GRAZING, True): (event.IMPACT,),
    (GRAZING, False): (event.TOUCH, event.PART),
    (OPENS, True): (event.RELEASE, event.STICK),
    (OPENS, False): (event.PART, event.TOUCH),
}  # events at the zero of a minimum, of the reference and of the exact penalty


class Margin(NamedTuple):
    """A condition on an orbit, met while ``value`` > 0."""

    kind: str
    event: int  # of the sequence; len(kinds) is the end of the cycle
    inside: bool  # whether it concerns the phase that ends with the event, not the event
    column: int  # of the facts of that event, or what steps adds to them; that of a minimum is followed by its instant
    value: float = np.nan
    more: tuple[int, ...] = ()  # the events that follow each other at its zero

    def point_at(self, orbit: Orbit, method: Reference | ExactPenalty) -> str:
        """The kind of the point at its zero, with the orbit there: the same from both sides.

        On one side there is a phase more, a contact or a flight. From there the point is where that has no length, from
        the other side where a minimum is zero.
        """
        grazes = self.kind == GRAZING and not self.inside and not method.rigid
        flight_vanishes = grazes and orbit.at_any_stop[short_phase(orbit, self.event)[0]] == event.PART
        return OPENS if self.kind == STAYS_SHUT or flight_vanishes else self.kind

    def stop(self, orbit: Orbit) -> int:
        """The stop that it is about, 1 or 2."""
        return 1 + (self.more[0] if self.inside else orbit.kinds[self.event]) // event.SECOND


def margins(orbit: Orbit, evaluation: Evaluation, method: Reference | ExactPenalty) -> list[Margin]:
    """All margins of an orbit, in a fixed order for each sequence of events."""
    conditions, columns = _conditions_of(orbit, method)
    values = steps.margin_values(*_of_values(columns, orbit, evaluation, method)).tolist()
    return [margin._replace(value=value) for margin, value in zip(conditions, values, strict=True)]


def least_margin(orbit: Orbit, evaluation: Evaluation, method: Reference | ExactPenalty) -> float:
    """The smallest margin of an orbit."""
    return steps.least_of_margins(*_of_values(_conditions_of(orbit, method)[1], orbit, evaluation, method))


def parts_more_than_pressed(k: int, point: "CurvePoint") -> float:
    """By how much the parting speed of impact k less ε exceeds the force that parts the bodies."""
    parting, force = point.evaluation.facts[k, [event.PARTING, event.FORCE]]
    return float(parting - point.method.threshold + force)


def impacts_that_may_stick(before: "CurvePoint", after: "CurvePoint") -> Iterator[int]:
    """The impacts that may stick between two neighbours though they do at neither, for one reason each."""
    k, threshold, kinds = -1, before.method.threshold, numbers_of(before.orbit.kinds)
    while threshold > 0:
        k = steps.impact_that_may_stick(kinds, before.evaluation.facts, after.evaluation.facts, threshold, k + 1)
        if k < 0:
            return
        yield k


def _of_values(conditions: np.ndarray, orbit: Orbit, evaluation: Evaluation, method: Reference | ExactPenalty) -> tuple:
    """What the values of margins are made of."""
    return evaluation.facts, orbit.instants, float(method.threshold), conditions


def _conditions_of(orbit: Orbit, method: Reference | ExactPenalty) -> tuple[tuple[Margin, ...], np.ndarray]:
    rigid = method.rigid
    return _conditions(orbit.kinds, orbit.first, rigid, rigid and method.threshold > 0)


@lru_cache(maxsize=1024)
def _conditions(kinds: tuple[int, ...], first: int, rigid: bool, sticks: bool) -> tuple[tuple[Margin, ...], np.ndarray]:
    """The margins of a sequence of events, without their values, and where these stand: events and columns, (2, n)."""
    found = tuple(_margins(kinds, first, rigid, sticks))
    return found, np.array([[margin.event for margin in found], [margin.column for margin in found]])


def _margins(kinds: tuple[int, ...], first: int, rigid: bool, sticks: bool) -> Iterator[Margin]:
    touching, before = first > 0, kinds[-1] if kinds else event.SECOND * (first == 2)  # that the phase begins with
    for k, kind in enumerate(kinds):
        yield from _within(k, touching, before, rigid)
        what = kind % event.SECOND
        if k and before == kind - what + event.RELEASE:  # its closing speed is of second order
            yield Margin(STAYS_SHUT, k, False, steps.LENGTH)
        elif what in (event.IMPACT, event.STICK, event.CHATTER, event.TOUCH):
            yield Margin(GRAZING, k, False, event.CLOSING)
        if what == event.IMPACT and sticks:
            yield Margin(STICKING_BEGINS, k, False, steps.BEGINS)
        if what == event.STICK:
            yield Margin(STICKING_ENDS, k, False, steps.ENDS)
        if what == event.CHATTER:
            yield Margin(STICKING_ENDS, k, False, event.FORCE)
            yield Margin(LATER_SUM, k, False, event.ROOM)
        if what == event.PART:
            yield Margin(GRAZING, k, False, event.PARTING)
        touching, before = kind in event.JOINS, kind
    yield from _within(len(kinds), touching, before, rigid)


def _within(k: int, touching: bool, before: int, rigid: bool) -> Iterator[Margin]:
    """The margins of a phase that begins with an event ``before``: of what is watched, and of the other stop's gap."""
    within = OPENS if touching else GRAZING
    yield Margin(within, k, True, event.LOWEST, more=at_stop_of(before, _MORE[within, rigid]))
    if not touching:
        other = (before + event.SECOND) % (2 * event.SECOND)
        yield Margin(GRAZING, k, True, event.ACROSS, more=at_stop_of(other, _MORE[GRAZING, rigid]))
