"""The base of all drivers: call a kernel in pieces, so that a run can be cancelled, and collect what it records."""

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
from vibroscope.engine.facts import Ending
from vibroscope.engine.kernels.compile.record import IMPACT_COLUMNS, Buffers, PackedBuffers, make_buffers
from vibroscope.engine.result import Checkpoint, Cost, Impacts, Status, Trajectory, check_cancelled

CAPACITY = 4096  # rows of impacts and contacts in the buffers, which the driver empties when they are full


_USED = set()  # loops that this process has called, so that they are compiled, or loaded


class Driver(ABC):
    """One run of one solver.

    Subclasses hold the packed tables and the solver's state; ``periods`` counts what is done since the start of the
    run.
    """

    def __init__(self, eta: float, periods: int, keep: int, kept_from: int, phases: np.ndarray, sampled_periods: int):
        self.period = 2 * math.pi / eta
        self.periods = periods
        self.kept_from = kept_from
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

    def advance(self, stop: int, cancelled: Callable[[], bool] | None, *, record: bool) -> tuple[Status, str]:
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
            status, again = self.integrate(upto, buffers)
            self.seconds += time.perf_counter() - begin
            self._collect(buffers.views)
            if status is not Status.OK:
                return status, self.explain(status)
            if not again:
                self.periods = upto
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
    def integrate(self, stop: int, buffers: PackedBuffers) -> tuple[Status, bool]:
        """Call the kernel up to the end of period ``stop``; the flag: it has to be called again."""

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
