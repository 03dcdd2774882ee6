"""A run from rest under a load that is no harmonic, and what is left of it after the load.

The instants at which it is sampled are such that its peaks are known: the largest values between samples are those of
the cubic that has the values and the slopes of both ends of an interval.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from vibroscope.engine.arguments import Poll, require
from vibroscope.engine.energy.balance import energy_balance
from vibroscope.engine.energy.events import EnergyBalance
from vibroscope.engine.load import Load
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System
from vibroscope.engine.outputs import peaks
from vibroscope.engine.result import Impacts, Record, Response, Trajectory
from vibroscope.engine.simulate import SAMPLES_LIMIT, simulate_load, under_load

CYCLE_SAMPLES = 128  # in the fastest cycle without contact: a peak between them is missed by 3e-4 of it at most
CONTACT_SAMPLES = 64  # in a contact
CONTACT_CYCLE = 12  # … at least so many in a cycle of a penalty contact that lasts
CYCLE = 2 * math.pi  # of body 1, in 1/ω₁
PULSE_SAMPLES = 400  # of a half-sine, between which it is straight
FREE_CYCLES = 4.0  # that a run goes on after the load, unless said otherwise


def largest(time: np.ndarray, value: np.ndarray, slope: np.ndarray, smooth: np.ndarray) -> float:
    """The largest |f| of samples f and f′ at instants τ, (n,) each.

    ``smooth``, (n − 1,): the intervals within which f′ does not jump. The error is that of a cubic, of fourth order.
    """
    h, found = np.diff(time), float(np.abs(value).max(initial=0.0))
    turning = np.flatnonzero(smooth & (h > 0.0) & (slope[:-1] * slope[1:] < 0.0))
    if not len(turning):
        return found
    h, first, begin, end = h[turning], value[turning], slope[turning], slope[turning + 1]
    mean = (value[turning + 1] - first) / h
    square, cube = (3.0 * mean - 2.0 * begin - end) / h, (begin + end - 2.0 * mean) / (h * h)
    # f′ = begin + 2 square s + 3 cube s² has one root within; the form that does not cancel
    root = np.sqrt(np.maximum(square * square - 3.0 * cube * begin, 0.0))
    turn = -(square + np.copysign(root, square))
    with np.errstate(divide="ignore", invalid="ignore"):
        s, other = begin / turn, turn / (3.0 * cube)
    s = np.where((s >= 0.0) & (s <= h), s, np.clip(other, 0.0, h))
    extreme = first + s * (begin + s * (square + s * cube))
    return max(found, float(np.nanmax(np.abs(extreme))))


def without_impacts(sampled: Trajectory, impacts: Impacts) -> np.ndarray:
    """The intervals between samples, (n − 1,) of bool, in which no impact falls."""
    places = np.searchsorted(impacts.time, sampled.time, side="right")
    return np.diff(places) == 0


@dataclass(frozen=True, eq=False)
class Instants(Record):
    """A request for samples at given shares of a run."""

    shares: np.ndarray = field(default_factory=lambda: np.zeros(1))

    @classmethod
    def of(cls, shares: np.ndarray) -> "Instants":
        """The record of these shares, of one period."""
        return cls(1, len(shares), None, shares)

    def phases(self, steps: int) -> np.ndarray:
        """The shares themselves."""
        return self.shares


def instants_of(system: System, method: Method, contacts: np.ndarray, depth: float = 0.0) -> np.ndarray:
    """Shares of the run at which it is sampled: even ones, the beginnings of segments of the load, and contacts.

    ``depth``: the deepest penetration, at which a spring of another law than Kδ is stiffest.
    """
    load = system.excitation.load
    fastest = max(1.0, 1.0 if system.wall else system.kappa, load.frequency)
    count = int(np.ceil(CYCLE_SAMPLES * fastest * load.length / (2 * np.pi)))
    stiffer = max(1.0, system.stiffness_factor2)  # of two stops
    rate = 0.0
    if not method.rigid:
        n = method.spring_exponent
        stiffer *= (method.stiffening or 1.0) * n * depth ** (n - 1.0)
        rate = np.sqrt(stiffer * method.stiffness / system.mass_share)
    lengths = contacts[:, 1] - contacts[:, 0]
    within = CONTACT_SAMPLES + (CONTACT_CYCLE * rate * lengths / (2 * np.pi)).astype(int)
    total = count + len(load.segments) + int(within.sum())
    require("samples", total, 1, SAMPLES_LIMIT, "take a shorter load, or a shorter time after it")
    spans = zip(contacts, within, strict=True)
    inside = [np.linspace(*span, number, endpoint=False) for span, number in spans]
    shares = np.concatenate(
        [np.arange(count) / count, load.segments[:, 0] / load.length, *(x / load.length for x in inside)]
    )
    shares = np.unique(shares)
    return shares[shares < 1.0]


@dataclass(frozen=True)
class Transient:
    """Outcome of :func:`engine.transient`.

    Attributes
    ----------
    load : Load
    response : Response
        The run as one of :func:`engine.simulate` that has one period, from τ = 0 to its end: samples of all of it,
        impacts and contacts. Displacements are relative to the base.
    start : (4,) tuple of float
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0.
    """

    load: Load
    response: Response
    start: tuple[float, float, float, float]

    @property
    def ok(self) -> bool:
        """Whether the run reached its end."""
        return self.response.ok

    @cached_property
    def peaks(self) -> dict[str, float]:
        """The largest values, by the names of :data:`engine.PEAKS`, of the whole run (:func:`engine.peaks`).

        Displacements and penetration also between samples, unless the method has a time step: it knows steps alone.
        """
        found, response = peaks(self.response), self.response
        if response.method.has_step:
            return found
        first, second = self._farthest(0.0, np.zeros(2))
        sampled, impacts = response.trajectory, response.impacts
        if response.method.rigid:
            speeds = np.abs([impacts.velocity_before, impacts.velocity_after]).max(axis=(0, 1), initial=0.0)
            met = {f"velocity{body + 1}": max(found[f"velocity{body + 1}"], float(speeds[body])) for body in (0, 1)}
            return found | met | {"displacement1": first, "displacement2": second}
        system, (v1, v2) = response.system, sampled.velocity
        depth = np.maximum(-system.nearest_gap(*sampled.displacement), 0.0)
        first_stop = system.gap(*sampled.displacement) < 0.0
        rate = np.where(depth > 0.0, np.where(first_stop, v1 - v2, v2 - v1), 0.0)
        deepest = largest(sampled.time, depth, rate, self._smooth)
        return found | {"displacement1": first, "displacement2": second, "penetration": deepest}

    @property
    def _smooth(self) -> np.ndarray:
        """The intervals between samples in which velocities do not jump; none of a method with a time step."""
        sampled, response = self.response.trajectory, self.response
        if response.method.rigid:
            return without_impacts(sampled, response.impacts)
        return np.full(len(sampled.time) - 1, not response.method.has_step)

    def _farthest(self, begin: float, rest: np.ndarray) -> tuple[float, float]:
        """The largest displacement of each body from a place, from an instant on, impacts included."""
        sampled, response, impacts = self.response.trajectory, self.response, self.response.impacts
        later, met = sampled.time >= begin, impacts.time >= begin
        time, smooth = sampled.time[later], self._smooth[len(later) - later.sum() :]
        places = impacts.position, (0.0 if response.system.wall else 1.0) * impacts.position2(response.system)
        found = []
        for x, v, at, touched in zip(sampled.displacement, sampled.velocity, rest, places, strict=True):
            between = largest(time, x[later] - at, v[later], smooth)
            touches = touched[met] - at if response.method.rigid else np.zeros(0)
            found.append(max(between, float(np.abs(touches).max(initial=0.0))))
        return found[0], found[1]

    @cached_property
    def load_missed(self) -> float:
        """The share of ∫|L|dτ that steps do not see, which read the load at their instants alone; 0 without steps."""
        response, load = self.response, self.load
        if not response.method.has_step:
            return 0.0
        step = response.window[1] / response.method.steps
        read = np.arange(math.ceil(load.end / step) + 1) * step
        inside = np.linspace(0.0, load.end, PULSE_SAMPLES) if load.frequency else np.empty(0)
        time = np.unique(np.concatenate([read, load.segments[:, 0], inside]))
        middle, length = 0.5 * (time[1:] + time[:-1]), np.diff(time)
        seen, true = np.interp(middle, read, load.at(read)), load.at(middle)
        return float(np.abs(true - seen) @ length / max(np.abs(true) @ length, np.finfo(float).tiny))

    @cached_property
    def residual(self) -> tuple[float, float]:
        """Amplitude of the free vibration in which each body is at the end of the run; 0 of a wall.

        It is that of the displacement from the static equilibrium, if no further contact comes, of an oscillator
        without a damper: √(ξ² + (ξ′ + dωξ)²/(1 − d²)ω²). Of a body without a spring its speed.
        """
        c, (x1, v1, x2, v2) = self.response.system, self.response.section[-1]
        rest1, rest2 = c.separate_rest
        omega1 = math.sqrt(c.spring1)
        first = _amplitude(x1 - rest1, v1, omega1, c.d1 / omega1) if omega1 else abs(float(v1))
        if c.wall:
            return first, 0.0
        return first, _amplitude(x2 - rest2, v2, c.kappa, c.d2) if c.kappa else abs(float(v2))

    @cached_property
    def later_peaks(self) -> np.ndarray:
        """Residual response: the largest displacement of each body from its static equilibrium after the load, (2,)."""
        rest = np.nan_to_num(self.response.system.separate_rest, posinf=0.0, neginf=0.0)
        return np.array(self._farthest(self.load.end, rest))

    @property
    def in_contact(self) -> bool:
        """Whether the bodies touch at the end of the run."""
        contacts, end = self.response.contacts, self.response.window[1]
        return bool(len(contacts) and contacts[-1, 1] >= end * (1 - 1e-12))

    @cached_property
    def energy(self) -> EnergyBalance:
        """The energy balance of the run, as one period (:mod:`engine.energy.balance`)."""
        return energy_balance(self.response, start=self.start)


def transient(
    system: System,
    load: Load,
    method: Method,
    *,
    free: float = FREE_CYCLES * CYCLE,
    initial: Sequence[float] | None = None,
    cancelled: Poll | None = None,
) -> Transient:
    """Run a system from rest under a load in place of its harmonic motion and forces; constant forces stay.

    Parameters
    ----------
    system : System
    load : Load
    method : Reference, ExactPenalty or TimeStepping
        ``steps`` are those in 2π/ω₁, a natural period of body 1. At a step the load has its value there, between steps
        it is linear: as an FE code reads it. Exact solutions know the load between its samples, and where it jumps.
    free : float
        Time in 1/ω₁ for which the run goes on after the load.
    initial : (4,) sequence
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0, by default rest, the static equilibrium (:attr:`System.rest`).
    cancelled : callable, optional
        Polled many times a second; when it returns true the run is cancelled.

    Returns
    -------
    Transient

    Raises
    ------
    ValueError
        If a number is out of range, the method does not go with a load, or the load is a force on a wall.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Load, Reference, System, transient
    >>> body = System(wall=True, d1=0.05, clearance=0.5)
    >>> run = transient(body, Load.half_sine(peak=-1.0, duration=3.0), Reference())
    >>> len(run.response.impacts), round(run.peaks["displacement1"], 4), round(run.residual[0], 4)
    (1, 0.5, 0.1044)
    """
    system, method = under_load(system, load, method, free)
    response = simulate_load(system, method, record=samples_of(system, method), initial=initial, cancelled=cancelled)
    if response.ok and len(response.contacts) and not method.has_step:
        depth = float(np.maximum(-system.nearest_gap(*response.trajectory.displacement), 0.0).max())
        shares = instants_of(system, method, response.contacts, depth)  # contacts are short beside all else
        record = Instants.of(shares)
        response = simulate_load(system, method, record=record, initial=initial, cancelled=cancelled)
    return Transient(load, response, tuple(map(float, system.rest if initial is None else initial)))


def samples_of(system: System, method: Method) -> Record:
    """The samples of a whole run: those of every step, or what resolves each body's vibration and the load."""
    return Record(1, method.steps) if method.has_step else Instants.of(instants_of(system, method, np.empty((0, 2))))


def _amplitude(x: float, v: float, omega: float, d: float) -> float:
    return float(math.hypot(x, (v + d * omega * x) / (omega * math.sqrt(1 - d * d))))
