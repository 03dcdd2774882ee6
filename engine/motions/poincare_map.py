"""The Poincaré map of the closed-form solvers with its exact Jacobian (:mod:`..kernels.event_driven.saltation`).

With a contact law other than spring and damper the Jacobian is by central differences, eight more runs.

The map carries the state y = (ξ₁, ξ₁′, g, g′), with the gap g, from τ = 0 to τ = pT; at a wall y = (0, 0, g, g′).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.event_driven import LinearFlow, contact_state, displaced_state, set_up, within
from vibroscope.engine.drivers.law_driven import LawFlow, needs_law
from vibroscope.engine.facts import Amount, Dimensionless, Statement, stated
from vibroscope.engine.methods import ExactPenalty, Reference
from vibroscope.engine.model import System
from vibroscope.engine.motions.tolerances import LARGEST_PRESSING, LEAST_SIZE
from vibroscope.engine.result import check_cancelled


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

    def __init__(
        self, system: System, eta: float, method: Reference | ExactPenalty, cancelled: Callable[[], bool] | None
    ):
        self.mechanics, self.rigid = system, method.rigid
        self.by_differences = needs_law(method)
        if self.by_differences:
            self.flow = LawFlow(system, eta, method)
        else:
            self.flow = LinearFlow(set_up(system, eta, method, impulses=False))
        self.cancelled = cancelled
        self.periods = 0

    def start(self, y: Sequence[float]) -> np.ndarray:
        """Return the packed hybrid state at y; for the reference a penetration is set to zero."""
        x1, v1, gap, rate = map(float, y)
        gap = within(self.mechanics, gap) if self.rigid else gap
        return self.flow.start((x1, v1, gap, rate))

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
