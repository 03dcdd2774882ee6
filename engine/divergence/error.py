"""The error of a penalty solution as one number, computed quickly for searches that try many settings.

It is the root mean square difference of both displacements from the reference over all sampled periods, relative to the
root mean square of the reference: ``total`` of :func:`.compare.compare`. All periods count, since a constant step makes
a section scatter, and a single period may be close to the reference by chance.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.divergence.grid import (
    PER_PERIOD,
    about_rest,
    closest_repetition,
    grid_of,
    relative_to,
    rms,
    samples_by_period,
    samples_on_grid,
    simulate_samples,
)
from vibroscope.engine.drivers.newmark import SkippedSamples
from vibroscope.engine.drivers.section import period_of
from vibroscope.engine.methods import ExactPenalty, Reference, TimeStepping
from vibroscope.engine.model import System
from vibroscope.engine.motions.steady import steady
from vibroscope.engine.result import Record, Response
from vibroscope.engine.simulate import simulate


class Target:
    """The steady cycle of the reference, which the errors of penalty solutions are measured from.

    It may be used from several threads.

    Parameters
    ----------
    reference : Response
        A run of the reference that reached its end.
    period : int, optional
        Excitation periods after which it repeats itself; by default it is found from the section.

    Raises
    ------
    ValueError
        If the run ended early.

    Attributes
    ----------
    reference : Response
    period : int
        0 if the reference does not repeat itself; then there is no error (see ``periodic``).
    """

    def __init__(self, reference: Response, period: int | None = None):
        if not reference.ok:
            raise ValueError(f"the reference ended as {reference.status}: {reference.message}")
        self.reference = reference
        self.period = period_of(reference.section) if period is None else period
        self._cycles: dict[Record, tuple[np.ndarray, float]] = {}

    @classmethod
    def find(
        cls,
        system: System,
        eta: float,
        reference: Reference | None = None,
        *,
        initial: Sequence[float] | None = None,
        cancelled: Poll | None = None,
    ) -> "Target":
        """Find the motion that the reference (by default the paper's) settles to from rest, or from ``initial``.

        Raises
        ------
        ValueError
            If a number is out of range, or the run ends early.
        Cancelled
            If ``cancelled`` returned true.
        """
        found = steady(system, eta, reference or Reference(), initial=initial, cancelled=cancelled)
        return cls(found.response, found.period or None)

    @property
    def periodic(self) -> bool:
        """Whether the reference repeats itself: only then a difference at each instant is meaningful."""
        return self.period > 0

    def error(self, penalty: Response, cancelled: Poll | None = None) -> float:
        """Return the rms difference of the displacements over all sampled periods, relative to the reference.

        Parameters
        ----------
        penalty : Response
            Of the same system and η, sampled in phase with the excitation as by simulate. Without samples its kept
            periods are simulated again.

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
            steps = penalty.method.steps if penalty.method.has_step else None
            penalty = simulate_samples(penalty, Record(penalty.keep, PER_PERIOD, steps), cancelled)
        return self.error_of_samples(samples_by_period(penalty)[:2], grid_of(penalty), cancelled)

    def error_of_samples(self, displacement: np.ndarray, grid: Record, cancelled: Poll | None = None) -> float:
        """Return the error of ξ₁ and ξ₂ sampled on a grid, (2, periods, m)."""
        cycle, size = self.cycle(grid, cancelled)
        return relative_to(rms(displacement - closest_repetition(cycle, displacement)), size)

    def cycle(self, grid: Record, cancelled: Poll | None = None) -> tuple[np.ndarray, float]:
        """Return one cycle of ξ₁ and ξ₂ on the grid, (2, period, m), and its rms from rest; both are cached."""
        if grid not in self._cycles:
            cycle = samples_on_grid(self.reference, replace(grid, periods=self.period), cancelled)[:2]
            self._cycles[grid] = cycle, rms(about_rest(cycle, self.reference.system))
        return self._cycles[grid]


class SampledRuns:
    """Runs in any thread; those whose steps are skipped share their arrays with the next run.

    Parameters
    ----------
    system : System
    eta : float
    """

    def __init__(self, system: System, eta: float):
        self._system, self._eta = system, eta
        first = SkippedSamples(system, eta)
        self._can_run, self._idle = first.can_run, [first]  # that no thread uses

    def is_skipped(self, method: ExactPenalty | TimeStepping) -> bool:
        """Whether a run with this method takes milliseconds."""
        return method.plain and method.linear and self._can_run(method.steps)

    def run(
        self,
        method: ExactPenalty | TimeStepping,
        start: tuple,
        periods: int,
        record: Record,
        cancelled: Poll | None = None,
        every_step: bool = False,
    ) -> tuple[np.ndarray | None, int]:
        """Return ξ₁ and ξ₂ over the recorded periods, (2, record.periods, m), and the steps taken.

        There are no samples if the run ended early. With ``every_step`` no step is skipped.

        Raises
        ------
        Cancelled
            If ``cancelled``, which is polled many times a second, returned true.
        """
        if every_step:
            method = replace(method, every_step=True)
        elif self.is_skipped(method):
            numbers = method.stiffness, method.damping, method.steps
            return self._skip(numbers, start, periods, record, cancelled)
        options = {"periods": periods, "keep": record.periods, "initial": start, "record": record}
        found = simulate(self._system, self._eta, method, cancelled=cancelled, **options)
        samples, steps = found.trajectory, found.cost.steps
        return None if samples is None else samples.displacement[:, :-1].reshape(2, record.periods, -1), steps

    def _skip(self, *run) -> tuple[np.ndarray | None, int]:
        try:
            own = self._idle.pop()
        except IndexError:  # as many threads run
            own = SkippedSamples(self._system, self._eta)
        try:
            return own.run(*run)
        finally:
            self._idle.append(own)

    def error(
        self,
        target: Target,
        method: ExactPenalty | TimeStepping,
        start: tuple,
        periods: int,
        record: Record,
        cancelled: Poll | None = None,
        every_step: bool = False,
    ) -> tuple[float, float]:
        """Return the error of a run over the recorded periods, inf if it ends early, and the steps per period.

        Arguments and errors are those of :meth:`run`.
        """
        displacement, steps = self.run(method, start, periods, record, cancelled, every_step)
        if displacement is None:
            return np.inf, steps / periods
        grid = replace(record, periods=1, per_period=displacement.shape[2])
        return target.error_of_samples(displacement, grid, cancelled), steps / periods
