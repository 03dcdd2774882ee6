"""Driver of Newmark's method with a constant step: its own loop of few operations, and skipping."""

from collections.abc import Callable

import numpy as np

from ..kernels.accelerated import skip
from ..kernels.accelerated.step_map import FREE, REACHES, SKIPPING, set_up_skipping
from ..kernels.compile.options import uncompiled
from ..kernels.compile.record import Buffers, PackedBuffers
from ..kernels.equations.rates import free_rate
from ..kernels.parameters import no_keys
from ..kernels.time_stepping import newmark
from ..methods import TimeStepping
from ..result import Checkpoint
from .parameters import parameters_of
from .stepping import SteppingDriver

STEPS_PER_CALL = 5_000_000
SHORTEST_STRIDE = 2  # steps from entry to entry of a flight's coarser tables; with fewer, skipping is no quicker


def takes_own_loop(method: TimeStepping) -> bool:
    """Whether the loop of this driver is the quickest: it skips with the first law alone."""
    return method.plain and (method.linear or not method.skips_steps)


def can_skip(eta: float, rate, steps, method: TimeStepping):
    """Whether skipping is possible and worth it here; η, the rate of free motion and the steps may be arrays."""
    return (takes_own_loop(method) and method.skips_steps) & has_strides(eta, rate, steps)


def has_strides(eta: float, rate, steps):
    """Whether a flight's coarser tables have a stride with which skipping is quicker than every step."""
    return SHORTEST_STRIDE * rate * 2 * np.pi / eta / steps <= REACHES[FREE]


class NewmarkDriver(SteppingDriver):
    """One run of Newmark's method: skipping steps where that is possible, else step by step."""

    layout = newmark.STATE
    solves_per_call = STEPS_PER_CALL

    def begin(self) -> None:
        system, eta, method = self.run
        parameters = parameters_of(system, eta, method)
        self._row = np.array(parameters)
        self._scheme = newmark.scheme_of(parameters)
        self._packed = self._cosines = None
        if can_skip(eta, free_rate(parameters), method.steps, method):
            self._packed = SKIPPING.zeros()
            set_up_skipping(self._packed, no_keys(), self._row)
        else:
            self._cosines = self.cosines_of_steps()

    def start_state(self, start: Checkpoint) -> np.ndarray:
        state = self.layout.zeros()
        newmark.write_start(self._row, state, *map(float, start.state))
        return state

    def cosines_of_steps(self) -> tuple[np.ndarray, np.ndarray]:
        """cos(ητ + ψ) of both bodies at the beginning of each step of a period, and at the end of the last.

        Where both are the same, so are the arrays: the loop then reads one of them.
        """
        angle, m = self.angles_of_steps(), self._scheme
        first, second = uncompiled(newmark.phased)(m, np.cos(angle), np.sin(angle))
        return first, first if (m.cosine1, m.sine1) == (m.cosine2, m.sine2) else second

    @property
    def loop(self) -> Callable:
        return newmark.integrate if self._packed is None else skip.integrate_skipping

    def call(self, last: int, buffers: PackedBuffers) -> int:
        arrays = self._state, last, self._window
        if self._packed is None:
            return newmark.integrate(self._scheme, self._cosines, *arrays, buffers.views)
        return skip.integrate_skipping(self._packed, *arrays, buffers.flat, buffers.sizes, True)

    def record_open_contact(self, buffers: Buffers) -> None:
        last, now = self._steps_done(), self._now
        if not now.pressed or last <= self._window[0]:
            return
        if self._packed is not None:
            skip.record_open_contact(self._packed, self._state, last, buffers)
        else:
            motion = uncompiled(newmark.motion_of)(self._scheme, now)
            newmark.end_contact(self._scheme, now.contact, last, motion, buffers)
