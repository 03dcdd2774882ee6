"""The Poincaré map of the closed-form solvers with its exact Jacobian (:mod:`..kernels.event_driven.saltation`).

With a contact law other than spring and damper the Jacobian is by central differences, eight more runs.

The map carries the state y = (ξ₁, ξ₁′, g, g′), with the gap g, from τ = 0 to τ = pT; at a wall y = (0, 0, g, g′).

Floquet multipliers of a periodic motion, and the bifurcation that they show to be near.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.drivers.event_driven import LinearFlow, contact_state, displaced_state, set_up
from vibroscope.engine.drivers.law_driven import LawFlow, needs_law
from vibroscope.engine.facts import Amount, Dimensionless, Statement, stated
from vibroscope.engine.methods import ExactPenalty, Method, Reference
from vibroscope.engine.model import System
from vibroscope.engine.motions.tolerances import (
    LARGEST_PRESSING,
    LEAST_SIZE,
    NEUTRAL,
    REAL_MULTIPLIER,
    STATE_DIFFERENCE,
    SURELY_STABLE,
)
from vibroscope.engine.result import check_cancelled
from vibroscope.engine.simulate import simulate


def unresolved(system: System) -> str | Statement:
    """Why rounding hides the orbits of a system; empty if it does not.

    Displacements are computed from the equilibrium of the separate bodies. Where a large constant force acts on a weak
    spring, this lies so far beyond the contact that the motion near the contact has few digits left.
    """
    if system.rests_afar or -system.static_gap <= LARGEST_PRESSING:
        return ""
    return stated(
        "without contact the bodies would overlap at rest by {}{}, more than {}, and rounding hides periodic motions: "
        "give stiffer springs, or smaller constant forces",
        Amount(-system.static_gap, "displacement"),
        Dimensionless(" units of length"),
        Amount(LARGEST_PRESSING, "displacement"),
    )


def size_of(states: np.ndarray) -> float:
    """Largest number of states, (…, 4), that counts as the size of a motion: LEAST_SIZE at least."""
    return max(np.abs(states).max(), LEAST_SIZE)


class Return(NamedTuple):
    """Image of a state y under the Poincaré map.

    Attributes
    ----------
    state : (4,) ndarray
        P(y).
    jacobian : (4, 4) ndarray
        DP(y).
    course : int
        Fingerprint of the sequence of impacts, contacts and flights; it differs between different sequences.
    residual : float
        Largest element of |P(y) − y|.
    """

    state: np.ndarray
    jacobian: np.ndarray
    course: int
    residual: float


class PoincareMap:
    """The Poincaré map τ ≡ 0 mod T of one closed-form solver; it counts the excitation periods that it integrates."""

    def __init__(self, system: System, eta: float, method: Reference | ExactPenalty, cancelled: Poll | None):
        self.mechanics = system
        self.by_differences = needs_law(method)
        if self.by_differences:
            self.flow = LawFlow(system, eta, method)
        else:
            self.flow = LinearFlow(set_up(system, eta, method, impulses=False))
        self.cancelled = cancelled
        self.periods = 0

    def start(self, y: Sequence[float]) -> np.ndarray:
        """Return the packed hybrid state at y."""
        return self.flow.start(y)

    def coordinates(self, states: np.ndarray) -> np.ndarray:
        """Convert (…, 4) states ξ₁, ξ₁′, ξ₂, ξ₂′ to those of the map."""
        return contact_state(self.mechanics, states)

    def displacements(self, y: np.ndarray) -> np.ndarray:
        """Convert (…, 4) states of the map to ξ₁, ξ₁′, ξ₂, ξ₂′."""
        return displaced_state(self.mechanics, y)

    def follow(self, y: np.ndarray, direction: np.ndarray, periods: int) -> tuple[np.ndarray, np.ndarray]:
        """Follow a disturbance of a motion, at a third of the time that Jacobians take.

        Parameters
        ----------
        y, direction : (4,) ndarray
            The state and the disturbance; afterwards those at the end, the direction of length 1.
        periods : int

        Returns
        -------
        growth : (periods,) ndarray
            ln of the growth of the disturbance in each period: −∞ where nothing is left of it, and another one begins;
            nan from the period on that ends early or has no derivative.
        states : (periods, 4) ndarray
            P(y), P(P(y)), …
        """
        growth, states = np.full(periods, np.nan), np.full((periods, 4), np.nan)
        for begin in range(0, periods, self.flow.periods_per_call):
            check_cancelled(self.cancelled)
            part = slice(begin, begin + self.flow.periods_per_call)
            self.flow.follow(y, direction, growth[part], states[part])
            if np.isnan(growth[part][-1]):
                break
        self.periods += int(np.isfinite(states[:, 0]).sum())
        return growth, states

    def residual(self, y: np.ndarray, count: int) -> float:
        """Largest element of |P(y) − y| over ``count`` periods, without the Jacobian; inf if there is none."""
        found = self._run(self.flow.end, y, count)
        return np.inf if found is None else float(np.abs(found[0] - y).max())

    def _run(self, flow: Callable, y: np.ndarray, count: float, *more: np.ndarray):
        check_cancelled(self.cancelled)
        found = flow(self.start(y), float(count), *more)
        self.periods += count
        return None if found is None or not all(np.isfinite(array).all() for array in found[:-1]) else found

    def __call__(self, y: np.ndarray, count: float = 1) -> Return | None:
        """Map y over ``count`` periods; None if the integration ends early or the map has no derivative at y."""
        found = self._run(self.flow.with_jacobian, y, count)
        if found is None:
            return None
        end, jacobian, course = found
        return Return(end, jacobian, course, float(np.abs(end - y).max()))


DOUBLING, FOLD, NEIMARK_SACKER, GRAZING = "period doubling", "fold", "Neimark-Sacker", "grazing"
SYMMETRY_BREAKING = "symmetry breaking"


def multipliers(
    system: System,
    eta: float,
    method: Method,
    state: np.ndarray,
    period: float,
    cancelled: Poll | None = None,
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
    cancelled: Poll | None = None,
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
