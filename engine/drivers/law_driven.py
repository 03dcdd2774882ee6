"""Driver of exact penalty solutions with a contact law other than spring and damper."""

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np
from vibroscope.engine.drivers.event_driven import NO_BUFFERS, EventDriver, Flow, integral_of
from vibroscope.engine.drivers.law_pieces import Piece, pieces_of
from vibroscope.engine.drivers.parameters import parameters_of, parameters_of_stops
from vibroscope.engine.facts import Ending
from vibroscope.engine.kernels.compile.options import uncompiled
from vibroscope.engine.kernels.compile.record import Buffers, PackedBuffers
from vibroscope.engine.kernels.equations.contact_law import MAIN, OTHER, ContactLaw, contact_law_of, force
from vibroscope.engine.kernels.equations.motion import (
    coefficients,
    contact_coordinates,
    free_equilibrium,
    free_rate,
    load_rate,
    pressed_equilibrium,
    pressed_generator,
    pressed_rate,
)
from vibroscope.engine.kernels.equations.motion import separated_generator as free_generator
from vibroscope.engine.kernels.event_driven import law_integrate as kernel
from vibroscope.engine.kernels.event_driven.integrate import MOST_PAUSES
from vibroscope.engine.kernels.event_driven.law_contact import NUMBERS, TABLE, WORK, LawSystem
from vibroscope.engine.kernels.event_driven.law_energy import integrate_powers
from vibroscope.engine.kernels.event_driven.output import append_contact
from vibroscope.engine.kernels.event_driven.state import (
    COLLISION,
    FLIGHT,
    FREQUENCY,
    GIVEN,
    MOST_EFFORT,
    SEEN_FROM,
    STATE,
    HybridState,
    later_state,
    linear_state,
    start_state,
)
from vibroscope.engine.kernels.event_driven.state import NUMBERS as NUMBERS_OF_LOAD
from vibroscope.engine.kernels.event_driven.two_stops import from_first
from vibroscope.engine.kernels.linear.tables import (
    DEEPEST,
    INTEGRAL,
    POINTS,
    REACH,
    TERMS,
    WIDTH,
    Phase,
    Scratch,
    full_generator,
    tabulate,
)
from vibroscope.engine.kernels.parameters import Parameters
from vibroscope.engine.kernels.status import CROSSED, OK, PAUSED
from vibroscope.engine.law_table import LAWS, damper_of
from vibroscope.engine.load import Load
from vibroscope.engine.methods import ExactPenalty
from vibroscope.engine.model import System
from vibroscope.engine.result import Checkpoint, Status

GAP, RATE = 2, 3  # columns of z
PIECES = 4  # with the flight
DIFFERENCE = 1e-6  # of a start, for a derivative, as a share of its largest number


def needs_law(method) -> bool:
    """Whether a method is an exact penalty solution whose contact is not a spring and a damper all the time."""
    if method.rigid or method.has_step or method.linear:
        return False
    # without a damper those in closed form are one, but for a spring of two stiffnesses
    return by_steps(method) or method.damping > 0.0 or method.stiffening is not None


def by_steps(method) -> bool:
    """Whether a method is an exact penalty solution whose contact is integrated by steps, having no closed form."""
    return not (method.rigid or method.has_step or LAWS[method.law].closed_form)


class _Watched(NamedTuple):
    """What ends a piece where it falls to zero."""

    by_depth: float  # factors of δ and v
    by_speed: float
    constant: float
    target: float  # the mode that follows
    mirrored: int = -1  # which of its watched quantities then begins at zero


def _watched_in(law: ContactLaw, pieces: dict[int, Piece]) -> dict[int, list[_Watched]]:
    """What ends each piece of a law: its kinks, and where bodies part in it the gap."""
    if not pieces:
        return {}
    opening = int(uncompiled(kernel.first_piece)(law, 0.0, -1.0) - kernel.PIECES_FROM)  # that in which bodies part
    opens = _Watched(law.stiffness, 0.0, 0.0, FLIGHT)
    watched: dict[int, list[_Watched]] = {piece: [opens] if OTHER <= piece == opening else [] for piece in pieces}
    for k, row in enumerate(pieces[MAIN].kinks):
        other = OTHER + k
        watched[MAIN].append(_Watched(*row, kernel.PIECES_FROM + other, len(watched[other])))
        watched[other].append(_Watched(*pieces[other].kinks[0], kernel.PIECES_FROM + MAIN, k))
    if opening == MAIN:
        watched[MAIN].append(opens)
    return watched


def set_up_law(p: Parameters, load: Load | None = None) -> LawSystem:
    """Tables and numbers of a run; those of a law that is not piecewise linear are the flight's alone."""
    c, law = uncompiled(coefficients)(p), uncompiled(contact_law_of)(p)
    tables = {
        "spacing": np.zeros(PIECES),
        "position": np.zeros(PIECES),
        "gap": np.zeros(PIECES),
        "pulled": np.zeros(PIECES),
        "watched": np.zeros(2 * PIECES),
        "rows": np.zeros((2 * PIECES, 7, INTEGRAL + 1)),
        "transitions": np.zeros((PIECES, POINTS, 6, 6)),
        "offsets": np.zeros((PIECES, POINTS, 4)),
        "counts": np.zeros(PIECES, dtype=np.int64),
        "targets": np.zeros(2 * PIECES, dtype=np.int64),
        "mirrored": np.full(2 * PIECES, -1, dtype=np.int64),
        "impulse": np.zeros((PIECES, 7)),
    }
    flight = _add_piece(tables, p, 0, Piece(0.0, 0.0), [_Watched(-1.0, 0.0, 0.0, COLLISION)])
    pieces = pieces_of(law)
    for piece, watched in _watched_in(law, pieces).items():
        _add_piece(tables, p, piece, pieces[piece], watched)
    now = np.zeros(NUMBERS_OF_LOAD)
    if load is not None:
        now[[GIVEN, FREQUENCY]] = 1.0, load.frequency
    return LawSystem(
        period=2 * np.pi / p.eta,
        eta=p.eta,
        rigid=False,
        wall=p.wall,
        clearance=p.clearance,
        play=p.play,
        sign=p.sign,
        law=law,
        react1=c.react1,
        inverse_mass=c.inverse_mass,
        generator=free_generator(p),
        flight=flight,
        load=now,
        segments=np.zeros(1) if load is None else load.segments.ravel(),
        scratch=Scratch(np.zeros(WIDTH), np.zeros((DEEPEST, TERMS + 2))),
        work=np.zeros((WORK, NUMBERS)),
        **tables,
    )


def _add_piece(tables: dict, p: Parameters, piece: int, contact: Piece, watched: list[_Watched]) -> Phase:
    """Add the tables of a piece; returns those of what it watches first."""
    stiffness, damping, push, _ = contact
    own = p._replace(stiffness=stiffness, damping=damping)
    acts = stiffness > 0.0
    generator = pressed_generator(own) if acts else free_generator(p)
    position, gap = pressed_equilibrium(own) if acts else free_equilibrium(p)
    parted = push / (p.stiffness_share + stiffness) if push else 0.0  # by how much the constant moves the equilibrium
    share = 1.0 if p.spring1 == 0.0 < p.kappa else p.stiffness_share  # … and that of body 1
    position, gap = position - uncompiled(coefficients)(p).react1 * share * parted, gap + parted
    h, rate = REACH / (pressed_rate(own) if acts else free_rate(p)), uncompiled(load_rate)(p)
    tables["spacing"][piece], tables["position"][piece], tables["gap"][piece] = h, position, gap
    tables["counts"][piece] = len(watched)
    phases = []
    for k, each in enumerate(watched):
        row = np.zeros(6)
        row[GAP], row[RATE] = -each.by_depth, -each.by_speed
        i, level = 2 * piece + k, float(row[GAP] * gap) + each.constant
        phases.append(tabulate(generator, rate, row, h, (position, gap, level)))
        tables["watched"][i], tables["rows"][i] = level, phases[k].rows
        tables["transitions"][piece], tables["offsets"][piece] = phases[k].transitions, phases[k].offsets
        tables["pulled"][piece] = phases[k].pulled
        tables["targets"][i], tables["mirrored"][i] = int(each.target), each.mirrored
    if acts:
        acting = np.zeros(6)
        acting[GAP], acting[RATE] = force(stiffness, damping, 1.0, 0.0), force(stiffness, damping, 0.0, 1.0)
        integral = integral_of(full_generator(generator, rate), acting)
        tables["impulse"][piece, :6] = integral
        tables["impulse"][piece, 6] = acting[GAP] * gap + push - integral[:4] @ generator[:, 6]
    return phases[0]


def set_up_stops(system: System, eta: float, method: ExactPenalty) -> list[LawSystem]:
    """Tables and numbers of a run as seen from each stop."""
    return [set_up_law(p, system.excitation.load) for p in parameters_of_stops(system, eta, method)]


def start_of_law(systems: Sequence[LawSystem], y: Sequence[float]) -> np.ndarray:
    """The packed hybrid state at y = (ξ₁, ξ₁′, g, g′), and after it the number of the stop from which it is seen."""
    y, stop = tuple(map(float, y)), int(y[2] > 0.5 * systems[0].play)
    y = uncompiled(from_first)(y, stop, systems[0].play)
    return np.append(STATE.pack(uncompiled(start_state)(systems[stop], y)), float(stop))


def integrate_law(
    systems: Sequence[LawSystem], state: np.ndarray, stop: float, window: tuple[float, float], buffers: PackedBuffers
) -> tuple[int, int, int]:
    """Call the event loop, of one stop after the other; returns what it does."""
    code, events, effort = CROSSED, 0, 0
    while code == CROSSED:
        here = int(state[SEEN_FROM])
        code, more, work = kernel.integrate_law(systems[here], state, stop, window, buffers.flat, buffers.sizes)
        events, effort = events + more, effort + work
        if code == CROSSED:
            state[SEEN_FROM] = 1.0 - here
            code = PAUSED if effort > MOST_EFFORT else CROSSED
    return code, events, effort


def motion_after(p: LawSystem, a: HybridState, s: float) -> tuple[tuple[float, float, float, float], float]:
    """(ξ₁, ξ₁′, g, g′) s after a hybrid state, no event between them, and ∫λ of a contact on the way."""
    piece = 0 if a.mode == kernel.SMOOTH else uncompiled(kernel.piece_of)(a)
    phase = uncompiled(kernel.phase_of)(p, piece, 0)
    z = uncompiled(linear_state)(p, phase, a)
    y = kernel.law_motion(p, a, z, s)
    if a.mode == kernel.SMOOTH:
        return y, p.work[TABLE, 4]
    end = uncompiled(linear_state)(p, phase, uncompiled(later_state)(p, a, s, y, a.mode, 0.0, a.contact))
    return y, uncompiled(kernel.piece_impulse)(p, piece, z, end, s)


class LawDriver(EventDriver):
    """One exact penalty solution, from event to event."""

    loop: ClassVar = staticmethod(kernel.integrate_law)

    def begin(self, start: Checkpoint) -> None:
        self._systems = set_up_stops(*self.problem)
        if len(start.state) > 4:
            self._state = np.array(start.state)
        else:
            self._state = start_of_law(self._systems, uncompiled(contact_coordinates)(start.system, *start.state))

    @property
    def _hybrid(self) -> LawSystem:
        """As the state is seen."""
        return self._systems[int(self._state[SEEN_FROM])]

    def call(self, stop: int, buffers: PackedBuffers) -> tuple[int, int, int]:
        return integrate_law(self._systems, self._state, float(stop), self._window, buffers)

    def explain(self, status: Status) -> Ending:
        period = int(self._now.period) + 1
        if status is Status.UNRESOLVED:
            return Ending(
                f"from period {period} on a contact needs steps too short to go on",
                "its damper is too stiff beside its spring",
                "take a smaller K or D, or a law whose damper does not depend on the closing speed",
            )
        what = f"over {kernel.MOST_EVENTS} events in period {period}"
        return Ending(what, "a contact does not end", "take a smaller K")

    def record_open_contact(self, buffers: Buffers) -> None:
        p, a = self._hybrid, self._now
        if a.mode <= kernel.PIECES_FROM or self.periods <= self.kept_from:
            return
        s = (self.periods - a.period) * self.period - a.tau
        y, more = motion_after(p, a, s)
        now = uncompiled(later_state)(p, a, s, y, a.mode, 0.0, a.contact)
        now = now._replace(contact=now.contact._replace(impulse=now.contact.impulse + more))
        append_contact(p, now, self._window, buffers)


def remembers(system: System, method) -> bool:
    """Whether the damper of an open contact depends on the speed with which it closed, which is no part of a state."""
    return needs_law(method) and damper_of(system, method)[1]


class LawFlow(Flow):
    """The flow of an exact penalty solution with such a law; derivatives are central differences."""

    periods_per_call = 1

    def __init__(self, system: System, eta: float, method: ExactPenalty):
        if remembers(system, method):
            raise ValueError(
                f"the damper of the law {method.law!r} depends on the speed with which a contact closed: a state "
                "in contact does not say how it goes on; give D"
            )
        self._systems = set_up_stops(system, eta, method)

    def start(self, y: Sequence[float]) -> np.ndarray:
        return start_of_law(self._systems, y)

    def end(self, start: np.ndarray, periods: float) -> tuple[np.ndarray, int] | None:
        """Y after so many periods, and the events on the way; None if the run ends early."""
        state, events = start.copy(), 0
        for _ in range(MOST_PAUSES):
            status, more, _ = integrate_law(self._systems, state, float(periods), (0.0, 0.0), NO_BUFFERS)
            events += more
            if status != PAUSED:
                break
        if status != OK:
            return None
        a, here = STATE.read(state), int(state[SEEN_FROM])
        p = self._systems[here]
        y, _ = motion_after(p, a, (periods - a.period) * p.period - a.tau)
        return np.array(uncompiled(from_first)(y, here, p.play)), events

    def image(self, y: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        start = self.start(y)
        found = self.end(start, 1.0)
        change = None if found is None else self._derivative(start, 1.0, direction, found[1])
        return None if change is None else (found[0], change)

    def _derivative(self, start: np.ndarray, periods: float, direction: np.ndarray, events: int) -> np.ndarray | None:
        """The derivative by a central difference; None if a neighbour has other events. A wall does not move."""
        a = STATE.read(start)
        y = (a.x1, a.v1, a.gap, a.rate), int(start[SEEN_FROM]), self._systems[0].play
        y = np.array(uncompiled(from_first)(*y))
        width = DIFFERENCE * max(float(np.abs(y).max()), DIFFERENCE)
        change = width * direction * ([0.0, 0.0, 1.0, 1.0] if self._systems[0].wall else 1.0)
        sides = [self.end(self.start(y + sign * change), periods) for sign in (1.0, -1.0)]
        if None in sides or any(more != events for _, more in sides):
            return None
        return (sides[0][0] - sides[1][0]) / (2 * width)

    def with_jacobian(self, start: np.ndarray, periods: float) -> tuple[np.ndarray, np.ndarray, int] | None:
        found, jacobian = self.end(start, periods), np.zeros((4, 4))
        if found is None:
            return None
        for i in range(2 if self._systems[0].wall else 0, 4):
            column = self._derivative(start, periods, np.eye(4)[i], found[1])
            if column is None:
                return None
            jacobian[:, i] = column
        return found[0], jacobian, found[1]


def law_powers(system: System, eta: float, method: ExactPenalty, state: Sequence[float], periods: range) -> np.ndarray:
    """Work of the excitation, losses of the dampers and work of λ on the contact, (n, 3), in each of n periods.

    ``state``: of a run after ``periods.start`` periods, as its checkpoint has it.
    """
    p = set_up_law(parameters_of(system, eta, method), system.excitation.load)
    packed = np.array(state)
    if len(packed) == 4:
        packed = start_of_law([p], uncompiled(contact_coordinates)(system, *state))
    sums = np.zeros((len(periods) + 1, 3))
    both = np.zeros((2, 3))
    for k, period in enumerate(periods):
        if integrate_powers(p, packed, float(period + 1), both) != OK:
            return np.full((len(periods), 3), np.nan)
        sums[k + 1] = both[1]
    return np.diff(sums, axis=0)
