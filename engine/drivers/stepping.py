"""The base of the drivers with a time step: its state, counting in steps, and the message of a divergence."""

from abc import abstractmethod
from functools import cached_property
from typing import ClassVar

import numpy as np
from vibroscope.engine.drivers.base import Driver
from vibroscope.engine.drivers.parameters import parameters_of_stops
from vibroscope.engine.facts import Ending
from vibroscope.engine.kernels.compile.packing import Layout
from vibroscope.engine.kernels.compile.record import PackedBuffers
from vibroscope.engine.kernels.parameters import Parameters
from vibroscope.engine.kernels.status import CROSSED, FULL, PAUSED, STATUSES
from vibroscope.engine.kernels.time_stepping.newmark import LIMIT
from vibroscope.engine.methods import TimeStepping
from vibroscope.engine.model import System
from vibroscope.engine.result import Checkpoint, Cost, Record, Status
from vibroscope.engine.wording import end_text


class SteppingDriver(Driver):
    """One run of a method with a time step.

    Between two stops the state is seen from the one or the other, with the tables of that one; where it passes far
    enough from one stop the loop ends as CROSSED, and goes on as seen from the other.

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
        self._stops = [self.tables_of(p) for p in parameters_of_stops(*self.run)]
        own = len(start.state) >= self.layout.size
        self._see_from(self._first_stop(start, own))
        self._state = np.array(start.state[: self.layout.size]) if own else self.start_state(start)
        self._started = self.steps_taken()
        self.load_loop(0)

    @abstractmethod
    def tables_of(self, p: Parameters) -> dict:
        """The attributes of this driver that the loop needs, as seen from a stop."""

    def _see_from(self, stop: int) -> None:
        self._stop = stop
        vars(self).update(self._stops[stop])

    def _first_stop(self, start: Checkpoint, own: bool) -> int:
        """The number of the stop from which a start is seen."""
        if own:
            return int(start.state[self.layout.size]) if len(self._stops) > 1 else 0
        system = start.system
        return int(system.gap(start.state[0], start.state[2]) > 0.5 * system.play)

    @abstractmethod
    def turned(self, other: dict, begins: bool) -> np.ndarray:
        """The packed state as seen from the stop with the ``other`` tables; ``begins``: whether its impact is kept."""

    @abstractmethod
    def start_state(self, start: Checkpoint) -> np.ndarray:
        """The packed state at τ = 0."""

    def integrate(self, stop: int, buffers: PackedBuffers) -> tuple[Status, bool]:
        code = self.call(stop * self._method.steps, buffers)
        if code == CROSSED:
            other = 1 - self._stop
            self._state = self.turned(self._stops[other], self._now.step >= self._window[0])
            self._see_from(other)
            code = PAUSED
        again = code in (FULL, PAUSED)
        return Status.OK if again else STATUSES[code], again

    def checkpoint(self) -> Checkpoint:
        seen_from = (float(self._stop),) if len(self._stops) > 1 else ()
        return Checkpoint(*self.run, self.periods, (*self._state.tolist(), *seen_from))

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

    @cached_property
    def load(self) -> np.ndarray:
        """cos ητ and sin ητ at the beginning of each step of a period, and at the end of the last, (2, n + 1).

        Of a load that is no harmonic its value there and its slope up to the next step: between steps it is linear.
        """
        n, load = self._method.steps, self.run[0].excitation.load
        if load is None:
            angle = 2 * np.pi * np.arange(n + 1) / n
            return np.array([np.cos(angle), np.sin(angle)])
        value = load.at(np.arange(n + 1) * (self.period / n))
        return np.array([value, np.append(np.diff(value), 0.0) * (n / self.period)])

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
