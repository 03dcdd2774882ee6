"""Where a sequence of events ceases to hold: which one follows, and the first orbit that has it.

- *Grazing* of an impact, or a touch, whose closing speed falls to zero: the same orbit without it. The other way round,
  where the gap of a flight falls to zero: the same orbit with an impact, or a contact, more. Likewise a contact of the
  penalty that opens in between. Both sequences have the orbit at this point in common.
- *Sticking*: with the threshold ε an impact that leaves a parting speed of ε takes the whole relative velocity instead,
  so that the motion jumps by as much.

Which way the new curve goes is said by its own margins.

Where an impact begins or ceases to stick the motion jumps by about ε, and the first orbit is that behind the jump. What
is zero where a sequence ends, the parting speed less ε or the force that presses the bodies together, is so at an orbit
of the sequence beyond the jump, too, at another α₁. There its curve begins, and leads to where that grows. So a branch
has the same orbits and points whichever way it is followed: a jump has two ends, and both are points.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise, tee

import numpy as np
from vibroscope.engine.continuation.curve import Curve, CurvePoint
from vibroscope.engine.continuation.kinds import GRAZING, OPENS, STICKING_BEGINS, STICKING_ENDS
from vibroscope.engine.continuation.orbit import (
    LATER_SUM,
    STAYS_SHUT,
    Margin,
    Orbit,
    at_stop_of,
    least_period,
    orbit_of_run,
    short_phase,
    touching_at_start,
    within_cycle,
)
from vibroscope.engine.continuation.roots import zero_ahead
from vibroscope.engine.continuation.tolerances import (
    INSIDE_CURVE,
    LOCATED_JUMP,
    REPEATED,
    SHORTEST_CONTACT,
    SHORTEST_FLIGHT,
    ZERO_MARGIN,
)
from vibroscope.engine.continuation.tracer import first_ahead, walk
from vibroscope.engine.drivers.orbit import event

JUMPS = 10.0 ** np.arange(-7, -3)  # of the range, to where runs show a sequence that follows
SPLICED = 3  # events of a run, from the first that differs on, with which the last orbit may go on
STEPS = 10.0 ** np.arange(-7, -2.5, 0.5)  # scaled, along the new curve: the first that shows which way it goes


def after_jump(curve: Curve, last: CurvePoint, margin: Margin | None) -> tuple[CurvePoint | None, CurvePoint | None]:
    """The nearest orbit with another sequence that runs from the last one show, where a margin is zero.

    Without a margin the sequence has a complete chatter. There may be no orbit with a sequence where the run shows it,
    but on the other side of the last orbit.

    Returns
    -------
    CurvePoint or None
        The first orbit beyond the jump, its tangent away from there.
    CurvePoint or None
        The end of its curve from which it comes; None if it is not known.
    """
    sticking = margin and Sticking.of(curve, last, margin)
    last = last.within_cycle()  # its state at τ = 0, from which runs begin, lies before all its events
    onwards = 1.0 if last.tangent[-1] >= 0 else -1.0
    first, second = tee(_starts(curve, last, onwards, complete=margin is None))
    found = (sticking.first_orbit(start) for start in first if sticking is not None)
    other = ((_leading_on(curve, start, last.value, onwards), None) for start in second)
    return next((both for both in chain(found, other) if both[0] is not None), (None, None))


def _starts(curve: Curve, last: CurvePoint, onwards: float, complete: bool) -> Iterator[CurvePoint]:
    """Solutions near the last orbit with the sequences of events that runs from there show; ``complete``: as above."""
    seen, runs = {last.orbit.kinds}, []
    places = [last.value + way * jump for jump in JUMPS * curve.width for way in (onwards, -onwards)]
    places = [value for value in places if curve.low <= value <= curve.high]

    def near(guess: Orbit, values: Sequence[float]) -> Iterator[CurvePoint]:
        seen.add(guess.kinds)
        found = (last.neighbour(guess, value, onwards) for value in values)
        return (start for start in found if start is not None)

    for shown in places:
        guess = orbit_of_run(curve.family.at(shown), last.evaluation.section[0], last.orbit.period)
        if guess is None or guess.kinds in seen or (complete and event.CHATTER not in guess.at_any_stop):
            continue
        runs.append((shown, guess))
        yield from near(guess, (shown, *places))
        sticks = [k for k, pair in enumerate(pairwise(guess.at_any_stop)) if pair == (event.STICK, event.RELEASE)]
        pairs = zip(guess.kinds, last.orbit.kinds, strict=False)
        differs = next((k for k, (kind, before) in enumerate(pairs) if kind != before), 0)
        for k in sorted({differs, *sticks}):
            yield from _with_phase_of(curve, last, guess, k)
        for k in sticks:
            yield from _with_phase_of(curve, last, _parting(guess, k), k - 1)
    for shown, run in runs:
        for guess in (*_spliced(last.orbit, run), *_second_cycle(curve, run, shown)):
            if guess.kinds not in seen and not complete:
                yield from near(guess, places)


def _second_cycle(curve: Curve, run: Orbit, value: float) -> Iterator[Orbit]:
    """What the cycle after that of a run suggests: in the first, the last orbit may still have had to come to rest."""
    end = curve.evaluate(run, value).after[-1, :4]
    guess = orbit_of_run(curve.family.at(value), end, run.period)
    if guess is not None:
        yield guess


def _spliced(last: Orbit, run: Orbit) -> Iterator[Orbit]:
    """The last orbit with the first events of a run that it does not have; the run is still far from its own orbit."""
    pairs = enumerate(zip(run.kinds, last.kinds, strict=False))
    differs = next((k for k, (kind, before) in pairs if kind != before), len(run.kinds))
    for k in range(differs + 1, min(differs + SPLICED, len(run.kinds)) + 1):
        later = int((last.instants <= run.instants[k - 1]).sum())
        while last.at_any_stop[later : later + 1] == (event.RELEASE,) and run.kinds[k - 1] not in event.JOINS:
            later += 1
        kinds = run.kinds[:k] + last.kinds[later:]
        instants = np.concatenate([run.instants[:k], last.instants[later:]])
        yield Orbit(
            last.period, kinds, touching_at_start(kinds, last.first), np.concatenate([run.unknowns[:4], instants])
        )


def _with_phase_of(curve: Curve, last: CurvePoint, guess: Orbit, k: int) -> Iterator[CurvePoint]:
    """The solution near the last orbit in which the phase after event k lasts as long as in a guess, at any α₁."""
    if not 0 <= k < len(guess.kinds) - 1:
        return
    start = curve.with_phase(guess, last.value, k, k + 1)
    if start is not None and last.is_near(start.orbit):
        yield start


def _parting(orbit: Orbit, k: int) -> Orbit:
    """The orbit whose impact k parts instead of sticking until a release: beyond a jump it may not be pressed."""
    kinds = (*orbit.kinds[:k], *at_stop_of(orbit.kinds[k], (event.IMPACT,)), *orbit.kinds[k + 2 :])
    return replace(orbit, kinds=kinds, unknowns=np.delete(orbit.unknowns, 5 + k))


@dataclass(frozen=True)
class Sticking:
    """Where an impact begins or ceases to stick: what is zero there, of the orbits on either side of the jump.

    Attributes
    ----------
    curve : Curve
    event : int
        The impact, as it is numbered where all events lie in [0, p).
    sticks : bool
        Whether it sticks beyond the jump.
    column : int
        Of the facts: PARTING if the parting speed is ε there, FORCE if the bodies are not pressed together.
    """

    curve: Curve
    event: int
    sticks: bool
    column: int

    @classmethod
    def of(cls, curve: Curve, last: CurvePoint, margin: Margin) -> "Sticking | None":
        """That of the last orbit before the jump; None if its margin is another one."""
        k, kinds = margin.event, last.orbit.at_any_stop
        if margin.kind not in (STICKING_BEGINS, STICKING_ENDS) or kinds[k] == event.CHATTER:
            return None
        parting, force = last.evaluation.facts[k, [event.PARTING, event.FORCE]]
        column = event.PARTING if abs(parting - last.method.threshold) < abs(force) else event.FORCE
        _, turned = within_cycle(last.orbit, last.evaluation, curve.equations(last.value))
        return cls(curve, (k + turned) % len(kinds), kinds[k] == event.IMPACT, column)

    def first_orbit(self, start: CurvePoint) -> tuple[CurvePoint | None, CurvePoint | None]:
        """The first orbit of a curve beyond the jump, with the tangent away from it, and the end of that curve.

        ``start`` is any orbit nearby.
        """
        kind = event.STICK if self.sticks else event.IMPACT
        ahead = next(walk(self.curve, start), None)
        if ahead is None or start.orbit.at_any_stop[self.event : self.event + 1] != (kind,):
            return None, None
        inwards = start if self._value(ahead) > self._value(start) else start.turned()
        beyond_end = self._value(start) <= 0
        way = inwards if beyond_end else inwards.turned()
        for here, there in pairwise(chain((way,), walk(self.curve, way))):
            if (self._value(there) <= 0) != beyond_end:
                return self._last_before(there, here) if beyond_end else self._last_before(here.turned(), there)
        return None, None

    def _last_before(self, inside: CurvePoint, outside: CurvePoint) -> tuple[CurvePoint | None, CurvePoint | None]:
        """The orbit right before the end of its curve, which lies between two others, and that end.

        With the tangent of the first.
        """
        zero = zero_ahead(self.curve.along(inside), inside.way_to(outside), self._value, LOCATED_JUMP)
        point = None if zero is None else self.curve.ahead(inside, (1 - INSIDE_CURVE) * zero[0])
        if point is None or not point.holds:
            return None, None
        return point, zero[1]

    def _value(self, point: CurvePoint) -> float:
        """What is zero at the jump, and positive where the sequence beyond it holds."""
        facts = point.evaluation.facts[self.event]
        if self.column == event.FORCE:
            return float(facts[event.FORCE] if self.sticks else -facts[event.FORCE])
        slower = float(point.method.threshold - facts[event.PARTING])
        return slower if self.sticks else -slower


def _leading_on(curve: Curve, start: CurvePoint, last: float, onwards: float) -> CurvePoint | None:
    """The first orbit from another one on beyond the last α₁, or else away from it: between them it may lead back."""
    low, high = sorted((start.value, last))
    found = None
    if (start.value - last) * onwards < 0:
        found = first_ahead(curve, (start,), lambda there: (there - last) * onwards > 0)
    if found is None:
        found = first_ahead(curve, (start, start.turned()), lambda there: not low <= there <= high)
    return found


def beyond(curve: Curve, last: CurvePoint) -> tuple[CurvePoint | None, Margin, CurvePoint | None, bool]:
    """The first orbit with the sequence that follows where margins of the last one are zero, and the margin it crosses.

    None if no orbit is found. Where the motion jumps, also the end of the curve from which that orbit comes; and
    whether runs have led to it, which may show orbits of the branch before. Its tangent points away from the last one.

    Where an impact grazes the flight before it may do so, too, so that several margins are zero at once. So they are
    where the orbit meets one of a shorter period: that repeats itself, and is returned only if there is no other.
    """
    shorter = None
    found = sorted(last.margins, key=lambda each: each.value)
    crossed = [each for each in found if each.value <= max(ZERO_MARGIN, found[0].value)]
    for margin in crossed:
        for orbit, phase in _neighbours(curve, last, margin):
            point = _with_short_phase(curve, last, orbit, *phase) if phase else _on_its_side(curve, last, orbit)
            if point is not None and least_period(point.evaluation.section, REPEATED) == orbit.period:
                return point, margin, None, False
            shorter = shorter or (point and (point, margin, None, False))
    if shorter is not None:
        return shorter
    point, end = after_jump(curve, last, found[0])
    return point, found[0], end, True


def after_chatter(curve: Curve, last: CurvePoint) -> CurvePoint | None:
    """The first orbit whose chatter is complete, beyond where grazings accumulate; None if none is found."""
    return after_jump(curve, last, None)[0]


def where_contact_opens(curve: Curve, following: CurvePoint) -> CurvePoint | None:
    """The orbit of the reference at which a flight has no length, from the first one beyond that has no such flight.

    The force of the contact is smallest there, and zero. With the flight it is lost in rounding how short that is. None
    if it is not found.
    """
    back = following.turned()

    def force(point: CurvePoint) -> float:
        return min((each.value for each in point.margins if each.kind == OPENS), default=np.inf)

    points = ((s, curve.ahead(back, s)) for s in STEPS)
    reach = next((s for s, point in points if point is not None and force(point) < 0), None)
    zero = None if reach is None else zero_ahead(curve.along(back), reach, force)
    return zero and zero[1]


def on_its_sequence(curve: Curve, start: CurvePoint) -> CurvePoint | None:
    """A start that is an orbit, or else the first one along its curve: it may lie beyond the end of its sequence."""
    return start if start.holds else first_ahead(curve, (start, start.turned()))


def _neighbours(curve: Curve, last: CurvePoint, margin: Margin) -> Iterator[tuple[Orbit, tuple[int, int] | None]]:
    """The orbit at the zero of a margin with more events or fewer, and those between which a new phase is short."""
    orbit, k, method = last.orbit, margin.event, curve.family.method
    rigid = method.rigid
    if margin.inside:
        length = SHORTEST_FLIGHT if rigid and margin.kind == OPENS else SHORTEST_CONTACT
        n, where = len(margin.more), last.evaluation.facts[k, margin.column + 1]
        new = orbit.with_events(k, where + length * np.linspace(0.0, 1.0, n), margin.more)
        yield new, (k, k + n - 1) if n > 1 else None
    elif margin.kind == LATER_SUM:
        yield _summed_later(orbit, k, last.evaluation.after[k, -1], curve.family.at(last.value)[0].restitution), None
    elif margin.kind == STAYS_SHUT:
        yield orbit.without({k - 1, k}), None
    elif margin.kind == GRAZING and orbit.at_any_stop[k] == event.IMPACT:
        yield orbit.without({k}), None
    elif margin.kind == GRAZING and not rigid:
        yield orbit.without({*short_phase(orbit, k)[:2]}), None


def _summed_later(orbit: Orbit, k: int, end: float, restitution: float) -> Orbit:
    """The orbit with an impact more before the chatter that event k begins and that ends at ``end``.

    Its flights last as terms of a geometric series do.
    """
    new = orbit.with_events(k, orbit.instants[k], at_stop_of(orbit.kinds[k], (event.IMPACT,)))
    new.unknowns[4 + k + 1] += (1.0 - restitution) * (end - orbit.instants[k])
    return new


def _with_short_phase(curve: Curve, last: CurvePoint, orbit: Orbit, i: int, j: int) -> CurvePoint | None:
    """The orbit whose phase between events i and j is as short as in the guess, and grows."""
    point = curve.with_phase(orbit, last.value, i, j)
    point = point and point.within_cycle()  # a new phase may lie across its ends
    return point if point is not None and point.holds else None


def _on_its_side(curve: Curve, last: CurvePoint, guess: Orbit) -> CurvePoint | None:
    """The first orbit near a guess at the last α₁, on the side on which its sequence holds."""
    start = last.neighbour(guess, last.value, last.tangent[-1])
    return start and _first(curve, (start, start.turned()))


def _first(curve: Curve, starts: Sequence[CurvePoint]) -> CurvePoint | None:
    """The first orbit ahead of one of these whose sequence holds."""
    points = (curve.ahead(start, step) for step in STEPS for start in starts)
    return next((point for point in points if point is not None and point.holds), None)
