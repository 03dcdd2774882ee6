"""Driver of Newmark's method with a constant step: its own loop of few operations, and skipping.

A search makes thousands of runs that take less time than Python needs to set up a driver. For it
:class:`SkippedSamples` makes once what does not change from run to run, and collects nothing but samples.

Plain twin: :func:`engine.simulate` (tests/engine/test_trials.py).
"""

from collections.abc import Callable
from functools import cached_property

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.drivers.base import CAPACITY, SteppingDriver
from vibroscope.engine.drivers.parameters import at_start, parameter_rows, parameters_of_stops
from vibroscope.engine.kernels.accelerated import skip
from vibroscope.engine.kernels.accelerated.step_map import FREE, REACHES, SKIPPING, set_up_skipping
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.compile.record import Buffers, PackedBuffers, make_buffers
from vibroscope.engine.kernels.equations.motion import free_rate
from vibroscope.engine.kernels.parameters import Parameters, no_tables
from vibroscope.engine.kernels.status import FULL, OK
from vibroscope.engine.kernels.time_stepping import newmark
from vibroscope.engine.kernels.time_stepping.newmark import STATE, write_start
from vibroscope.engine.methods import Newmark, TimeStepping
from vibroscope.engine.model import System
from vibroscope.engine.result import Checkpoint, Record, check_cancelled

STEPS_PER_CALL = 5_000_000
SHORTEST_STRIDE = 2  # steps from entry to entry of a flight's coarser tables; with fewer, skipping is no quicker


def takes_own_loop(method: TimeStepping) -> bool:
    """Whether the loop of this driver is the quickest: it skips with the first law alone."""
    return method.plain and (method.linear or not method.skips_steps)


def can_skip(eta: float, rate, steps, method: TimeStepping):
    """Whether skipping is possible and worth it here; η, the rate of free motion and the steps may be arrays."""
    return (takes_own_loop(method) and method.skips_steps) & has_strides(eta, rate, steps)


def are_held(p: Parameters):
    """Whether the skips know the motion: no constant force acts on a body without a spring; p: numbers or arrays."""
    return ((p.pull == 0.0) & (p.pull1 == 0.0)) | (p.wall > 0.0)


def has_strides(eta: float, rate, steps):
    """Whether a flight's coarser tables have a stride with which skipping is quicker than every step."""
    return SHORTEST_STRIDE * rate * 2 * np.pi / eta / steps <= REACHES[FREE]


def set_up_stops(packed: np.ndarray, keys: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Write the tables of skips, (s, SKIPPING.size), of parameters as seen from each stop, (s, n); returns them."""
    for each in zip(packed, keys, rows, strict=True):
        set_up_skipping(*each)
    return packed


class NewmarkDriver(SteppingDriver):
    """One run of Newmark's method: skipping steps where that is possible, else step by step."""

    layout = newmark.STATE
    solves_per_call = STEPS_PER_CALL

    @cached_property
    def _packed(self) -> np.ndarray | None:
        """The tables of skips as seen from each stop; None where every step is taken."""
        stops = parameters_of_stops(*self.problem)
        p, harmonic = stops[0], self.system.excitation.load is None
        skips = harmonic and are_held(p) and can_skip(p.eta, free_rate(p), self.method.steps, self.method)
        return set_up_stops(*no_tables(SKIPPING, len(stops)), np.array(stops)) if skips else None

    def tables_of(self, p: Parameters) -> dict:
        scheme = newmark.scheme_of(p)
        cosines = None if self._packed is not None else self.cosines_of_steps(scheme)
        return {"_row": np.array(p), "_scheme": scheme, "_cosines": cosines}

    def start_state(self, start: Checkpoint) -> np.ndarray:
        state = np.zeros(self.layout.size + 1)
        row = np.array(at_start(Parameters(*self._row), self.load[0, 0]))
        newmark.write_start(row[None], state, *map(float, start.state))
        return state

    def turned(self, other: dict, begins: bool) -> np.ndarray:
        return self.layout.pack(uncompiled(newmark.turned)(self._scheme, other["_scheme"], self._now, begins))

    def cosines_of_steps(self, m: newmark.Scheme) -> tuple[np.ndarray, np.ndarray]:
        """cos(ητ + ψ), or the load, of both bodies at the beginning of each step, and at the end of the last.

        A constant force that no equilibrium holds is part of it.

        Where both are the same, so are the arrays: the loop then reads one of them.
        """
        first, second = uncompiled(newmark.phased)(m, *self.load)
        same = (m.cosine1, m.sine1, m.offset1) == (m.cosine2, m.sine2, m.offset2)
        first, second = first + m.offset1, second + m.offset2
        return first, first if same else second

    @property
    def loop(self) -> Callable:
        return newmark.integrate if self._packed is None else skip.integrate_skipping

    def call(self, last: int, buffers: PackedBuffers) -> int:
        arrays = self._state, last, self._window
        if self._packed is None:
            return newmark.integrate(self._scheme, self._cosines, *arrays, buffers.views)
        code = skip.integrate_skipping(self._packed, *arrays, buffers.flat, buffers.sizes, True)
        self._see_from(int(self._state[newmark.SEEN_FROM]))
        return code

    def record_open_contact(self, buffers: Buffers) -> None:
        last, now = self._steps_done(), self._now
        if not now.pressed or last <= self._window[0]:
            return
        if self._packed is not None:
            skip.record_open_contact(self._packed, self._state, last, buffers)
        else:
            motion = uncompiled(newmark.motion_of)(self._scheme, now)
            newmark.end_contact(self._scheme, now.contact, last, motion, 0.0, buffers)


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
        stops = parameters_of_stops(system, eta, self._method)
        self._skips, self._rate = are_held(stops[0]), free_rate(stops[0])
        self._rows = np.array(stops)
        self._factors = np.array(system.contact_factors[: len(stops)]).T
        self._packed, self._keys = no_tables(SKIPPING, len(stops))
        self._state = np.zeros(STATE.size + 1)
        self._step = STATE.begin("step")
        self._nothing = make_buffers(0, np.zeros(1), 0, 0)
        self._made: dict[tuple[int, int], PackedBuffers] = {}

    def can_run(self, steps: int) -> bool:
        """Whether a run with so many steps is made by skips."""
        return self._skips and bool(can_skip(self._eta, self._rate, steps, self._method))

    def run(
        self,
        numbers: tuple[float, float, int],
        start: tuple,
        periods: int,
        record: Record,
        cancelled: Poll | None = None,
    ) -> tuple[np.ndarray | None, int]:
        """Return ξ₁ and ξ₂ over the recorded periods, (2, record.periods, m), and the steps taken.

        There are no samples if the run ended early. ``numbers`` are K, D and the steps per period.

        Raises
        ------
        Cancelled
            If ``cancelled``, which is polled at first and many times a second, returned true.
        """
        K, D, steps = numbers
        stiffness, damping = self._factors  # of the second stop multiples of those of the first
        parameter_rows(self._rows, {"stiffness": K * stiffness, "damping": D * damping, "steps": steps})
        set_up_stops(self._packed, self._keys, self._rows)
        write_start(self._rows, self._state, *start)
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
