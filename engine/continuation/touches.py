"""The events of orbits that graze, with the touch as one of them; and events that pass the ends of the cycle."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..drivers.law_driven import needs_law
from ..drivers.orbit import IMPACT, JOINS, PART, TOUCH, WHERE
from .margins import GRAZING, OPENS, Margin, margins
from .orbit import Orbit, touching_at_start
from .plane import Place, Plane
from .switches import REOPENED, contact_of, flight_of, flight_vanishes, short_phase

SHORT = 1e-5  # excitation periods: a contact shorter than that is a touch


def touched(plane: Plane, place: Place) -> Iterator[tuple[Orbit, int]]:
    """A grazing orbit with its touch as an event, and which: for each touch there may be, the closest first."""
    orbit, pressed = place.orbit, not plane.rigid and not needs_law(plane.over.method)
    if pressed and len(orbit.kinds) > 1 and (lengths := np.diff(orbit.instants)).min() < SHORT:
        yield marked(orbit, int(np.argmin(lengths)))
    kinds = (GRAZING,) if plane.rigid else (GRAZING, OPENS)
    found = [each for each in margins(orbit, place.evaluation, plane.over.method) if each.kind in kinds]
    for margin in sorted(found, key=lambda each: abs(each.value)):
        yield touched_at(plane, place, margin)


def touched_at(plane: Plane, place: Place, margin: Margin) -> tuple[Orbit, int]:
    """The orbit with the touch at which a margin is zero as an event, and which."""
    orbit, k = place.orbit, margin.event
    law = plane.over.method.law if needs_law(plane.over.method) else None
    if not margin.inside:
        if law:
            return marked_where_open(orbit, k, law) if margin.kind == OPENS else marked_with_law(orbit, k, law)
        return (orbit, k) if plane.rigid else marked(orbit, k)
    apart = IMPACT if plane.rigid else PART
    kind, where = (TOUCH if margin.kind == OPENS else apart), place.evaluation.facts[k, WHERE]
    unknowns = np.insert(orbit.unknowns, 4 + k, where)
    return replace(orbit, kinds=(*orbit.kinds[:k], kind, *orbit.kinds[k:]), unknowns=unknowns), k


def marked(orbit: Orbit, k: int) -> tuple[Orbit, int]:
    """The orbit with a marker in place of event k and of that next to it in time, and where."""
    first, second, length = short_phase(orbit, k)
    m, instants = len(orbit.kinds), orbit.instants
    middle = instants[first] + 0.5 * length
    rest = [j for j in range(m) if j not in (first, second)]
    place = sum(j < first for j in rest)
    kinds = [orbit.kinds[j] for j in rest]
    kinds.insert(place, orbit.kinds[second])
    unknowns = np.concatenate([orbit.unknowns[:4], np.insert(instants[rest], place, middle)])
    first_touching = touching_at_start(tuple(kinds), orbit.first)
    return Orbit(orbit.period, tuple(kinds), first_touching, unknowns), place


def marked_with_law(orbit: Orbit, k: int, law: str) -> tuple[Orbit, int]:
    """The same with another contact law: the marker in place of the short contact, or flight, at event k.

    After a short flight the marker is a touch, since the law goes on from there as after one.
    """
    vanishes = flight_vanishes(orbit, k, law)
    (events, length), kind = (flight_of(orbit, k), TOUCH) if vanishes else (contact_of(orbit, k), PART)
    rest = [j for j in range(len(orbit.kinds)) if j not in events]
    place = sum(j < events[0] for j in rest)
    kinds = [orbit.kinds[j] for j in rest]
    kinds.insert(place, kind)
    middle = orbit.instants[events[0]] + 0.5 * length
    unknowns = np.concatenate([orbit.unknowns[:4], np.insert(orbit.instants[rest], place, middle)])
    return Orbit(orbit.period, tuple(kinds), touching_at_start(tuple(kinds), orbit.first), unknowns), place


def marked_where_open(orbit: Orbit, k: int, law: str) -> tuple[Orbit, int]:
    """The same where the contact is about to open at event k, the first of those that become a part and a touch."""
    more = (k + 1) % len(orbit.kinds) if len(REOPENED[law]) > 1 else None
    kinds, place = list(orbit.kinds), k - (more == 0)
    kinds[k] = TOUCH
    rest = [j for j in range(len(kinds)) if j != more]
    kinds, unknowns = tuple(kinds[j] for j in rest), orbit.unknowns[[*range(4), *(4 + j for j in rest)]]
    return Orbit(orbit.period, kinds, touching_at_start(kinds, orbit.first), unknowns), place


def without(orbit: Orbit, k: int) -> Orbit:
    """The orbit without event k."""
    kinds = (*orbit.kinds[:k], *orbit.kinds[k + 1 :])
    first = orbit.kinds[k] in JOINS and not kinds
    return Orbit(orbit.period, kinds, touching_at_start(kinds, first), np.delete(orbit.unknowns, 4 + k))
