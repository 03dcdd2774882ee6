"""Floquet multipliers of a periodic motion, and the bifurcation that they show to be near."""

from collections.abc import Callable, Sequence

import numpy as np
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System
from vibroscope.engine.motions.poincare_map import PoincareMap, size_of
from vibroscope.engine.motions.tolerances import NEUTRAL, REAL_MULTIPLIER, STATE_DIFFERENCE, SURELY_STABLE
from vibroscope.engine.simulate import simulate

DOUBLING, FOLD, NEIMARK_SACKER, GRAZING = "period doubling", "fold", "Neimark-Sacker", "grazing"
SYMMETRY_BREAKING = "symmetry breaking"


def multipliers(
    system: System,
    eta: float,
    method: Method,
    state: np.ndarray,
    period: float,
    cancelled: Callable[[], bool] | None = None,
) -> np.ndarray:
    """Return the Floquet multipliers of the motion that returns to ``state`` after ``period`` periods.

    For closed-form solvers they are the eigenvalues of the exact Jacobian. For Newmark they are those of the discrete
    map, by central differences. With a constant step this map is affine as long as contact begins and ends in the same
    steps, so that narrow differences give its derivative but for rounding; that a disturbance shifts the instants of
    contact by less than a step has no effect on it. With located steps the map is smooth, and the differences err by
    the square of their width.

    Parameters
    ----------
    state : (4,) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ ≡ 0 mod T.
    period : float
        In excitation periods, whole ones with a time step.

    Returns
    -------
    (4,) complex ndarray
        Largest first; empty if the map has no derivative there.
    """
    if not method.has_step:
        poincare = PoincareMap(system, eta, method, cancelled)
        returned = poincare(poincare.coordinates(state), period)
        return np.empty(0, complex) if returned is None else eigenvalues_by_modulus(returned.jacobian)
    width = STATE_DIFFERENCE * size_of(state)
    columns = []
    for disturbance in width * np.eye(4)[: 2 if system.wall else 4]:  # a wall does not move
        above, below = (
            simulate(system, eta, method, periods=period, keep=1, initial=start, cancelled=cancelled)
            for start in (state + disturbance, state - disturbance)
        )
        if not (above.ok and below.ok):
            return np.empty(0, complex)
        columns.append((above.section[-1] - below.section[-1]) / (2 * width))
    jacobian = np.zeros((4, 4))
    jacobian[:, : len(columns)] = np.transpose(columns)
    return eigenvalues_by_modulus(jacobian)


def half_cycle_multipliers(
    system: System,
    eta: float,
    method: Method,
    state: np.ndarray,
    period: int,
    cancelled: Callable[[], bool] | None = None,
) -> np.ndarray:
    """Return the multipliers of a symmetric motion between two stops from a state to its mirror image, half its length.

    Their squares are its Floquet multipliers (Swift and Wiesenfeld 1984). Of a method with a time step they are those
    of its limit.

    Parameters
    ----------
    state : (4,) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ ≡ 0 mod T.
    period : int
        Of the whole motion, odd.

    Returns
    -------
    (4,) complex ndarray
        Largest first; empty if the map has no derivative there.
    """
    return -multipliers(system, eta, method.limit, state, period / 2, cancelled)  # the mirror turns a disturbance


def eigenvalues_by_modulus(jacobian: np.ndarray) -> np.ndarray:
    """Return the eigenvalues of a matrix, complex, largest modulus first."""
    values = np.linalg.eigvals(jacobian).astype(complex)
    return values[np.argsort(-np.abs(values), kind="stable")]


def is_stable(values: np.ndarray) -> np.ndarray:
    """Whether small disturbances die away, by the multipliers of a motion, or of many in the rows of an array."""
    return np.abs(np.atleast_1d(values)).max(axis=-1, initial=0.0) < 1 - SURELY_STABLE


def may_be_stable(values: np.ndarray) -> np.ndarray:
    """Whether small disturbances do not grow: they die away, or the motion lies where it bifurcates."""
    return np.abs(np.atleast_1d(values)).max(axis=-1, initial=0.0) <= 1 + NEUTRAL


def fate_of_disturbances(values: np.ndarray) -> str:
    """What becomes of small disturbances, by the multipliers of a motion."""
    if is_stable(values):
        return "die away"
    return "neither grow nor die away" if may_be_stable(values) else "grow"


def lyapunov_exponent(values: np.ndarray, period: int) -> float:
    """Return ln |largest multiplier| / period, the largest Lyapunov exponent of a cycle; −∞ if all are zero."""
    with np.errstate(divide="ignore"):
        return float(np.log(np.abs(values).max()) / period) if len(values) else np.nan


def nearest_bifurcation(
    values: np.ndarray, closing_speeds: np.ndarray, approach: float, halves: Sequence[complex] = ()
) -> tuple[str, float]:
    """Return the name of the bifurcation that a periodic motion is nearest to, and the distance from it.

    A multiplier m can leave the unit circle at −1 (period doubling), at +1 (fold), or as one of a complex pair
    (Neimark–Sacker). Its distance is |1 − |m||, and its argument decides which of the three it is. Where a symmetric
    motion has m = +1, it loses its symmetry if the multiplier over half a cycle is −1, and is at a fold if it is +1.
    The two motions that begin there are said to be near a fold: m alone does not show more of them. At a grazing
    bifurcation an impact disappears, or a new one appears, with zero closing speed. The distance from it is the
    smallest closing speed relative to the largest, where a chatter counts with its first impact only.

    Parameters
    ----------
    values : (4,) complex ndarray
        Floquet multipliers.
    closing_speeds : (m,) ndarray
    approach : float
        The smallest closing speed that counts, nan if there is none (:class:`.description.Motion`).
    halves : sequence of complex
        Of a symmetric motion, its :func:`half_cycle_multipliers`; else none.

    Returns
    -------
    (str, float)
        ``("", nan)`` if nothing is known.
    """
    candidates = [(abs(1 - abs(value)), bifurcation_of(value, halves)) for value in values]
    if np.isfinite(approach):
        candidates.append((approach / closing_speeds.max(initial=approach), GRAZING))
    if not candidates:
        return "", np.nan
    distance, name = min(candidates)
    return name, float(distance)


def bifurcation_of(value: complex, halves: Sequence[complex]) -> str:
    """Name the bifurcation at which a multiplier of this argument leaves the unit circle; ``halves``: as above."""
    if abs(value.imag) > REAL_MULTIPLIER * abs(value):
        return NEIMARK_SACKER
    if value.real < 0:
        return DOUBLING
    half = min(halves, key=lambda each: abs(each**2 - value), default=1.0)
    return SYMMETRY_BREAKING if half.real < 0 else FOLD
