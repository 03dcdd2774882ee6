"""What keeps a solution of the equations an orbit, and where orbits bifurcate: functions with zeros.

Each is smooth along a curve of orbits with one sequence of events. A *margin* is positive as long as the solution is an
orbit with this sequence; at its zero the sequence changes. An *indicator* changes its sign at a bifurcation.
"""

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..drivers.orbit import (
    CHATTER,
    CLOSING,
    FORCE,
    IMPACT,
    LOWEST,
    PART,
    PARTING,
    RELEASE,
    ROOM,
    STICK,
    TOUCH,
    Evaluation,
    numbers_of,
)
from ..drivers.orbit_steps import (
    BEGINS,
    ENDS,
    LENGTH,
    branch_point_indicator,
    doubling_indicator,
    impact_that_may_stick,
    indicators_of,
    least_of_margins,
    margin_values,
    neimark_sacker_indicator,
)
from ..methods import ExactPenalty, Reference
from .curve import CurvePoint
from .orbit import Orbit, short_phase

# kinds of points, in the order of their numbers in stores
FOLD, DOUBLING, NEIMARK_SACKER, BRANCH_POINT = "fold", "period doubling", "Neimark-Sacker", "branch point"
GRAZING = "grazing"
STICKING_BEGINS, STICKING_ENDS = "sticking begins", "sticking ends"
CHATTER_COMPLETES = "chatter completes"
OPENS = "contact opens"
POINT_KINDS = (
    FOLD,
    DOUBLING,
    NEIMARK_SACKER,
    BRANCH_POINT,
    GRAZING,
    STICKING_BEGINS,
    STICKING_ENDS,
    OPENS,
    CHATTER_COMPLETES,
)
LATER_SUM = "chatter summed later"  # no point of a branch: the orbit is the same
STAYS_SHUT = "contact no longer opens"  # OPENS from the other side
BIFURCATIONS = (FOLD, DOUBLING, BRANCH_POINT, NEIMARK_SACKER)
_MORE = {
    (GRAZING, True): (IMPACT,),
    (GRAZING, False): (TOUCH, PART),
    (OPENS, True): (RELEASE, STICK),
    (OPENS, False): (PART, TOUCH),
}  # events at the zero of a minimum, of the reference and of the exact penalty


class Margin(NamedTuple):
    """A condition on an orbit, met while ``value`` > 0."""

    kind: str
    event: int  # of the sequence; len(kinds) is the end of the cycle
    inside: bool  # whether it concerns the phase that ends with the event, not the event
    value: float = np.nan
    more: tuple[int, ...] = ()  # the events that follow each other at its zero

    def point_at(self, orbit: Orbit, method: Reference | ExactPenalty) -> str:
        """The kind of the point at its zero, with the orbit there: the same from both sides.

        On one side there is a phase more, a contact or a flight. From there the point is where that has no length, from
        the other side where a minimum is zero.
        """
        grazes = self.kind == GRAZING and not self.inside and not method.rigid
        flight_vanishes = grazes and orbit.kinds[short_phase(orbit, self.event)[0]] == PART
        return OPENS if self.kind == STAYS_SHUT or flight_vanishes else self.kind


def margins(orbit: Orbit, evaluation: Evaluation, method: Reference | ExactPenalty) -> list[Margin]:
    """All margins of an orbit, in a fixed order for each sequence of events."""
    conditions, columns = _conditions_of(orbit, method)
    values = margin_values(*_of_values(columns, orbit, evaluation, method)).tolist()
    return [margin._replace(value=value) for margin, value in zip(conditions, values, strict=True)]


def least_margin(orbit: Orbit, evaluation: Evaluation, method: Reference | ExactPenalty) -> float:
    """The smallest margin of an orbit."""
    return least_of_margins(*_of_values(_conditions_of(orbit, method)[1], orbit, evaluation, method))


def reasons_not_to_stick(evaluation: Evaluation, method: Reference | ExactPenalty) -> np.ndarray:
    """Why impacts do not stick, where one of two is positive: parting speed − ε, force that parts them, (m, 2)."""
    facts = evaluation.facts[:-1]
    return np.column_stack([facts[:, PARTING] - method.threshold, -facts[:, FORCE]])


def impacts_that_may_stick(
    orbit: Orbit, before: Evaluation, after: Evaluation, method: Reference | ExactPenalty
) -> Iterator[int]:
    """The impacts that may stick between two neighbours though they do at neither, for one reason each."""
    k, threshold = -1, method.threshold
    while threshold > 0:
        k = impact_that_may_stick(numbers_of(orbit.kinds), before.facts, after.facts, threshold, k + 1)
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
def _conditions(
    kinds: tuple[int, ...], first: bool, rigid: bool, sticks: bool
) -> tuple[tuple[Margin, ...], np.ndarray]:
    """The margins of a sequence of events, without their values, and where these stand: events and columns, (2, n)."""
    found = list(_margins(kinds, first, rigid, sticks))
    return tuple(margin for margin, _ in found), np.array([[margin.event, column] for margin, column in found]).T


def _margins(kinds: tuple[int, ...], first: bool, rigid: bool, sticks: bool) -> Iterator[tuple[Margin, int]]:
    touching = first
    for k, kind in enumerate((*kinds, None)):
        within = OPENS if touching else GRAZING
        yield Margin(within, k, True, more=_MORE[within, rigid]), LOWEST
        if k and kind is not None and kinds[k - 1] == RELEASE:  # its closing speed is of second order
            yield Margin(STAYS_SHUT, k, False), LENGTH
        elif kind in (IMPACT, STICK, CHATTER, TOUCH):
            yield Margin(GRAZING, k, False), CLOSING
        if kind == IMPACT and sticks:
            yield Margin(STICKING_BEGINS, k, False), BEGINS
        if kind == STICK:
            yield Margin(STICKING_ENDS, k, False), ENDS
        if kind == CHATTER:
            yield Margin(STICKING_ENDS, k, False), FORCE
            yield Margin(LATER_SUM, k, False), ROOM
        if kind == PART:
            yield Margin(GRAZING, k, False), PARTING
        touching = kind in (STICK, CHATTER, TOUCH)


def indicator(kind: str, point: CurvePoint) -> float:
    """What changes its sign at a point of one of the kinds BIFURCATIONS.

    Determinants of the whole Jacobian instead of that of the Poincaré map, which is infinite at a grazing impact.
    """
    if kind == FOLD:
        return float(point.tangent[-1])
    jacobian = point.evaluation.jacobian
    if kind == DOUBLING:
        return doubling_indicator(jacobian)
    if kind == BRANCH_POINT:
        return branch_point_indicator(jacobian, point.slope, point.tangent)
    return neimark_sacker_indicator(jacobian)


def indicators(point: CurvePoint) -> np.ndarray:
    """All of them, (4,)."""
    return indicators_of(point.evaluation.jacobian, point.slope, point.tangent)
