"""Comparison of motions that do not repeat in step: the distributions of their Poincaré sections.

Two chaotic motions separate at the rate of their Lyapunov exponent, so that their difference at an instant says nothing
about either. The distribution of the section does not depend on the initial state. Two distributions differ by their
Wasserstein distance: how far the points of one must move, on average, to become those of the other. For equally many
points on a line it is the mean of |aᵢ − bᵢ| over the sorted values. (The tests check it against
scipy.stats.wasserstein_distance; the engine does not need SciPy.) It is taken for ξ₁ and ξ₂, relative to the rms of the
reference's section, from the static equilibrium.

Finite sections of one motion differ by chance, too. The distance between the two halves of the reference's own section,
divided by √2 because the compared sections are twice as long, is the floor: a total of a few floors may be chance.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..result import Response
from ..simulate import simulate
from .grid import about_rest, rms
from .parts import PerSolution

SECTION = 1000  # periods: quick to compute, and their distribution is known to about 1/√SECTION
CHANCE = 3.0  # floors


@dataclass(frozen=True)
class Statistics:
    """Wasserstein distances of the sections, relative to ``size``; nan where a run ended early.

    Attributes
    ----------
    total : float
        Distance of Newmark's section from the reference's.
    time_step, regularisation, joint_damping : float
        Distance between neighbours in the chain of :mod:`.parts`. Distances do not add up: the total is at most
        their sum.
    floor : float
        Distance that chance alone causes between sections of this length.
    sections : PerSolution of (SECTION, 2) ndarray
        ξ₁ and ξ₂ of each run.
    size : float
        Rms of the reference's section from the static equilibrium.
    """

    total: float
    time_step: float
    regularisation: float
    joint_damping: float
    floor: float
    sections: PerSolution[np.ndarray] = field(repr=False)
    size: float = field(repr=False)

    @property
    def chance(self) -> float:
        """The largest distance that may be chance."""
        return CHANCE * self.floor

    def total_of(self, section: np.ndarray) -> float:
        """Return the relative distance of another section, (SECTION, 2), from the reference's."""
        return wasserstein_distance(section, self.sections.reference) / self.size


def statistics(runs: PerSolution[Response], cancelled: Callable[[], bool] | None = None) -> Statistics:
    """Compare the sections of four runs, each continued from its checkpoint for SECTION periods."""
    sections = PerSolution(*(long_section(run, cancelled) for run in runs))
    size = rms(about_rest(sections.reference.T, runs.reference.system))
    halves = np.split(sections.reference, 2)
    return Statistics(
        total=wasserstein_distance(sections.penalty, sections.reference) / size,
        time_step=wasserstein_distance(sections.penalty, sections.exact) / size,
        regularisation=wasserstein_distance(sections.exact, sections.derived) / size,
        joint_damping=wasserstein_distance(sections.derived, sections.reference) / size,
        floor=wasserstein_distance(*halves) / size / math.sqrt(2),
        sections=sections,
        size=size,
    )


def wasserstein_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Return the mean of the Wasserstein distances between the columns of two (n, k) arrays."""
    return float(np.mean(np.abs(np.sort(one, axis=0) - np.sort(other, axis=0))))


def long_section(run: Response, cancelled: Callable[[], bool] | None = None) -> np.ndarray:
    """Return ξ₁ and ξ₂ of the section of a long run from the checkpoint, (SECTION, 2); nan if it ends early."""
    if run.ok:
        how = {"periods": SECTION, "keep": SECTION, "initial": run.checkpoint, "cancelled": cancelled}
        run = simulate(run.system, run.eta, run.method, **how)
    if not run.ok:
        return np.full((SECTION, 2), np.nan)
    return run.section[:, [0, 2]]
