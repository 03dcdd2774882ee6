"""Samples of many short runs of Newmark's method, one after the other in the same arrays: for searches.

A search makes thousands of runs that take less time than Python needs to set up a driver. So what does not change from
run to run is made once, and nothing is collected but samples.

Plain twin: :func:`engine.simulate.sample_run` (tests/engine/test_trials.py).
"""

from collections.abc import Callable

import numpy as np
from vibroscope.engine.drivers.base import CAPACITY
from vibroscope.engine.drivers.newmark import STEPS_PER_CALL, can_skip
from vibroscope.engine.drivers.parameters import parameter_rows, parameters_of_stops
from vibroscope.engine.kernels.accelerated import skip
from vibroscope.engine.kernels.accelerated.step_map import SKIPPING, set_up_skipping
from vibroscope.engine.kernels.compile.record import PackedBuffers, make_buffers
from vibroscope.engine.kernels.equations.rates import free_rate
from vibroscope.engine.kernels.parameters import no_keys
from vibroscope.engine.kernels.status import FULL, OK
from vibroscope.engine.kernels.time_stepping.newmark import STATE, write_start
from vibroscope.engine.methods import Newmark
from vibroscope.engine.model import System
from vibroscope.engine.result import Record, check_cancelled


class SkippedSamples:
    """Runs of one system at one η by skips, in one thread at a time.

    Parameters
    ----------
    system : System
    eta : float
    """

    def __init__(self, system: System, eta: float):
        self._method = Newmark(1.0, 0.0, 1000)
        self._eta = eta
        parameters, *_ = parameters_of_stops(system, eta, self._method)
        self._has_one_stop = not system.two_stops
        self._rate = free_rate(parameters)
        self._rows = np.array([parameters])
        self._packed, self._keys, self._state = SKIPPING.zeros(), no_keys(), STATE.zeros()
        self._step = STATE.begin("step")
        self._nothing = make_buffers(0, np.zeros(1), 0, 0)
        self._made: dict[tuple[int, int], PackedBuffers] = {}

    def can_run(self, steps: int) -> bool:
        """Whether a run with so many steps is made by skips."""
        return self._has_one_stop and bool(can_skip(self._eta, self._rate, steps, self._method))

    def run(
        self,
        numbers: tuple[float, float, int],
        start: tuple,
        periods: int,
        record: Record,
        cancelled: Callable[[], bool] | None = None,
    ) -> tuple[np.ndarray | None, int]:
        """Return ξ₁ and ξ₂ over the recorded periods, (2, record.periods, m), and the steps taken.

        There are no samples if the run ended early. ``numbers`` are K, D and the steps per period.

        Raises
        ------
        Cancelled
            If ``cancelled``, which is polled at first and many times a second, returned true.
        """
        steps = numbers[2]
        parameter_rows(self._rows, dict(zip(("stiffness", "damping", "steps"), numbers, strict=True)))
        set_up_skipping(self._packed, self._keys, self._rows[0])
        write_start(self._rows[0], self._state, *start)
        stride, sampled = record.stride(steps), periods - record.periods
        window, buffers = (sampled * steps, sampled * steps, stride), self._buffers(record.periods, -(-steps // stride))
        for begin, end, recorded in ((0, sampled, self._nothing), (sampled, periods, buffers)):
            at_once = max(1, STEPS_PER_CALL // steps)
            for stop in (*range(begin + at_once, end, at_once), end):
                check_cancelled(cancelled)
                if self._integrate(stop * steps, window, recorded) != OK:
                    return None, int(self._state[self._step])
        samples = buffers.views.samples[:-1, 0:3:2]
        return np.ascontiguousarray(samples.T).reshape(2, record.periods, -1), periods * steps

    def _integrate(self, stop: int, window: tuple[int, int, int], buffers: PackedBuffers) -> int:
        code = FULL
        while code == FULL:  # of impacts and contacts, which nobody asks for
            buffers.views.used[:] = 0
            code = skip.integrate_skipping(self._packed, self._state, stop, window, buffers.flat, buffers.sizes, False)
        return code

    def _buffers(self, periods: int, per_period: int) -> PackedBuffers:
        """Buffers for so many periods and samples in each."""
        asked = periods, per_period
        if asked not in self._made:
            self._made[asked] = make_buffers(periods, np.zeros(per_period), periods, CAPACITY)
        return self._made[asked]
