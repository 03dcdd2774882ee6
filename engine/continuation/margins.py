"""What keeps a solution of the equations an orbit, and where orbits bifurcate: functions with zeros.

Each is smooth along a curve of orbits with one sequence of events. A *margin* is positive as long as the solution is an
orbit with this sequence; at its zero the sequence changes. An *indicator* changes its sign at a bifurcation.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..drivers.law_driven import needs_law
from ..drivers.orbit import (
    CHATTER,
    CLOSING,
    DAMP,
    DEPTH,
    FORCE,
    IMPACT,
    LOAD,
    LOWEST,
    PART,
    PARTING,
    RELEASE,
    STICK,
    TOUCH,
    WHERE,
)
from ..drivers.orbit_steps import branch_point_indicator, doubling_indicator, neimark_sacker_indicator
from ..methods import Reference
from .curve import CurvePoint
from .orbit import Orbit
from .switches import CONTACT, switches_within

# kinds of points, in the order of their numbers in stores
FOLD, DOUBLING, NEIMARK_SACKER, BRANCH_POINT = "fold", "period doubling", "Neimark-Sacker", "branch point"
GRAZING = "grazing"
STICKING_BEGINS, STICKING_ENDS = "sticking begins", "sticking ends"
CHATTER_COMPLETES = "chatter completes"
OPENS, STAYS_SHUT = "contact opens", "contact no longer opens"
SWITCHES_MORE, SWITCHES_LESS = "damper switches more", "damper switches less"  # of a contact law
POINT_KINDS = (
    FOLD,
    DOUBLING,
    NEIMARK_SACKER,
    BRANCH_POINT,
    GRAZING,
    STICKING_BEGINS,
    STICKING_ENDS,
    OPENS,
    STAYS_SHUT,
    CHATTER_COMPLETES,
    SWITCHES_MORE,
    SWITCHES_LESS,
)
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
    value: float
    column: int = WHERE  # of the facts: when, within the phase
    more: tuple[int, ...] = ()  # the events that follow each other at its zero


def margins(orbit: Orbit, evaluation, method) -> list[Margin]:
    """All margins of an orbit, in a fixed order for each sequence of events."""
    if needs_law(method):
        return list(law_margins(orbit, evaluation, method.law))
    rigid, facts = isinstance(method, Reference), evaluation.facts.tolist()
    threshold = method.threshold if rigid else 0.0
    found, touching = [], orbit.first
    for k, kind in enumerate(orbit.kinds):
        found.append(_inside(facts, k, touching, rigid))
        parting, force = facts[k][PARTING], facts[k][FORCE]
        if k and orbit.kinds[k - 1] == RELEASE:  # the closing speed vanishes with the square of the length
            found.append(Margin(STAYS_SHUT, k, False, orbit.instants[k] - orbit.instants[k - 1]))
        elif kind in (IMPACT, STICK, CHATTER, TOUCH):
            found.append(Margin(GRAZING, k, False, facts[k][CLOSING]))
        if kind == IMPACT and threshold > 0:
            found.append(Margin(STICKING_BEGINS, k, False, max(parting - threshold, -force)))
        if kind == STICK:
            found.append(Margin(STICKING_ENDS, k, False, min(threshold - parting, force)))
        if kind == CHATTER:
            found.append(Margin(STICKING_ENDS, k, False, force))
        if kind == PART:
            found.append(Margin(GRAZING, k, False, parting))
        touching = kind in (STICK, CHATTER, TOUCH)
    found.append(_inside(facts, len(orbit.kinds), touching, rigid))
    return found


def _inside(facts: list[list[float]], k: int, touching: bool, rigid: bool) -> Margin:
    kind = OPENS if touching else GRAZING
    return Margin(kind, k, True, facts[k][LOWEST], more=_MORE[kind, rigid])


def law_margins(orbit: Orbit, evaluation, law: str) -> Iterator[Margin]:
    """All margins of an orbit with a piecewise linear contact law."""
    facts, m = evaluation.facts, len(orbit.kinds)
    began = orbit.kinds[-1] if m else TOUCH if orbit.first else PART
    for k, kind in enumerate((*orbit.kinds, None)):
        if began == PART:
            yield Margin(GRAZING, k, True, facts[k, LOWEST], more=CONTACT[law])
        else:
            for lowest, column, more in switches_within(law, began if m else None):
                yield Margin(SWITCHES_MORE, k, True, facts[k, lowest], column, more)
        if kind in (TOUCH, PART):
            yield Margin(GRAZING, k, False, facts[k, CLOSING])
        elif kind is not None:
            yield Margin(SWITCHES_LESS, k, False, facts[k, CLOSING])
            if kind in (LOAD, DAMP):
                yield Margin(OPENS, k, False, facts[k, DEPTH])
        began = kind


def least(found: list[Margin]) -> float:
    """The smallest margin."""
    return min(margin.value for margin in found)


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
    return np.array([indicator(kind, point) for kind in BIFURCATIONS])
