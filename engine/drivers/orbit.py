"""The equations of a periodic orbit of a solution in closed form (:mod:`..kernels.event_driven.orbit`).

``event``: numbers of what happens at an event, and the columns of its facts, from the same module.
``steps``: steps of Newton's method, tangents, indicators and margins (:mod:`..kernels.event_driven.orbit_steps`).
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from vibroscope.engine.drivers.event_driven import COMPLETION
from vibroscope.engine.drivers.parameters import parameters_of_stops
from vibroscope.engine.kernels.event_driven import orbit as event
from vibroscope.engine.kernels.event_driven import orbit_steps as steps
from vibroscope.engine.kernels.event_driven.orbit import evaluate_orbit, orbit_slope, orbit_state_later
from vibroscope.engine.kernels.event_driven.orbit_steps import solve_orbit
from vibroscope.engine.kernels.event_driven.state import SYSTEM
from vibroscope.engine.kernels.parameters import ETA, no_tables
from vibroscope.engine.methods import ExactPenalty, Reference
from vibroscope.engine.model import System

Cycle = tuple[tuple[int, ...], int, int]  # events, the stop at which the bodies touch at τ = 0, 1 or 2, and its periods
INFINITE = 1e10  # an element of the Jacobian above that is one of a grazing impact


class Evaluation(NamedTuple):
    """The equations of an orbit at given unknowns.

    Attributes
    ----------
    residual : (4 + m,) ndarray
        y(pT) − y₀, then what is zero at each event.
    jacobian : (4 + m, 4 + m) ndarray
    facts : (m + 1, FACTS) ndarray
        Of each event, and of the end of the cycle: columns CLOSING, PARTING, FORCE, LOWEST, WHERE, ROOM, ACROSS,
        WHERE_ACROSS.
    after : (m + 1, 5) ndarray
        State (ξ₁, ξ₁′, g, g′) right after each event and its time in excitation periods; last the end of the cycle.
    section : (p, 4) ndarray
        States at τ = 0, T, … (p − 1)T.
    """

    residual: np.ndarray
    jacobian: np.ndarray
    facts: np.ndarray
    after: np.ndarray
    section: np.ndarray

    @classmethod
    def zeros(cls, events: int, periods: int = 0) -> "Evaluation":
        """Room for the equations of so many events and periods; for none without facts, as Newton steps are taken."""
        n, facts = 4 + events, events + 1 if periods else 0
        return cls(*map(np.zeros, (n, (n, n), (facts, event.FACTS), (events + 1, 5), (periods, 4))))

    @property
    def monodromy(self) -> np.ndarray:
        """Jacobian of the Poincaré map over the cycle, (4, 4); not finite at a grazing impact, where there is none."""
        return steps.monodromy_of(self.jacobian)

    @property
    def multipliers(self) -> np.ndarray:
        """Floquet multipliers, (4,); see :func:`multipliers_of`."""
        return multipliers_of([self])[0]


def multipliers_of(evaluations: Sequence[Evaluation]) -> np.ndarray:
    """Floquet multipliers of orbits, (n, 4), largest first; at a grazing impact the first is infinite, the others nan.

    All together: LAPACK takes less time for such a matrix than a call does.
    """
    matrices = np.array([each.monodromy for each in evaluations])
    infinite = ~(np.abs(matrices).max(axis=(1, 2)) < INFINITE)
    matrices[infinite] = 0.0
    values = np.linalg.eigvals(matrices).astype(complex)
    order = (-np.abs(values)).argsort(axis=1, kind="stable")
    values = values[np.arange(len(values))[:, None], order]
    values[infinite] = np.inf, np.nan, np.nan, np.nan
    return values


@lru_cache(maxsize=1024)
def numbers_of(kinds: tuple[int, ...]) -> np.ndarray:
    """What happens at each event, as kernels take it."""
    return np.array(kinds, dtype=np.int64)


def _of_kernels(kinds: tuple[int, ...], first: int, period: int) -> tuple[np.ndarray, int, float]:
    return numbers_of(kinds), first, float(period)


class OrbitEquations:
    """The equations of the orbits of one system, η and method.

    Parameters
    ----------
    system : System
    eta : float
    method : Reference or ExactPenalty
        With the law "kelvin-voigt".
    like : OrbitEquations, optional
        Equations of the same kind of system and method, of the same thread: both set up the same tables, anew where
        they depend on a number in which they differ.
    """

    def __init__(
        self, system: System, eta: float, method: Reference | ExactPenalty, like: "OrbitEquations | None" = None
    ) -> None:
        self._system, self._method = system, method
        if like is None:
            rows = np.array(parameters_of_stops(system, eta, method))
            self._problem = rows, method.rigid, COMPLETION
            self._tables, self._tables_beside = no_tables(SYSTEM, len(rows)), no_tables(SYSTEM, len(rows))
        else:
            self._problem = like._rows_of(system, eta, method), *like._problem[1:]
            self._tables, self._tables_beside = like._tables, like._tables_beside

    def _rows_of(self, system: System, eta: float, method: Reference | ExactPenalty) -> np.ndarray:
        """The parameters of another problem; where only η differs from this one, its own with that η."""
        if self._system is not system or self._method is not method or system.excitation.power:
            return np.array(parameters_of_stops(system, eta, method))
        rows = self._problem[0].copy()
        rows[:, ETA] = eta
        return rows

    def __call__(self, cycle: Cycle, unknowns: np.ndarray, out: Evaluation | None = None) -> Evaluation:
        """Evaluate the equations of orbits with a sequence of events.

        Parameters
        ----------
        cycle : (tuple of int, int, int)
            What happens at each of the m events: IMPACT, STICK, CHATTER, RELEASE (reference), TOUCH, PART (penalty),
            and SECOND more at the second stop; the stop at which the bodies touch at τ = 0, 1 or 2, and 0 if they do
            not; and the excitation periods of the cycle.
        unknowns : (4 + m,) ndarray
            ξ₁, ξ₁′, g, g′ at τ = 0, then the instants of the events in excitation periods.
        out : Evaluation, optional
            To be filled, instead of a new one.
        """
        found = Evaluation.zeros(len(cycle[0]), cycle[2]) if out is None else out
        evaluate_orbit(self._tables, self._problem, _of_kernels(*cycle), unknowns, tuple(found))
        return found

    def solve(self, cycle: Cycle, unknowns: np.ndarray, width: float) -> Evaluation | None:
        """The equations at the orbit near a guess; None if Newton's method does not find it.

        Parameters
        ----------
        cycle : (tuple of int, int, int)
        unknowns : (4 + m,) ndarray
            Of a guess; moved to the orbit in place.
        width : float
            The unit of α₁.
        """
        found = Evaluation.zeros(len(cycle[0]), cycle[2])
        solved = solve_orbit(self._tables, self._problem, _of_kernels(*cycle), unknowns, width, tuple(found))
        return found if solved else None

    def slope(
        self,
        problem: tuple[System, float, Reference | ExactPenalty],
        h: float,
        cycle: Cycle,
        unknowns: np.ndarray,
        residual: np.ndarray,
    ) -> np.ndarray:
        """∂F/∂α₁ by a difference, (4 + m,).

        Parameters
        ----------
        problem : tuple
            System, η and method where α₁ is greater by ``h``.
        h : float
        cycle, unknowns
            As above.
        residual : (4 + m,) ndarray
            F of this problem.
        """
        rows = self._rows_of(*problem), self._problem
        return orbit_slope(self._tables_beside, *rows, _of_kernels(*cycle), unknowns, residual, float(h))

    def state_later(self, kind: int, state: np.ndarray, turn: float, length: float) -> np.ndarray:
        """The state (ξ₁, ξ₁′, g, g′) a number of excitation periods after another one, without an event on the way.

        Parameters
        ----------
        kind : int
            The event that began the phase.
        state : (4,) ndarray
        turn, length : float
            When it holds, and how much later, in excitation periods.
        """
        return np.array(orbit_state_later(self._tables, self._problem, kind, state, turn, length))
