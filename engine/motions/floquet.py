"""Floquet multipliers of a periodic motion, and the bifurcation that they say is near."""

from collections.abc import Callable

import numpy as np

from ..methods import ExactPenalty, Method, Reference
from ..model import System
from ..simulate import simulate
from .poincare_map import PoincareMap, coordinates

WIDTH = 1e-7  # of a difference, in sizes of the state: far less than a time step shifts, far more than rounding
REAL = 1e-9  # a multiplier with no more of an imaginary part is real

DOUBLING, FOLD, NEIMARK_SACKER, GRAZING = "period doubling", "fold", "Neimark-Sacker", "grazing"


def multipliers(
    system: System,
    eta: float,
    method: Method,
    state: np.ndarray,
    period: int,
    cancelled: Callable[[], bool] | None = None,
) -> np.ndarray:
    """Floquet multipliers of the motion that returns to ``state`` after ``period`` periods, largest first.

    In closed form they are the eigenvalues of the exact Jacobian. For Newmark they are those of the discrete map, which
    is affine as long as contact begins and ends with the same steps, so that narrow differences give its derivative but
    for rounding; what a disturbance does to the instants of contact is no part of it if it is less than a step. With
    the located step the map is smooth, and the differences are good to the square of their width.

    Parameters
    ----------
    state : (4,) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ ≡ 0 mod T.
    period : int

    Returns
    -------
    (4,) complex ndarray
        Empty if the motion has no derivative there.
    """
    if isinstance(method, Reference | ExactPenalty):
        back = PoincareMap(system, eta, method, cancelled)(coordinates(state), period)
        return np.empty(0, complex) if back is None else largest_first(back.jacobian)
    width = WIDTH * max(np.abs(state).max(), 1e-9)
    columns = []
    for k in range(4):
        step = width * np.eye(4)[k]
        ends = [
            simulate(system, eta, method, periods=period, keep=1, initial=state + change, cancelled=cancelled)
            for change in (step, -step)
        ]
        if not all(end.ok for end in ends):
            return np.empty(0, complex)
        columns.append((ends[0].section[-1] - ends[1].section[-1]) / (2 * width))
    return largest_first(np.transpose(columns))


def largest_first(jacobian: np.ndarray) -> np.ndarray:
    """Eigenvalues by modulus."""
    values = np.linalg.eigvals(jacobian).astype(complex)
    return values[np.argsort(-np.abs(values), kind="stable")]


def exponent(values: np.ndarray, period: int) -> float:
    """ln |largest multiplier| / period, the largest Lyapunov exponent of a periodic motion; −∞ if all are zero."""
    with np.errstate(divide="ignore"):
        return float(np.log(np.abs(values).max()) / period) if len(values) else np.nan


def nearest(values: np.ndarray, closing_speeds: np.ndarray, approach: float) -> tuple[str, float]:
    """The bifurcation that a periodic motion is nearest to, and how far.

    A multiplier leaves the unit circle at −1 (period doubling), at +1 (fold), or as one of a pair (Neimark–Sacker); how
    far it is from there is 1 − |m|, and where on the circle its argument tells. A motion grazes when an approach of the
    pendulums ceases to be an impact, or becomes one: the distance is the smallest closing speed, a chatter counted by
    its first impact, as a share of the largest.

    Parameters
    ----------
    values : (4,) complex ndarray
        Floquet multipliers.
    closing_speeds : (m,) ndarray
    approach : float
        The smallest that counts, nan if there is none (:class:`.description.Motion`).
    """
    found = [(abs(1 - abs(value)), _leaves_at(value)) for value in values]
    if np.isfinite(approach):
        found.append((approach / closing_speeds.max(initial=approach), GRAZING))
    if not found:
        return "", np.nan
    margin, name = min(found)
    return name, float(margin)


def _leaves_at(value: complex) -> str:
    if abs(value.imag) > REAL * abs(value):
        return NEIMARK_SACKER
    return DOUBLING if value.real < 0 else FOLD
