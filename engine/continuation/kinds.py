"""The kinds of points on branches: what they are called and marked with, and how bifurcations are located.

A *bifurcation* is where a test function changes its sign along a curve of orbits, if that is what it seems to be. An
orbit that is symmetric between two stops may lose its symmetry at what otherwise is a branch point, or a fold of those
that have lost it; its multiplier over half a cycle decides (:func:`..motions.poincare_map.bifurcation_of`). Each
other kind is the zero of a margin, where the sequence of events changes (:mod:`.orbit`).
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from vibroscope.engine.continuation.roots import changes_ahead, zero_ahead
from vibroscope.engine.continuation.tolerances import NEAR_LOSS, REAL_PAIR, SINGULAR, UNLIKE
from vibroscope.engine.drivers.event_driven import displaced_state
from vibroscope.engine.drivers.orbit import steps
from vibroscope.engine.motions.poincare_map import (
    DOUBLING,
    FOLD,
    GRAZING,
    NEIMARK_SACKER,
    SYMMETRY_BREAKING,
    bifurcation_of,
    half_cycle_multipliers,
)

if TYPE_CHECKING:
    from vibroscope.engine.continuation.curve import Curve, CurvePoint

BRANCH_POINT, OPENS, CHATTER_COMPLETES = "branch point", "contact opens", "chatter completes"
STICKING_BEGINS, STICKING_ENDS = "sticking begins", "sticking ends"


class PointKind(NamedTuple):
    """A kind of points.

    Attributes
    ----------
    one, several : str
        Words for one point and for more.
    marker, sign : str
        Its mark in a figure, by the name that Bokeh gives it, and the same as a letter.
    test : callable, optional
        Of a bifurcation: the function of an orbit on its curve that changes its sign there.
    confirmed : callable, optional
        Whether a change of sign is what it seems to be, of the orbit there.
    multiplier : float, optional
        Where the multiplier passes the unit circle that does so there; a pair passes anywhere.
    """

    one: str
    several: str
    marker: str
    sign: str
    test: "Callable[[CurvePoint], float] | None" = None
    confirmed: "Callable[[CurvePoint], bool] | None" = None
    multiplier: float | None = None

    def words(self, count: int = 1) -> str:
        """The kind of so many points."""
        return self.one if count == 1 else self.several

    def critical(self, multipliers: np.ndarray) -> complex:
        """The multiplier of an orbit that passes the unit circle, whatever others are larger; else the largest."""
        if self.multiplier is not None:
            return complex(multipliers[np.argmin(np.abs(multipliers - self.multiplier))])
        pairs = multipliers[multipliers.imag != 0] if self.test else multipliers[:0]
        return complex(pairs[np.argmin(np.abs(np.abs(pairs) - 1))] if len(pairs) else multipliers[0])


# Determinants of the whole Jacobian instead of that of the Poincaré map, which is infinite at a grazing impact.


def _turns(point: "CurvePoint") -> float:
    return float(point.tangent[-1])


def _doubles(point: "CurvePoint") -> float:
    return steps.doubling_indicator(point.evaluation.jacobian)


def _leaves_circle(point: "CurvePoint") -> float:
    return steps.neimark_sacker_indicator(point.evaluation.jacobian)


def _branches(point: "CurvePoint") -> float:
    return steps.branch_point_indicator(point.evaluation.jacobian, point.slope, point.tangent)


def _has_multiplier(value: float) -> "Callable[[CurvePoint], bool]":
    def has(point: "CurvePoint") -> bool:
        off = np.abs(point.multipliers - value).min()  # infinite at a grazing impact, where there are no others
        return bool(np.isfinite(point.extended).all()) and not off >= UNLIKE * np.abs(point.multipliers[0])

    return has


def _has_pair(point: "CurvePoint") -> bool:
    on_circle = point.multipliers[np.abs(np.abs(point.multipliers) - 1) < REAL_PAIR]
    return bool((np.abs(on_circle.imag) > REAL_PAIR).any())


def _has_two_directions(point: "CurvePoint") -> bool:
    if not np.isfinite(point.extended).all():
        return False
    singular = np.linalg.svd(point.extended * point.scales, compute_uv=False)
    return bool(singular[-1] < SINGULAR * singular[-2])


#: By name, in the order of their numbers in stores.
POINT_KINDS = {
    FOLD: PointKind("fold", "folds", "triangle", "▲", _turns, _has_multiplier(1.0), 1.0),
    DOUBLING: PointKind("period doubling", "period doublings", "diamond", "◆", _doubles, _has_multiplier(-1.0), -1.0),
    NEIMARK_SACKER: PointKind("Neimark–Sacker point", "Neimark–Sacker points", "star", "★", _leaves_circle, _has_pair),
    BRANCH_POINT: PointKind("branch point", "branch points", "plus", "✚", _branches, _has_two_directions, 1.0),
    GRAZING: PointKind("grazing", "grazing", "circle", "○"),
    STICKING_BEGINS: PointKind("sticking begins", "beginnings of sticking", "square", "□"),
    STICKING_ENDS: PointKind("sticking ends", "ends of sticking", "square_x", "⊠"),
    OPENS: PointKind("contact opens", "contacts that open", "x", "×"),
    CHATTER_COMPLETES: PointKind("chatter completes", "chatters that complete", "square_cross", "⊞"),
    SYMMETRY_BREAKING: PointKind(
        "symmetry breaking", "losses of symmetry", "hex", "⬢", _branches, _has_multiplier(1.0), 1.0
    ),
}
BIFURCATIONS = tuple(name for name, kind in POINT_KINDS.items() if kind.test)


def indicator(kind: str, point: "CurvePoint") -> float:
    """The test function of a kind of bifurcations."""
    return POINT_KINDS[kind].test(point)


def indicators(point: "CurvePoint") -> dict[str, float]:
    """All test functions, each once."""
    return {kind: indicator(kind, point) for kind in BIFURCATIONS if kind != SYMMETRY_BREAKING}


def bifurcations_ahead(
    curve: "Curve", here: "CurvePoint", step: float, before: dict[str, float], after: dict[str, float]
) -> list[tuple[str, "CurvePoint"]]:
    """Kinds and orbits of the bifurcations within a step, in their order; ``before``, ``after``: the test functions."""
    found, at = {}, curve.along(here)
    if here.orbit.is_symmetric:
        ahead = lambda s: curve.ahead(here, s) or curve.symmetric(here.unknowns + s * here.along, here)  # noqa: E731
        at = lambda s: ahead(s) if s else here  # noqa: E731
    for kind, point in changes_ahead(at, step, (before, after), indicator, _confirmed):
        if kind in (FOLD, BRANCH_POINT) and loses_symmetry(curve, point):
            kind, point = SYMMETRY_BREAKING, _loss_near(curve, point) or point
        found.setdefault(kind, point)
    return list(found.items())


def _loss_near(curve: "Curve", point: "CurvePoint") -> "CurvePoint | None":
    """Where symmetric orbits lose their symmetry, to rounding, from a place where test functions show it.

    There the Jacobian is singular. Unlike the test functions its determinant needs no tangent, of which there are two.
    """
    _, kept = ways_at_loss(point)
    ahead = curve.symmetric(point.unknowns + NEAR_LOSS * kept * point.scales, point)
    if ahead is None:
        return None
    determinant = lambda there: steps.relative_determinant(there.evaluation.jacobian.copy())  # noqa: E731
    at = lambda s: curve.symmetric(ahead.unknowns - s * kept * point.scales, point)  # noqa: E731
    zero = zero_ahead(at, 2.0 * NEAR_LOSS, determinant)
    return zero and zero[1]


def ways_at_loss(point: "CurvePoint") -> tuple[np.ndarray, np.ndarray]:
    """Scaled directions, (n + 1,) each, of the orbits that lose their symmetry at a point, and of those that do not."""
    lost = np.append(np.linalg.svd(point.evaluation.jacobian * point.scales[:-1])[2][-1], 0.0)
    return lost, across(lost, *np.linalg.svd(point.extended * point.scales)[2][-2:])


def across(tangent: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The direction orthogonal to the tangent in the plane of two vectors, of length one."""
    farther = second if abs(tangent @ second) < abs(tangent @ first) else first
    away = farther - tangent * (tangent @ farther)
    return away / np.linalg.norm(away)


def loses_symmetry(curve: "Curve", point: "CurvePoint") -> bool:
    """Whether an orbit with a multiplier of +1 loses its symmetry between two stops there."""
    problem, orbit = curve.family.at(point.value), point.orbit
    if not (problem[0].is_symmetric and orbit.is_symmetric):
        return False
    state = displaced_state(problem[0], point.evaluation.section[0])
    return bifurcation_of(1.0 + 0.0j, half_cycle_multipliers(*problem, state, orbit.period)) == SYMMETRY_BREAKING


def _confirmed(kind: str, point: "CurvePoint") -> "CurvePoint | None":
    return point if POINT_KINDS[kind].confirmed(point) else None
