"""The Poincaré map of the solvers in closed form, with its exact Jacobian (:mod:`..kernels.event_driven.saltation`)."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..drivers.event_driven import set_up
from ..kernels.compile.record import make_buffers
from ..kernels.event_driven.integrate import integrate
from ..kernels.event_driven.saltation import make_variation
from ..kernels.event_driven.state import STATE, start_state
from ..kernels.status import OK
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


_NO_BUFFERS = make_buffers(0, np.zeros(1), 0, 0)


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
        self.system = set_up(system, eta, method)
        self.cancelled = cancelled
        self.periods = 0

    def start(self, y) -> np.ndarray:
        """The packed hybrid state at y; the bodies of a reference do not penetrate each other."""
        x1, v1, gap, rate = map(float, y)
        gap = max(gap, 0.0) if self.system.views.rigid else gap
        return STATE.pack(start_state(x1, v1, gap, rate))

    def __call__(self, y, count: int = 1) -> Return | None:
        """The return after ``count`` periods; None if the run ends early, or has no derivative."""
        if self.cancelled is not None and self.cancelled():
            raise Cancelled
        variation, nothing = make_variation(), _NO_BUFFERS
        status, _, _ = integrate(
            self.system.packed, self.start(y), float(count), (0.0, 0.0), nothing.flat, nothing.sizes, variation
        )
        self.periods += count
        end, jacobian = variation.end, variation.state
        if status != OK or not (np.isfinite(end).all() and np.isfinite(jacobian).all()):
            return None
        return Return(end, jacobian, int(variation.course[0]), float(np.abs(end - y).max()))
