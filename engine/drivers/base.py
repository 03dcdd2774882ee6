"""The base of all drivers: call a kernel in pieces, so that a run can be cancelled, and collect what it records.

The base of the drivers with a time step: its state, counting in steps, and the message of a divergence.
"""

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import ClassVar

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.drivers.parameters import parameters_of_stops
from vibroscope.engine.facts import Amount, Dimensionless, Ending, Statement, stated
from vibroscope.engine.kernels.compile.packing import Layout
from vibroscope.engine.kernels.compile.record import IMPACT_COLUMNS, Buffers, PackedBuffers, make_buffers
from vibroscope.engine.kernels.parameters import Parameters
from vibroscope.engine.kernels.status import CROSSED, FULL, OK, PAUSED, STATUSES
from vibroscope.engine.kernels.time_stepping.newmark import LIMIT
from vibroscope.engine.result import Checkpoint, Cost, Impacts, Record, Status, Trajectory, check_cancelled
from vibroscope.engine.wording import end_text

CAPACITY = 4096  # rows of impacts and contacts in the buffers, which the driver empties when they are full


_USED = set()  # loops that this process has called, so that they are compiled, or loaded


class Driver(ABC):
    """One run of one solver.

    Subclasses hold the packed tables and the solver's state; ``periods`` counts what is done since the start of the
    run.
    """

    def __init__(self, start: Checkpoint, keep: int, kept_from: int, record: Record | None):
        self.problem = self.system, self.eta, self.method = start.system, start.eta, start.method
        self.period = 2 * math.pi / self.eta
        self.periods = start.periods
        self.kept_from = kept_from
        sampled_periods, phases = 0, np.zeros(1)
        if record:
            steps = self.method.steps or record.steps or record.per_period
            sampled_periods, phases = record.periods, record.phases(steps)
        self.sampled_from = kept_from + keep - sampled_periods
        self.seconds = 0.0
        self._buffers = make_buffers(keep, phases, sampled_periods, CAPACITY)
        self._no_buffers = make_buffers(0, phases, 0, 0)
        self._impacts: list[np.ndarray] = []
        self._contacts: list[np.ndarray] = []

    def load_loop(self, stop: int) -> None:
        """Compile or load the loop outside the measured seconds, by a call up to where nothing is left to do."""
        if self.loop not in _USED:
            state, self._state = self._state, self._state.copy()
            self.call(stop, self._no_buffers)
            self._state = state
            _USED.add(self.loop)

    def advance(self, stop: int, cancelled: Poll | None, *, record: bool) -> tuple[Status, str]:
        """Run to the end of period ``stop``; returns status and message.

        Raises
        ------
        Cancelled
            If ``cancelled`` returned true.
        """
        buffers = self._buffers if record else self._no_buffers
        while self.periods < stop:
            check_cancelled(cancelled)
            upto = min(stop, self.periods + self.periods_per_call())
            self.prepare()
            begin = time.perf_counter()
            code = self.integrate(upto, buffers)
            self.seconds += time.perf_counter() - begin
            self._collect(buffers.views)
            if code == OK:
                self.periods = upto
            elif code not in (FULL, PAUSED):
                return STATUSES[code], self.explain(STATUSES[code])
        return Status.OK, ""

    def _collect(self, buffers: Buffers) -> None:
        """Copy the recorded impacts and contacts, and empty their buffers."""
        impacts, contacts = buffers.used
        if impacts:
            self._impacts.append(buffers.impacts[:impacts].copy())
        if contacts:
            self._contacts.append(buffers.contacts[:contacts].copy())
        buffers.used[:] = 0

    @property
    def section(self) -> np.ndarray:
        """Rows of the kept periods that were completed."""
        return self._buffers.views.section[: self.section_rows_done()]

    def results(self) -> dict:
        """The fields of a Response that the run has filled."""
        self.record_open_contact(self._buffers.views)
        self._collect(self._buffers.views)
        rows = np.concatenate([np.empty((0, IMPACT_COLUMNS)), *self._impacts])
        contacts = np.concatenate([np.empty((0, 2)), *self._contacts])
        return {
            "section": self.section,
            "impacts": Impacts(
                time=rows[:, 0],
                position=rows[:, 1],
                velocity_before=rows[:, 2:4],
                velocity_after=rows[:, 4:6],
                impulse=rows[:, 6],
                closing_speed=rows[:, 7],
            ),
            "contacts": contacts[contacts[:, 1] > contacts[:, 0]],
            "trajectory": self._trajectory(),
            "cost": self.cost(),
        }

    def _trajectory(self) -> Trajectory | None:
        phases, samples = self._buffers.views.phases, self._buffers.views.samples
        if len(samples) == 0 or self.section_rows_done() < len(self._buffers.views.section):
            return None
        whole, part = np.divmod(np.arange(len(samples)), len(phases))
        time = (self.sampled_from + whole + phases[part]) * self.period
        columns = np.ascontiguousarray(samples.T)
        return Trajectory(time, columns[[0, 2]], columns[[1, 3]], columns[4])

    @abstractmethod
    def periods_per_call(self) -> int:
        """Periods that take some hundredths of a second, so that a cancelled run ends soon."""

    def prepare(self) -> None:  # noqa: B027, most kernels ask for nothing
        """Make what the next call of the kernel needs, outside the measured seconds."""

    @property
    @abstractmethod
    def loop(self) -> Callable:
        """The loop that :meth:`call` calls."""

    @abstractmethod
    def call(self, stop: int, buffers: PackedBuffers):
        """Call the loop up to the end of a period, or of a step; returns, maybe with more, the code of its end."""

    @abstractmethod
    def integrate(self, stop: int, buffers: PackedBuffers) -> int:
        """Call the kernel up to the end of period ``stop``; FULL and PAUSED: it has to be called again."""

    @abstractmethod
    def explain(self, status: Status) -> Ending:
        """Why the run ended and what to change."""

    @abstractmethod
    def record_open_contact(self, buffers: Buffers) -> None:
        """Record the contact that is open at the end of the run as ending there."""

    @abstractmethod
    def section_rows_done(self) -> int:
        """Kept periods that were completed."""

    @abstractmethod
    def cost(self) -> Cost:
        """Cost so far."""

    @abstractmethod
    def checkpoint(self) -> Checkpoint:
        """The state as it is."""


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

    def __init__(self, start: Checkpoint, keep: int, kept_from: int, record: Record | None):
        super().__init__(start, keep, kept_from, record)
        n = self.method.steps
        self._window = (kept_from * n, self.sampled_from * n, record.stride(n) if record else n)
        self._stops = [self.tables_of(p) for p in parameters_of_stops(*self.problem)]
        own = len(start.state) >= self.layout.size
        self._see_from(self._first_stop(start, own))
        self._state = self._as_seen(start.state if own else self.start_state(start))
        self._started = self.steps_taken()
        self.load_loop(0)

    @abstractmethod
    def tables_of(self, p: Parameters) -> dict:
        """The attributes of this driver that the loop needs, as seen from a stop."""

    def _see_from(self, stop: int) -> None:
        self._stop = stop
        vars(self).update(self._stops[stop])

    def _as_seen(self, state: Sequence[float]) -> np.ndarray:
        """A packed state, and behind it the stop from which it is seen."""
        return np.append(state[: self.layout.size], float(self._stop))

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

    def integrate(self, stop: int, buffers: PackedBuffers) -> int:
        code = self.call(stop * self.method.steps, buffers)
        if code != CROSSED:
            return code
        other = 1 - self._stop
        state = self.turned(self._stops[other], self._now.step >= self._window[0])
        self._see_from(other)
        self._state = self._as_seen(state)
        return PAUSED

    def checkpoint(self) -> Checkpoint:
        state = self._state if len(self._stops) > 1 else self._state[:-1]
        return Checkpoint(*self.problem, self.periods, tuple(state.tolist()))

    @property
    def _now(self) -> tuple:
        """The solver's state; its field ``step`` counts the steps done."""
        return self.layout.read(self._state)

    def _steps_done(self) -> int:
        # a skip stops short of where a run is cut; a run that ended early stands where it did
        return max(self._now.step, self.periods * self.method.steps)

    def steps_taken(self) -> int:
        """Those since τ = 0, as its cost counts them."""
        return self._steps_done()

    def periods_per_call(self) -> int:
        return max(1, self.solves_per_call // self.method.steps)

    def section_rows_done(self) -> int:
        return max(0, (self._steps_done() - self._window[0]) // self.method.steps)

    def cost(self) -> Cost:
        return Cost(self.seconds, steps=self.steps_taken() - self._started)

    @cached_property
    def load(self) -> np.ndarray:
        """cos ητ and sin ητ at the beginning of each step of a period, and at the end of the last, (2, n + 1).

        Of a load that is no harmonic its value there and its slope up to the next step: between steps it is linear.
        """
        n, load = self.method.steps, self.system.excitation.load
        if load is None:
            angle = 2 * np.pi * np.arange(n + 1) / n
            return np.array([np.cos(angle), np.sin(angle)])
        value = load.at(np.arange(n + 1) * (self.period / n))
        return np.array([value, np.append(np.diff(value), 0.0) * (n / self.period)])

    def explain(self, status: Status) -> Ending:
        return self.explain_divergence(self._now.step)

    def explain_divergence(self, step: int, limit: str = "") -> Ending:
        """The step at which the run diverged, the reason, what to change, and the limit of stability if it is known."""
        n, method = self.method.steps, self.method
        solution = "Newmark's solution" if method.is_newmarks else f"the solution by {method.integrator.short_title()}"
        when, finer = f"period {step / n:.2f}", f"more steps per period than {n}"
        if self.system.excitation.load is not None:  # there is no period
            when, finer = Statement(Dimensionless("τ = "), Amount(step * self.period / n, "time", 3)), "shorter steps"
        cause = stated("the gap passed {} base amplitudes at step {} ({})", end_text(LIMIT), str(step), when)
        return Ending(f"{solution} blew up", cause, f"take {finer}, or a smaller K or D", limit)
