"""Bifurcations between two orbits of a curve: where an indicator changes its sign, if that is what it seems to be."""

import numpy as np

from .curve import Curve, CurvePoint
from .margins import BIFURCATIONS, BRANCH_POINT, DOUBLING, FOLD, NEIMARK_SACKER, indicator
from .roots import changes_ahead
from .tolerances import REAL_PAIR, SINGULAR, UNLIKE

MULTIPLIERS = {FOLD: 1.0, DOUBLING: -1.0}


def bifurcations_ahead(
    curve: Curve, here: CurvePoint, step: float, before: np.ndarray, after: np.ndarray
) -> list[tuple[str, CurvePoint]]:
    """Kinds and orbits of the bifurcations within a step, in their order.

    ``before`` and ``after``: the indicators, (4,), at both ends.
    """
    if not (before * after < 0).any():
        return []
    ends = tuple(dict(zip(BIFURCATIONS, each.tolist(), strict=True)) for each in (before, after))
    return changes_ahead(curve.along(here), step, ends, indicator, _confirmed)


def _confirmed(kind: str, point: CurvePoint) -> CurvePoint | None:
    return point if _is_bifurcation(kind, point) else None


def _is_bifurcation(kind: str, point: CurvePoint) -> bool:
    """Whether a change of sign is what it seems to be."""
    if kind == NEIMARK_SACKER:
        values = point.multipliers
        return bool((np.abs(values.imag[np.abs(np.abs(values) - 1) < REAL_PAIR]) > REAL_PAIR).any())
    if not np.isfinite(point.extended).all():
        return False
    if kind in MULTIPLIERS:
        values = point.multipliers
        off = np.abs(values - MULTIPLIERS[kind]).min()
        return not off >= UNLIKE * np.abs(values[0])  # infinite at a grazing impact, where there are no others
    if kind == BRANCH_POINT:
        singular = np.linalg.svd(point.extended * point.scales, compute_uv=False)
        return bool(singular[-1] < SINGULAR * singular[-2])
    return True
