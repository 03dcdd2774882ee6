"""A curve of bifurcation points in two numbers, followed one way by pseudo-arclength in all unknowns."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from vibroscope.engine.continuation.closing import difference_of_halves, share_on_chord
from vibroscope.engine.continuation.kinds import DOUBLING, FOLD
from vibroscope.engine.continuation.meetings import Meetings
from vibroscope.engine.continuation.orbit import within_cycle
from vibroscope.engine.continuation.points import PointProblem
from vibroscope.engine.continuation.points.problem import Place, between
from vibroscope.engine.continuation.tolerances import CLOSED_CURVE, EXTRAPOLATED, MEETS, ROUGH_STEP, SAME_POINT
from vibroscope.engine.continuation.tracer import StepControl, Tracer

PARTS = (
    0.85,
    0.7,
    0.55,
    0.4,
)  # of the difference of halves: places with these, from which both numbers are extrapolated
CLOSES = "the curve closes in itself"


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

    def __init__(
        self, problem: PointProblem, start: Place, way: float, cancelled: Callable[[], bool] | None = None
    ) -> None:
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
