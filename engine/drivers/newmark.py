"""Driver of Newmark's method."""

import cmath
import math

import numpy as np

leaps = None
from ..kernels import newmark as kernel

from ..kernels.record import Record as Buffers
from ..methods import Newmark
from ..model import System
from ..result import Checkpoint, Cost, Record, Status
from .base import Driver

STEPS_PER_CALL = 5_000_000
LEAPS_PAY_FROM = 10**18


def pack(system: System, eta: float, method: Newmark) -> kernel.Scheme:
    """Coefficients of one step (derived in :mod:`engine.kernels.newmark`)."""
    h = 2 * math.pi / eta / method.steps
    mu, k, d = system.mass_ratio, method.stiffness, method.damping
    c1, c2 = 2 * system.d1, 2 * system.d2 * system.kappa
    k1, k2 = 1.0, system.kappa**2
    m1 = 1 + c1 * h / 2 + k1 * h * h / 4
    m2 = 1 + c2 * h / 2 + k2 * h * h / 4
    sigma = k * h * h / 4 + d * h
    shared = 1 + sigma * (1 / m1 + 1 / (mu * m2))
    return kernel.Scheme(
        h=h,
        damping1=c1 * h / m1,
        stiffness1=k1 * h * h / m1,
        load1=eta * eta * h * h / m1,
        react1=h * h / m1,
        damping2=c2 * h / m2,
        stiffness2=k2 * h * h / m2,
        load2=eta * eta * h * h / m2,
        react2=h * h / (mu * m2),
        stiffness=k,
        damper=d,
        contact_p=k / shared,
        contact_q=2 * d / h / shared,
        contact_a=sigma / (h * h) / shared,
    )


def pack_flight(k: float, d: float, eta: float, h: float) -> object:
    """Discrete free motion of one pendulum (derived in :mod:`engine.kernels.leaps`)."""
    pole = complex(-d * k, k * math.sqrt(1 - d * d))
    tangent = 2j / h * math.tan(eta * h / 2)
    discrete = 2 / h * cmath.atanh(pole * h / 2)
    steady = eta**2 / (k * k + tangent * (tangent + 2 * d * k))
    return object(pole, discrete, tangent, steady, 2 * d * k, k * k, eta**2)


def pack_squeeze(m: kernel.Scheme, flights: tuple, mu: float, phasors: np.ndarray) -> object:
    """Discrete motion in contact, on z = (p₁, Q₁, p₂ − p₁, Q₂ − Q₁)."""
    free1 = np.array([-m.stiffness1, -m.damping1, 0, 0])
    free2 = np.array([-m.stiffness2, -m.damping2, -m.stiffness2, -m.damping2])
    force = np.array([0, 0, -m.contact_p, -m.contact_q]) + m.contact_a * (free1 - free2)
    a1, apart = free1 - m.react1 * force, free2 - free1 + (m.react1 + m.react2) * force
    one = np.eye(4)
    c = np.array([a1 + one[1], a1, apart + one[3], apart])
    row = apart / 4 + one[2]
    moves = np.empty((leaps.BLOCK, 4, 4))
    moves[0] = c
    for k in range(1, leaps.BLOCK):
        moves[k] = moves[k - 1] + c + c @ moves[k - 1]
    rows = np.vstack([row, row + row @ moves[:-1]])
    # steady displacements: the trapezoidal rule sees the excitation at η̂
    w = flights[0].tangent
    spring = m.stiffness + 2 * m.damper * w
    one, two = (f.stiffness + w * (w + f.damping) for f in flights)
    matrix = np.array([[one + spring, -spring], [-spring / mu, two + spring / mu]])
    x1, x2 = np.linalg.solve(matrix, np.full(2, flights[0].load, dtype=complex))
    p, q = 1 + m.h * w + (m.h * w) ** 2 / 4, m.h * w + (m.h * w) ** 2 / 2
    steady = np.array([p * x1, q * x1, p * (x2 - x1), q * (x2 - x1)])
    n = len(phasors)
    gaps = ((x2 - x1) * phasors).real[np.arange(n + leaps.BLOCK + 1) % n]
    return object(steady, np.ascontiguousarray(rows.T), moves, gaps, np.zeros(leaps.BLOCK))


def pack_leaps(m: kernel.Scheme, system: System, eta: float, n: int) -> tuple:
    """What :func:`engine.kernels.leaps.leap` takes between the scheme and the state."""
    flights = tuple(pack_flight(k, d, eta, m.h) for k, d in ((1.0, system.d1), (system.kappa, system.d2)))
    poles = (*(flight.discrete for flight in flights), complex(0.0, eta))
    phasors = np.exp(2j * np.pi * np.arange(n) / n)
    return *flights, make_ladder(poles, poles), pack_squeeze(m, flights, system.mass_ratio, phasors), phasors


class NewmarkDriver(Driver):
    """One run of Newmark's method."""

    def __init__(
        self,
        system: System,
        eta: float,
        method: Newmark,
        start: Checkpoint,
        keep: int,
        kept_from: int,
        record: Record | None,
    ):
        n = method.steps
        phases = record.phases(n) if record else np.zeros(1)
        self.run = system, eta, method
        super().__init__(eta, start.periods, keep, kept_from, phases, record.periods if record else 0)
        self._method = method
        self._scheme = pack(system, eta, method)
        self._cosines = np.cos(2 * np.pi * np.arange(n + 1) / n)
        self._leaps = None if method.every_step or n < LEAPS_PAY_FROM else pack_leaps(self._scheme, system, eta, n)
        stride = record.stride(n) if record else n
        self._window = (kept_from * n, self.sampled_from * n, stride)
        self._state = _state(self._scheme, system, eta, method, start)
        self._started = start.periods * n
        self._load()

    def _load(self) -> None:
        """Compile or load what this run calls, outside the measured seconds; a call up to step 0 does nothing."""
        state = self._state.copy()
        if not getattr(kernel.advance_recorded, "signatures", True):
            kernel.advance_recorded(self._scheme, self._cosines, state, 0, self._window, self._nothing)
        if self._leaps is None and not getattr(kernel.advance, "signatures", True):
            kernel.advance(self._scheme, self._cosines, state, 0)
        if self._leaps is not None and not getattr(leaps.leap, "signatures", True):
            leaps.leap(self._scheme, *self._leaps, state, 0)

    def periods_per_call(self) -> int:
        return max(1, STEPS_PER_CALL // self._method.steps)

    def march(self, stop: int, record: Buffers) -> tuple[Status, bool]:
        last = stop * self._method.steps
        if record is not self._nothing:
            code = kernel.advance_recorded(self._scheme, self._cosines, self._state, last, self._window, record)
        elif self._leaps is not None:
            code = leaps.leap(self._scheme, *self._leaps, self._state, last)
        else:
            code = kernel.advance(self._scheme, self._cosines, self._state, last)
        return (Status.DIVERGED if code == kernel.DIVERGED else Status.OK), code == kernel.FULL

    def explain(self, status: Status) -> str:
        step, n = int(self._state[kernel.STEP]), self._method.steps
        return (
            f"Newmark's solution blew up: the gap passed {kernel.LIMIT:g} base amplitudes at step {step} "
            f"(period {step / n:.2f}); take more steps per period than {n}, or a smaller K or D"
        )

    def close_open_contact(self, record: Buffers) -> None:
        if self._state[kernel.CONTACT] > 0.0 and self._state[kernel.STEP] > self._window[0]:
            now = kernel.motion_of(self._scheme, self._state)
            kernel.close_contact(self._scheme, self._state, self._state[kernel.STEP], now, record)

    def section_rows_done(self) -> int:
        return max(0, (int(self._state[kernel.STEP]) - self._window[0]) // self._method.steps)

    def cost(self) -> Cost:
        return Cost(self.seconds, steps=int(self._state[kernel.STEP]) - self._started)

    def checkpoint(self) -> Checkpoint:
        return Checkpoint(*self.run, self.periods, tuple(self._state))


def _state(scheme: kernel.Scheme, system: System, eta: float, method: Newmark, start: Checkpoint) -> np.ndarray:
    state = np.zeros(kernel.SLOTS)
    if len(start.state) == kernel.SLOTS:
        state[:] = start.state
        return state
    x1, v1, x2, v2 = start.state
    h, mu = scheme.h, system.mass_ratio
    contact = x2 <= x1
    force = method.stiffness * (x1 - x2) + 2 * method.damping * (v1 - v2) if contact else 0.0
    # acceleration at τ = 0 from the equations of motion (MODEL.md, "Motion")
    a1 = h * h * (eta**2 - 2 * system.d1 * v1 - x1 - force)
    a2 = h * h * (eta**2 - 2 * system.d2 * system.kappa * v2 - system.kappa**2 * x2 + force / mu)
    state[kernel.A1], state[kernel.A2] = a1, a2
    state[kernel.Q1], state[kernel.Q2] = h * v1 + 0.5 * a1, h * v2 + 0.5 * a2
    state[kernel.P1], state[kernel.P2] = x1 + h * v1 + 0.25 * a1, x2 + h * v2 + 0.25 * a2
    state[kernel.CONTACT] = float(contact)
    return state
