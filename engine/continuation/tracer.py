"""One tracer for every curve of orbits: steps along it, to the borders of its ranges, with one control of their length.

What is followed is a *curve* (:class:`.curve.Curve` of orbits, :class:`.points.problem.PointProblem` of points in
two numbers): it has a point ahead at each distance along the tangent of another one, and borders. What is special
between two points, and what goes on where a sequence of events ends, is said by the kinds of tracers.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain, zip_longest
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.continuation.tolerances import AT_BORDER
from vibroscope.engine.result import check_cancelled

if TYPE_CHECKING:
    from vibroscope.engine.continuation.branch import Point
    from vibroscope.engine.continuation.curve import Curve, CurvePoint

P = TypeVar("P")


class StepControl(NamedTuple):
    """Steps along a curve, of scaled lengths: they grow, and are halved where the curve is not found, or turns."""

    first: float
    largest: float
    smallest: float
    growth: float
    bend: float = math.inf  # angle between neighbouring tangents to which steps are fitted
    turn: float | None = None  # cosine between neighbouring tangents, below which a step is halved

    def shrunk(self, at: Callable[[float], P | None], here: P, there: P | None, step: float) -> tuple[P | None, float]:
        """The point to go on to, instead of ``there`` a step ahead if need be, and how far ahead; None if none is."""
        while there is None or (self.turn is not None and not there.tangent @ here.tangent >= self.turn):
            step /= 2
            if step < self.smallest:
                return None, step
            there = at(step)
        return there, step

    def following(self, step: float, here: P, there: P) -> float:
        """The length to try after a step."""
        growth = self.growth
        if self.bend < math.inf:
            angle = math.sqrt(max(2.0 - 2.0 * float(there.tangent @ here.tangent), 0.0))
            growth = min(self.bend / angle, growth) if angle else growth
        return min(step * growth, self.largest)


WALK, LONGEST_WALK = StepControl(first=1e-5, largest=np.inf, smallest=1e-7, growth=4.0, turn=0.98), 0.03


@dataclass
class Trace:
    """A curve followed one way.

    Attributes
    ----------
    points : list
        In their order along the curve.
    marks : list of (Point, CurvePoint)
        Points of a branch, and the orbits there.
    reason : str
        Why it ends.
    length : float
        Scaled.
    joined : float or None
        α₁ where a branch ends in one of a shorter period.
    """

    points: list
    marks: "list[tuple[Point, CurvePoint]]" = field(default_factory=list)
    reason: str = ""
    length: float = 0.0
    joined: float | None = None


class Tracer(Trace):
    """Follows a curve one way from a point.

    Parameters
    ----------
    curve
        What is followed.
    start
        Its first point; the tangent there gives the direction.
    cancelled : callable, optional
    """

    control: StepControl
    what = "orbits"

    def __init__(self, curve, start, cancelled: Poll | None = None) -> None:
        super().__init__([start])
        self.curve, self.cancelled = curve, cancelled

    def run(self, most: int) -> Iterator["Tracer"]:
        """Follow the curve to its end, or over so many points; yield after each step."""
        step = self.control.first
        while not self.reason:
            check_cancelled(self.cancelled)
            if len(self.points) >= most:
                self.reason = f"given up after {most} {self.what}"
                return
            step = self._advance(step)
            yield self

    def _advance(self, step: float) -> float:
        """Take a step; return the length to try next."""
        here = self.points[-1]
        way, border = self.curve.border_ahead(here)
        if way < AT_BORDER:
            self.reason = self.curve.left(border)
            return step
        step, at = min(step, way), self.curve.along(here)  # beyond the border there may be no such system
        if self._vanishes(here, step):
            return self.control.first / 10
        there = at(step) if step < way else self.curve.at_border(here, way, border)
        there, step = self.control.shrunk(at, here, there, step)
        if there is None:
            self.reason = self._why_lost(here)
            return step
        there, border = self.curve.within(here, there)
        if border is not None:
            self.reason = self.curve.left(border)
            if there is None:
                return step
            step = self.curve.distance(here, there)
        following = self._special(here, there, step)
        if following is not None:
            return following
        there, step = self._closed(here, there, step)
        self._accept(here, there, step)
        return self.control.following(step, here, there)

    def _vanishes(self, here: P, step: float) -> bool:
        """Whether the sequence of events ends at the last point, and another one was taken up."""
        return False

    def _why_lost(self, here: P) -> str:
        """Why no step leads on."""

    def _special(self, here: P, there: P, step: float) -> float | None:
        """The length of the next step, if the curve ends or changes between two points; None if it does not."""

    def _closed(self, here: P, there: P, step: float) -> tuple[P, float]:
        """The first point instead of the next one, if the curve is back there."""
        return there, step

    def _accept(self, here: P, there: P, step: float) -> None:
        """Note what lies between two points, and add the second."""


def walk(curve: "Curve", point: "CurvePoint") -> "Iterator[CurvePoint]":
    """Orbits ahead of one, at distances that grow up to LONGEST_WALK, one after the other: there may be folds."""
    way, step = 0.0, WALK.first
    while way < LONGEST_WALK:
        at = curve.along(point)
        there, step = WALK.shrunk(at, point, at(step), step)
        if there is None:
            return
        way, step, point = way + step, WALK.following(step, point, there), there
        yield there


def first_ahead(
    curve: "Curve", starts: "Sequence[CurvePoint]", leads_on: Callable[[float], bool] = lambda _: True
) -> "CurvePoint | None":
    """The first orbit ahead of one of these whose sequence holds, at an α₁ that leads on."""
    points = chain.from_iterable(zip_longest(*(walk(curve, start) for start in starts)))
    return next((point for point in points if point is not None and leads_on(point.value) and point.holds), None)
