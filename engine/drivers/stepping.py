"""The base of the drivers with a time step: counting in steps, and the message of a divergence."""

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from ..facts import Ending
from ..kernels.time_stepping.newmark import LIMIT
from ..methods import Newmark, TimeStepping
from ..model import System
from ..result import Checkpoint, Cost, Record
from ..wording import end_text
from .base import Driver


class SteppingDriver(Driver):
    """One run of a method with a time step; subclasses hold the solver's state as ``_state``."""

    solution = "Newmark's solution"
    solves_per_call: ClassVar[int]  # which take some hundredths of a second

    def __init__(
        self,
        system: System,
        eta: float,
        method: Newmark | TimeStepping,
        start: Checkpoint,
        keep: int,
        kept_from: int,
        record: Record | None,
    ):
        n = method.steps
        phases = record.phases(n) if record else np.zeros(1)
        super().__init__(eta, start.periods, keep, kept_from, phases, record.periods if record else 0)
        self.run = system, eta, method
        self._method = method
        self._window = (kept_from * n, self.sampled_from * n, record.stride(n) if record else n)
        self._started = start.periods * n
        self.begin(start)

    @abstractmethod
    def begin(self, start: Checkpoint) -> None:
        """Set up the kernel and the state that the run starts from."""

    def checkpoint(self) -> Checkpoint:
        return Checkpoint(*self.run, self.periods, tuple(self._state.tolist()))

    @property
    @abstractmethod
    def _now(self) -> tuple:
        """The solver's state as far as it is known; its field ``step`` counts the steps done."""

    def _steps_done(self) -> int:
        # a skip stops short of where a run is cut; a run that ended early stands where it did
        return max(self._now.step, self.periods * self._method.steps)

    def periods_per_call(self) -> int:
        return max(1, self.solves_per_call // self._method.steps)

    def section_rows_done(self) -> int:
        return max(0, (self._steps_done() - self._window[0]) // self._method.steps)

    def cost(self) -> Cost:
        return Cost(self.seconds, steps=self._steps_done() - self._started)

    def angles_of_steps(self) -> np.ndarray:
        """ητ at the beginning of each step of a period, and at the end of the last."""
        n = self._method.steps
        return 2 * np.pi * np.arange(n + 1) / n

    def explain_divergence(self, step: int, limit: str = "") -> Ending:
        """The step at which the run diverged, the reason, what to change, and the limit of stability if it is known."""
        n = self._method.steps
        return Ending(
            f"{self.solution} blew up",
            f"the gap passed {end_text(LIMIT)} base amplitudes at step {step} (period {step / n:.2f})",
            f"take more steps per period than {n}, or a smaller K or D",
            limit,
        )
