"""The error of a penalty solution: one number, quickly, for searches that try many settings.

It is the root mean square difference of both displacements from the reference over all sampled periods, relative to
the root mean square of the reference: ``total`` of :func:`.compare`. All periods count, since a constant step
scatters, and one of its periods may be near by luck.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..methods import Newmark, Reference
from ..model import System
from ..motions.motion import repeats_after
from ..motions.steady import steady
from ..result import Record, Response
from .grid import PER_PERIOD, best_shift, by_period, grid_of, on_grid, repeated, rms, sampled_again


class Target:
    """The reference's steady cycle, as what penalty solutions are held against.

    Calls from several threads do no harm.

    Parameters
    ----------
    reference : Response
        A run of the reference that reached its end.
    period : int, optional
        Excitation periods after which it repeats itself; by default as its section says.

    Raises
    ------
    ValueError
        If the run ended early.

    Attributes
    ----------
    reference : Response
    period : int
        0 if the reference does not repeat itself; then no error exists (see ``periodic``).
    """

    def __init__(self, reference: Response, period: int | None = None):
        if not reference.ok:
            raise ValueError(f"the reference ended as {reference.status}: {reference.message}")
        self.reference = reference
        self.period = repeats_after(reference.section) if period is None else period
        self._cycles: dict[Record, tuple[np.ndarray, float]] = {}

    @classmethod
    def find(
        cls,
        system: System,
        eta: float,
        reference: Reference | None = None,
        *,
        cancelled: Callable[[], bool] | None = None,
    ) -> "Target":
        """The motion that the reference (by default the paper's) settles to from rest.

        Raises
        ------
        ValueError
            If a number is out of range, or the run ends early.
        Cancelled
            If ``cancelled`` returned true.
        """
        found = steady(system, eta, reference or Reference(), cancelled=cancelled)
        return cls(found.response, found.period or None)

    @property
    def periodic(self) -> bool:
        """Whether the reference repeats itself: only then an error at each instant means something."""
        return self.period > 0

    def error(self, penalty: Response) -> float:
        """Rms difference of the displacements relative to the reference, over all sampled periods.

        Parameters
        ----------
        penalty : Response
            Of the same system and η, its sampled periods in step with the excitation as simulate gives them. Without
            samples, its kept periods are run again with some.

        Returns
        -------
        float
            inf if the run ended early.

        Raises
        ------
        ValueError
            If the reference does not repeat itself, or belongs to another system or η.
        """
        if not self.periodic:
            raise ValueError(
                "the reference does not repeat itself: no error exists at each instant, compare statistics"
            )
        if (penalty.system, penalty.eta) != (self.reference.system, self.reference.eta):
            raise ValueError(
                "the response and the reference belong to different systems or eta: compare like with like"
            )
        if not penalty.ok:
            return np.inf
        if penalty.trajectory is None:
            steps = penalty.method.steps if isinstance(penalty.method, Newmark) else None
            penalty = sampled_again(penalty, Record(penalty.keep, PER_PERIOD, steps))
        cycle, size = self.cycle(grid_of(penalty))
        displacement = by_period(penalty)[:2]
        shift = best_shift(cycle, displacement)
        return rms(displacement - repeated(cycle, displacement.shape[1], shift)) / size

    def cycle(self, grid: Record) -> tuple[np.ndarray, float]:
        """One cycle of ξ₁ and ξ₂ at the grid's instants, (2, period, m), and its rms; kept for the next call."""
        if grid not in self._cycles:
            cycle = on_grid(self.reference, replace(grid, periods=self.period))[:2]
            self._cycles[grid] = cycle, rms(cycle)
        return self._cycles[grid]
