"""The three parts that add up to the difference between a penalty solution and the reference.

    Newmark(K, D, Δτ) − reference(d₃) =  [Newmark(K, D, Δτ) − exact penalty(K, D)]       time step
                                       + [exact penalty(K, D) − reference(derived d₃)]   regularisation by K and D
                                       + [reference(derived d₃) − reference(d₃)]         joint damping         (53)

Each bracket changes one thing: the time step tends to zero; then K tends to infinity at the restitution e; then the
joined pendulums have the measured damping instead of that of the two dampers. The sum telescopes, so that it holds at
every instant for any four solutions.

A motion of p > 1 periods can run in p ways that differ by whole excitation periods, all of equal right. The brackets
must not count that as a difference. So the reference and the exact penalty solution are shifted by whole periods to be
closest to Newmark's, and the reference with derived damping to be closest to the reference: each solution is aligned
with a neighbour in the chain. (Aligned with a reference of one period, the exact penalty solution of a doubled motion
would have two equally good shifts, and could end up one period off Newmark's.)
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from vibroscope.engine.divergence.grid import about_rest, relative_to, rms, samples_beside, samples_on_grid
from vibroscope.engine.facts import Choice, Statement, stated
from vibroscope.engine.methods import CONTACT_LAWS
from vibroscope.engine.motions.description import Motion
from vibroscope.engine.motions.motion import SAMPLED_PERIODS
from vibroscope.engine.result import Record, Response

T = TypeVar("T")
PART_NAMES = {"time_step": "time step", "regularisation": "K and D", "joint_damping": "joint damping"}
PARTS = tuple(PART_NAMES)


class PerSolution(NamedTuple, Generic[T]):
    """One value for each of the four solutions of a comparison."""

    penalty: T
    exact: T
    derived: T
    reference: T


@dataclass(frozen=True)
class DifferenceSeries:
    """The four solutions on Newmark's grid, their difference and its parts as time series.

    Attributes
    ----------
    time : (n,) ndarray
        τ of Newmark's run at the sampled instants of its kept periods.
    runs : PerSolution of (4, n) ndarray
        ξ₁, ξ₂, ξ₁′, ξ₂′ of each solution; nan for one that ended early.
    shifts : PerSolution of int
        Excitation periods by which each was shifted.
    size : float
        Rms of the reference's displacements from the static equilibrium.
    periods : int
        Excitation periods in the series.
    """

    time: np.ndarray
    runs: PerSolution[np.ndarray]
    shifts: PerSolution[int]
    size: float
    periods: int

    @cached_property
    def total(self) -> np.ndarray:
        """Newmark − reference, (4, n): ξ₁, ξ₂, ξ₁′, ξ₂′; the parts have the same rows."""
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

    def relative(self, difference: np.ndarray) -> float:
        """Return the rms of the displacements in a difference, relative to ``size``.

        Relative to a reference that stays at rest a difference is infinite, unless there is none.
        """
        return relative_to(rms(difference[:2]), self.size)

    def without(self, name: str) -> float:
        """Return the relative rms of the total without one of PARTS."""
        return self.relative(self.total - getattr(self, name))


def difference_series(
    runs: PerSolution[Response],
    motions: PerSolution[Motion],
    per_period: int,
    cancelled: Callable[[], bool] | None = None,
) -> DifferenceSeries:
    """Sample the kept periods of four runs, SAMPLED_PERIODS at most, on one grid, up to ``per_period`` times a period.

    Of closed-form solutions that repeat themselves one cycle is sampled and repeated.

    Raises
    ------
    ValueError
        If Newmark's run ended early.
    """
    penalty = runs.penalty
    keep, steps = min(penalty.keep, SAMPLED_PERIODS), penalty.method.steps
    newmark = samples_on_grid(penalty, Record(keep, per_period, steps), cancelled)

    grid = Record(1, per_period, steps)
    reference, reference_shift = samples_beside(runs.reference, motions.reference.period, newmark, grid, cancelled)
    exact, exact_shift = samples_beside(runs.exact, motions.exact.period, newmark, grid, cancelled)
    derived, derived_shift = samples_beside(runs.derived, motions.derived.period, reference, grid, cancelled)
    instants = np.arange(keep)[:, None] + grid.phases(steps)
    return DifferenceSeries(
        time=penalty.window[0] + instants.ravel() * penalty.period,
        runs=PerSolution(*(rows.reshape(4, -1) for rows in (newmark, exact, derived, reference))),
        shifts=PerSolution(0, exact_shift, derived_shift, reference_shift),
        size=rms(about_rest(reference[:2], penalty.system)),
        periods=keep,
    )


@dataclass(frozen=True)
class Difference:
    """The difference of a penalty solution from the reference, and its parts as far as they are known.

    Attributes
    ----------
    measure : {"displacements", "sections"}
        Rms of the displacements over the kept periods, where the reference repeats itself; else the distance of the
        Poincaré sections (:mod:`.statistics`).
    total : float
        Relative to the reference; nan if a solution does not reach the end of the longer runs for the sections.
    parts : dict of str to float
        The same of each of PARTS (:mod:`.parts`), of the joint damping only where the reference has one of its own;
        empty where the displacements are compared and not all four motions repeat themselves. They add up at each
        instant, not as numbers.
    chance : float
        The largest distance of sections that may be chance; 0 for displacements.
    law : str
        The contact law of the penalty solution.
    """

    measure: str
    total: float
    parts: dict[str, float]
    chance: float = 0.0
    law: str = CONTACT_LAWS[0]

    def name(self, part: str) -> str | Statement:
        """Return the words for a part; of K and D with a law that is another one than the spring and the damper."""
        named = part == "regularisation" and self.law != CONTACT_LAWS[0]
        return stated("{} (law {})", PART_NAMES[part], Choice("law", (self.law,))) if named else PART_NAMES[part]

    @property
    def largest(self) -> str:
        """The name of the largest part; "" where the parts are not known."""
        return max(self.parts, key=self.parts.__getitem__, default="")


def known(values: dict[str, float]) -> dict[str, float]:
    """Only the finite ones."""
    return {name: float(value) for name, value in values.items() if np.isfinite(value)}
