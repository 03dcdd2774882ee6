"""A plane of starts: two of the four initial numbers, or the start phase of the excitation and one of them."""

from dataclasses import dataclass

import numpy as np
from vibroscope.engine.arguments import shown
from vibroscope.engine.checks import require
from vibroscope.engine.methods import Method
from vibroscope.engine.model import COORDINATES, System
from vibroscope.engine.simulate import FARTHEST

PHASE = "phase"  # when a run begins, as a share of the excitation period
AXES = (*COORDINATES, PHASE)


@dataclass(frozen=True)
class StartPlane:
    """The plane of starts of a basin.

    Attributes
    ----------
    axes : (str, str)
        Of `AXES`, different ones.
    spans : ((float, float), (float, float))
        Ends of both.
    start : (4,) tuple of float
        ξ₁, ξ₁′, ξ₂, ξ₂′ of every start; those on the axes have no effect.
    phase : float
        Of every start, where it is not on an axis: 0 ≤ phase < 1.

    Raises
    ------
    ValueError
        If an axis is unknown or given twice, or a number is out of range.
    """

    axes: tuple[str, str]
    spans: tuple[tuple[float, float], tuple[float, float]]
    start: tuple[float, float, float, float]
    phase: float = 0.0

    def __post_init__(self):
        if unknown := [name for name in self.axes if name not in AXES]:
            raise ValueError(f"{shown(unknown[0])} is no axis of a plane of starts: give two of {', '.join(AXES)}")
        if self.axes[0] == self.axes[1]:
            raise ValueError(f"both axes are {self.axes[0]}: give two different ones of {', '.join(AXES)}")
        for name, span in zip(self.axes, self.spans, strict=True):
            for end in span:
                _checked(name, end)
        for name, value in zip(COORDINATES, self.start, strict=True):
            _checked(f"start {name}", value)
        _checked(PHASE, self.phase)

    def check(self, system: System) -> None:
        """Raise a ValueError where the system has no such starts."""
        second = [name for name in self.axes if name in COORDINATES[2:]]
        if system.wall and second:
            raise ValueError(f"{second[0]} cannot be an axis: a wall does not move; give xi1, v1 or phase")
        if system.wall and any(self.start[2:]):
            raise ValueError(f"start xi2, v2 = {self.start[2]:g}, {self.start[3]:g}: a wall does not move; give 0, 0")
        if PHASE in self.axes and not system.excitation.drives:
            raise ValueError("phase cannot be an axis: nothing drives the bodies; give two of xi1, v1, xi2, v2")

    def starts(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """ξ₁, ξ₁′, ξ₂, ξ₂′ and the phase of the starts at points of the plane, (n, 4) and (n,)."""
        columns = np.column_stack([np.tile(self.start, (len(x), 1)), np.full(len(x), self.phase)])
        for name, values in zip(self.axes, (x, y), strict=True):
            columns[:, AXES.index(name)] = values
        return columns[:, :4], columns[:, 4] % 1.0

    def lattice(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """The starts of count × count points, each in the middle of its part of the plane."""
        middles = (np.arange(count) + 0.5) / count
        x, y = (low + (high - low) * middles for low, high in self.spans)
        return self.starts(np.repeat(x, count), np.tile(y, count))


def can_begin(system: System, method: Method, starts: np.ndarray) -> np.ndarray:
    """Whether a solver can begin from each start, (n,) of bool: the reference knows no penetration."""
    if not method.rigid:
        return np.ones(len(starts), bool)
    return system.overlaps_of(starts) == 0


def _checked(name: str, value: float) -> None:
    if name == PHASE:
        require(name, value, 0, 1, "give a share of the excitation period")
    else:
        require(name, value, -FARTHEST, FARTHEST, "start within a million units of length")
