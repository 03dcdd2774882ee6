"""Which events of the piecewise linear contact laws follow each other, and which fall together where a sequence ends.

A contact begins with a touch and ends with a part; in between the law may change its piece
(:mod:`..kernels.event_driven.law_orbit`). A short contact always has the events CONTACT. Where a contact is about to
open, its depth falls to zero at the first of the events REOPENED, which becomes a part and a touch.
"""

from ..drivers.law_orbit import IN_EXTRA, IN_OVERLAP, IN_PUSH, piece_after
from ..drivers.orbit import (
    DAMP,
    LIMIT,
    LOAD,
    LOWEST,
    OTHER_LOWEST,
    OTHER_WHERE,
    PART,
    RELAX,
    TOUCH,
    UNLIMIT,
    UNLOAD,
    WHERE,
)
from .orbit import Orbit

CONTACT = {
    "cut": (TOUCH, UNLOAD, PART),
    "limited": (TOUCH, UNLIMIT, UNLOAD, PART),
    "compression": (TOUCH, RELAX, PART),
}
REOPENED = {"cut": (LOAD,), "limited": (LOAD, LIMIT), "compression": (DAMP,)}
# Of each piece: columns of the facts with the lowest minimum of what it watches, and the pairs of events at its zero
_WITHIN = {
    "cut": {
        IN_OVERLAP: ((OTHER_LOWEST, OTHER_WHERE, (LOAD, UNLOAD)),),
        IN_PUSH: ((LOWEST, WHERE, (UNLOAD, LOAD)),),
    },
    "limited": {
        IN_OVERLAP: ((OTHER_LOWEST, OTHER_WHERE, (LOAD, UNLOAD)),),
        IN_PUSH: ((LOWEST, WHERE, (UNLOAD, LOAD)), (OTHER_LOWEST, OTHER_WHERE, (LIMIT, UNLIMIT))),
        IN_EXTRA: ((LOWEST, WHERE, (UNLIMIT, LIMIT)),),
    },
    "compression": {
        IN_PUSH: ((LOWEST, WHERE, (RELAX, DAMP)),),
        IN_EXTRA: ((OTHER_LOWEST, OTHER_WHERE, (DAMP, RELAX)),),
    },
}


def switches_within(law: str, began: int | None) -> tuple[tuple[int, int, tuple[int, int]], ...]:
    """Columns of the lowest minimum and of its instant, and the events there, for each quantity that a piece watches.

    ``began``: the event that began the piece, None where the contact lasts without any.
    """
    return _WITHIN[law][IN_PUSH if began is None else piece_after(law, began)]


def partners(one: int, other: int) -> bool:
    """Whether two different events are zeros of the same quantity: their kinds are numbered in pairs."""
    return one != other and one // 2 == other // 2


def partner(orbit: Orbit, k: int) -> int | None:
    """The neighbour of switch k at which the same quantity is zero, the nearer one; None if there is none."""
    m, instants, period = len(orbit.kinds), orbit.instants, orbit.period
    found = [j for j in ((k + 1) % m, (k - 1) % m) if partners(orbit.kinds[j], orbit.kinds[k])]

    def distance(j: int) -> float:
        return min((instants[j] - instants[k]) % period, (instants[k] - instants[j]) % period)

    return min(found, key=distance, default=None)


def contact_of(orbit: Orbit, k: int) -> tuple[list[int], float]:
    """The events of the contact that event k begins or ends, in their order, and how long it lasts."""
    return _run(orbit, k, TOUCH, PART)


def flight_of(orbit: Orbit, k: int) -> tuple[list[int], float]:
    """The part and the touch of the flight that event k begins or ends, and how long it lasts."""
    return _run(orbit, k, PART, TOUCH)


def short_phase(orbit: Orbit, k: int) -> tuple[int, int, float]:
    """Event k and its neighbour that is nearer in time, in their order, and how long the phase between them lasts."""
    m = len(orbit.kinds)
    before, after = (k - 1) % m, (k + 1) % m
    ahead, behind = _length(orbit, k, after), _length(orbit, before, k)
    return (k, after, ahead) if abs(ahead) <= abs(behind) else (before, k, behind)


def flight_vanishes(orbit: Orbit, k: int, law: str | None) -> bool:
    """Whether a flight of the penalty has no length where event k grazes, and not a contact; ``law``: of its own."""
    if law is None:
        return orbit.kinds[short_phase(orbit, k)[0]] == PART
    return flight_of(orbit, k)[1] <= contact_of(orbit, k)[1]


def _length(orbit: Orbit, first: int, last: int) -> float:
    """From one event to a later one, across the end of the cycle if that has the smaller number."""
    length = orbit.instants[last] - orbit.instants[first]
    return float(length if last > first else length + orbit.period)


def _run(orbit: Orbit, k: int, begin: int, end: int) -> tuple[list[int], float]:
    kinds, m = orbit.kinds, len(orbit.kinds)
    first = next(j % m for j in range(k, k - m - 1, -1) if kinds[j % m] == begin)
    last = next(j for j in range(first, first + m + 1) if kinds[j % m] == end)
    events = [j % m for j in range(first, last + 1)]
    return events, _length(orbit, events[0], events[-1])
