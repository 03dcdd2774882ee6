"""A branch of periodic motions, and the points on it."""

from dataclasses import dataclass

import numpy as np

from ..motions.floquet import is_stable
from ..wording import html_table
from .kinds import BIFURCATIONS, POINT_KINDS


@dataclass(frozen=True)
class Point:
    """A bifurcation, or a change of the sequence of events.

    Attributes
    ----------
    kind : str
        One of POINT_KINDS. A point has the same kind from both sides: where a contact opens there
        is a flight more on one of them. Where an impact begins or ceases to stick the motion jumps, and both ends of
        the jump are points.
    value : float
        The number over which the branch is followed, to 1e-10 of its range.
    period : int
        p of the orbit, in excitation periods.
    multipliers : (4,) complex ndarray
        Floquet multipliers, largest first; infinite at a grazing impact.
    state : (4,) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ ≡ 0 mod pT.
    events : tuple of str
        What happens in the cycle, in its order: "impact", "stick", "chatter" and "release", or "touch" and "part".
    instants : (m,) ndarray
        When, in excitation periods.
    index : int
        Of the branch's value after which it lies.
    """

    kind: str
    value: float
    period: int
    multipliers: np.ndarray
    state: np.ndarray
    events: tuple[str, ...]
    instants: np.ndarray
    index: int

    @property
    def is_crossing(self) -> bool:
        """Whether a multiplier passes the unit circle here."""
        return self.kind in BIFURCATIONS

    @property
    def critical_multiplier(self) -> complex:
        """The multiplier that passes the unit circle here, whatever others are larger; else the largest."""
        return POINT_KINDS[self.kind].critical(self.multipliers)


@dataclass(frozen=True)
class Branch:
    """Periodic motions along a branch, in the order in which they were followed.

    Attributes
    ----------
    over : str
        The number that varies.
    period : int
        p, excitation periods of the cycle.
    values : (n,) ndarray
        The number at each orbit.
    sections : (n, p, 4) ndarray
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, T, … (p − 1)T.
    multipliers : (n, 4) complex ndarray
        Largest first.
    sequences : tuple of (int, str)
        From which orbit on which events follow each other in the cycle.
    points : tuple of Point
    ends : (str, str)
        Why the branch ends where it begins, and where it ends.
    """

    over: str
    period: int
    values: np.ndarray
    sections: np.ndarray
    multipliers: np.ndarray
    sequences: tuple[tuple[int, str], ...]
    points: tuple[Point, ...]
    ends: tuple[str, str]

    @property
    def stable(self) -> np.ndarray:
        """Whether small disturbances die away, (n,) of bool."""
        return is_stable(self.multipliers)

    @property
    def stable_ranges(self) -> tuple[tuple[float, float], ...]:
        """The parts of the range over which orbits are stable, in the order in which they were followed.

        A part ends at the point at which the orbits become unstable, or else with the last stable orbit.
        """
        edges = np.flatnonzero(np.diff(np.concatenate([[0], self.stable.astype(int), [0]])))
        parts = (
            sorted((self._edge(first - 1, first), self._edge(last - 1, last - 1)))
            for first, last in edges.reshape(-1, 2)
        )
        return tuple((low, high) for low, high in parts)

    def _edge(self, index: int, stable: int) -> float:
        """The value at which stability changes between orbit ``index`` and the next; else that of a stable orbit."""
        between = [point for point in self.points if point.index == index]
        crossing = [point for point in between if point.is_crossing] or between
        return float(crossing[0].value if crossing else self.values[stable])

    def __repr__(self) -> str:
        low, high = self.values.min(), self.values.max()
        return (
            f"Branch(period {self.period} over {self.over} from {low:g} to {high:g}: {len(self.values)} orbits, "
            f"{np.mean(self.stable):.0%} stable, {len(self.points)} points)"
        )

    def _repr_html_(self) -> str:
        return html_table(repr(self), {f"{point.kind}, {self.over}": point.value for point in self.points})
