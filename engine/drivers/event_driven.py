"""Driver of the solvers in closed form: the reference and the exact penalty solution."""

import math

import numpy as np

from ..kernels.compile.packing import fold
from ..kernels.compile.record import Folded
from ..kernels.compile.record import Record as Buffers
from ..kernels.event_driven import integrate as kernel
from ..kernels.event_driven import setup
from ..kernels.event_driven.state import Anchor, Contact, Touch, touches
from ..kernels.linear.slow_subspace import fast_part
from ..kernels.linear.tables import INTEGRAL, full, make_scratch
from ..methods import ExactPenalty, Reference
from ..model import System
from ..result import Checkpoint, Cost, Record, Status
from .base import Driver
from .parameters import numbers_of
from .slow_subspace import circles

PERIODS_PER_CALL = 2000
_STATUS = {kernel.PILED_UP: Status.PILED_UP, kernel.UNRESOLVED: Status.UNRESOLVED}
MOST_PAUSES = 8  # in one period
COMPLETION = 1e-5  # the closed form of a chatter's rest leaves out the square of this


def pack(system: System, eta: float, method: Reference | ExactPenalty) -> Contact:
    """Phases and contact law as the kernels want them (:mod:`engine.kernels.event_driven.setup`)."""
    cell, rigid = numbers_of(system, eta, method), isinstance(method, Reference)
    touching = setup.touching_phase(cell, rigid)
    if not rigid:
        # z′ = A z gives ∫z dτ = A⁻¹ Δz
        generator = setup.pressed_generator(cell)
        touching.rows[:, INTEGRAL] = np.linalg.solve(full(generator, eta).T, setup.watched(cell, rigid))
    calm, fast = touching, np.zeros((4, 6))
    radius, slow_pole = (0.0, 0.0) if rigid else circles(np.array([cell]))[0]
    if radius > 0:
        fast = fast_part(generator, cell.eta, radius)
        calm = setup.calm_phase(cell, fast, slow_pole)
        calm.rows[:, INTEGRAL] = touching.rows[:, INTEGRAL]
    return Contact(
        2 * math.pi / eta,
        rigid,
        setup.flight_phase(cell),
        touching,
        calm,
        bool(radius > 0),
        fast,
        *setup.force_of(cell, rigid),
        mass_share=cell.mass_share,
        restitution=cell.restitution,
        threshold=cell.threshold,
        completion=COMPLETION,
        scratch=make_scratch(),
    )


class ClosedDriver(Driver):
    """One run in closed form, from event to event."""

    def __init__(
        self,
        system: System,
        eta: float,
        method: Reference | ExactPenalty,
        start: Checkpoint,
        keep: int,
        kept_from: int,
        record: Record | None,
    ):
        phases = record.phases(record.steps or record.per_period) if record else np.zeros(1)
        self.run = system, eta, method
        super().__init__(eta, start.periods, keep, kept_from, phases, record.periods if record else 0)
        self.packed = pack(system, eta, method)
        self._folded = fold(self.packed)
        self._events = self._evaluations = self._pauses = 0
        self._paused_in = -1.0
        self._window = (float(kept_from), float(self.sampled_from))
        self._state = _state(self.packed, start)
        if not getattr(kernel.march, "signatures", True):  # compile, or load, outside the measured seconds
            state, self._state = self._state, self._state.copy()
            self.march(start.periods - 1, self._nothing)
            self._state = state

    def periods_per_call(self) -> int:
        return PERIODS_PER_CALL

    @property
    def _anchor(self) -> Anchor:
        numbers = len(Anchor._fields) - 1
        return Anchor(*self._state[:numbers], Touch(*self._state[numbers:]))

    def march(self, stop: int, record: Folded) -> tuple[Status, bool]:
        code, events, evaluations = kernel.march(
            self._folded, self._state, float(stop), self._window, record.flat, record.sizes
        )
        self._events += events
        self._evaluations += evaluations
        if code == kernel.PAUSED:
            self._pauses = self._pauses + 1 if self._state[0] == self._paused_in else 0
            self._paused_in = self._state[0]
            if self._pauses > MOST_PAUSES:
                return Status.UNRESOLVED, False
        return _STATUS.get(code, Status.OK), code in (kernel.FULL, kernel.PAUSED)

    def explain(self, status: Status) -> str:
        period = int(self._anchor.period) + 1
        if status is Status.UNRESOLVED and self._pauses > MOST_PAUSES:
            return (
                f"following period {period} was given up: what is fast in it does not die away; "
                "take a smaller K or a larger D, or a higher eta"
            )
        if status is Status.UNRESOLVED:
            return (
                f"in period {period} the joined pendulums would part into each other: their joint damping and the two "
                "dampers contradict each other; take the derived joint damping, or smaller damping ratios"
            )
        change = "take a larger threshold or a smaller restitution" if self.packed.rigid else "take a smaller K"
        return f"over {kernel.MOST_EVENTS} impacts and contacts in period {period}: the chatter does not end; {change}"

    def close_open_contact(self, record: Buffers) -> None:
        if touches(self._anchor) and self.periods > self.kept_from:
            kernel.note_open(self.packed, self._anchor, float(self.periods), self._window, record)

    def section_rows_done(self) -> int:
        return max(0, self.periods - self.kept_from)

    def cost(self) -> Cost:
        return Cost(self.seconds, events=self._events, evaluations=self._evaluations)

    def checkpoint(self) -> Checkpoint:
        return Checkpoint(*self.run, self.periods, tuple(self._state.tolist()))


def _state(packed: Contact, start: Checkpoint) -> np.ndarray:
    if len(start.state) > 4:
        return np.array(start.state)
    x1, v1, x2, v2 = start.state
    if packed.rigid and x2 < x1:
        raise ValueError(
            f"initial gap ξ₂ − ξ₁ = {x2 - x1:g} is negative: the reference knows no penetration, start with ξ₂ ≥ ξ₁"
        )
    *numbers, touch = kernel.prepare(packed, x1, v1, x2 - x1, v2 - v1)
    return np.array([*numbers, *touch])
