"""The plane of two numbers in which bifurcation points are followed: its problems, and orbits in it."""

from dataclasses import dataclass

import numpy as np

from ..drivers.orbit import Evaluation, OrbitEquations
from .family import Family, ParameterRange
from .margins import Margin, margins
from .orbit import KeptEquations, Orbit


@dataclass(frozen=True)
class Place:
    """A solution, or a guess: the orbit, the shares of both numbers, and what the equations say there.

    On a curve also the problem that it solves, their derivatives, and the tangent; all scaled.
    """

    orbit: Orbit
    shares: np.ndarray
    evaluation: Evaluation
    problem: object = None
    matrix: np.ndarray | None = None
    tangent: np.ndarray | None = None

    def scaled(self, scales: np.ndarray) -> np.ndarray:
        """X in units of ``scales``, (n + 2,)."""
        return np.append(self.orbit.unknowns / scales, self.shares)


class Plane:
    """The problems over two numbers; the tables of the last few are kept."""

    def __init__(self, over: Family, along: Family, axes: tuple[ParameterRange, ParameterRange]) -> None:
        self.over, self.along, self.axes = over, along, axes
        self._equations = KeptEquations(self.problem)

    @property
    def rigid(self) -> bool:
        """Whether impacts are instantaneous."""
        return self.over.method.rigid

    def values(self, shares: np.ndarray) -> tuple[float, float]:
        """α₁ and α₂ at shares of their ranges."""
        return self.axes[0].value(float(shares[0])), self.axes[1].value(float(shares[1]))

    def words(self, shares: np.ndarray) -> str:
        """Both numbers."""
        return ", ".join(
            f"{axis.name} = {value:.8g}" for axis, value in zip(self.axes, self.values(shares), strict=True)
        )

    def problem(self, *shares: float) -> tuple:
        """System, η and method."""
        value, along = self.values(shares)
        system, eta, method = self.along.at(along)
        return Family(self.over.over, system, eta, method).at(value)

    def equations(self, shares: np.ndarray) -> OrbitEquations:
        """The equations at shares of the ranges; raises ValueError where a number is out of its range."""
        return self._equations(*map(float, shares))

    def at(self, orbit: Orbit, shares: np.ndarray) -> Place:
        """The equations of an orbit at shares of the ranges."""
        found = self.equations(shares)(orbit.cycle, orbit.unknowns)
        return Place(orbit, np.asarray(shares, dtype=float), found)

    def margins(self, place: Place) -> list[Margin]:
        """What keeps it an orbit."""
        return margins(place.orbit, place.evaluation, self.problem(*place.shares)[2])
