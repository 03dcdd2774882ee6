"""What survives where motions do not repeat in step: how their Poincaré sections are distributed.

Two chaotic motions part at the rate of their Lyapunov exponent, so that their difference at an instant says nothing
about either. The distribution of the section does not depend on the start. Two of them differ by the Wasserstein
distance: how far the points of one must move, on average, to become those of the other. For as many points on a line it
is the mean of |aₖ − bₖ| over the sorted values. (That is scipy.stats.wasserstein_distance, to which the tests hold it;
the page does without SciPy.) It is taken for ξ₁ and ξ₂, relative to the rms of the reference's.

Finite sections of one and the same motion differ as well. The distance between two halves of the reference's own
section, scaled by 1/√2 as sections twice as long are compared, is the floor: differences below some of it are chance.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from ..result import Response
from ..simulate import simulate
from .grid import rms
from .parts import Runs

SECTION = 1000  # periods: a section is cheap, and its distribution is told to about 1/√SECTION
CHANCE = 3.0  # floors


@dataclass(frozen=True)
class Statistics:
    """Wasserstein distances of the sections, relative to the rms of the reference's; nan where a run ended early.

    Attributes
    ----------
    total : float
        Newmark's section from the reference's.
    time_step, regularisation, joint_damping : float
        The same between neighbours in the chain of :mod:`.parts`. Distances do not add up: the total is at most
        their sum.
    floor : float
        What chance makes of sections as long as these.
    sections : Runs of (SECTION, 2) ndarray
        ξ₁ and ξ₂ of each run.
    """

    total: float
    time_step: float
    regularisation: float
    joint_damping: float
    floor: float
    sections: Runs[np.ndarray] = field(repr=False)

    @property
    def alike(self) -> bool:
        """Whether the distributions differ by no more than CHANCE floors."""
        return self.total <= CHANCE * self.floor

    def of(self, section: np.ndarray) -> float:
        """``total`` if Newmark's section were this one."""
        return distance(section, self.sections.reference) / rms(self.sections.reference)


def statistics(runs: Runs[Response]) -> Statistics:
    """Hold the sections of four runs against each other, each followed from its checkpoint for SECTION periods."""
    sections = Runs(*(section_of(run) for run in runs))
    size = rms(sections.reference)
    halves = np.split(sections.reference, 2)
    return Statistics(
        total=distance(sections.penalty, sections.reference) / size,
        time_step=distance(sections.penalty, sections.exact) / size,
        regularisation=distance(sections.exact, sections.derived) / size,
        joint_damping=distance(sections.derived, sections.reference) / size,
        floor=distance(*halves) / size / math.sqrt(2),
        sections=sections,
    )


def distance(one: np.ndarray, other: np.ndarray) -> float:
    """Mean of the Wasserstein distances of the columns of two (n, k) arrays, n points on a line each."""
    return float(np.mean(np.abs(np.sort(one, axis=0) - np.sort(other, axis=0))))


def section_of(run: Response) -> np.ndarray:
    """ξ₁ and ξ₂, (SECTION, 2); nan if the run ended early."""
    if run.ok:
        run = simulate(run.system, run.eta, run.method, periods=SECTION, keep=SECTION, initial=run.checkpoint)
    if not run.ok:
        return np.full((SECTION, 2), np.nan)
    return run.section[:, [0, 2]]
