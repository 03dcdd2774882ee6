"""Three parts that add up to the difference of a penalty solution from the reference.

    Newmark(K, D, Δτ) − reference(d₃) =  [Newmark(K, D, Δτ) − exact penalty(K, D)]       time step
                                       + [exact penalty(K, D) − reference(derived d₃)]   regularisation by K and D
                                       + [reference(derived d₃) − reference(d₃)]         joint damping, the model's form

(MODEL.md, "What the difference is made of".) Each bracket changes one thing: the step goes to zero, then K to infinity
at the restitution e, then the joint takes the damping that was measured. The sum telescopes, so that it holds at every
instant whatever the four solutions are.

A motion of p > 1 periods can run in p ways that differ by whole excitation periods, and each is as right as the other.
The brackets must not count that as a difference, so the reference and the exact penalty solution are moved to where
they are closest to Newmark's, and the reference with derived damping to where it is closest to the reference:
neighbours in the chain are held against each other. (Held against a reference of one period, the exact solution of a
doubled motion would find both ways equally good, and could end up a period off Newmark's.)
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from ..motions.motion import Motion
from ..result import Record, Response
from .grid import laid_over, on_grid, rms

T = TypeVar("T")
PARTS = ("time_step", "regularisation", "joint_damping")


class Runs(NamedTuple, Generic[T]):
    """One thing of each of the four solutions."""

    penalty: T
    exact: T
    derived: T
    reference: T


@dataclass(frozen=True)
class Parts:
    """Four solutions on Newmark's grid, and what they differ by.

    Attributes
    ----------
    time : (n,) ndarray
        τ of Newmark's run at the sampled instants of its kept periods.
    runs : Runs of (4, n) ndarray
        ξ₁, ξ₂, ξ₁′, ξ₂′ of each solution; nan for one that ended early.
    shifts : Runs of int
        Excitation periods by which each was moved.
    """

    time: np.ndarray
    runs: Runs[np.ndarray]
    shifts: Runs[int]

    @cached_property
    def total(self) -> np.ndarray:
        """Newmark − reference, (4, n): ξ₁, ξ₂, ξ₁′, ξ₂′; the same rows in each part."""
        return self.runs.penalty - self.runs.reference

    @cached_property
    def time_step(self) -> np.ndarray:
        """Newmark − exact penalty."""
        return self.runs.penalty - self.runs.exact

    @cached_property
    def regularisation(self) -> np.ndarray:
        """Exact penalty − reference with derived joint damping."""
        return self.runs.exact - self.runs.derived

    @cached_property
    def joint_damping(self) -> np.ndarray:
        """Reference with derived joint damping − reference."""
        return self.runs.derived - self.runs.reference

    @cached_property
    def residual(self) -> float:
        """Largest deviation of the sum of the parts from the total, in base amplitudes (and ω₁ times these)."""
        return float(np.abs(self.time_step + self.regularisation + self.joint_damping - self.total).max())

    @cached_property
    def size(self) -> float:
        """Rms of the reference's displacements."""
        return rms(self.runs.reference[:2])

    def relative(self, difference: np.ndarray) -> float:
        """Rms of the displacements in a difference, relative to those of the reference."""
        return rms(difference[:2]) / self.size

    def without(self, name: str) -> float:
        """Relative rms that would be left of the total if one of PARTS vanished and the other parts stayed."""
        return self.relative(self.total - getattr(self, name))


def parts_of(runs: Runs[Response], motions: Runs[Motion], per_period: int) -> Parts:
    """The kept periods of four runs on one grid; of those in closed form that repeat, one cycle is sampled.

    Raises
    ------
    ValueError
        If Newmark's run ended early.
    """
    penalty = runs.penalty
    keep, steps = penalty.keep, penalty.method.steps
    newmark = on_grid(penalty, Record(keep, per_period, steps))

    grid = Record(1, per_period, steps)
    reference, moved = laid_over(runs.reference, motions.reference.period, newmark, grid)
    exact, moved_exact = laid_over(runs.exact, motions.exact.period, newmark, grid)
    derived, moved_derived = laid_over(runs.derived, motions.derived.period, reference, grid)
    instants = np.arange(keep)[:, None] + grid.phases(steps)
    return Parts(
        time=penalty.window[0] + instants.ravel() * penalty.period,
        runs=Runs(*(rows.reshape(4, -1) for rows in (newmark, exact, derived, reference))),
        shifts=Runs(0, moved_exact, moved_derived, moved),
    )
