"""Where an impact of the reference begins, or ceases, to stick: it parts at ε, or is no longer pressed."""

from collections.abc import Iterator

from ..kinds import STICKING_BEGINS, STICKING_ENDS
from ..margins import Margin
from ..orbit import Orbit
from ..plane import Place, Plane
from .problem import PointProblem


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
