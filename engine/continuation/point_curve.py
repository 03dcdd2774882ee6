"""Curves of bifurcation points in two parameters: where a fold, a doubling or a grazing lies as another one varies.

On the curve the orbit solves its equations and an indicator, or a margin, is zero. Orbits are a smooth function of both
numbers (λ, μ), but at a fold of the instant of an event in place of λ. So the curve is the zero line of one function of
two variables, which is followed by pseudo-arclength; each value costs one orbit.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..drivers.event_driven import contact_state
from ..methods import ExactPenalty, Reference
from ..model import System, require
from .branch import Point
from .curve import Curve, CurvePoint
from .family import Family
from .margins import BIFURCATIONS, BRANCH_POINT, FOLD, GRAZING, indicator, least, margins
from .orbit import KINDS, Orbit, check_cancelled, touching_at_start

FIRST_STEP, LARGEST_STEP, SMALLEST_STEP = 0.005, 0.02, 1e-7  # scaled by the ranges
DIFFERENCE = 1e-6  # scaled, of the gradient
NEWTON_STEPS = 8
CONVERGED = 1e-11  # scaled
MOST_POINTS = 2000


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
        Points of codimension two, where another bifurcation lies on the curve: its kind and both numbers.
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
        If a number is out of range, or points of this kind are not followed.
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
    allowed = [kind for kind in (*BIFURCATIONS, GRAZING) if kind != BRANCH_POINT]
    if point.kind not in allowed:
        raise ValueError(f"points of the kind {point.kind!r} are not followed: give one of {', '.join(allowed)}")
    if along == over:
        raise ValueError(f"along = {along!r} is the number that varies already: give another one")
    for ends in ((over, low, high), (along, along_low, along_high)):
        name, *values = ends
        first, last = (require(name, end, -1e12, 1e12, "give the ends of the range as numbers") for end in values)
        if not first < last:
            raise ValueError(f"{name} from {first:g} to {last:g} is an empty range: give the smaller number first")
    walk = _Walk(Family(over, system, eta, method), Family(along, system, eta, method), point, cancelled)
    walk.box = np.array([[low, high], [along_low, along_high]])
    start = walk.family_along.value
    if not along_low <= start <= along_high:
        raise ValueError(f"{along} = {start:g} lies outside {along_low:g} … {along_high:g}: begin within the range")
    walk.start()
    forwards, backwards = walk.follow(1.0), walk.follow(-1.0)
    values = np.array([*backwards.values[::-1], *forwards.values[1:]])
    return PointCurve(
        kind=point.kind,
        over=over,
        along=along,
        period=point.period,
        values=values,
        meetings=(*backwards.meetings[::-1], *forwards.meetings),
        ends=(backwards.reason, forwards.reason),
    )


@dataclass
class _Trace:
    values: list
    meetings: list
    reason: str = ""


@dataclass(frozen=True)
class _Place:
    """A point of the plane of both variables: the orbit there, λ, μ, and the function whose zero line is followed."""

    orbit: Orbit
    value: float
    along: float
    function: float
    point: CurvePoint


class _Walk:
    """The zero line of the function of a point's kind, in the variable q (λ, or at a fold an instant) and in μ."""

    def __init__(self, family: Family, along: Family, point: Point, cancelled) -> None:
        self.family_over, self.family_along = family, along
        self.kind, self.point, self.cancelled = point.kind, point, cancelled

    def start(self) -> None:
        """Find the first place, at the point itself."""
        self._widths = np.diff(self.box, axis=1)[:, 0]
        orbit = _orbit_of(self.family_over, self.point)
        self._index = 4 if self.kind == FOLD else len(orbit.unknowns)  # of q in (unknowns, λ)
        if self.kind == FOLD:
            self._widths = np.array([1.0, self._widths[1]])
        self.first = self._at(orbit, self.point.value, self.family_along.value, None)
        if self.first is None:
            raise ValueError(
                f"the orbit of the point at {self.family_over.over} = {self.point.value:g} is not found again"
            )

    def _curve(self, along: float) -> Curve:
        system, eta, method = self.family_along.at(along)
        return Curve(Family(self.family_over.over, system, eta, method), *self.box[0])

    def _at(self, orbit: Orbit, value: float, along: float, q: float | None) -> _Place | None:
        """The place with this q (by default that of the guess) and μ."""
        try:
            curve = self._curve(along)
            if self._index == len(orbit.unknowns):
                value = value if q is None else q
                found = curve.corrected(orbit, value)
            else:
                row = np.zeros(len(orbit.unknowns) + 1)
                row[self._index] = 1.0
                both = curve.constrained(orbit, value, row, orbit.unknowns[self._index] if q is None else q)
                found, value = both if both is not None else (None, value)
            if found is None:
                return None
            point = CurvePoint(curve, found, value)
            return _Place(found, value, along, self._function(curve, point), point)
        except ValueError:  # a number is out of its range
            return None

    def _function(self, curve: Curve, point: CurvePoint) -> float:
        if self.kind == FOLD:
            return float(np.linalg.det(point.evaluation.jacobian) / self._scale(point))
        if self.kind != GRAZING:
            return indicator(self.kind, point)
        found = margins(point.orbit, point.evaluation, curve.family.method)
        return min((m.value for m in found if m.kind == GRAZING), key=abs)

    def _scale(self, point: CurvePoint) -> float:
        return float(np.prod(np.linalg.norm(point.evaluation.jacobian, axis=1)))

    def _q(self, place: _Place) -> float:
        return float(np.append(place.orbit.unknowns, place.value)[self._index])

    def _coordinates(self, place: _Place) -> np.ndarray:
        return np.array([self._q(place), place.along])

    def _gradient(self, place: _Place) -> np.ndarray | None:
        """Scaled gradient of the function."""
        found = []
        for k in range(2):
            ends = []
            for way in (1, -1):
                there = self._coordinates(place)
                there[k] += way * DIFFERENCE * self._widths[k]
                moved = self._at(place.orbit, place.value, there[1], there[0])
                if moved is None:
                    return None
                ends.append(moved.function)
            found.append((ends[0] - ends[1]) / (2 * DIFFERENCE))
        return np.array(found)

    def _corrected(self, place: _Place, direction: np.ndarray) -> _Place | None:
        """The place on the zero line, across a direction."""
        gradient = self._gradient(place)
        for _ in range(NEWTON_STEPS):
            if gradient is None:
                return None
            try:
                step = np.linalg.solve([gradient, direction], [-place.function, 0.0])
            except np.linalg.LinAlgError:
                return None
            if not np.abs(step).max() < 0.1:
                return None
            there = self._coordinates(place) + step * self._widths
            following = self._at(place.orbit, place.value, there[1], there[0])
            if following is None:
                return None
            place = following
            if np.abs(step).max() < CONVERGED:
                return place
        return place if np.abs(step).max() < 1e-8 else None

    def follow(self, way: float) -> _Trace:
        """Follow the zero line one way."""
        place = self.first
        trace = _Trace([[place.value, place.along]], [])
        gradient, tangent, step = self._gradient(place), None, FIRST_STEP
        while not trace.reason:
            check_cancelled(self.cancelled)
            if gradient is None or not np.abs(gradient).max() > 0:
                trace.reason = "the orbit is lost"
                break
            turned = np.array([-gradient[1], gradient[0]]) / np.linalg.norm(gradient)
            tangent = turned * (way if tangent is None else np.sign(turned @ tangent) or 1.0)
            ahead = self._coordinates(place) + step * tangent * self._widths
            guess = self._at(place.orbit, place.value, ahead[1], ahead[0])
            found = guess and self._corrected(guess, tangent)
            if found is None:
                step /= 2
                if step < SMALLEST_STEP:
                    trace.reason = f"no orbit is found beyond {self._words(place)}"
                continue
            self._meet(trace, place, found)
            outside = [not a <= x <= b for x, (a, b) in zip((found.value, found.along), self.box, strict=True)]
            if any(outside):
                name = (self.family_over.over, self.family_along.over)[outside.index(True)]
                trace.reason = f"{name} leaves the range"
                break
            found_margins = margins(
                found.orbit, found.point.evaluation, self._curve(found.along).family.at(found.value)[2]
            )
            others = [m for m in found_margins if not (self.kind == GRAZING and m.kind == GRAZING)]
            if others and least(others) <= 0:
                lost = min(others, key=lambda m: m.value).kind
                trace.meetings.append((lost, found.value, found.along))
                trace.reason = f"{lost} at {self._words(found)}: the sequence of events changes"
                break
            place = found
            trace.values.append([place.value, place.along])
            gradient = self._gradient(place)
            step = min(1.5 * step, LARGEST_STEP)
            if len(trace.values) >= MOST_POINTS:
                trace.reason = f"given up after {MOST_POINTS} points"
        return trace

    def _meet(self, trace: _Trace, place: _Place, found: _Place) -> None:
        """Note other bifurcations that lie on the curve between two places."""
        for kind in BIFURCATIONS:
            if kind in (self.kind, BRANCH_POINT) or (self.kind == FOLD and kind == FOLD):
                continue
            before, after = (_value(kind, each.point) for each in (place, found))
            if before * after < 0:
                share = before / (before - after)
                value, along = (
                    a + share * (b - a) for a, b in ((place.value, found.value), (place.along, found.along))
                )
                trace.meetings.append((kind, float(value), float(along)))

    def _words(self, place: _Place) -> str:
        return f"{self.family_over.over} = {place.value:.8g}, {self.family_along.over} = {place.along:.8g}"


def _orbit_of(family: Family, point: Point) -> Orbit:
    """The orbit at a point."""
    system, _, _ = family.at(point.value)
    kinds = tuple(KINDS[name] for name in point.events)
    state = contact_state(system, point.state)
    return Orbit(point.period, kinds, touching_at_start(kinds, False), np.concatenate([state, point.instants]))


def _value(kind: str, point: CurvePoint) -> float:
    if kind == FOLD:  # the tangent has no orientation here
        jacobian = point.evaluation.jacobian
        return float(np.linalg.det(jacobian) / np.prod(np.linalg.norm(jacobian, axis=1)))
    return indicator(kind, point)
