"""Curves of points in two parameters: where a fold, a doubling or a grazing lies as another one varies.

A curve is followed by pseudo-arclength in all unknowns (:mod:`.points`), so that its turning points and its
cusps are nothing special. Where another bifurcation lies on it, or where the sequence of events ceases to hold, both
conditions are solved together: a point of codimension two, the same from either curve (:mod:`.meetings`).
"""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from vibroscope.engine.continuation.branch import Point
from vibroscope.engine.continuation.family import Family, ParameterRange
from vibroscope.engine.continuation.orbit import KINDS, Orbit, touching_at_start
from vibroscope.engine.continuation.point_trace import CLOSES, PointTracer
from vibroscope.engine.continuation.points import PointProblem
from vibroscope.engine.continuation.points.problem import Place, Plane
from vibroscope.engine.continuation.question import BranchQuestion
from vibroscope.engine.continuation.tolerances import SAME_POINT
from vibroscope.engine.drivers.event_driven import contact_state

MOST_POINTS = 2000  # of a curve in each direction


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


def continue_point(question: BranchQuestion, point: Point, **plane: object) -> PointCurve:
    """Follow a bifurcation point of a branch while a second number varies.

    Parameters
    ----------
    question : BranchQuestion
    point : Point
        Of the branch, of one of the kinds FOLLOWED_KINDS.
    **plane
        Arguments of :class:`PointCurves`, which follows several points.

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
    >>> from vibroscope.engine import BranchQuestion, Reference, System, continue_branch, continue_point
    >>> question = BranchQuestion(System(), 2.76, Reference(), low=2.5, high=3.0, max_period=1)
    >>> point = continue_branch(question).points[0]
    >>> curve = continue_point(question, point, along="restitution", along_low=0.45, along_high=0.55)
    >>> curve.kind, curve.values.shape[1], curve.ends
    ('period doubling', 2, ('restitution leaves the range', 'restitution leaves the range'))
    """
    return PointCurves(question, **plane).follow(point)


class PointCurves:
    """The curves of several points in the same two numbers, each followed once.

    Parameters
    ----------
    question : BranchQuestion
        As the branch was followed (:func:`continue_branch`); the range bounds the curves.
    along : str
        The second number; by default a curve begins where it has the value that the other arguments give it.
    along_low, along_high : float
        Its range.
    cancelled : callable, optional
        Polled many times a second; when it returns true the work is cancelled.

    Raises
    ------
    ValueError
        If a number is out of range.
    """

    def __init__(
        self,
        question: BranchQuestion,
        *,
        along: str,
        along_low: float,
        along_high: float,
        cancelled: Callable[[], bool] | None = None,
    ) -> None:
        if along == question.over:
            raise ValueError(f"along = {along!r} is the number that varies already: give another one")
        second = Family(along, question.system, question.eta, question.method)
        span = ParameterRange.of(second, along_low, along_high)
        self._plane = Plane(question.family, second, (question.span, span))
        span.check_start(second.value)
        self._cancelled = cancelled
        self._traces: list[tuple[str, PointTracer]] = []

    def follow(self, point: Point, start: float | None = None) -> PointCurve | None:
        """The curve of a point that was found at the second number ``start``, by default that of the problem.

        None if the point lies on a curve that was followed before.
        """
        rigid = self._plane.rigid
        followed = [kind for kind, problem in PointProblem.by_kind.items() if problem.serves(kind, rigid)]
        if point.kind not in followed:
            raise ValueError(f"points of the kind {point.kind!r} are not followed: give one of {', '.join(followed)}")
        over, along = self._plane.axes
        start = self._plane.along.value if start is None else start
        shares = np.array([over.share(point.value), along.share(start)])
        if any(kind == point.kind and trace.passes(point.period, shares) for kind, trace in self._traces):
            return None
        problem, place = _begun(self._plane, point, shares)
        traces = []
        for way in (1.0, -1.0):
            traces.append(PointTracer(problem, place, way, self._cancelled))
            deque(traces[-1].run(MOST_POINTS), maxlen=0)
            if traces[-1].reason == CLOSES:
                break
        self._traces += [(point.kind, trace) for trace in traces]
        forwards, backwards = traces[0], traces[1:]
        return PointCurve(
            kind=point.kind,
            over=over.name,
            along=along.name,
            period=point.period,
            values=np.array([place for each in backwards for place in each.values[:0:-1]] + forwards.values),
            meetings=(*(met for each in backwards for met in each.meetings[::-1]), *forwards.meetings),
            ends=(traces[-1].reason, forwards.reason),
        )


def _begun(plane: Plane, point: Point, shares: np.ndarray) -> tuple[PointProblem, Place]:
    """The problem of a point's kind, and its solution at the point.

    Raises
    ------
    ValueError
        If there is none.
    """
    for orbit in _orbits_of(plane, point, shares):
        place = plane.at(orbit, shares)
        for problem, guess in PointProblem.by_kind[point.kind].begun(point.kind, plane, place):
            found = problem.at_share(plane.at(guess, shares), 1, shares[1])
            if found is not None and abs(found.shares[0] - shares[0]) < SAME_POINT:
                return problem, found
    value, along = plane.values(shares)
    over, second = plane.axes
    raise ValueError(
        f"the orbit of the {point.kind} at {over.name} = {value:.8g}, {second.name} = {along:.6g} is not found again"
    )


def _orbits_of(plane: Plane, point: Point, shares: np.ndarray) -> Iterator[Orbit]:
    """The orbit at a point; an event before τ = 0 may have been noted with the state behind it."""
    system, _, _ = plane.problem(*shares)
    kinds = tuple(KINDS[name] for name in point.events)
    state, instants = contact_state(system, point.state), np.asarray(point.instants)
    early = int((instants < 0).sum())
    for turn in (early, 0) if early else (0,):
        there = (*kinds[turn:], *kinds[:turn])
        times = np.append(instants[turn:], instants[:turn] + point.period)
        for first in {touching_at_start(there, False), touching_at_start(there, True)}:
            yield Orbit(point.period, there, first, np.concatenate([state, times]))
