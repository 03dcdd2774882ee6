"""Driver of Newmark's method."""

import numpy as np

from ..kernels.accelerated import skip as leaps
from ..kernels.accelerated.step_map import FREE, REACHES
from ..kernels.compile.packing import room
from ..kernels.compile.record import Folded
from ..kernels.compile.record import Record as Buffers
from ..kernels.event_driven.setup import free_pole, no_keys
from ..kernels.time_stepping import newmark as kernel
from ..kernels.time_stepping.setup import begin_steps, scheme_of, set_up_leaps
from ..methods import Newmark
from ..model import System
from ..result import Checkpoint, Cost, Status
from .parameters import numbers_of
from .stepping import SteppedDriver

STEPS_PER_CALL = 5_000_000
SHORTEST_STRIDE = 2  # steps from entry to entry of a flight's coarser tables; with fewer, walking is as quick


def pack(system: System, eta: float, method: Newmark) -> kernel.Scheme:
    """Coefficients of one step (derived in :mod:`engine.kernels.time_stepping.newmark`)."""
    return scheme_of(numbers_of(system, eta, method))


class NewmarkDriver(SteppedDriver):
    """One run of Newmark's method."""

    def begin(self, start: Checkpoint) -> None:
        system, eta, method = self.run
        self._scheme = pack(system, eta, method)
        self._leaps = self._cosines = None
        cell = numbers_of(system, eta, method)
        if method.every_step or SHORTEST_STRIDE * free_pole(cell) * self._scheme.h > REACHES[FREE]:
            self._cosines = self._cosines_of_steps()
        else:
            self._leaps = room(leaps.SIZE)
            set_up_leaps(self._leaps, no_keys(), np.array(cell))
        self._state = _state(self._scheme, system, eta, method, start)
        self._started = start.periods * method.steps
        self._load()

    def _load(self) -> None:
        """Compile or load what this run calls, outside the measured seconds; a call up to step 0 does nothing."""
        if not getattr(self._kernel(True), "signatures", True) or not getattr(self._kernel(False), "signatures", True):
            state, self._state = self._state, self._state.copy()
            self.march(0, self._nothing)
            self._state = state

    def _kernel(self, kept: bool):
        if self._leaps is not None:
            return leaps.leap
        return kernel.advance_recorded if kept else kernel.advance

    def periods_per_call(self) -> int:
        return max(1, STEPS_PER_CALL // self._method.steps)

    def march(self, stop: int, record: Folded) -> tuple[Status, bool]:
        last = stop * self._method.steps
        if self._leaps is not None:
            code = leaps.leap(self._leaps, self._state, last, self._window, record.flat, record.sizes, True)
        elif record is not self._nothing:
            code = kernel.advance_recorded(self._scheme, self._cosines, self._state, last, self._window, record.views)
        else:
            code = kernel.advance(self._scheme, self._cosines, self._state, last)
        return (Status.DIVERGED if code == kernel.DIVERGED else Status.OK), code == kernel.FULL

    def explain(self, status: Status) -> str:
        step = int(self._state[kernel.STEP])
        return self._blown_up(f"step {step} (period {step / self._method.steps:.2f})", kernel.LIMIT)

    def close_open_contact(self, record: Buffers) -> None:
        last = self._steps_done()
        if self._state[kernel.CONTACT] > 0.0 and last > self._window[0]:
            if self._leaps is not None:
                leaps.finish(self._leaps, self._state.copy(), last, record)
            else:
                kernel.close_contact(
                    self._scheme, self._state, last, kernel.motion_of(self._scheme, self._state), record
                )

    def _steps_done(self) -> int:
        # leaps stop short of where a run is cut; a run that blew up stands where it did
        return max(int(self._state[kernel.STEP]), self.periods * self._method.steps)

    def section_rows_done(self) -> int:
        return max(0, (self._steps_done() - self._window[0]) // self._method.steps)

    def cost(self) -> Cost:
        return Cost(self.seconds, steps=self._steps_done() - self._started)


def _state(scheme: kernel.Scheme, system: System, eta: float, method: Newmark, start: Checkpoint) -> np.ndarray:
    state = np.zeros(leaps.SLOTS)
    if len(start.state) == leaps.SLOTS:
        state[:] = start.state
        return state
    begin_steps(state, scheme, numbers_of(system, eta, method), start.state)
    return state
