"""The base of the drivers with a time step: its state, counting in steps, and the message of a divergence."""

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

import numpy as np

from ..facts import Ending
from ..kernels.compile.packing import Layout
from ..kernels.compile.record import PackedBuffers
from ..kernels.status import FULL, PAUSED, STATUSES
from ..kernels.time_stepping.newmark import LIMIT
from ..methods import TimeStepping
from ..model import System
from ..result import Checkpoint, Cost, Record, Status
from ..wording import end_text
from .base import Driver, is_first_use


class SteppingDriver(Driver):
    """One run of a method with a time step.

    Attributes
    ----------
    layout : Layout
        Of the solver's state, which is packed in ``_state``.
    """

    layout: ClassVar[Layout]
    solves_per_call: ClassVar[int]  # which take some hundredths of a second

    def __init__(
        self,
        system: System,
        eta: float,
        method: TimeStepping,
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
        self.begin()
        own = len(start.state) == self.layout.size
        self._state = np.array(start.state) if own else self.start_state(start)
        self._started = self.steps_taken()
        self._load()

    @abstractmethod
    def begin(self) -> None:
        """Set up what the loop needs."""

    @abstractmethod
    def start_state(self, start: Checkpoint) -> np.ndarray:
        """The packed state at τ = 0."""

    @property
    @abstractmethod
    def loop(self) -> Callable:
        """The loop that :meth:`call` calls."""

    @abstractmethod
    def call(self, last: int, buffers: PackedBuffers) -> int:
        """Integrate to the end of step ``last``; returns the code of :mod:`..kernels.status`, FULL or PAUSED: again."""

    def _load(self) -> None:
        """Compile or load the loop outside the measured seconds; a call up to step 0 does nothing."""
        if is_first_use(self.loop):
            state, self._state = self._state, self._state.copy()
            self.call(0, self._no_buffers)
            self._state = state

    def integrate(self, stop: int, buffers: PackedBuffers) -> tuple[Status, bool]:
        code = self.call(stop * self._method.steps, buffers)
        again = code in (FULL, PAUSED)
        return Status.OK if again else STATUSES[code], again

    def checkpoint(self) -> Checkpoint:
        return Checkpoint(*self.run, self.periods, tuple(self._state.tolist()))

    @property
    def _now(self) -> tuple:
        """The solver's state; its field ``step`` counts the steps done."""
        return self.layout.read(self._state)

    def _steps_done(self) -> int:
        # a skip stops short of where a run is cut; a run that ended early stands where it did
        return max(self._now.step, self.periods * self._method.steps)

    def steps_taken(self) -> int:
        """Those since τ = 0, as its cost counts them."""
        return self._steps_done()

    def periods_per_call(self) -> int:
        return max(1, self.solves_per_call // self._method.steps)

    def section_rows_done(self) -> int:
        return max(0, (self._steps_done() - self._window[0]) // self._method.steps)

    def cost(self) -> Cost:
        return Cost(self.seconds, steps=self.steps_taken() - self._started)

    def angles_of_steps(self) -> np.ndarray:
        """ητ at the beginning of each step of a period, and at the end of the last."""
        n = self._method.steps
        return 2 * np.pi * np.arange(n + 1) / n

    def explain(self, status: Status) -> Ending:
        return self.explain_divergence(self._now.step)

    def explain_divergence(self, step: int, limit: str = "") -> Ending:
        """The step at which the run diverged, the reason, what to change, and the limit of stability if it is known."""
        n, method = self._method.steps, self._method
        solution = "Newmark's solution" if method.is_newmarks else f"the solution by {method.integrator.short_title()}"
        return Ending(
            f"{solution} blew up",
            f"the gap passed {end_text(LIMIT)} base amplitudes at step {step} (period {step / n:.2f})",
            f"take more steps per period than {n}, or a smaller K or D",
            limit,
        )
