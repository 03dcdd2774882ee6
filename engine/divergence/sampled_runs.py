"""Displacements of many runs of one system at one η, for searches that try many settings."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..drivers.skipped_samples import SkippedSamples
from ..methods import ExactPenalty, Newmark, TimeStepping
from ..model import System
from ..result import Checkpoint, Record
from ..simulate import sample_run


class SampledRuns:
    """Runs in one thread at a time; those whose steps are skipped share their arrays.

    Parameters
    ----------
    system : System
    eta : float
    """

    def __init__(self, system: System, eta: float):
        self._system, self._eta = system, eta
        self._skipping = SkippedSamples(system, eta)

    def is_skipped(self, method: ExactPenalty | Newmark | TimeStepping) -> bool:
        """Whether a run with this method takes milliseconds."""
        plain = method.has_step and not (method.has_choices or method.located) and method.linear
        return plain and self._skipping.can_run(method.steps)

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
            return self._skipping.run(numbers, start, periods, record, cancelled)
        checkpoint = Checkpoint(self._system, self._eta, method, 0, start)
        options = {"periods": periods, "record": record, "cancelled": cancelled}
        samples, steps = sample_run(self._system, self._eta, method, checkpoint, **options)
        if samples is None:
            return None, steps
        return samples.displacement[:, :-1].reshape(2, record.periods, -1), steps
