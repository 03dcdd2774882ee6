"""The branch that begins at a period doubling or a branch point of another one."""

import numpy as np

from .curve import Curve, CurvePoint
from .margins import DOUBLING

AWAY = 10.0 ** np.arange(-4, -1.0, 0.5)  # scaled first steps on the branch


def other_branch(curve: Curve, kind: str, point: CurvePoint) -> CurvePoint | None:
    """The first orbit of the branch that begins at a point of this kind; None if it is not found."""
    times = 2 if kind == DOUBLING else 1
    orbit = point.orbit.repeated(times)
    here = CurvePoint(curve, orbit, point.value)
    scales = curve.scales(orbit)
    tangent = np.concatenate([point.tangent[:4], np.tile(point.tangent[4:-1], times), point.tangent[-1:]])
    if not np.isfinite(here.extended).all():
        return None
    away = _across(
        tangent / np.linalg.norm(tangent), *np.linalg.svd(here.extended * scales)[2][-2:]
    )  # both null vectors
    for step in AWAY:
        guess = here.unknowns + step * away * scales
        row = away / scales
        start = curve.constrained(orbit.at(guess[:-1]), float(guess[-1]), (row, row @ guess), away)
        if start is None:
            continue
        rows = start.evaluation.section
        half = orbit.period // 2
        if kind == DOUBLING and np.abs(rows[0] - rows[half]).max() < 0.1 * step * scales[0]:
            continue  # back on the branch of half the period
        if start.least_margin > 0:
            return start
    return None


def _across(tangent: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The direction orthogonal to the tangent in the plane of two vectors, of length one."""
    farther = second if abs(tangent @ second) < abs(tangent @ first) else first
    away = farther - tangent * (tangent @ farther)
    return away / np.linalg.norm(away)
