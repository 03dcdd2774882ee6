"""The events of orbits that graze, with the touch as one of them; and events that pass the ends of the cycle."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..drivers.orbit import IMPACT, JOINS, PART, TOUCH, WHERE
from .margins import GRAZING, OPENS, Margin, margins
from .orbit import Orbit, short_phase, touching_at_start
from .plane import Place, Plane

SHORT = 1e-5  # excitation periods: a contact shorter than that is a touch


def touched(plane: Plane, place: Place) -> Iterator[tuple[Orbit, int]]:
    """A grazing orbit with its touch as an event, and which: for each touch there may be, the closest first."""
    orbit = place.orbit
    if not plane.rigid and len(orbit.kinds) > 1 and (lengths := np.diff(orbit.instants)).min() < SHORT:
        yield marked(orbit, int(np.argmin(lengths)))
    kinds = (GRAZING,) if plane.rigid else (GRAZING, OPENS)
    found = [each for each in margins(orbit, place.evaluation, plane.over.method) if each.kind in kinds]
    for margin in sorted(found, key=lambda each: abs(each.value)):
        yield touched_at(plane, place, margin)


def touched_at(plane: Plane, place: Place, margin: Margin) -> tuple[Orbit, int]:
    """The orbit with the touch at which a margin is zero as an event, and which."""
    orbit, k = place.orbit, margin.event
    if not margin.inside:
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


def without(orbit: Orbit, k: int) -> Orbit:
    """The orbit without event k."""
    kinds = (*orbit.kinds[:k], *orbit.kinds[k + 1 :])
    first = orbit.kinds[k] in JOINS and not kinds
    return Orbit(orbit.period, kinds, touching_at_start(kinds, first), np.delete(orbit.unknowns, 4 + k))
