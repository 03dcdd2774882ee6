"""Comparison of motions that do not repeat in step: the distributions of their Poincaré sections.

Two chaotic motions separate at the rate of their Lyapunov exponent, so that their difference at an instant says nothing
about either. The distribution of the section does not depend on the initial state. Two distributions differ by their
Wasserstein distance: how far the points of one must move, on average, to become those of the other. For equally many
points on a line it is the mean of |aᵢ − bᵢ| over the sorted values. (The tests check it against
scipy.stats.wasserstein_distance; the engine does not need SciPy.) It is taken for ξ₁ and ξ₂, relative to the rms of the
reference's section, from the static equilibrium.

Finite sections of one motion differ by chance, too: by as much as neighbouring blocks of it do, less the longer they
are (:func:`.window.chance_distance`). Blocks that follow each other show chance and not drift. That of both motions
together is the floor: a total of a few floors may be chance.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from vibroscope.engine.divergence.grid import about_rest, rms, run_again
from vibroscope.engine.divergence.parts import PerSolution
from vibroscope.engine.divergence.tolerances import CHANCE
from vibroscope.engine.divergence.window import SECTION, chance_distance, wasserstein_distance
from vibroscope.engine.model import DISPLACEMENTS
from vibroscope.engine.result import Response


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

    @property
    def without_joint_damping(self) -> float:
        """Relative distance of Newmark's section from that of the reference with derived joint damping."""
        return wasserstein_distance(self.sections.penalty, self.sections.derived) / self.size


def statistics(runs: PerSolution[Response], cancelled: Callable[[], bool] | None = None) -> Statistics:
    """Compare the sections of four runs over their SECTION kept periods, or as many from their checkpoints."""
    sections = PerSolution(*(_section(run, cancelled) for run in runs))
    size = rms(about_rest(sections.reference.T, runs.reference.system))
    return Statistics(
        total=wasserstein_distance(sections.penalty, sections.reference) / size,
        time_step=wasserstein_distance(sections.penalty, sections.exact) / size,
        regularisation=wasserstein_distance(sections.exact, sections.derived) / size,
        joint_damping=wasserstein_distance(sections.derived, sections.reference) / size,
        floor=rms(np.array([chance_distance(each) for each in (sections.penalty, sections.reference)])) / size,
        sections=sections,
        size=size,
    )


def _section(run: Response, cancelled: Callable[[], bool] | None) -> np.ndarray:
    """Return ξ₁ and ξ₂ of the section, (SECTION, 2); nan if the run ends early."""
    if run.ok and run.keep != SECTION:
        run = run_again(run, periods=SECTION, keep=SECTION, initial=run.checkpoint, cancelled=cancelled)
    return run.section[:, DISPLACEMENTS] if run.ok else np.full((SECTION, 2), np.nan)
