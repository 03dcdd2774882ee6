"""Curves of points in two parameters: where a fold, a doubling or a grazing lies as another one varies.

A curve is followed by pseudo-arclength in all unknowns (:mod:`.points`), so that its turning points and its cusps are
nothing special. Where another bifurcation lies on it, or where the sequence of events ceases to hold, both conditions
are solved together: a point of codimension two, the same from either curve. That of a point that grazes, too, is solved
on the curve of grazings, whose touch is an event.
"""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.continuation.branch import Point
from vibroscope.engine.continuation.family import BranchQuestion, Family, ParameterRange
from vibroscope.engine.continuation.follow import difference_of_halves, share_on_chord
from vibroscope.engine.continuation.kinds import (
    BIFURCATIONS,
    BRANCH_POINT,
    DOUBLING,
    FOLD,
    GRAZING,
    NEIMARK_SACKER,
    indicator,
)
from vibroscope.engine.continuation.orbit import KINDS, Margin, Orbit, touching_at_start, within_cycle
from vibroscope.engine.continuation.points import PointProblem
from vibroscope.engine.continuation.points.at_event import Grazing, touched_at
from vibroscope.engine.continuation.points.problem import Place, Plane, between
from vibroscope.engine.continuation.points.singular import regular, short_pairs
from vibroscope.engine.continuation.roots import changes_ahead, zero_ahead
from vibroscope.engine.continuation.tolerances import (
    CLOSED_CURVE,
    EXTRAPOLATED,
    MEETS,
    NEAR_MEETING,
    ON_CIRCLE,
    ROUGH_STEP,
    SAME_POINT,
)
from vibroscope.engine.continuation.tracer import StepControl, Tracer
from vibroscope.engine.drivers.event_driven import contact_state
from vibroscope.engine.motions.poincare_map import SYMMETRY_BREAKING

CUSP = "cusp"

Key = tuple[str, bool]  # kind of the other bifurcation, and whether it is one of the orbit without the touch
At = Callable[[float], Place | None]  # the place a distance ahead
MOST_POINTS = 2000  # of a curve in each direction
# Of the difference of halves: places with these, from which both numbers are extrapolated
PARTS = (0.85, 0.7, 0.55, 0.4)
CLOSES = "the curve closes in itself"


class Meetings:
    """What may lie on the curve of one kind of points with one sequence of events."""

    def __init__(self, problem: PointProblem) -> None:
        self._problem, self._plane, self._kind = problem, problem.plane, problem.kind
        self._touch = problem.event if self._kind == GRAZING else None

    def tests(self, place: Place) -> dict[Key, float]:
        """Numbers that change their sign where another bifurcation lies on the curve."""
        keys = [(kind, False) for kind in BIFURCATIONS if kind not in (self._kind, BRANCH_POINT, SYMMETRY_BREAKING)]
        if self._touch is not None:  # a touching impact has no multipliers, and a marker has no determinant
            bare = [(kind, True) for kind, _ in keys]
            keys = [*bare, *(key for key in keys if self._plane.rigid and key[0] != NEIMARK_SACKER)]
        if self._kind == FOLD:
            keys.append((CUSP, False))
        return {key: self._test(key, place) for key in keys}

    def located(self, at: At, length: float, here: Place, found: Place) -> list[tuple[str, Place]]:
        """Other bifurcations between two places, in their order: kind and place."""
        ends = self.tests(here), self.tests(found)
        return [(key[0], place) for key, place in changes_ahead(at, length, ends, self._test, self._confirmed)]

    def _confirmed(self, key: Key, near: Place) -> Place | None:
        """The place where both conditions hold; None if a sign changes by rounding."""
        place = self._both(near, partial(self._test, key))
        if place is None or key[0] != NEIMARK_SACKER:
            return place
        return place if _on_unit_circle(self._bare(place) if key[1] else place) else None

    def last_of_sequence(self, at: At, length: float) -> tuple[float, Place, Margin] | None:
        """Where the first margin becomes zero: the distance, the place and the margin; None if it is not found."""
        zero = zero_ahead(at, length, self._problem.least_margin)
        return zero and (*zero, min(self._problem.margins(zero[1]), key=lambda each: each.value))

    def at_margin(self, near: Place, margin: Margin) -> Place | None:
        """The point of the curve at which a margin is zero, from a place near it; None if there is none."""
        if margin.kind == GRAZING and self._kind in BIFURCATIONS:
            return self._grazing_too(near, margin)
        return self._both(near, lambda there: self._margin(there, margin))

    def _margin(self, place: Place, margin: Margin) -> float:
        return next((each.value for each in self._problem.margins(place) if each[:4] == margin[:4]), np.nan)

    def _grazing_too(self, near: Place, margin: Margin) -> Place | None:
        orbit, touch = touched_at(self._plane, near, margin)
        grazing = Meetings(Grazing(GRAZING, self._plane, orbit, touch))
        key = self._kind, margin.inside or not self._plane.rigid
        return grazing._both(self._plane.at(orbit, near.shares), lambda there: grazing._test(key, there))

    def _both(self, near: Place, other: Callable[[Place], float]) -> Place | None:
        """Where another function is zero, too."""
        try:
            row = self._problem.gradient(other, near)
        except ValueError:
            return None
        size = np.abs(row).max()
        if not 0 < size < np.inf:
            return None
        found = self._problem.solved(near, row / size, lambda there: other(there) / size)
        return found if found is not None and np.abs(found.shares - near.shares).max() < NEAR_MEETING else None

    def _bare(self, place: Place) -> Place:
        """The orbit without its touch."""
        return self._plane.at(place.orbit.without({self._touch}), place.shares)

    def _test(self, key: Key, place: Place) -> float:
        """The number of a key; nan where a contact has no length."""
        kind, bare = key
        there = self._bare(place) if bare else place
        if kind == NEIMARK_SACKER:
            return indicator(kind, there)
        try:
            if kind == CUSP:
                return self._problem.curvature(place)
            orbit = there.orbit
            matrix, _ = regular(kind, there, np.ones(len(orbit.unknowns)), short_pairs(orbit))
        except ValueError:
            return np.nan
        with np.errstate(all="ignore"):  # infinite multipliers
            return float(np.linalg.det(matrix / np.linalg.norm(matrix, axis=1, keepdims=True)))


def _on_unit_circle(place: Place) -> bool:
    """Whether a pair of multipliers does: a complex one, or two real ones at a resonance."""
    values = place.evaluation.multipliers
    on = values[np.abs(np.abs(values) - 1) < ON_CIRCLE]
    return len(on) > 1


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
        As the branch was followed (:func:`engine.continue_branch`); the range bounds the curves.
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
        cancelled: Poll | None = None,
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


# --- following --------------------------------------------------------------------------------------------------------


class PointTracer(Tracer):
    """Follows a curve of points one way from a place, at first towards larger α₂ if ``way`` is 1.

    Attributes
    ----------
    values : list of (float, float)
        α₁ and α₂.
    meetings : list of (str, float, float)
    """

    control = StepControl(first=0.005, largest=0.02, smallest=1e-7, growth=1.5)
    what = "points"

    def __init__(self, problem: PointProblem, start: Place, way: float, cancelled: Poll | None = None) -> None:
        super().__init__(problem, start, cancelled)
        self.plane, self.kind = problem.plane, problem.kind
        self.values: list[tuple[float, float]] = []
        self.meetings: list[tuple[str, float, float]] = []
        self.points.clear()
        self._add(start)
        self._direct(np.append(np.zeros(len(self.curve.scales) + 1), way))

    def passes(self, period: int, shares: np.ndarray) -> bool:
        """Whether the curve goes through a point of the plane."""
        for here, there in zip(self.points[:-1], self.points[1:], strict=True):
            sides = here.shares[1] - shares[1], there.shares[1] - shares[1]
            if here.orbit.period != period or here.orbit.kinds != there.orbit.kinds or sides[0] * sides[1] > 0:
                continue
            part = sides[0] / (sides[0] - sides[1]) if sides[0] != sides[1] else 0.0
            guess = between(self.plane, here, there, part)
            if guess is None or abs(guess.shares[0] - shares[0]) > self.control.largest:
                continue
            found = here.problem.at_share(guess, 1, shares[1])
            if found is not None and abs(found.shares[0] - shares[0]) < SAME_POINT:
                return True
        return False

    # -- one step ------------------------------------------------------------------------------------------------------

    def _why_lost(self, here: Place) -> str:
        return f"no orbit is found beyond {self.plane.words(here.shares)}"

    def _special(self, here: Place, there: Place, step: float) -> float | None:
        if self._halves_meet(here, there) and (doubling := self._doubling_ahead(here)) is not None:
            self._end(DOUBLING, doubling, "both halves of the cycle become the same")
            return step
        meetings = Meetings(self.curve)
        if self.curve.least_margin(there) > 0:
            return None
        self.reason, at = "", self._between(here, there)
        last = meetings.last_of_sequence(at, self.curve.distance(here, there))
        place = last and meetings.at_margin(*last[1:])
        if place is not None:
            self._note(meetings.located(at, last[0], here, last[1]))
            kind = last[2].point_at(place.orbit, self.plane.over.method)
            self._end(kind, place.shares, "the sequence of events changes")
        elif step > ROUGH_STEP:
            return step / 4
        else:
            kind = last[2].kind if last else "the end of its sequence of events"
            self.reason = f"at {self.plane.words(here.shares)} it can no longer be distinguished from {kind}"
        return step

    def _accept(self, here: Place, there: Place, step: float) -> None:
        length = self.curve.distance(here, there)
        self._note(Meetings(self.curve).located(self._between(here, there), length, here, there))
        turn = self._add(there)
        if not self.reason and self._returned():
            self.reason = CLOSES
        elif not self.reason:
            before = here.tangent
            known = (turn == 0) * before[:4]  # else the state at τ = 0 is another one
            self._direct(np.concatenate([known, np.roll(before[4:-2], turn), before[-2:]]))

    def _between(self, here: Place, there: Place) -> Callable[[float], Place | None]:
        """The place at each distance from one to the next, which is known."""
        at, length = self.curve.along(here), self.curve.distance(here, there)
        return lambda s: there if s == length else at(s)

    def _direct(self, towards: np.ndarray) -> None:
        """Find the tangent at the last place."""
        here = self.curve.directed(self.points[-1], towards)
        if here is None:
            self.reason = f"the curve has no direction at {self.plane.words(self.points[-1].shares)}"
        else:
            self.points[-1] = here

    def _add(self, place: Place) -> int:
        """Add a place to the curve, with all its events within the cycle; by how many places these were turned."""
        self.values.append(self.plane.values(place.shares))
        orbit, turn = within_cycle(place.orbit, place.evaluation, self.plane.equations(place.shares))
        if turn:
            turned = self.curve.turned(turn, orbit)
            moved = turned.at_share(self.plane.at(orbit, place.shares), 1, place.shares[1])
            if moved is not None and np.abs(moved.shares - place.shares).max() < SAME_POINT:
                self.curve, place = turned, moved
            else:
                turn = 0
        self.points.append(replace(place, problem=self.curve))
        return turn

    def _note(self, met: list[tuple[str, Place]]) -> None:
        self.meetings += [(kind, *self.plane.values(place.shares)) for kind, place in met]

    def _end(self, kind: str, shares: np.ndarray, why: str) -> None:
        """End at a point of another kind."""
        self.values.append(self.plane.values(shares))
        self.meetings.append((kind, *self.values[-1]))
        self.reason = f"{kind} at {self.plane.words(shares)}: {why}"

    def _halves_meet(self, here: Place, found: Place) -> bool:
        """Whether both halves of the cycle become the same between two places, or maybe ahead of them."""
        if self.kind != FOLD or here.orbit.period % 2:
            return False
        before = difference_of_halves(here)
        return difference_of_halves(found) @ before < MEETS * (before @ before)

    def _doubling_ahead(self, here: Place) -> np.ndarray | None:
        """The shares of both numbers where the halves of the cycle become the same; None if it is not found.

        There a fold of 2p periods ends at a doubling of p, from which orbits of 2p begin in either direction on its two
        sides. The equations are singular there, as doublings solve them, too. On the curve both numbers are even in the
        difference of the halves, so that they are extrapolated in its square from orbits with a given difference.
        """
        before = difference_of_halves(here)
        size = np.linalg.norm(before)

        def difference(place: Place) -> float:
            return float(difference_of_halves(place) @ before) / size

        row = self.curve.gradient(difference, here)
        squares, shares = [size**2], [here.shares]
        for part in PARTS:
            along = -(1.0 - part) * size / float(row @ here.tangent)
            guess = self.curve.moved(here, along * here.tangent)
            found = self.curve.solved(guess, row, lambda there, part=part: difference(there) - part * size)
            if found is None:
                return None
            squares.append((part * size) ** 2)
            shares.append(found.shares)
        ends = extrapolated(np.array(squares), np.array(shares))
        return ends[-1] if np.abs(ends[-1] - ends[-2]).max() < EXTRAPOLATED else None

    def _returned(self) -> bool:
        """Whether the curve is back where it began."""
        if len(self.points) < 10:
            return False
        start, second, before, here = (self.points[k] for k in (0, 1, -2, -1))
        if not start.orbit.kinds == before.orbit.kinds == here.orbit.kinds:
            return False
        first, second, one, two = (place.scaled(self.curve.scales) for place in (start, second, before, here))
        share = share_on_chord(first, one, two, CLOSED_CURVE)
        return share is not None and 0 <= share <= 1 and (two - one) @ (second - first) > 0


def extrapolated(squares: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (n, 2) at arguments (n,), extrapolated to zero by the polynomials through the first 1 … n (Neville)."""
    values = values.copy()
    for k in range(1, len(values)):
        near, far = squares[k:, None], squares[:-k, None]
        values[k:] = (far * values[k:] - near * values[k - 1 : -1]) / (far - near)
    return values
