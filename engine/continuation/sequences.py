"""Where a sequence of events ceases to hold: which one follows, and the first orbit that has it.

- *Grazing* of an impact, or a touch, whose closing speed falls to zero: the same orbit without it. The other way round,
  where the gap of a flight falls to zero: the same orbit with an impact, or a contact, more. Likewise a contact of the
  penalty that opens in between. Both sequences have the orbit at this point in common.
- *Sticking*: with the threshold ε an impact that leaves a parting speed of ε takes the whole relative velocity instead,
  so that the motion jumps by as much (:mod:`.jumps`).

Its own margins say which way the new curve goes.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from vibroscope.engine.continuation.curve import Curve, CurvePoint
from vibroscope.engine.continuation.jumps import after_jump
from vibroscope.engine.continuation.kinds import GRAZING, OPENS
from vibroscope.engine.continuation.margins import LATER_SUM, STAYS_SHUT, Margin
from vibroscope.engine.continuation.orbit import Orbit, at_stop_of, least_period, short_phase
from vibroscope.engine.continuation.roots import zero_ahead
from vibroscope.engine.continuation.tolerances import REPEATED, SHORTEST_CONTACT, SHORTEST_FLIGHT, ZERO_MARGIN
from vibroscope.engine.continuation.tracer import first_ahead
from vibroscope.engine.drivers.orbit import event

STEPS = 10.0 ** np.arange(-7, -2.5, 0.5)  # scaled, along the new curve: the first that shows which way it goes


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
