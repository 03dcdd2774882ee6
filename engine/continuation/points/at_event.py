"""Points at an event of the orbit: grazings and contacts that open, and where an impact begins or ceases to stick.

At a grazing the closing speed of a touch is zero, whose instant is an unknown. It is an impact of the reference; of the
penalty it is a *marker*, an event without effect, since both events of a contact fall together. An impact of the
reference begins to stick where it parts at ε, and ceases to where it is no longer pressed.
"""

from collections.abc import Iterator

import numpy as np
from vibroscope.engine.continuation.kinds import GRAZING, OPENS, STICKING_BEGINS, STICKING_ENDS
from vibroscope.engine.continuation.orbit import Margin, Orbit, short_phase
from vibroscope.engine.continuation.points.problem import Place, Plane, PointProblem
from vibroscope.engine.continuation.tolerances import SAME_TOUCH, TOUCH_LENGTH
from vibroscope.engine.drivers.orbit import event


class Grazing(PointProblem):
    """The closing speed of an event is zero."""

    kinds = (GRAZING, OPENS)

    def __init__(self, _: str, plane: Plane, orbit: Orbit, event: int) -> None:
        super().__init__(GRAZING, plane, orbit, event)  # a contact that opens is a grazing from within

    @classmethod
    def serves(cls, kind: str, rigid: bool) -> bool:
        """The reference's contact opens at a force of zero."""
        return kind == GRAZING or not rigid

    @classmethod
    def begun(cls, kind: str, plane: Plane, place: Place) -> Iterator[tuple[PointProblem, Orbit]]:
        """For each touch there may be, the closest first."""
        orbit = place.orbit
        if not plane.rigid and len(orbit.kinds) > 1 and (lengths := np.diff(orbit.instants)).min() < TOUCH_LENGTH:
            yield cls._of_touch(plane, *marked(orbit, int(np.argmin(lengths))))
        kinds = (GRAZING,) if plane.rigid else (GRAZING, OPENS)
        found = [each for each in plane.margins(place) if each.kind in kinds]
        for margin in sorted(found, key=lambda each: abs(each.value)):
            yield cls._of_touch(plane, *touched_at(plane, place, margin))

    @classmethod
    def _of_touch(cls, plane: Plane, orbit: Orbit, touch: int) -> tuple[PointProblem, Orbit]:
        return cls(GRAZING, plane, orbit, touch), orbit

    def condition(self, place: Place) -> float:
        """The closing speed."""
        return float(place.evaluation.facts[self.event, event.CLOSING] / self.scales[0])

    def is_own(self, margin: Margin, place: Place) -> bool:
        """That of the touch."""
        if not margin.inside:
            return margin.event == self.event
        where = place.evaluation.facts[margin.event, margin.column + 1]
        return abs(where - place.orbit.instants[self.event]) < SAME_TOUCH


def touched_at(plane: Plane, place: Place, margin: Margin) -> tuple[Orbit, int]:
    """The orbit with the touch at which a margin is zero as an event, and which."""
    orbit, k = place.orbit, margin.event
    if not margin.inside:
        return (orbit, k) if plane.rigid else marked(orbit, k)
    return orbit.with_events(k, place.evaluation.facts[k, margin.column + 1], margin.more[-1:]), k


def marked(orbit: Orbit, k: int) -> tuple[Orbit, int]:
    """The orbit with a marker in place of event k and of that next to it in time, and where."""
    first, second, length = short_phase(orbit, k)
    place, middle = min(first, len(orbit.kinds) - 2), orbit.instants[first] + 0.5 * length
    return orbit.without({first, second}).with_events(place, middle, (orbit.kinds[second],)), place


class Sticking(PointProblem):
    """The margin of an impact is zero: the curve is one end of the jump, on the side of these orbits."""

    kinds = (STICKING_BEGINS, STICKING_ENDS)

    @classmethod
    def serves(cls, kind: str, rigid: bool) -> bool:
        """Contacts of the penalty have a length."""
        return rigid

    @classmethod
    def begun(cls, kind: str, plane: Plane, place: Place) -> Iterator[tuple[PointProblem, Orbit]]:
        """For each impact, that with the smallest margin first."""
        of_kind = (margin for margin in plane.margins(place) if margin.kind == kind)
        for margin in sorted(of_kind, key=lambda each: abs(each.value)):
            yield cls(kind, plane, place.orbit, margin.event), place.orbit

    def condition(self, place: Place) -> float:
        """The margin."""
        return next(margin.value for margin in self.plane.margins(place) if self.is_own(margin, place))

    def is_own(self, margin: Margin, place: Place) -> bool:
        """That of the impact."""
        return (margin.kind, margin.event) == (self.kind, self.event)
