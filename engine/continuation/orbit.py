"""A periodic orbit as the sequence of its events, and how it is read off a run.

Margins keep a solution of the equations an orbit with its sequence of events. Each is smooth along a curve of orbits
with one sequence of events, and positive as long as the solution is an orbit with this sequence. At its zero the
sequence changes.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from vibroscope.engine.continuation.kinds import GRAZING, OPENS, STICKING_BEGINS, STICKING_ENDS
from vibroscope.engine.continuation.tolerances import INSTANT_ROUNDING, SAME_HALVES
from vibroscope.engine.drivers.event_driven import hybrid_state
from vibroscope.engine.drivers.orbit import Evaluation, OrbitEquations, event, numbers_of, steps
from vibroscope.engine.methods import ExactPenalty, Reference
from vibroscope.engine.motions.poincare_map import size_of
from vibroscope.engine.result import Checkpoint
from vibroscope.engine.simulate import simulate

if TYPE_CHECKING:
    from vibroscope.engine.continuation.curve import CurvePoint


NAMES = {getattr(event, name.upper()): name for name in ("impact", "stick", "chatter", "release", "touch", "part")}
NAMES |= {kind + event.SECOND: f"{name} at the second stop" for kind, name in NAMES.items()}
KINDS = {name: kind for kind, name in NAMES.items()}
LATER_SUM = "chatter summed later"  # no point of a branch: the orbit is the same
STAYS_SHUT = "contact no longer opens"  # OPENS from the other side
_MORE = {
    (GRAZING, True): (event.IMPACT,),
    (GRAZING, False): (event.TOUCH, event.PART),
    (OPENS, True): (event.RELEASE, event.STICK),
    (OPENS, False): (event.PART, event.TOUCH),
}  # events at the zero of a minimum, of the reference and of the exact penalty


@dataclass(frozen=True)
class Orbit:
    """A closed orbit, or a guess of one.

    Attributes
    ----------
    period : int
        p, excitation periods of the cycle.
    kinds : tuple of int
        What happens at each event of the cycle, in the order of time, and at which stop.
    first : int
        The stop at which the bodies touch at τ = 0, 1 or 2; 0 if they do not.
    unknowns : (4 + m,) ndarray
        ξ₁, ξ₁′, g, g′ at τ = 0, then the instants of the events in excitation periods, in [0, p].
    """

    period: int
    kinds: tuple[int, ...]
    first: int
    unknowns: np.ndarray

    @property
    def cycle(self) -> tuple[tuple[int, ...], int, int]:
        """The sequence as its equations take it."""
        return self.kinds, self.first, self.period

    @property
    def instants(self) -> np.ndarray:
        """Instants of the events in excitation periods, (m,)."""
        return self.unknowns[4:]

    @property
    def events(self) -> tuple[str, ...]:
        """The events by name."""
        return tuple(NAMES[kind] for kind in self.kinds)

    @property
    def sequence(self) -> str:
        """The events in words."""
        without = "no contact", "lasting contact", "lasting contact at the second stop"
        return ", ".join(self.events) or without[self.first]

    @property
    def at_any_stop(self) -> tuple[int, ...]:
        """What happens at each event, whichever stop it is at."""
        return tuple(kind % event.SECOND for kind in self.kinds)

    @property
    def is_symmetric(self) -> bool:
        """Whether each event is one at the other stop half a cycle later."""
        half = len(self.kinds) // 2
        mirrored = tuple((kind + event.SECOND) % (2 * event.SECOND) for kind in self.kinds[half:])
        if not half or self.period % 2 == 0 or mirrored != self.kinds[:half]:
            return False
        off = self.instants[half:] - self.instants[:half] - 0.5 * self.period
        return bool(np.abs(off).max() < SAME_HALVES)

    def has_sequence_of(self, other: "Orbit") -> bool:
        """Whether another orbit has the same events, in this order."""
        return self.kinds == other.kinds and self.first == other.first

    def at(self, unknowns: np.ndarray) -> "Orbit":
        """The orbit with this sequence of events at other unknowns."""
        return Orbit(self.period, self.kinds, self.first, unknowns)

    def with_events(self, k: int, instants: np.ndarray | float, kinds: tuple[int, ...]) -> "Orbit":
        """The orbit with events more before event k."""
        kinds = (*self.kinds[:k], *kinds, *self.kinds[k:])
        unknowns = np.insert(self.unknowns, 4 + k, instants)
        return Orbit(self.period, kinds, touching_at_start(kinds, self.first), unknowns)

    def without(self, events: set[int]) -> "Orbit":
        """The orbit without some events: a touch alone, or the two that begin and end a phase."""
        kinds = tuple(kind for k, kind in enumerate(self.kinds) if k not in events)
        last = self.kinds[min(events)]
        touching = 1 + last // event.SECOND if (last in event.JOINS) == (len(events) == 1) else 0  # if no event is left
        unknowns = np.delete(self.unknowns, [4 + k for k in events])
        return Orbit(self.period, kinds, touching_at_start(kinds, touching), unknowns)

    def repeated(self, times: int) -> "Orbit":
        """The same orbit over several cycles."""
        shifts = np.repeat(np.arange(times) * self.period, len(self.kinds))
        unknowns = np.concatenate([self.unknowns[:4], np.tile(self.instants, times) + shifts])
        return replace(self, period=times * self.period, kinds=self.kinds * times, unknowns=unknowns)


class KeptEquations:
    """The equations of orbits at some numbers, of which the last few are kept.

    Parameters
    ----------
    problem : callable
        System, η and method at these numbers.
    """

    def __init__(self, problem: Callable[..., tuple]) -> None:
        self._problem, self._known = problem, {}

    def __call__(self, *numbers: float) -> OrbitEquations:
        """The equations; a ValueError where a number is out of its range."""
        found = self._known.get(numbers)
        if found is None:
            last = next(reversed(self._known.values()), None)
            if len(self._known) > 8:
                self._known.clear()
            found = self._known[numbers] = OrbitEquations(*self._problem(*numbers), like=last)
        return found


def least_period(rows: np.ndarray, same: float) -> int:
    """After how many excitation periods the section of a cycle, (p, 4), repeats itself, to a share of its size."""
    size = same * size_of(rows)
    shorter = (p for p in range(1, len(rows)) if len(rows) % p == 0)
    return next((p for p in shorter if np.abs(rows - np.roll(rows, -p, axis=0)).max() <= size), len(rows))


def touching_at_start(kinds: tuple[int, ...], default: int) -> int:
    """The stop at which the bodies touch at τ = 0, 1 or 2, by the last event of the cycle; 0 if they do not."""
    if not kinds:
        return default
    return 1 + kinds[-1] // event.SECOND if kinds[-1] in event.JOINS else 0


def at_stop_of(kind: int, kinds: tuple[int, ...]) -> tuple[int, ...]:
    """Events at the stop of another one, of those at the first."""
    return tuple(each + kind // event.SECOND * event.SECOND for each in kinds)


def within_cycle(orbit: Orbit, evaluation: Evaluation, equations: OrbitEquations) -> tuple[Orbit, int]:
    """The same orbit with all events in [0, p), and by how many places they are turned.

    Events that have passed an end of the cycle are counted at the other end; the state at τ = 0 then is that after
    them, or before them. With events beyond both ends, those beyond the second are left to another call.
    """
    m, instants, period = len(orbit.kinds), orbit.instants, orbit.period
    times = instants.tolist()
    if not m or (min(times) >= 0 and max(times) < period):
        return orbit, 0
    early = int((instants < 0).sum())
    late = 0 if early else int((instants >= period).sum())
    turned = -early if early else late
    kinds = tuple(np.roll(orbit.kinds, turned).tolist())
    times = np.roll(instants, turned)
    times[m - early :] += period
    times[:late] -= period
    source = (early - 1) if early else (m - 1 - late) % m
    turn = evaluation.after[source, 4] - (0 if early else period * (1 if late < m else 2))
    state = equations.state_later(orbit.kinds[source], evaluation.after[source, :4], turn, -turn)
    return Orbit(period, kinds, touching_at_start(kinds, orbit.first), np.concatenate([state, times])), turned


def orbit_of_run(problem: tuple, y: np.ndarray, period: int) -> Orbit | None:
    """The orbit that a run over one cycle from y = (ξ₁, ξ₁′, g, g′) suggests; None if the run ends early."""
    system, eta, method = problem
    start = Checkpoint(system, eta, method, 0, tuple(hybrid_state(*problem, y).tolist()))
    run = simulate(system, eta, method, periods=period, keep=period, initial=start)
    if not run.ok:
        return None
    cycle, begun = run.period, event.SECOND if y[2] > 0.5 * system.play else 0
    events = (_impacts_and_contacts if method.rigid else _contacts)(run, cycle, period, begun)
    kinds, first = tuple(kind for _, kind in events), 1 + begun // event.SECOND if len(run.contacts) else 0
    return Orbit(period, kinds, touching_at_start(kinds, first), np.array([*y, *(time for time, _ in events)]))


def _stops_of(run) -> np.ndarray:
    """What is added to the events of impacts by their stop, (n,)."""
    return np.where(run.impacts.impulse < 0, event.SECOND, 0)


def _contacts(run, cycle: float, period: int, begun: int) -> list[tuple[float, int]]:
    """Beginnings and ends of contacts of the penalty within the cycle; one that is open at its end ends there.

    ``begun``: what is added to the events of the stop near which the run begins.
    """
    events = []
    stops = dict(zip(run.impacts.time, _stops_of(run).tolist(), strict=True))
    for begin, end in run.contacts:
        stop = stops.get(begin, begun)
        if begin > 0.0:
            events.append((begin / cycle, event.TOUCH + stop))
        if end / cycle < period - INSTANT_ROUNDING:
            events.append((end / cycle, event.PART + stop))
    return sorted(events)


def _impacts_and_contacts(run, cycle: float, period: int, begun: int) -> list[tuple[float, int]]:
    """Impacts and permanent contacts of the reference within the cycle; ``begun`` as above."""
    begins, ends = run.contacts.T / cycle if len(run.contacts) else (np.empty(0), np.empty(0))
    times = run.impacts.time / cycle
    kinds = [event.STICK if time in begins else event.IMPACT for time in times]
    for begin in begins:
        before = np.flatnonzero(times < begin)
        if begin > 0.0 and begin not in times and len(before):
            kinds[before[-1]] = event.CHATTER
    stops = _stops_of(run)
    events = list(zip(times.tolist(), (stops + np.array(kinds, dtype=int)).tolist(), strict=True))
    for end in ends[ends < period].tolist():
        met = np.append(begun, stops[times < end])  # the last of them is in contact
        events.append((end, event.RELEASE + int(met[-1])))
    return sorted(events)


def short_phase(orbit: Orbit, k: int) -> tuple[int, int, float]:
    """Event k and its neighbour that is nearer in time, in their order, and how long the phase between them lasts."""
    m = len(orbit.kinds)
    before, after = (k - 1) % m, (k + 1) % m
    ahead, behind = _length(orbit, k, after), _length(orbit, before, k)
    return (k, after, ahead) if abs(ahead) <= abs(behind) else (before, k, behind)


def _length(orbit: Orbit, first: int, last: int) -> float:
    """From one event to a later one, across the end of the cycle if that has the smaller number."""
    length = orbit.instants[last] - orbit.instants[first]
    return float(length if last > first else length + orbit.period)


class Margin(NamedTuple):
    """A condition on an orbit, met while ``value`` > 0."""

    kind: str
    event: int  # of the sequence; len(kinds) is the end of the cycle
    inside: bool  # whether it concerns the phase that ends with the event, not the event
    column: int  # of the facts of that event, or what steps adds to them; that of a minimum is followed by its instant
    value: float = np.nan
    more: tuple[int, ...] = ()  # the events that follow each other at its zero

    def point_at(self, orbit: Orbit, method: Reference | ExactPenalty) -> str:
        """The kind of the point at its zero, with the orbit there: the same from both sides.

        On one side there is a phase more, a contact or a flight. From there the point is where that has no length, from
        the other side where a minimum is zero.
        """
        grazes = self.kind == GRAZING and not self.inside and not method.rigid
        flight_vanishes = grazes and orbit.at_any_stop[short_phase(orbit, self.event)[0]] == event.PART
        return OPENS if self.kind == STAYS_SHUT or flight_vanishes else self.kind

    def stop(self, orbit: Orbit) -> int:
        """The stop that it is about, 1 or 2."""
        return 1 + (self.more[0] if self.inside else orbit.kinds[self.event]) // event.SECOND


def margins(orbit: Orbit, evaluation: Evaluation, method: Reference | ExactPenalty) -> list[Margin]:
    """All margins of an orbit, in a fixed order for each sequence of events."""
    conditions, columns = _conditions_of(orbit, method)
    values = steps.margin_values(*_of_values(columns, orbit, evaluation, method)).tolist()
    return [margin._replace(value=value) for margin, value in zip(conditions, values, strict=True)]


def least_margin(orbit: Orbit, evaluation: Evaluation, method: Reference | ExactPenalty) -> float:
    """The smallest margin of an orbit; nan if one of them is."""
    values = steps.margin_values(*_of_values(_conditions_of(orbit, method)[1], orbit, evaluation, method))
    return float(values.min())


def parts_more_than_pressed(k: int, point: "CurvePoint") -> float:
    """By how much the parting speed of impact k less ε exceeds the force that parts the bodies."""
    parting, force = point.evaluation.facts[k, [event.PARTING, event.FORCE]]
    return float(parting - point.method.threshold + force)


def impacts_that_may_stick(before: "CurvePoint", after: "CurvePoint") -> Iterator[int]:
    """The impacts that may stick between two neighbours though they do at neither, for one reason each."""
    k, threshold, kinds = -1, before.method.threshold, numbers_of(before.orbit.kinds)
    while threshold > 0:
        k = steps.impact_that_may_stick(kinds, before.evaluation.facts, after.evaluation.facts, threshold, k + 1)
        if k < 0:
            return
        yield k


def _of_values(conditions: np.ndarray, orbit: Orbit, evaluation: Evaluation, method: Reference | ExactPenalty) -> tuple:
    """What the values of margins are made of."""
    return evaluation.facts, orbit.instants, float(method.threshold), conditions


def _conditions_of(orbit: Orbit, method: Reference | ExactPenalty) -> tuple[tuple[Margin, ...], np.ndarray]:
    rigid = method.rigid
    return _conditions(orbit.kinds, orbit.first, rigid, rigid and method.threshold > 0)


@lru_cache(maxsize=1024)
def _conditions(kinds: tuple[int, ...], first: int, rigid: bool, sticks: bool) -> tuple[tuple[Margin, ...], np.ndarray]:
    """The margins of a sequence of events, without their values, and where these stand: events and columns, (2, n)."""
    found = tuple(_margins(kinds, first, rigid, sticks))
    return found, np.array([[margin.event for margin in found], [margin.column for margin in found]])


def _margins(kinds: tuple[int, ...], first: int, rigid: bool, sticks: bool) -> Iterator[Margin]:
    touching, before = first > 0, kinds[-1] if kinds else event.SECOND * (first == 2)  # that the phase begins with
    for k, kind in enumerate(kinds):
        yield from _within(k, touching, before, rigid)
        what = kind % event.SECOND
        if k and before == kind - what + event.RELEASE:  # its closing speed is of second order
            yield Margin(STAYS_SHUT, k, False, steps.LENGTH)
        elif what in (event.IMPACT, event.STICK, event.CHATTER, event.TOUCH):
            yield Margin(GRAZING, k, False, event.CLOSING)
        if what == event.IMPACT and sticks:
            yield Margin(STICKING_BEGINS, k, False, steps.BEGINS)
        if what == event.STICK:
            yield Margin(STICKING_ENDS, k, False, steps.ENDS)
        if what == event.CHATTER:
            yield Margin(STICKING_ENDS, k, False, event.FORCE)
            yield Margin(LATER_SUM, k, False, event.ROOM)
        if what == event.PART:
            yield Margin(GRAZING, k, False, event.PARTING)
        touching, before = kind in event.JOINS, kind
    yield from _within(len(kinds), touching, before, rigid)


def _within(k: int, touching: bool, before: int, rigid: bool) -> Iterator[Margin]:
    """The margins of a phase that begins with an event ``before``: of what is watched, and of the other stop's gap."""
    within = OPENS if touching else GRAZING
    yield Margin(within, k, True, event.LOWEST, more=at_stop_of(before, _MORE[within, rigid]))
    if not touching:
        other = (before + event.SECOND) % (2 * event.SECOND)
        yield Margin(GRAZING, k, True, event.ACROSS, more=at_stop_of(other, _MORE[GRAZING, rigid]))
