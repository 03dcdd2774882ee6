"""The equations of a periodic orbit with a piecewise linear contact law (:mod:`..kernels.event_driven.law_orbit`)."""

from collections.abc import Sequence

import numpy as np

from ..kernels.compile.options import uncompiled
from ..kernels.equations.contact_law import COMPRESSION, LAWS
from ..kernels.event_driven import law_integrate as loop
from ..kernels.event_driven import law_orbit as kernel
from ..kernels.event_driven.orbit import DAMP, LAW_FACTS, LIMIT, LOAD, PART, RELAX, TOUCH, UNLIMIT, UNLOAD
from ..kernels.event_driven.state import linear_state, start_state
from ..methods import ExactPenalty
from ..model import System
from .law_driven import set_up_law
from .orbit import Evaluation, numbers_of
from .orbit_newton import solve_stepwise

IN_FLIGHT, IN_OVERLAP, IN_PUSH, IN_EXTRA = kernel.IN_FLIGHT, kernel.IN_OVERLAP, kernel.IN_PUSH, kernel.IN_EXTRA
MOST_BLOCKS = 200_000  # of a run whose events are listed
MOST_TABLES = 64  # of equations of one family that are kept: 20 kB each


def piece_after(law: str, kind: int) -> int:
    """The piece of a law that an event begins: IN_FLIGHT, IN_OVERLAP, IN_PUSH or IN_EXTRA."""
    return uncompiled(kernel.piece_after)(LAWS.index(law), kind)


class LawOrbitEquations:
    """The equations of the orbits of one system, η and law; called as :class:`.orbit.OrbitEquations` is.

    Parameters
    ----------
    system : System
    eta : float
    method : ExactPenalty
        With a piecewise linear law other than "kelvin-voigt", and a damper.
    like : LawOrbitEquations, optional
        Equations of the same kind of system and law: tables that are the same are taken from there.
    """

    def __init__(
        self, system: System, eta: float, method: ExactPenalty, like: "LawOrbitEquations | None" = None
    ) -> None:
        self._tables = {} if like is None else like._tables
        if len(self._tables) > MOST_TABLES:
            self._tables.clear()
        self._system, self._law = set_up_law(system, eta, method, self._tables), method.law

    def __call__(
        self, kinds: Sequence[int], first: bool, period: int, unknowns: np.ndarray, out: Evaluation | None = None
    ) -> Evaluation:
        """Evaluate the equations of orbits with this sequence of events."""
        piece = piece_after(self._law, kinds[-1]) if kinds else IN_PUSH if first else IN_FLIGHT
        found = Evaluation.zeros(len(kinds), period, LAW_FACTS) if out is None else out
        kernel.evaluate_law_orbit(self._system, numbers_of(tuple(kinds)), piece, float(period), unknowns, tuple(found))
        return found

    def solve(
        self, kinds: Sequence[int], first: bool, period: int, unknowns: np.ndarray, width: float
    ) -> Evaluation | None:
        """As :meth:`.orbit.OrbitEquations.solve`."""
        return solve_stepwise(self, (kinds, first, period), unknowns, width)

    def slope(
        self,
        problem: tuple[System, float, ExactPenalty],
        h: float,
        kinds: Sequence[int],
        first: bool,
        period: int,
        unknowns: np.ndarray,
        residual: np.ndarray,
    ) -> np.ndarray:
        """As :meth:`.orbit.OrbitEquations.slope`."""
        there = LawOrbitEquations(*problem, like=self)(
            kinds, first, period, unknowns, Evaluation.without_facts(len(kinds))
        )
        with np.errstate(invalid="ignore"):  # there may be no such orbit
            return (there.residual - residual) / h

    def state_later(self, kind: int, state: np.ndarray, turn: float, length: float) -> np.ndarray:
        """As :meth:`.orbit.OrbitEquations.state_later`."""
        return np.array(kernel.law_state_later(self._system, piece_after(self._law, kind), state, turn, length))

    def events(self, y: np.ndarray, period: int) -> list[tuple[float, int]] | None:
        """Instants in excitation periods and kinds of the events of a run from y = (ξ₁, ξ₁′, g, g′) over a cycle.

        None if there are too many of them.
        """
        p, found, piece = self._system, [], None
        a = uncompiled(start_state)(p, tuple(map(float, y)))
        for _ in range(MOST_BLOCKS):
            a, before = loop.resolve_law_event(p, a), piece
            piece, turn = uncompiled(loop.piece_of)(a), a.period + a.tau / p.period
            if turn >= period:
                return found
            if before is not None and piece != before:
                found.append((turn, self._kind_between(before, piece)))
                if len(found) > loop.MOST_EVENTS:
                    return None
            z = uncompiled(linear_state)(p, uncompiled(loop.phase_of)(p, piece, 0), a)
            a = loop.follow_piece(p, a, z)[1]
        return None

    def _kind_between(self, before: int, after: int) -> int:
        """The event between two pieces."""
        if IN_FLIGHT in (before, after):
            return PART if after == IN_FLIGHT else TOUCH
        if IN_OVERLAP in (before, after):
            return UNLOAD if after == IN_OVERLAP else LOAD
        reduced, whole = (RELAX, DAMP) if self._system.law == COMPRESSION else (LIMIT, UNLIMIT)
        return reduced if after == IN_EXTRA else whole
