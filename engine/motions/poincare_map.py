"""The Poincaré map of the solvers in closed form, with its exact Jacobian (:mod:`..kernels.event_driven.tangent`)."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..drivers.event_driven import pack
from ..kernels.event_driven import integrate as kernel
from ..kernels.event_driven.tangent import march_along
from ..methods import ExactPenalty, Reference
from ..model import System
from ..result import Cancelled


def coordinates(state: Sequence[float]) -> np.ndarray:
    """ξ₁, ξ₁′, g, g′, which the map works in, of ξ₁, ξ₁′, ξ₂, ξ₂′; also row by row."""
    state = np.asarray(state, dtype=float)
    return state - state[..., [0, 1, 0, 1]] * np.array([0, 0, 1, 1])


def displacements(y: np.ndarray) -> np.ndarray:
    """ξ₁, ξ₁′, ξ₂, ξ₂′ of ξ₁, ξ₁′, g, g′."""
    return y + y[..., [0, 1, 0, 1]] * np.array([0, 0, 1, 1])


class Return(NamedTuple):
    """Where the map leads from a state, both as ξ₁, ξ₁′, g, g′, and its Jacobian there."""

    state: np.ndarray
    jacobian: np.ndarray
    course: int  # differs between different sequences of impacts, contacts and flights
    miss: float  # largest |P(y) − y|


class PoincareMap:
    """The Poincaré map τ ≡ 0 mod T of a solver in closed form, over any number of periods; it counts them."""

    def __init__(
        self, system: System, eta: float, method: Reference | ExactPenalty, cancelled: Callable[[], bool] | None
    ):
        self.packed = pack(system, eta, method)
        self.cancelled = cancelled
        self.periods = 0

    def start(self, y):
        """The anchor at y; a reference has no penetration."""
        x1, v1, gap, rate = map(float, y)
        return kernel.prepare(self.packed, x1, v1, max(gap, 0.0) if self.packed.rigid else gap, rate)

    def __call__(self, y, count: int = 1) -> Return | None:
        """None if the march ends early, or has no derivative."""
        if self.cancelled is not None and self.cancelled():
            raise Cancelled
        end, jacobian, course, code = march_along(self.packed, self.start(y), float(count))
        self.periods += count
        end = np.array(end)
        if code != kernel.DONE or not (np.isfinite(end).all() and np.isfinite(jacobian).all()):
            return None
        return Return(end, jacobian, course, float(np.abs(end - y).max()))
