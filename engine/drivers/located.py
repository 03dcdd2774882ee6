"""Driver of Newmark's method with its step cut at each contact change."""

import numpy as np

from ..kernels.compile.options import uncompiled
from ..kernels.compile.record import Buffers, PackedBuffers
from ..kernels.status import PAUSED, STATUSES
from ..kernels.time_stepping import located as kernel
from ..kernels.time_stepping.contact_location import forcing_with
from ..result import Checkpoint, Cost, Status
from .parameters import parameters_of
from .stepping import SteppingDriver

SOLVES_PER_CALL = 2_000_000


class LocatedDriver(SteppingDriver):
    """One run of Newmark's method with located contact changes."""

    def begin(self, start: Checkpoint) -> None:
        self._scheme = kernel.located_scheme(parameters_of(*self.run))
        self._forces = self.forces_of_steps()
        if len(start.state) == kernel.STATE.size:
            self._state = np.array(start.state)
        else:
            self._state = kernel.STATE.pack(kernel.start_state(self._scheme, start.state, self.kept_from == 0))
        self._started = self._now.solves
        if not getattr(kernel.integrate_located, "signatures", True):  # compile or load outside the measured seconds
            state, self._state = self._state, self._state.copy()
            self._call(0, 0, self._no_buffers)
            self._state = state

    def forces_of_steps(self) -> np.ndarray:
        """f₁ and f at the beginning of each step of a period, and at the end of the last, (n + 1, 2)."""
        angle = self.angles_of_steps()
        return np.column_stack(uncompiled(forcing_with)(self._scheme, np.cos(angle), np.sin(angle)))

    @property
    def _now(self) -> kernel.LocatedState:
        return kernel.STATE.read(self._state)

    def periods_per_call(self) -> int:
        return max(1, SOLVES_PER_CALL // self._method.steps)

    def _call(self, last: int, most: int, buffers: PackedBuffers) -> int:
        return kernel.integrate_located(
            self._scheme, self._forces, self._state, last, most, self._window, buffers.views
        )

    def integrate(self, stop: int, buffers: PackedBuffers) -> tuple[Status, bool]:
        code = self._call(stop * self._method.steps, SOLVES_PER_CALL, buffers)
        again = code == PAUSED
        return Status.OK if again else STATUSES[code], again

    def explain(self, status: Status) -> str:
        step, n = self._now.step, self._method.steps
        if status is Status.DIVERGED:
            return self.explain_divergence(step)
        return (
            f"more than {kernel.SOLVES_PER_STEP:,} solves within step {step} (period {step / n:.2f}): contacts follow "
            "each other far faster than the excitation; take a smaller K, or a D that ends them"
        )

    def record_open_contact(self, buffers: Buffers) -> None:
        now = self._now
        if now.pressed and now.step > self._window[0]:
            time = now.step * self._scheme.h + now.offset
            kernel.end_contact(self._scheme, now.contact, time, uncompiled(kernel.motion_of)(now), buffers)

    def section_rows_done(self) -> int:
        return max(0, (self._now.step - self._window[0]) // self._method.steps)

    def cost(self) -> Cost:
        return Cost(self.seconds, steps=self._now.solves - self._started)
