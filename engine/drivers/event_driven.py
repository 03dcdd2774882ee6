"""Driver of the event-driven solvers in closed form: the reference and the exact penalty solution."""

from collections.abc import Callable, Sequence
from typing import ClassVar, NamedTuple

import numpy as np

from ..facts import ETA, Ending, stated
from ..kernels.compile.options import uncompiled
from ..kernels.compile.record import Buffers, PackedBuffers, make_buffers
from ..kernels.equations.coordinates import contact_coordinates, displacements
from ..kernels.event_driven import integrate as kernel
from ..kernels.event_driven.disturbance import follow_disturbance
from ..kernels.event_driven.output import record_open_contact
from ..kernels.event_driven.saltation import make_variation
from ..kernels.event_driven.setup import full_pressed_generators, set_up_events, watched_in_contact, write_laws
from ..kernels.event_driven.state import (
    STATE,
    SYSTEM,
    HybridState,
    HybridSystem,
    in_contact,
    write_start,
)
from ..kernels.linear.tables import INTEGRAL
from ..kernels.parameters import no_keys
from ..kernels.status import FULL, OK, PAUSED, STATUSES
from ..methods import ExactPenalty, Reference
from ..model import System
from ..result import Checkpoint, Cost, Record, Status
from .base import Driver, is_first_use
from .parameters import parameters_of
from .slow_subspace import separating_circles

PERIODS_PER_CALL = 2000
NO_BUFFERS = make_buffers(0, np.zeros(1), 0, 0)
COMPLETION = 1e-5  # the closed form of a chatter's end neglects the square of this


class EventDrivenSystem(NamedTuple):
    """The tables of a run, packed for the kernels and as views of the same array."""

    packed: np.ndarray
    views: HybridSystem


def set_up(
    system: System,
    eta: float,
    method: Reference | ExactPenalty,
    completion: float | None = None,
    *,
    impulses: bool = True,
) -> EventDrivenSystem:
    """Phases and laws of a run.

    ``completion``: how far a chatter must have come to be summed (COMPLETION); ``impulses``: whether those of penalty
    contacts are asked for.
    """
    parameters, rigid = parameters_of(system, eta, method), method.rigid
    row = np.array(parameters)
    circle = np.zeros(2) if rigid else separating_circles(row[None])[0]
    packed = SYSTEM.zeros()
    set_up_events(packed, no_keys(), row, rigid, circle, COMPLETION if completion is None else completion)
    views = SYSTEM.read(packed)
    if impulses and not rigid:  # z′ = A z gives ∫z dτ = A⁻¹ Δz
        generator = full_pressed_generators(row[None])[0]
        integral = np.linalg.solve(generator.T, watched_in_contact(parameters, rigid))
        views.contact.rows[:, INTEGRAL] = views.slow_contact.rows[:, INTEGRAL] = integral
    return EventDrivenSystem(packed, views)


class EventDriver(Driver):
    """One run in closed form, from event to event.

    Attributes
    ----------
    loop : compiled function
        The event loop; one of another signature belongs to a subclass with its own ``begin`` and ``call``.
    """

    loop: ClassVar = staticmethod(kernel.integrate)

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
        self._events = self._evaluations = self._pauses = 0
        self._paused_in = -1.0
        self._window = (float(kept_from), float(self.sampled_from))
        self.begin(start)
        if is_first_use(self.loop):  # compile, or load, outside the measured seconds
            state, self._state = self._state, self._state.copy()
            self.integrate(start.periods - 1, self._no_buffers)
            self._state = state

    def begin(self, start: Checkpoint) -> None:
        """Set up the tables and the state that the run starts from."""
        self._system = set_up(*self.run)
        self._state = packed_start(self._system, start)

    def call(self, stop: int, buffers: PackedBuffers) -> tuple[int, int, int]:
        """Call the event loop."""
        packed, window = self._system.packed, self._window
        return self.loop(packed, self._state, float(stop), window, buffers.flat, buffers.sizes, None)

    def periods_per_call(self) -> int:
        return PERIODS_PER_CALL

    @property
    def _now(self) -> HybridState:
        return STATE.read(self._state)

    def integrate(self, stop: int, buffers: PackedBuffers) -> tuple[Status, bool]:
        code, events, evaluations = self.call(stop, buffers)
        self._events += events
        self._evaluations += evaluations
        if code == PAUSED:
            self._pauses = self._pauses + 1 if self._now.period == self._paused_in else 0
            self._paused_in = self._now.period
            if self._pauses > kernel.MOST_PAUSES:
                return Status.UNRESOLVED, False
        again = code in (FULL, PAUSED)
        return Status.OK if again else STATUSES[code], again

    def explain(self, status: Status) -> Ending:
        period = int(self._now.period) + 1
        if status is Status.UNRESOLVED and self._pauses > kernel.MOST_PAUSES:
            return Ending(
                f"following period {period} was given up",
                "what is fast in it does not die away",
                stated("take a smaller K or a larger D, or a higher {}", ETA),
            )
        if status is Status.UNRESOLVED:
            return Ending(
                f"in period {period} the joined bodies would part into each other",
                "their joint damping and the two dampers contradict each other",
                "take the derived joint damping, or smaller damping ratios",
            )
        rigid = self._system.views.rigid
        change = "take a larger threshold or a smaller restitution" if rigid else "take a smaller K"
        what = f"over {kernel.MOST_EVENTS} impacts and contacts in period {period}"
        return Ending(what, "the chatter does not end", change)

    def record_open_contact(self, buffers: Buffers) -> None:
        if uncompiled(in_contact)(self._now) and self.periods > self.kept_from:
            record_open_contact(self._system.views, self._now, float(self.periods), self._window, buffers)

    def section_rows_done(self) -> int:
        return max(0, self.periods - self.kept_from)

    def cost(self) -> Cost:
        return Cost(self.seconds, events=self._events, evaluations=self._evaluations)

    def checkpoint(self) -> Checkpoint:
        return Checkpoint(*self.run, self.periods, tuple(self._state.tolist()))


def start_at(system: EventDrivenSystem, y: Sequence[float]) -> np.ndarray:
    """The packed hybrid state at τ = 0 with y = (ξ₁, ξ₁′, g, g′)."""
    state = STATE.zeros()
    write_start(system.packed, state, *map(float, y))
    return state


def hybrid_state(system: System, eta: float, method: Reference | ExactPenalty, y: Sequence[float]) -> np.ndarray:
    """The same without the tables of a run, of which a start needs none; a penetration of the reference is left out."""
    packed, state, rigid = SYSTEM.zeros(), STATE.zeros(), method.rigid
    write_laws(packed, parameters_of(system, eta, method), rigid, False, COMPLETION)
    x1, v1, gap, rate = map(float, y)
    write_start(packed, state, x1, v1, max(gap, 0.0) if rigid else gap, rate)
    return state


class LinearFlow(NamedTuple):
    """The flow of a solution in closed form, from τ = 0 on, in y = (ξ₁, ξ₁′, g, g′)."""

    system: EventDrivenSystem
    periods_per_call: int = 512  # of a disturbance that is followed: some milliseconds

    def start(self, y: Sequence[float]) -> np.ndarray:
        """The packed hybrid state at y."""
        return start_at(self.system, y)

    def with_jacobian(self, start: np.ndarray, periods: float) -> tuple[np.ndarray, np.ndarray, int] | None:
        """The result of :func:`integrate_variation`."""
        return integrate_variation(self.system, start, periods)

    def follow(self, y: np.ndarray, direction: np.ndarray, growth: np.ndarray, section: np.ndarray) -> None:
        """The work of :func:`..kernels.event_driven.disturbance.follow_disturbance`."""
        variation, nothing = uncompiled(make_variation)(1), (NO_BUFFERS.flat, NO_BUFFERS.sizes)
        packed, _ = self.system
        follow_disturbance(packed, STATE.zeros(), variation, nothing, y, direction, growth, section)


def integrate_variation(
    system: EventDrivenSystem, start: np.ndarray, periods: float
) -> tuple[np.ndarray, np.ndarray, int] | None:
    """Integrate the motion with its derivative with respect to its start.

    Parameters
    ----------
    system : EventDrivenSystem
    start : ndarray
        Packed hybrid state at τ = 0.
    periods : float

    Returns
    -------
    (4,) ndarray, (4, 4) ndarray, int
        y = (ξ₁, ξ₁′, g, g′) at the end; its Jacobian; a number that differs between different sequences of events.
        None if the integration ends early.
    """
    variation = uncompiled(make_variation)()
    status, _, _ = kernel.integrate(
        system.packed, start, periods, (0.0, 0.0), NO_BUFFERS.flat, NO_BUFFERS.sizes, variation
    )
    return (variation.end, variation.state, int(variation.course[0])) if status == OK else None


def packed_start(system: EventDrivenSystem, start: Checkpoint) -> np.ndarray:
    """The packed hybrid state of a checkpoint.

    Raises
    ------
    ValueError
        If the bodies of a reference penetrate each other.
    """
    if len(start.state) > 4:
        return np.array(start.state)
    rigid = system.views.rigid
    if rigid:
        check_apart(start)
    x1, v1, gap, rate = uncompiled(contact_coordinates)(start.system, *start.state)  # no arrays: a call takes longer
    return start_at(system, (x1, v1, max(gap, 0.0) if rigid else gap, rate))


def check_apart(start: Checkpoint) -> None:
    """Check a start of the reference; raises ValueError if the bodies penetrate each other."""
    overlap = start.system.overlap_of(start.state)
    if overlap > 0:
        raise ValueError(overlap_message(start.system, -overlap))


def overlap_message(system: System, gap: float) -> str:
    """Why a reference cannot start from a state with a negative gap, and what to do."""
    start = "ξ₁ ≤ clearance" if system.wall else "ξ₂ ≥ ξ₁" if system.clearance == 0 else "ξ₂ ≥ ξ₁ − clearance"
    name = "clearance − ξ₁" if system.wall else "ξ₂ − ξ₁" if system.clearance == 0 else "clearance + ξ₂ − ξ₁"
    return f"initial gap {name} = {gap:g} is negative: the reference knows no penetration, start with {start}"


def contact_state(system: System, state: np.ndarray | Sequence[float]) -> np.ndarray:
    """Convert (…, 4) states ξ₁, ξ₁′, ξ₂, ξ₂′ to ξ₁, ξ₁′, g, g′ as kernels count them."""
    return _converted(contact_coordinates, system, state)


def displaced_state(system: System, y: np.ndarray | Sequence[float]) -> np.ndarray:
    """Convert (…, 4) states ξ₁, ξ₁′, g, g′ as kernels count them to ξ₁, ξ₁′, ξ₂, ξ₂′."""
    return _converted(displacements, system, y)


def _converted(conversion: Callable, system: System, states: np.ndarray | Sequence[float]) -> np.ndarray:
    states = np.asarray(states, dtype=float)
    out = np.empty_like(states)
    for k, column in enumerate(uncompiled(conversion)(system, *(states[..., k] for k in range(4)))):
        out[..., k] = column
    return out
