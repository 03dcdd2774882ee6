"""The kinds of points on branches: what they are called and marked with, and how bifurcations are located.

A *bifurcation* is where a test function changes its sign along a curve of orbits, if that is what it seems to be. Each
other kind is the zero of a margin, where the sequence of events changes (:mod:`.margins`).
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..drivers.orbit import steps
from ..motions.floquet import DOUBLING, FOLD, GRAZING, NEIMARK_SACKER
from .roots import changes_ahead
from .tolerances import REAL_PAIR, SINGULAR, UNLIKE

if TYPE_CHECKING:
    from .curve import Curve, CurvePoint

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
}
BIFURCATIONS = tuple(name for name, kind in POINT_KINDS.items() if kind.test)


def indicator(kind: str, point: "CurvePoint") -> float:
    """The test function of a kind of bifurcations."""
    return POINT_KINDS[kind].test(point)


def indicators(point: "CurvePoint") -> dict[str, float]:
    """All test functions."""
    return {kind: indicator(kind, point) for kind in BIFURCATIONS}


def bifurcations_ahead(
    curve: "Curve", here: "CurvePoint", step: float, before: dict[str, float], after: dict[str, float]
) -> list[tuple[str, "CurvePoint"]]:
    """Kinds and orbits of the bifurcations within a step, in their order; ``before``, ``after``: the test functions."""
    return changes_ahead(curve.along(here), step, (before, after), indicator, _confirmed)


def _confirmed(kind: str, point: "CurvePoint") -> "CurvePoint | None":
    return point if POINT_KINDS[kind].confirmed(point) else None
