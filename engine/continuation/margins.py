"""What keeps a solution of the equations an orbit, and where orbits bifurcate: functions with zeros.

Each is smooth along a curve of orbits with one sequence of events. A *margin* is positive as long as the solution is an
orbit with this sequence; at its zero the sequence changes. An *indicator* changes its sign at a bifurcation.
"""

from typing import NamedTuple

import numpy as np

from ..drivers.orbit import CHATTER, CLOSING, FORCE, IMPACT, LOWEST, PART, PARTING, RELEASE, STICK, TOUCH
from ..methods import Reference
from .curve import CurvePoint
from .orbit import Orbit

# kinds of points, in the order of their numbers in stores
FOLD, DOUBLING, NEIMARK_SACKER, BRANCH_POINT = "fold", "period doubling", "Neimark-Sacker", "branch point"
GRAZING = "grazing"
STICKING_BEGINS, STICKING_ENDS = "sticking begins", "sticking ends"
CHATTER_COMPLETES = "chatter completes"
OPENS, STAYS_SHUT = "contact opens", "contact no longer opens"
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
)
BIFURCATIONS = (FOLD, DOUBLING, BRANCH_POINT, NEIMARK_SACKER)
PAIRS = [(i, j) for i in range(4) for j in range(i)]


class Margin(NamedTuple):
    """A condition on an orbit, met while ``value`` > 0."""

    kind: str
    event: int  # of the sequence; len(kinds) is the end of the cycle
    inside: bool  # whether it concerns the phase that ends with the event, not the event
    value: float


def margins(orbit: Orbit, evaluation, method) -> list[Margin]:
    """All margins of an orbit, in a fixed order for each sequence of events."""
    rigid, facts = isinstance(method, Reference), evaluation.facts
    threshold = method.threshold if rigid else 0.0
    found, touching = [], orbit.first
    for k, kind in enumerate(orbit.kinds):
        found.append(_inside(facts, k, touching, rigid))
        parting, force = facts[k, PARTING], facts[k, FORCE]
        if k and orbit.kinds[k - 1] == RELEASE:  # the closing speed vanishes with the square of the length
            found.append(Margin(STAYS_SHUT, k, False, orbit.instants[k] - orbit.instants[k - 1]))
        elif kind in (IMPACT, STICK, CHATTER, TOUCH):
            found.append(Margin(GRAZING, k, False, facts[k, CLOSING]))
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


def _inside(facts: np.ndarray, k: int, touching: bool, rigid: bool) -> Margin:
    return Margin(OPENS if touching else GRAZING, k, True, facts[k, LOWEST])


def least(found: list[Margin]) -> float:
    """The smallest margin."""
    return min(margin.value for margin in found)


def indicator(kind: str, point: CurvePoint) -> float:
    """What changes its sign at a point of one of the kinds BIFURCATIONS.

    Determinants of the whole Jacobian instead of that of the Poincaré map, which is infinite at a grazing impact.
    """
    jacobian = point.evaluation.jacobian
    if kind == FOLD:
        return float(point.tangent[-1])
    if kind == DOUBLING:
        doubled = jacobian.copy()
        doubled[range(4), range(4)] += 2.0
        return _signed(doubled)
    if kind == BRANCH_POINT:
        return _signed(np.vstack([point.extended, point.tangent]))
    events = np.sign(_signed(jacobian[4:, 4:])) if len(jacobian) > 4 else 1.0
    return events * _pairs(point.evaluation.monodromy)


def indicators(point: CurvePoint) -> np.ndarray:
    """All of them, (4,)."""
    return np.array([indicator(kind, point) for kind in BIFURCATIONS])


def _signed(matrix: np.ndarray) -> float:
    """The determinant relative to Hadamard's bound of it: of moderate size, and smooth."""
    with np.errstate(all="ignore"):  # at a grazing impact there may be none
        sign, logarithm = np.linalg.slogdet(matrix)
        return float(sign * np.exp(logarithm - np.log(np.linalg.norm(matrix, axis=1)).sum()))


def _pairs(monodromy: np.ndarray) -> float:
    """The product of 1 − mᵢmⱼ over all pairs of multipliers, scaled."""
    i, j = np.transpose(PAIRS)
    rows = monodromy[i], monodromy[j]
    second = rows[0][:, i] * rows[1][:, j] - rows[0][:, j] * rows[1][:, i]
    return _signed(np.eye(6) - second)
