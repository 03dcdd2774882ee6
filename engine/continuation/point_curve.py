"""Curves of bifurcation points in two parameters: where a fold, a doubling or a grazing lies as another one varies.

A curve is followed by pseudo-arclength in all unknowns (:mod:`.point_equations`), so that its turning points and its
cusps are nothing special. Where another bifurcation lies on it, or where the sequence of events ceases to hold, both
conditions are solved together: a point of codimension two, the same from either curve (:mod:`.meetings`).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ..drivers.event_driven import contact_state
from ..methods import ExactPenalty, Reference
from ..model import System, require
from .branch import Point
from .family import Family
from .margins import BIFURCATIONS, BRANCH_POINT, GRAZING
from .orbit import KINDS, Orbit, touching_at_start
from .plane import Axis, Place, Plane
from .point_equations import Condition, Equations
from .point_trace import CLOSES, SAME, Trace
from .touches import touched

FOLLOWED = tuple(kind for kind in (*BIFURCATIONS, GRAZING) if kind != BRANCH_POINT)


@dataclass(frozen=True)
class PointCurve:
    """A bifurcation point in two parameters.

    Attributes
    ----------
    kind : str
        Of the point.
    over, along : str
        The two numbers.
    period : int
    values : (n, 2) ndarray
        Both numbers, in the order of the curve.
    meetings : tuple of (str, float, float)
        Points of codimension two: the kind of the other bifurcation that lies on the curve, or "cusp", and both
        numbers.
    ends : (str, str)
        Why the curve ends.
    """

    kind: str
    over: str
    along: str
    period: int
    values: np.ndarray
    meetings: tuple[tuple[str, float, float], ...]
    ends: tuple[str, str]

    def __repr__(self) -> str:
        what = f"{self.kind} of period {self.period} over {self.over} and {self.along}"
        return f"PointCurve({what}: {len(self.values)} points, {len(self.meetings)} meetings)"


def continue_point(
    system: System,
    eta: float,
    method: Reference | ExactPenalty,
    point: Point,
    *,
    over: str = "eta",
    low: float,
    high: float,
    along: str,
    along_low: float,
    along_high: float,
    cancelled: Callable[[], bool] | None = None,
) -> PointCurve:
    """Follow a bifurcation point of a branch while a second number varies.

    Parameters
    ----------
    system, eta, method, over, low, high
        As the branch was followed (:func:`.search.continue_branch`); the range bounds the curve.
    point : Point
        Of this branch: a fold, a period doubling, a Neimark–Sacker point or a grazing.
    along : str
        The second number; where the curve begins it has the value that the other arguments give it.
    along_low, along_high : float
        Its range.
    cancelled : callable, optional
        Polled many times a second; when it returns true the work is cancelled.

    Returns
    -------
    PointCurve

    Raises
    ------
    ValueError
        If a number is out of range, points of this kind are not followed, or the orbit of the point is not found.
    Cancelled
        If ``cancelled`` returned true.

    Examples
    --------
    >>> from vibroscope.engine import Reference, System, continue_branch, continue_point
    >>> problem, reach = (System(), 2.76, Reference()), {"low": 2.5, "high": 3.0}
    >>> (point,) = continue_branch(*problem, low=2.7, high=2.85, max_period=1).points
    >>> curve = continue_point(*problem, point, **reach, along="restitution", along_low=0.45, along_high=0.55)
    >>> curve.kind, curve.values.shape[1], curve.ends
    ('period doubling', 2, ('restitution leaves the range', 'restitution leaves the range'))
    """
    curves = PointCurves(
        system,
        eta,
        method,
        over=over,
        low=low,
        high=high,
        along=along,
        along_low=along_low,
        along_high=along_high,
        cancelled=cancelled,
    )
    return curves.follow(point)


class PointCurves:
    """The curves of several points in the same two numbers, each followed once.

    Arguments and exceptions are those of :func:`continue_point`.
    """

    def __init__(
        self,
        system: System,
        eta: float,
        method: Reference | ExactPenalty,
        *,
        over: str = "eta",
        low: float,
        high: float,
        along: str,
        along_low: float,
        along_high: float,
        cancelled: Callable[[], bool] | None = None,
    ) -> None:
        if along == over:
            raise ValueError(f"along = {along!r} is the number that varies already: give another one")
        axes = []
        for name, *ends in ((over, low, high), (along, along_low, along_high)):
            first, last = (require(name, end, -1e12, 1e12, "give the ends of the range as numbers") for end in ends)
            if not first < last:
                raise ValueError(f"{name} from {first:g} to {last:g} is an empty range: give the smaller number first")
            axes.append(Axis(name, first, last))
        self._plane = Plane(Family(over, system, eta, method), Family(along, system, eta, method), tuple(axes))
        for family, axis in zip((self._plane.over, self._plane.along), axes, strict=True):
            for end in axis.low, axis.high:
                family.at(end)
        start = self._plane.along.value
        if not along_low <= start <= along_high:
            raise ValueError(f"{along} = {start:g} lies outside {along_low:g} … {along_high:g}: begin within the range")
        self._cancelled = cancelled
        self._traces: list[tuple[str, Trace]] = []

    def follow(self, point: Point, start: float | None = None) -> PointCurve | None:
        """The curve of a point that was found at the second number ``start``, by default that of the problem.

        None if the point lies on a curve that was followed before.
        """
        if point.kind not in FOLLOWED:
            raise ValueError(f"points of the kind {point.kind!r} are not followed: give one of {', '.join(FOLLOWED)}")
        over, along = self._plane.axes
        start = self._plane.along.value if start is None else start
        shares = np.array([over.share(point.value), along.share(start)])
        if any(kind == point.kind and trace.passes(point.period, shares) for kind, trace in self._traces):
            return None
        equations, place = _begun(self._plane, point, shares)
        forwards = Trace(self._plane, equations, place, self._cancelled)
        forwards.follow(1.0)
        backwards = Trace(self._plane, equations, place, self._cancelled)
        if forwards.reason == CLOSES:
            backwards.reason = CLOSES
        else:
            backwards.follow(-1.0)
        self._traces += [(point.kind, backwards), (point.kind, forwards)]
        return PointCurve(
            kind=point.kind,
            over=over.name,
            along=along.name,
            period=point.period,
            values=np.array([*backwards.values[::-1], *forwards.values[1:]]),
            meetings=(*backwards.meetings[::-1], *forwards.meetings),
            ends=(backwards.reason, forwards.reason),
        )


def _begun(plane: Plane, point: Point, shares: np.ndarray) -> tuple[Equations, Place]:
    """The equations of a point's kind, and their solution at the point.

    Raises
    ------
    ValueError
        If there is none.
    """
    for orbit in _orbits_of(plane, point, shares):
        place = plane.at(orbit, shares)
        choices = touched(plane, place) if point.kind == GRAZING else [(orbit, None)]
        for guess, touch in choices:
            equations = Equations(plane, Condition(point.kind, touch), guess)
            row = np.zeros(len(equations.scales) + 2)
            row[-1] = 1.0
            found = equations.solved(plane.at(guess, shares), row, lambda there: there.shares[1] - shares[1])
            if found is not None and abs(found.shares[0] - shares[0]) < SAME:
                return equations, found
    value, along = plane.values(shares)
    over, second = plane.axes
    raise ValueError(
        f"the orbit of the {point.kind} at {over.name} = {value:.8g}, {second.name} = {along:.6g} is not found again"
    )


def _orbits_of(plane: Plane, point: Point, shares: np.ndarray) -> Iterator[Orbit]:
    """The orbit at a point; an event before τ = 0 may have been noted with the state behind it."""
    system, _, _ = plane.problem(shares)
    kinds = tuple(KINDS[name] for name in point.events)
    state, instants = contact_state(system, point.state), np.asarray(point.instants)
    early = int((instants < 0).sum())
    for turn in (early, 0) if early else (0,):
        there = (*kinds[turn:], *kinds[:turn])
        times = np.append(instants[turn:], instants[:turn] + point.period)
        for first in {touching_at_start(there, False), touching_at_start(there, True)}:
            yield Orbit(point.period, there, first, np.concatenate([state, times]))
