"""Driver of exact penalty solutions with a contact law other than spring and damper."""

from typing import ClassVar

import numpy as np

from ..kernels.compile.options import uncompiled
from ..kernels.compile.record import Buffers, PackedBuffers
from ..kernels.equations.contact_law import COMPRESSION, CUT, LIMITED, force
from ..kernels.equations.coordinates import contact_coordinates
from ..kernels.equations.motion import coefficients, free_equilibrium, pressed_equilibrium, pressed_generator
from ..kernels.equations.motion import separated_generator as free_generator
from ..kernels.equations.rates import free_rate, pressed_rate
from ..kernels.event_driven import law_integrate as kernel
from ..kernels.event_driven.law_contact import NUMBERS, TABLE, WORK, LawSystem
from ..kernels.event_driven.output import append_contact
from ..kernels.event_driven.state import COLLISION, FLIGHT, STATE, later_state, linear_state, start_state
from ..kernels.linear.tables import DEEPEST, INTEGRAL, POINTS, REACH, TERMS, WIDTH, Scratch, full_generator, tabulate
from ..kernels.parameters import Parameters
from ..methods import PIECEWISE_LINEAR, ExactPenalty
from ..model import System
from ..result import Checkpoint, Status
from .event_driven import EventDriver
from .parameters import parameters_of

GAP, RATE = 2, 3  # columns of z
PIECES = 4  # with the flight
OVERLAP, PUSH, EXTRA = 1, 2, 3  # numbers of pieces


def needs_law(method) -> bool:
    """Whether a method is an exact penalty solution whose contact is not a spring and a damper all the time."""
    if not isinstance(method, ExactPenalty) or method.law == PIECEWISE_LINEAR[0]:
        return False
    return method.law not in PIECEWISE_LINEAR or method.damping > 0.0  # without a damper the first four are one


def _pieces(p: Parameters) -> dict[int, tuple[tuple[float, float], list[tuple[np.ndarray, float, int]]]]:
    """Of each piece of a law its spring and damper, and what it watches: a row of z, what follows, what mirrors it."""
    spring, damper = np.zeros(6), np.zeros(6)
    spring[GAP], damper[RATE] = force(p.stiffness, p.damping, 1.0, 0.0), force(p.stiffness, p.damping, 0.0, 1.0)
    open_again = (spring, FLIGHT, -1)
    whole, half = (p.stiffness, p.damping), (p.stiffness, 0.0)
    over = (0.0, 0.0), [open_again, (-spring - damper, kernel.PUSH, 0)]
    push = spring + damper, kernel.OVERLAP, 1
    if p.law == CUT:
        return {OVERLAP: over, PUSH: (whole, [push])}
    if p.law == LIMITED:
        double = 2.0 * p.stiffness, 0.0
        limit = spring - damper, kernel.EXTRA, 0
        return {OVERLAP: over, PUSH: (whole, [push, limit]), EXTRA: (double, [(damper - spring, kernel.PUSH, 1)])}
    if p.law == COMPRESSION:
        turn = damper, kernel.EXTRA, 1
        return {PUSH: (whole, [turn]), EXTRA: (half, [open_again, (-damper, kernel.PUSH, 0)])}
    return {}


def set_up_law(system: System, eta: float, method: ExactPenalty) -> LawSystem:
    """Tables and numbers of a run; those of a law that is not piecewise linear are the flight's alone."""
    p = parameters_of(system, eta, method)
    wall, c = p.wall > 0.0, uncompiled(coefficients)(p)
    tables = {
        "spacing": np.zeros(PIECES),
        "position": np.zeros(PIECES),
        "gap": np.zeros(PIECES),
        "watched": np.zeros(2 * PIECES),
        "rows": np.zeros((2 * PIECES, 6, INTEGRAL + 1)),
        "transitions": np.zeros((PIECES, POINTS, 6, 6)),
        "counts": np.zeros(PIECES, dtype=np.int64),
        "targets": np.zeros(2 * PIECES, dtype=np.int64),
        "mirrored": np.full(2 * PIECES, -1, dtype=np.int64),
        "impulse": np.zeros((PIECES, 7)),
    }
    gap_row = np.zeros(6)
    gap_row[GAP] = 1.0
    flight = _add_piece(tables, p, 0, (0.0, 0.0), [(gap_row, COLLISION, -1)])
    for piece, (contact, watched) in _pieces(p).items():
        _add_piece(tables, p, piece, contact, watched)
    return LawSystem(
        period=2 * np.pi / eta,
        frequency=eta / (2 * np.pi),
        eta=p.eta,
        rigid=False,
        wall=wall,
        clearance=p.clearance,
        law=int(p.law),
        stiffness=p.stiffness,
        gain=p.gain,
        relative=p.relative,
        exponent=p.exponent,
        penetration=p.penetration,
        react1=c.react1,
        inverse_mass=c.inverse_mass,
        generator=free_generator(p),
        flight=flight,
        scratch=Scratch(np.zeros(WIDTH), np.zeros((DEEPEST, TERMS + 2))),
        work=np.zeros((WORK, NUMBERS)),
        **tables,
    )


def _add_piece(tables: dict, p: Parameters, piece: int, contact: tuple[float, float], watched: list):
    """Add the tables of a piece, with its spring and damper; returns those of its first watched quantity."""
    own, wall = p._replace(stiffness=contact[0], damping=contact[1]), p.wall > 0.0
    acts = contact[0] > 0.0
    generator = pressed_generator(own) if acts else free_generator(p)
    position, gap = pressed_equilibrium(own) if acts else free_equilibrium(p)
    h = REACH / (pressed_rate(own) if acts else free_rate(p))
    tables["spacing"][piece], tables["position"][piece], tables["gap"][piece] = h, position, gap
    tables["counts"][piece] = len(watched)
    phases = []
    for k, (row, target, mirrored) in enumerate(watched):
        i, level = 2 * piece + k, float(row[GAP] * gap)
        phases.append(tabulate(generator, p.eta, row, h, (position, gap, level), wall))
        tables["watched"][i], tables["rows"][i], tables["transitions"][piece] = level, phases[k].rows, phases[k].transitions
        tables["targets"][i], tables["mirrored"][i] = int(target), mirrored
    if acts:
        acting = np.zeros(6)
        acting[GAP], acting[RATE] = force(*contact, 1.0, 0.0), force(*contact, 0.0, 1.0)
        # z′ = A z gives ∫z dτ = A⁻¹ Δz
        tables["impulse"][piece, :6] = np.linalg.solve(full_generator(generator, p.eta).T, acting)
        tables["impulse"][piece, 6] = acting[GAP] * gap
    return phases[0]


class LawDriver(EventDriver):
    """One exact penalty solution, from event to event."""

    loop: ClassVar = staticmethod(kernel.integrate_law)

    def begin(self, start: Checkpoint) -> None:
        self._system = set_up_law(*self.run)
        if len(start.state) > 4:
            self._state = np.array(start.state)
        else:
            y = uncompiled(contact_coordinates)(start.system, *start.state)
            self._state = STATE.pack(uncompiled(start_state)(self._system, y))

    def call(self, stop: int, buffers: PackedBuffers) -> tuple[int, int, int]:
        return self.loop(self._system, self._state, float(stop), self._window, buffers.flat, buffers.sizes)

    def explain(self, status: Status) -> str:
        period = int(self._now.period) + 1
        if status is Status.UNRESOLVED:
            return (
                f"from period {period} on a contact needs steps too short to go on: its damper is too stiff beside its "
                "spring; take a smaller K or D, or a law whose damper does not depend on the closing speed"
            )
        return f"over {kernel.MOST_EVENTS} events in period {period}: the contact does not come to rest; take a smaller K"

    def record_open_contact(self, buffers: Buffers) -> None:
        p, a = self._system, self._now
        if a.mode < kernel.OVERLAP or self.periods <= self.kept_from:
            return
        s, piece = (self.periods - a.period) * self.period - a.tau, uncompiled(kernel.piece_of)(a)
        phase = uncompiled(kernel.phase_of)(p, 0 if a.mode == kernel.SMOOTH else piece, 0)
        z = uncompiled(linear_state)(p, phase, a)
        now = uncompiled(later_state)(p, a, s, kernel.law_motion(p, a, z, s), a.mode, 0.0, a.contact)
        if a.mode == kernel.SMOOTH:
            more = p.work[TABLE, 4]
        else:
            more = uncompiled(kernel.piece_impulse)(p, piece, z, uncompiled(linear_state)(p, phase, now), s)
        now = now._replace(contact=now.contact._replace(impulse=now.contact.impulse + more))
        append_contact(p, now, self._window, buffers)
