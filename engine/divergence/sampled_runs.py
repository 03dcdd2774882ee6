"""Displacements and errors of many runs of one system at one η, for searches that try many settings."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..drivers.skipped_samples import SkippedSamples
from ..methods import ExactPenalty, Newmark, TimeStepping
from ..model import System
from ..result import Checkpoint, Record
from ..simulate import sample_run
from .error import Target


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

    def is_skipped(self, method: ExactPenalty | Newmark | TimeStepping) -> bool:
        """Whether a run with this method takes milliseconds."""
        plain = method.has_step and not (method.has_choices or method.located) and method.linear
        return plain and self._can_run(method.steps)

    def run(
        self,
        method: ExactPenalty | Newmark | TimeStepping,
        start: tuple,
        periods: int,
        record: Record,
        cancelled: Callable[[], bool] | None = None,
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
        checkpoint = Checkpoint(self._system, self._eta, method, 0, start)
        options = {"periods": periods, "record": record, "cancelled": cancelled}
        samples, steps = sample_run(self._system, self._eta, method, checkpoint, **options)
        if samples is None:
            return None, steps
        return samples.displacement[:, :-1].reshape(2, record.periods, -1), steps

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
        method: ExactPenalty | Newmark | TimeStepping,
        start: tuple,
        periods: int,
        record: Record,
        cancelled: Callable[[], bool] | None = None,
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
