"""Energy balance of a motion that is known in closed form between its events, followed from event to event.

The way from one row of the section to the next is cut into segments of a single phase: at the events, and at the
quarters of the period, where the stored energy is evaluated as well. On each segment the powers are integrated exactly.
The state starts anew from each row of the section, so that errors do not add up.

Between two events the state z = (ξ₁ − ξ₁*, ξ₁′, g − g*, g′, cos ητ, sin ητ, 1) relative to the equilibrium of the phase
obeys z′ = A z (:mod:`..kernels.linear.tables`); the column of the 1 is the constant force on a body without a spring.
The powers depend on velocities and excitation alone, so that the equilibrium does not matter to them. Every power is a
quadratic form zᵀVz, with the integral over a duration s

    ∫₀ˢ zᵀVz dτ = z(0)ᵀ G(s) z(0),    G(s) = ∫₀ˢ E(τ)ᵀ V E(τ) dτ,    G(2s) = G(s) + E(s)ᵀ G(s) E(s)     (50)

with E(τ) = exp(Aτ). G and E follow for short durations from their Taylor series, and for longer ones by doubling, where
E(2s) = E(s)².
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.drivers.event_driven import contact_state
from vibroscope.engine.drivers.parameters import Parameters, equilibria, generators, parameters_of, seen_from_stops
from vibroscope.engine.methods import Method
from vibroscope.engine.model import System
from vibroscope.engine.result import Response, check_cancelled

_TERMS = 16  # of the series in A s with |A| s ≤ 1/4
_STATE = np.eye(7)
_X1, _V1, _GAP, _RATE, _COSINE, _SINE, _ONE = _STATE
FLIGHT, CONTACT, CHATTER = range(3)  # phases, in the order of `EnergyForms.generators`
QUARTERS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
EPSILON = np.finfo(float).eps
_SEGMENTS_AT_ONCE = 1024


class EnergyForms(NamedTuple):
    """Generators of the phases of a motion, and its powers and energy as quadratic forms of z.

    The phases are flight, contact, and the last part of a chatter, in which the pendulums move as one while infinitely
    many impacts dissipate their relative motion.
    """

    parameters: Parameters  # a wall is body 1 that never moves
    generators: tuple[np.ndarray, ...]  # (7, 7) of each phase
    powers: tuple[np.ndarray, ...]  # (3, 7, 7) of each phase: excitation, dampers, contact damper
    equilibria: tuple[np.ndarray, ...]  # (7,) of each phase, relative to that of the flight
    stored: np.ndarray  # (7, 7) E without the contact spring, of z relative to the equilibrium of the flight
    ends: tuple[np.ndarray, ...]  # (7,) rows of what vanishes where flight and contact end, of the same z …
    levels: tuple[float, ...]  # … less these numbers


def energy_forms(system: System, eta: float, method: Method) -> EnergyForms:
    """The quadratic forms of a system with one stop, or with its first one alone."""
    c = system.with_first_stop
    p = parameters_of(c, eta, method)
    mu, x2, v2 = p.mu, _X1 + _GAP, _V1 + _RATE
    phases = generators(c, eta, method)
    load1, push = (row[4] * _COSINE + row[5] * _SINE for row in (phases[0][1], phases[0][3]))
    work = _product(load1, _V1) + mu * _product(load1 + push, v2)
    dampers = 2 * p.d1 * _product(_V1) + 2 * mu * p.damper2 * _product(v2)
    if c.rests_afar:
        springs = 0.5 * p.kappa**2 * _product(_GAP) - p.pull * _product(_X1, _GAP)
    else:
        springs = 0.5 * (p.spring1 * _product(_X1) + mu * p.kappa**2 * _product(x2))
        springs = springs - _product(_ONE, p.pull1 * _X1 + mu * (p.pull1 + p.pull) * x2)
    zero = np.zeros((7, 7))
    if method.rigid:
        dissipated = np.array([2 * (1 + mu) * p.damper3 * _product(_V1), zero])
        # the contact force is proportional to g″ of the motion without contact
        ends, levels = (_GAP, phases[0][3]), (p.free_gap, 0.0)
    else:
        dissipated = np.array([dampers, 2 * p.damping * _product(_RATE)])
        ends, levels = (_GAP, _GAP), (p.free_gap, p.free_gap)
    return EnergyForms(
        parameters=p,
        generators=phases,
        powers=(np.array([work, dampers, zero]), np.array([work, *dissipated]), np.array([work, dampers, zero])),
        equilibria=equilibria(c, eta, method),
        stored=0.5 * (_product(_V1) + mu * _product(v2)) + springs,
        ends=ends,
        levels=levels,
    )


def _product(row: np.ndarray, other: np.ndarray | None = None) -> np.ndarray:
    """Return the symmetric V with zᵀVz = (row·z)(other·z), (7, 7); by default the square of row·z."""
    other = row if other is None else other
    return 0.5 * (np.outer(row, other) + np.outer(other, row))


def phase_integrals(generator: np.ndarray, powers: np.ndarray, durations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return E(s) − 1, (n, 7, 7), and G(s) of each power, (n, 3, 7, 7), for n durations s.

    E − 1 is doubled rather than E, so that a slow motion keeps its digits beside a stiff contact.
    """
    # scaled by its own frequency, the gap of a stiff contact has the size of its rate
    frequency = np.sqrt(max(1.0, np.abs(generator[3, 2])))
    scale = np.array([1.0, 1.0, 1.0 / frequency, 1.0, 1.0, 1.0, 1.0])
    a = generator * (scale[None, :] / scale[:, None])
    forms = powers * (scale[:, None] * scale[None, :])
    longest = np.abs(a).sum(axis=1).max() * durations.max(initial=0.0)
    doublings = max(0, int(np.ceil(np.log2(max(longest, 1e-300) * 4))))
    h = (durations / 2.0**doublings)[:, None, None]
    change, power = np.zeros((len(durations), 7, 7)), np.eye(7)
    integral, form = np.zeros((len(durations), 3, 7, 7)), forms.copy()
    for k in range(1, _TERMS):
        integral += form * h[:, None] ** k
        form = (a.T @ form + form @ a) / (k + 1)
        power = power @ a / k
        change += power * h**k
    for _ in range(doublings):
        move = change[:, None] + np.eye(7)
        integral += np.swapaxes(move, 2, 3) @ integral @ move
        change = 2 * change + change @ change
    return change * (scale[:, None] / scale[None, :]), integral / (scale[:, None] * scale[None, :])


@dataclass(frozen=True)
class EnergyBalance:
    """Energy over each kept period, in units of m₁ω₁² times the base amplitude squared; all (n,) ndarrays.

    Attributes
    ----------
    gain : ndarray
        Increase of the mechanical energy.
    work : ndarray
        Work of the excitation on both masses, relative to the base.
    dampers : ndarray
        Energy dissipated by the dampers of the pendulums; in permanent contact, by that of the joined pendulums.
    contact : ndarray
        Energy dissipated by the contact damper (penalty).
    impacts : ndarray
        Energy dissipated by impacts (reference).
    stored : float
        Largest mechanical energy, of those at events and at the quarters of each period.
    """

    gain: np.ndarray
    work: np.ndarray
    dampers: np.ndarray
    contact: np.ndarray
    impacts: np.ndarray
    stored: float

    @property
    def lost(self) -> np.ndarray:
        """Energy dissipated by dampers, contact and impacts."""
        return self.dampers + self.contact + self.impacts

    @property
    def residual(self) -> np.ndarray:
        """Gain + losses − work: 0 but for errors of the solution; of steps, the energy that they create."""
        return self.gain + self.lost - self.work

    @property
    def size(self) -> float:
        """Energy to compare a residual with: the largest stored one, plus the work or the losses of a period."""
        return float(self.stored + max(np.abs(self.work).max(initial=0.0), self.lost.max(initial=0.0)))


def balance_between_events(response: Response, rows: np.ndarray, cancelled: Poll | None = None) -> EnergyBalance:
    """Balance the energy between consecutive rows of the section, (n + 1, 4): n periods."""
    forms = [energy_forms(seen, response.eta, own) for seen, own in seen_from_stops(response.system, response.method)]
    segments = _segments(response, rows)
    walk = _Walk(response, forms, rows)
    for first in range(0, len(segments), _SEGMENTS_AT_ONCE):
        check_cancelled(cancelled)
        part = segments[first : first + _SEGMENTS_AT_ONCE]
        changes, integrals = _all_integrals(forms, part)
        # events of coarse located steps may lead beyond all numbers: then the sums are nan, see below
        with np.errstate(over="ignore", invalid="ignore"):
            for segment, change, integral in zip(part, changes, integrals, strict=True):
                walk.follow(segment, change, integral)
    sums = walk.sums
    sums[~np.isfinite(sums).all(axis=1)] = np.nan
    stored = np.array([walk.stored(walk.section_state(row)) for row in rows])
    work, dampers, contact, impacts = sums.T
    largest = max(walk.largest_stored, float(stored.max()))
    return EnergyBalance(np.diff(stored), work, dampers, contact, impacts, largest)


class _Segment(NamedTuple):
    """A part of one phase between two events, or between an event and a quarter of the period."""

    row: int  # kept period
    phase: int
    begin: float  # τ
    end: float
    impact: int  # index of the impact that it begins with, or −1
    quarter: float  # fraction of the period at which it ends; 0 if an event ends it
    load: tuple[float, float] | None = None  # cos ητ and sin ητ, or what stands for them, where they begin anew
    stop: int = 0  # from which it is seen: that of its contact, or of the touch that ends a flight


def _segments(response: Response, rows: np.ndarray) -> list[_Segment]:
    """Cut the periods between rows of the section at the events and at their quarters."""
    rigid, periods = response.method.rigid, len(rows) - 1
    impacts, contacts = response.impacts.time, response.contacts
    closed = contacts[contacts[:, 1] < response.window[1], 1]
    times = np.unique(np.concatenate([impacts if rigid else [], contacts[:, 0], closed]))
    without_impact = np.setdiff1d(contacts[:, 0], impacts)  # contacts at the end of a chatter
    last, cuts, loads = round(response.window[1] / response.period), QUARTERS, {}
    load = response.system.excitation.load
    if load is not None:
        within = load.segments[load.segments[:, 0] < load.length]
        cuts = np.union1d(QUARTERS, within[:, 0] / load.length)
        loads = dict(zip(within[:, 0] / load.length * response.period, within[:, 1:], strict=True))
    segments, chattering = [], False
    for period in range(last - periods, last):
        quarters = (period + cuts) * response.period
        events = times[(times > quarters[0] if period > 0 else times >= 0) & (times < quarters[-1])]
        for begin, end in pairwise(np.union1d(quarters, events)):
            contact = np.searchsorted(contacts[:, 0], begin, side="right") - 1
            touching = contact >= 0 and begin < contacts[contact, 1]
            impact = int(np.searchsorted(impacts, begin, side="right")) - 1 if rigid else -1
            # the state at a row of the section already includes an impact there
            struck = impact >= 0 and impacts[impact] == begin and (begin > quarters[0] or period == 0)
            following = times[min(np.searchsorted(times, begin, side="right"), len(times) - 1)] if len(times) else 0.0
            chattering = rigid and not touching and (struck or chattering) and following in without_impact
            phase = CONTACT if touching else CHATTER if chattering else FLIGHT
            quarter = 0.0 if end in events else float(cuts[np.searchsorted(quarters, end)])
            row = period - (last - periods)
            stop = _stop_at(response, rows[0], end if phase == FLIGHT else begin)
            segments.append(_Segment(row, phase, begin, end, impact if struck else -1, quarter, loads.get(begin), stop))
    return segments


def _stop_at(response: Response, first: np.ndarray, time: float) -> int:
    """The stop that was touched last at a time: of the second one the impulse is negative."""
    system, impacts = response.system, response.impacts
    if not system.two_stops:
        return 0
    before = int(np.searchsorted(impacts.time, time, side="right")) - 1
    return int(impacts.impulse[before] < 0 if before >= 0 else system.gap(first[0], first[2]) > 0.5 * system.play)


def _all_integrals(forms: Sequence[EnergyForms], segments: list[_Segment]) -> tuple[np.ndarray, np.ndarray]:
    """E − 1, (n, 7, 7), and the integrals of the powers, (n, 3, 7, 7), of n segments."""
    durations = np.array([segment.end - segment.begin for segment in segments])
    kinds = np.array([(segment.stop, segment.phase) for segment in segments])
    changes, integrals = np.zeros((len(segments), 7, 7)), np.zeros((len(segments), 3, 7, 7))
    for stop, phase in np.unique(kinds, axis=0).tolist():
        chosen, own = (kinds == (stop, phase)).all(axis=1), forms[stop]
        changes[chosen], integrals[chosen] = phase_integrals(
            own.generators[phase], own.powers[phase], durations[chosen]
        )
    return changes, integrals


class _Walk:
    """Follows the state through all segments and sums what each of them dissipates.

    z is relative to the equilibrium of the flight as seen from the first stop; within a segment as from its own.
    """

    def __init__(self, response: Response, forms: Sequence[EnergyForms], rows: np.ndarray):
        self.response, self.of_stops, self.rows = response, forms, rows
        self.forms = forms[0]  # of the segment
        self.sums = np.zeros((len(rows) - 1, 4))  # of each period: work, dampers, contact damper, impacts
        self.largest_stored = 0.0
        self.row, self.elapsed, self.z = -1, 0.0, np.zeros(7)

    def section_state(self, row: np.ndarray) -> np.ndarray:
        """Return z, relative to the equilibrium of the flight, for a row ξ₁, ξ₁′, ξ₂, ξ₂′ of the section."""
        return np.array([*self.relative(row), 1.0, 0.0, 1.0])

    def relative(self, state: Sequence[float]) -> np.ndarray:
        """Return the first four numbers of z, relative to the equilibrium of the flight."""
        first = self.of_stops[0].parameters
        return contact_state(self.response.system, state) - np.array([first.free_position, 0.0, first.free_gap, 0.0])

    def stored(self, z: np.ndarray) -> float:
        """Return the mechanical energy E, of z as seen from the first stop."""
        first = self.of_stops[0]
        gap, play = z[2] + first.parameters.free_gap, self.response.system.play
        sides = zip(self.of_stops, (gap, play - gap), strict=False)
        springs = sum(own.parameters.stiffness * min(each, 0.0) ** 2 for own, each in sides)
        return z @ first.stored @ z + 0.5 * springs

    def _turn(self, stop: int, other: int) -> None:
        """Let z be seen from another stop: mirrored, and so a load that has no sign of its own in the forms."""
        if stop == other:
            return
        one, two, play = self.of_stops[stop].parameters, self.of_stops[other].parameters, self.response.system.play
        x1, v1, gap, rate, c, s, one_more = self.z
        sign = 1.0 if self.response.system.excitation.load is None else -1.0
        x1, gap = -(x1 + one.free_position) - two.free_position, play - (gap + one.free_gap) - two.free_gap
        self.z = np.array([x1, -v1, gap, -rate, sign * c, sign * s, one_more])

    def follow(self, segment: _Segment, change: np.ndarray, integral: np.ndarray) -> None:
        """Move the state to the end of a segment and add the energies of the segment to the sums.

        Parameters
        ----------
        change : (7, 7) ndarray
            E − 1 over the duration of the segment.
        integral : (3, 7, 7) ndarray
            G of each power.
        """
        if segment.row != self.row:
            self.row, self.elapsed, self.z = segment.row, 0.0, self.section_state(self.rows[segment.row])
        if segment.load is not None:
            self.z[4:6] = segment.load
        if segment.impact >= 0:
            self._apply_impact(segment)
        self.forms = self.of_stops[segment.stop]
        self._turn(0, segment.stop)
        generator, duration = self.forms.generators[segment.phase], segment.end - segment.begin
        equilibrium = self.forms.equilibria[segment.phase]
        z = self.z - equilibrium
        end = z + change @ z
        correction = self._duration_correction(segment, duration, end, generator)
        slope = generator @ end
        power = end @ self.forms.powers[segment.phase] @ end
        self.sums[segment.row, :3] += z @ integral @ z + correction * power
        self.z = end + correction * slope + 0.5 * correction**2 * (generator @ slope) + equilibrium
        self.elapsed += duration + correction
        if segment.quarter == 0.0 and self.response.method.rigid:
            self.z[2] = -self.forms.parameters.free_gap
        self._turn(segment.stop, 0)
        self.largest_stored = max(self.largest_stored, float(self.stored(self.z)))

    def _duration_correction(self, segment: _Segment, duration: float, end: np.ndarray, generator: np.ndarray) -> float:
        """Return the rounding error of the duration: the quantity that ends a phase vanishes at its exact end."""
        if segment.quarter > 0.0:
            return segment.quarter * self.response.period - self.elapsed - duration
        if segment.phase == CHATTER:
            return 0.0
        row = self.forms.ends[segment.phase]
        slope = row @ generator @ end
        value = row @ (end + self.forms.equilibria[segment.phase]) + self.forms.levels[segment.phase]
        correction = -value / slope if slope != 0.0 else 0.0
        allowed = 4 * EPSILON * (segment.end + self.response.period)
        return correction if abs(correction) <= allowed else 0.0

    def _apply_impact(self, segment: _Segment) -> None:
        """Set the state after an impact. If the rest of a chatter follows, it dissipates all relative motion."""
        impacts, share = self.response.impacts, self.response.system.mass_share
        v1, v2 = impacts.velocity_after[segment.impact]
        x1, x2 = impacts.position[segment.impact], impacts.position2(self.response.system)[segment.impact]
        before = np.diff(impacts.velocity_before[segment.impact])[0]
        after = v2 - v1
        if segment.phase != FLIGHT:
            v1 = 0.0 if self.response.system.wall else v1 + share * after
            after, v2 = 0.0, v1
        self.sums[segment.row, 3] += 0.5 * share * (before - after) * (before + after)
        touch = self.response.system.play if impacts.impulse[segment.impact] < 0 else 0.0
        self.z[:4] = self.relative((x1, v1, x2, v2))
        self.z[2], self.z[3] = touch - self.of_stops[0].parameters.free_gap, after
