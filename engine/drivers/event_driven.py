"""Driver of the event-driven solvers in closed form: the reference and the exact penalty solution.

Contacts with slow and fast modes, whose slow modes can be followed at their own pace.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import ClassVar, NamedTuple

import numpy as np
from vibroscope.engine.drivers.base import Driver
from vibroscope.engine.drivers.parameters import parameters_of_stops
from vibroscope.engine.facts import ETA, Ending, stated
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.compile.record import Buffers, PackedBuffers, make_buffers
from vibroscope.engine.kernels.equations.motion import contact_coordinates, displacements, pressed_generator
from vibroscope.engine.kernels.event_driven import integrate as kernel
from vibroscope.engine.kernels.event_driven import setup
from vibroscope.engine.kernels.event_driven.output import record_open_contact
from vibroscope.engine.kernels.event_driven.saltation import Variation, make_variation
from vibroscope.engine.kernels.event_driven.setup import (
    SEPARATION,
    full_pressed_generators,
    set_up_events,
    watched_in_contact,
    write_laws,
)
from vibroscope.engine.kernels.event_driven.state import (
    FREQUENCY,
    GIVEN,
    SEEN_FROM,
    STATE,
    SYSTEM,
    HybridState,
    HybridSystem,
    in_contact,
)
from vibroscope.engine.kernels.event_driven.two_stops import write_start
from vibroscope.engine.kernels.linear.tables import INTEGRAL
from vibroscope.engine.kernels.parameters import Parameters, no_tables
from vibroscope.engine.kernels.status import OK, PAUSED, UNRESOLVED
from vibroscope.engine.load import Load
from vibroscope.engine.methods import ExactPenalty, Reference
from vibroscope.engine.model import System
from vibroscope.engine.result import Checkpoint, Cost, Record, Status

PERIODS_PER_CALL = 2000
NO_BUFFERS = make_buffers(0, np.zeros(1), 0, 0)
COMPLETION = 1e-5  # the closed form of a chatter's end neglects the square of this


def separating_circles(rows: np.ndarray) -> np.ndarray:
    """A circle between the slow and the fast eigenvalues of each penalty contact.

    Parameters
    ----------
    rows : (n, len(Parameters)) ndarray
        Rows of :class:`engine.kernels.parameters.Parameters`.

    Returns
    -------
    (n, 2) ndarray
        Radius of the circle (see :mod:`engine.kernels.event_driven.setup`) and largest |eigenvalue| inside; zeros
        where the eigenvalues do not fall into groups.
    """
    circles = np.zeros((len(rows), 2))
    stiff = np.flatnonzero(setup.are_stiff(rows))
    if len(stiff) == 0:
        return circles
    sizes = np.sort(np.abs(np.linalg.eigvals(setup.full_pressed_generators(rows[stiff]))), axis=1)
    wide = sizes[:, 1:] > SEPARATION * sizes[:, :-1]
    last = wide.shape[1] - 1 - np.argmax(wide[:, ::-1], axis=1)  # between the fastest of the separate groups
    inner, outer = (np.take_along_axis(sizes, k[:, None], axis=1)[:, 0] for k in (last, last + 1))
    circles[stiff] = np.where(wide.any(axis=1)[:, None], np.column_stack([np.sqrt(inner * outer), inner]), 0.0)
    return circles


class EventDrivenSystem(NamedTuple):
    """The tables of a run as seen from each stop, packed for the kernels and as views of the same array."""

    packed: np.ndarray  # (1, n) or (2, n)
    views: HybridSystem  # as seen from the first stop
    second: HybridSystem | None = None

    def seen_from(self, state: np.ndarray) -> HybridSystem:
        """The views as the packed hybrid state is seen."""
        return self.second if state[SEEN_FROM] else self.views


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
    stops, completion = parameters_of_stops(system, eta, method), COMPLETION if completion is None else completion
    load = system.excitation.load
    packed, keys = no_tables(SYSTEM, len(stops), 0 if load is None else load.segments.size)
    how = method.rigid, completion, impulses, load
    return EventDrivenSystem(packed, *(_set_up_stop(*each, *how) for each in zip(packed, keys, stops, strict=True)))


def _set_up_stop(
    packed: np.ndarray,
    keys: np.ndarray,
    p: Parameters,
    rigid: bool,
    completion: float,
    impulses: bool,
    load: Load | None,
) -> HybridSystem:
    """Write phases, laws and segments of a load as seen from one stop, and return views of them."""
    row = np.array(p)
    circle = np.zeros(2) if rigid or load is not None else separating_circles(row[None])[0]
    set_up_events(packed, keys, row, rigid, circle, completion)
    views = SYSTEM.read(packed)
    if load is not None:
        packed[SYSTEM.size :] = load.segments.ravel()
        views.load[[GIVEN, FREQUENCY]] = 1.0, load.frequency
    if impulses and not rigid:
        generator = full_pressed_generators(row[None])[0]
        integral = integral_of(generator, watched_in_contact(p, rigid))
        pulled = -integral[:4] @ pressed_generator(p)[:, 6]
        views.contact.rows[:, INTEGRAL] = views.slow_contact.rows[:, INTEGRAL] = np.append(integral, pulled)
    return views


def integral_of(generator: np.ndarray, watched: np.ndarray) -> np.ndarray:
    """The row r with ∫w·z dτ = r·Δz for the row w that is ``watched``: z′ = A z gives r = A⁻ᵀw.

    With a pull p, z′ = A z + p, the time that passes counts with −r·p.

    Two bodies without springs have no equilibrium, and A no inverse; what is watched does not depend on where they are.
    Of a load that is linear in time the last two factors are those of ∫C and ∫S
    (:func:`..kernels.event_driven.state.load_integral`).
    """
    if len(generator) == 6 and not generator[5].any():
        own = integral_of(generator[:4, :4], watched[:4])
        return np.append(own, watched[4:] - own @ generator[:4, 4:])
    if not generator[:, 0].any():
        return np.linalg.lstsq(generator.T, watched)[0]
    return np.linalg.solve(generator.T, watched)


class EventDriver(Driver):
    """One run in closed form, from event to event.

    Attributes
    ----------
    loop : compiled function
        The event loop; one of another signature belongs to a subclass with its own ``begin`` and ``call``.
    """

    loop: ClassVar = staticmethod(kernel.integrate)

    def __init__(self, start: Checkpoint, keep: int, kept_from: int, record: Record | None):
        super().__init__(start, keep, kept_from, record)
        self._events = self._evaluations = self._pauses = 0
        self._paused_in = -1.0
        self._window = (float(kept_from), float(self.sampled_from))
        self.begin(start)
        self.load_loop(start.periods - 1)

    def begin(self, start: Checkpoint) -> None:
        """Set up the tables and the state that the run starts from."""
        self._hybrid = set_up(*self.problem)
        self._state = packed_start(self._hybrid, start)

    def call(self, stop: int, buffers: PackedBuffers) -> tuple[int, int, int]:
        """Call the event loop."""
        run = self._hybrid.packed, self._state, float(stop), self._window
        return self.loop(*run, buffers.flat, buffers.sizes, None)

    def periods_per_call(self) -> int:
        return PERIODS_PER_CALL

    @property
    def _now(self) -> HybridState:
        return STATE.read(self._state)

    @property
    def _place(self) -> float:
        """The period in which the run stands; of a load that is no harmonic, the thousandth part of its only one."""
        now = self._now
        return now.period if self.system.excitation.load is None else now.tau // (1e-3 * self.period)

    def integrate(self, stop: int, buffers: PackedBuffers) -> int:
        code, events, evaluations = self.call(stop, buffers)
        self._events += events
        self._evaluations += evaluations
        if code != PAUSED:
            return code
        self._pauses = self._pauses + 1 if self._place == self._paused_in else 0
        self._paused_in = self._place
        return UNRESOLVED if self._pauses > kernel.MOST_PAUSES else PAUSED

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
        rigid = self._hybrid.views.rigid
        change = "take a larger threshold or a smaller restitution" if rigid else "take a smaller K"
        what = f"over {kernel.MOST_EVENTS} impacts and contacts in period {period}"
        return Ending(what, "the chatter does not end", change)

    def record_open_contact(self, buffers: Buffers) -> None:
        if uncompiled(in_contact)(self._now) and self.periods > self.kept_from:
            views = self._hybrid.seen_from(self._state)
            record_open_contact(views, self._now, float(self.periods), self._window, buffers)

    def section_rows_done(self) -> int:
        return max(0, self.periods - self.kept_from)

    def cost(self) -> Cost:
        return Cost(self.seconds, events=self._events, evaluations=self._evaluations)

    def checkpoint(self) -> Checkpoint:
        return Checkpoint(*self.problem, self.periods, tuple(self._state.tolist()))


def start_at(packed: np.ndarray, y: Sequence[float]) -> np.ndarray:
    """The packed hybrid state at τ = 0 with y = (ξ₁, ξ₁′, g, g′), from the laws of each stop, (1, n) or (2, n)."""
    state = np.zeros(SEEN_FROM + 1)
    write_start(packed, state, tuple(map(float, y)))
    return state


def hybrid_state(system: System, eta: float, method: Reference | ExactPenalty, y: Sequence[float]) -> np.ndarray:
    """The same without the tables of a run, of which a start needs none."""
    stops = parameters_of_stops(system, eta, method)
    packed, _ = no_tables(SYSTEM, len(stops))
    for each, p in zip(packed, stops, strict=True):
        write_laws(each, p, method.rigid, False, COMPLETION)
    return start_at(packed, y)


class Flow(ABC):
    """The flow of a solution without a time step, from τ = 0 on, in y = (ξ₁, ξ₁′, g, g′)."""

    periods_per_call: ClassVar[int]  # of a disturbance that is followed: some milliseconds

    @abstractmethod
    def start(self, y: Sequence[float]) -> np.ndarray:
        """The packed hybrid state at y."""

    @abstractmethod
    def with_jacobian(self, start: np.ndarray, periods: float) -> tuple[np.ndarray, np.ndarray, int] | None:
        """The motion after so many periods, with its derivative with respect to its start.

        Returns
        -------
        (4,) ndarray, (4, 4) ndarray, int
            y at the end; its Jacobian; a number that differs between different sequences of events. None if the
            integration ends early, or there is no derivative.
        """

    @abstractmethod
    def image(self, y: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """y and a disturbance of it after a period; None if it ends early or has no derivative."""

    def follow(self, y: np.ndarray, direction: np.ndarray, growth: np.ndarray, section: np.ndarray) -> None:
        """The work of :func:`..kernels.event_driven.disturbance.follow_disturbance`, period by period."""
        growth[:] = np.nan
        for n in range(len(growth)):
            found = self.image(y, direction)
            length = np.nan if found is None else float(np.linalg.norm(found[1]))
            if not (length < np.inf and np.isfinite(found[0]).all()):
                return
            y[:] = section[n] = found[0]
            direction[:] = found[1] / length if length > 0.0 else 0.5
            growth[n] = np.log(length) if length > 0.0 else -np.inf


class LinearFlow(Flow):
    """The flow of a solution in closed form."""

    periods_per_call = 512

    def __init__(self, system: EventDrivenSystem):
        self._system = system

    def start(self, y: Sequence[float]) -> np.ndarray:
        return start_at(self._system.packed, y)

    def with_jacobian(self, start: np.ndarray, periods: float) -> tuple[np.ndarray, np.ndarray, int] | None:
        return self._with_variation(start, periods, uncompiled(make_variation)())

    def image(self, y: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        variation = uncompiled(make_variation)(1)
        variation.state[:, 0] = direction
        found = self._with_variation(self.start(y), 1.0, variation)
        return found and (found[0].copy(), found[1][:, 0].copy())

    def _with_variation(self, start: np.ndarray, periods: float, variation: Variation):
        """Integrate the motion with changes of its start."""
        nothing = NO_BUFFERS.flat, NO_BUFFERS.sizes
        status, _, _ = kernel.integrate(self._system.packed, start, periods, (0.0, 0.0), *nothing, variation)
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
    if system.views.rigid:
        check_apart(start)
    y = uncompiled(contact_coordinates)(start.system, *start.state)  # no arrays: a call takes longer
    return start_at(system.packed, y)


def check_apart(start: Checkpoint) -> None:
    """Check a start of the reference; raises ValueError if the bodies penetrate each other."""
    overlap = start.system.overlap_of(start.state)
    if overlap > 0:
        raise ValueError(overlap_message(start.system, -overlap))


def overlap_message(system: System, gap: float) -> str:
    """Why a reference cannot start from a state with a negative gap, and what to do."""
    if system.two_stops:
        return (
            f"a stop is penetrated by {-gap:g} at the start, and the reference knows no penetration: start with "
            "−clearance2 ≤ ξ₁ − ξ₂ ≤ clearance"
        )
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
