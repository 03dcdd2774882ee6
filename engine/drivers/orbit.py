"""The equations of a periodic orbit of a solution in closed form (:mod:`..kernels.event_driven.orbit`)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..kernels.event_driven.orbit import (
    CHATTER,
    CLOSING,
    DAMP,
    DEPTH,
    FACTS,
    FORCE,
    IMPACT,
    JOINS,
    LAW_FACTS,
    LIMIT,
    LOAD,
    LOWEST,
    OTHER_LOWEST,
    OTHER_WHERE,
    PART,
    PARTING,
    RELAX,
    RELEASE,
    STICK,
    TOUCH,
    UNLIMIT,
    UNLOAD,
    WHERE,
    evaluate_orbit,
    orbit_residuals,
    state_later,
)
from ..kernels.event_driven.orbit_steps import monodromy_of
from ..kernels.event_driven.setup import set_up_events
from ..kernels.event_driven.state import SYSTEM
from ..kernels.parameters import ETA, no_keys
from ..methods import ExactPenalty, Reference
from ..model import System
from .event_driven import COMPLETION
from .parameters import parameters_of, wall_of

__all__ = [
    "CHATTER",
    "CLOSING",
    "DAMP",
    "DEPTH",
    "FORCE",
    "IMPACT",
    "JOINS",
    "LAW_FACTS",
    "LIMIT",
    "LOAD",
    "LOWEST",
    "OTHER_LOWEST",
    "OTHER_WHERE",
    "PART",
    "PARTING",
    "RELAX",
    "RELEASE",
    "STICK",
    "TOUCH",
    "UNLIMIT",
    "UNLOAD",
    "WHERE",
    "Evaluation",
    "OrbitEquations",
]


NO_CIRCLE = np.zeros(2)  # that separates slow from fast eigenvalues: an orbit's contacts have no slow phase
JOINING = frozenset(JOINS)
INFINITE = 1e10  # an element of the Jacobian above that is one of a grazing impact


class Evaluation(NamedTuple):
    """The equations of an orbit at given unknowns.

    Attributes
    ----------
    residual : (4 + m,) ndarray
        y(pT) − y₀, then what is zero at each event.
    jacobian : (4 + m, 4 + m) ndarray
    facts : (m + 1, 5) ndarray
        Of each event, and of the end of the cycle: columns CLOSING, PARTING, FORCE, LOWEST, WHERE.
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
    def zeros(cls, events: int, periods: int, facts: int) -> "Evaluation":
        """Room for the equations of so many events and periods, with so many facts of each event."""
        n = 4 + events
        return cls(*map(np.zeros, (n, (n, n), (events + 1, facts), (events + 1, 5), (periods, 4))))

    @property
    def monodromy(self) -> np.ndarray:
        """Jacobian of the Poincaré map over the cycle, (4, 4); not finite at a grazing impact, where there is none."""
        return monodromy_of(self.jacobian)

    @property
    def multipliers(self) -> np.ndarray:
        """Floquet multipliers, (4,), largest first; the first is infinite at a grazing impact, and the others nan."""
        jacobian = self.monodromy
        if not np.abs(jacobian).max() < INFINITE:
            return np.array([np.inf, np.nan, np.nan, np.nan], dtype=complex)
        values = np.linalg.eigvals(jacobian).astype(complex)
        return values[np.argsort(-np.abs(values), kind="stable")]


def residuals(
    problems: Sequence[tuple[System, float, Reference | ExactPenalty]],
    kinds: Sequence[int],
    first: bool,
    period: int,
    unknowns: np.ndarray,
) -> np.ndarray:
    """The residuals of the same unknowns in several problems of one kind, (k, 4 + m)."""
    system, _, method = problems[0]
    rows, numbers = np.array([parameters_of(*each) for each in problems]), np.array(kinds, dtype=np.int64)
    how = rows, isinstance(method, Reference), wall_of(system), COMPLETION
    return orbit_residuals(SYSTEM.zeros(), *how, numbers, first, float(period), unknowns)


class OrbitEquations:
    """The equations of the orbits of one system, η and method.

    Tables are made where they are needed: those of contact for the first sequence of events in which the bodies touch.

    Parameters
    ----------
    system : System
    eta : float
    method : Reference or ExactPenalty
        With the law "kelvin-voigt".
    like : OrbitEquations, optional
        Equations of the same kind of system and method: tables that are the same are taken from there.
    """

    def __init__(
        self, system: System, eta: float, method: Reference | ExactPenalty, like: "OrbitEquations | None" = None
    ) -> None:
        self._problem, self._rigid = (system, method), isinstance(method, Reference)
        self._row = self._row_of(eta, like)
        self._wall, self._period = wall_of(system), 2 * np.pi / eta
        self._packed = SYSTEM.zeros() if like is None else like._packed.copy()
        self._keys = no_keys() if like is None else like._keys.copy()
        self._has_contact = False
        self._set_up(contact=False)

    def _row_of(self, eta: float, like: "OrbitEquations | None") -> np.ndarray:
        """The parameters; where only η differs from others, these with another η."""
        system, method = self._problem
        if like is None or like._problem[0] is not system or like._problem[1] is not method:
            return np.array(parameters_of(system, eta, method))
        row = like._row.copy()
        row[ETA] = eta
        return row

    def _set_up(self, contact: bool) -> None:
        before = self._keys[1].copy()
        if not contact:
            self._keys[1] = self._row  # a key that is met writes no tables
        set_up_events(self._packed, self._keys, self._row, self._rigid, NO_CIRCLE, COMPLETION)
        if not contact:
            self._keys[1] = before
        self._has_contact = contact

    def __call__(self, kinds: Sequence[int], first: bool, period: int, unknowns: np.ndarray) -> Evaluation:
        """Evaluate the equations of orbits with this sequence of events.

        Parameters
        ----------
        kinds : (m,) sequence of int
            What happens at each event: IMPACT, STICK, CHATTER, RELEASE (reference), TOUCH, PART (penalty).
        first : bool
            Whether the bodies touch at τ = 0.
        period : int
            Excitation periods of the cycle.
        unknowns : (4 + m,) ndarray
            ξ₁, ξ₁′, g, g′ at τ = 0, then the instants of the events in excitation periods.
        """
        if not self._has_contact and (first or not JOINING.isdisjoint(kinds)):
            self._set_up(contact=True)
        numbers, found = np.array(kinds, dtype=np.int64), Evaluation.zeros(len(kinds), period, FACTS)
        evaluate_orbit(self._packed, self._wall, numbers, first, float(period), unknowns, tuple(found))
        return found

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
        touching = kind in JOINS
        if touching and not self._has_contact:
            self._set_up(contact=True)
        return np.array(state_later(self._packed, self._wall, touching, state, turn, length * self._period))
