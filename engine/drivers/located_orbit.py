"""The equations of a periodic orbit of Newmark's method with located steps (:mod:`..kernels.located_orbit`)."""

from collections.abc import Sequence

import numpy as np

from ..kernels import located_orbit as kernel
from ..kernels.event_driven.orbit import FACTS, JOINS
from ..kernels.time_stepping.located import located_scheme
from ..methods import Newmark
from ..model import System
from .orbit import Evaluation, numbers_of
from .orbit_newton import solve_stepwise
from .time_stepping import parameters_of_steps


class LocatedOrbitEquations:
    """The equations of the orbits of one system, η and method; called as :class:`.orbit.OrbitEquations` is.

    Parameters
    ----------
    system : System
    eta : float
    method : Newmark
        With located steps and the law "kelvin-voigt".
    """

    def __init__(self, system: System, eta: float, method: Newmark) -> None:
        self._scheme = located_scheme(parameters_of_steps(system, eta, method))

    def __call__(
        self, kinds: Sequence[int], first: bool, period: int, unknowns: np.ndarray, out: Evaluation | None = None
    ) -> Evaluation:
        """Evaluate the equations of orbits with this sequence of events."""
        found = Evaluation.zeros(len(kinds), period, FACTS) if out is None else out
        sequence = numbers_of(tuple(kinds)), first, float(period)
        kernel.evaluate_located_orbit(self._scheme, *sequence, unknowns, tuple(found))
        return found

    def solve(
        self, kinds: Sequence[int], first: bool, period: int, unknowns: np.ndarray, width: float
    ) -> Evaluation | None:
        """As :meth:`.orbit.OrbitEquations.solve`."""
        return solve_stepwise(self, (kinds, first, period), unknowns, width)

    def slope(
        self,
        problem: tuple[System, float, Newmark],
        h: float,
        kinds: Sequence[int],
        first: bool,
        period: int,
        unknowns: np.ndarray,
        residual: np.ndarray,
    ) -> np.ndarray:
        """As :meth:`.orbit.OrbitEquations.slope`."""
        there = LocatedOrbitEquations(*problem)(kinds, first, period, unknowns, Evaluation.without_facts(len(kinds)))
        with np.errstate(invalid="ignore"):  # there may be no such orbit
            return (there.residual - residual) / h

    def state_later(self, kind: int, state: np.ndarray, turn: float, length: float) -> np.ndarray:
        """As :meth:`.orbit.OrbitEquations.state_later`."""
        y = tuple(map(float, state))
        return np.array(kernel.located_state_later(self._scheme, kind in JOINS, y, float(turn), float(length)))
