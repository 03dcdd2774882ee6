"""A curve of bifurcation points in two numbers, followed one way by pseudo-arclength in all unknowns."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..drivers.orbit_steps import null_vector
from .closing import difference_of_halves, share_on_chord
from .margins import DOUBLING, FOLD, Margin
from .meetings import Meetings
from .orbit import check_cancelled, within_cycle
from .plane import Place, Plane
from .point_equations import Condition, Equations, gradient_of, moved

FIRST_STEP, LARGEST_STEP, SMALLEST_STEP = 0.005, 0.02, 1e-7  # scaled lengths
ROUGH_STEP = 1e-5  # scaled: where a longer one leads out of the sequence, a shorter one may find its end
FAR = 0.1  # of a step: a correction as long as that leads to another curve, or the curve bends too much
ROUNDING = 1e-9
SAME = 1e-6  # of the ranges: points closer than that are the same
CLOSED = 0.01  # of a step
MEETS = 0.75  # of the difference of the halves of a cycle: a step to a smaller one may lead to where it is zero
PARTS = (0.85, 0.7, 0.55, 0.4)  # of that difference: from places with these both numbers are extrapolated …
EXTRAPOLATED = 1e-7  # … if the last of them changes the shares by less
MOST_POINTS = 2000
CLOSES = "the curve closes in itself"


@dataclass
class PointTrace:
    """A curve followed one way from a place.

    Attributes
    ----------
    values : list of (float, float)
        α₁ and α₂.
    meetings : list of (str, float, float)
    reason : str
        Why it ends.
    """

    plane: Plane
    equations: Equations
    place: Place
    cancelled: Callable[[], bool] | None
    reason: str = ""
    turn: int = 0  # by how many places the events of the last place were counted anew
    meetings: list = field(default_factory=list)
    values: list = field(default_factory=list)
    _places: list = field(default_factory=list)

    def __post_init__(self) -> None:
        self._meetings = Meetings(self.plane, self.equations)

    @property
    def kind(self) -> str:
        """Of the points."""
        return self.equations.condition.kind

    def follow(self, way: float) -> None:
        """Follow the curve, at first towards larger α₂ if ``way`` is 1."""
        self._accept(self.place)
        step, tangent = FIRST_STEP, None
        while not self.reason:
            check_cancelled(self.cancelled)
            if len(self.values) >= MOST_POINTS:
                self.reason = f"given up after {MOST_POINTS} points"
                return
            matrix, ahead = self._linearised(self.place)
            if ahead is None:
                self.reason = f"the curve has no direction at {self._words(self.place)}"
                return
            if tangent is None:
                tangent = ahead * (way if ahead[-1] >= 0 else -way)
            else:
                same = self.turn == 0  # else the state at τ = 0 is another one
                before = np.concatenate([same * tangent[:4], np.roll(tangent[4:-2], self.turn), tangent[-2:]])
                tangent = ahead if ahead @ before >= 0 else -ahead
            step = self._advance(matrix, tangent, step)

    def passes(self, period: int, shares: np.ndarray) -> bool:
        """Whether the curve goes through a point of the plane."""
        for (one, here), (_, there) in zip(self._places[:-1], self._places[1:], strict=True):
            sides = here.shares[1] - shares[1], there.shares[1] - shares[1]
            if here.orbit.period != period or here.orbit.kinds != there.orbit.kinds or sides[0] * sides[1] > 0:
                continue
            part = sides[0] / (sides[0] - sides[1]) if sides[0] != sides[1] else 0.0
            guess = between(self.plane, here, there, part)
            if guess is None or abs(guess.shares[0] - shares[0]) > LARGEST_STEP:
                continue
            found = self._at_share(one, guess, 1, shares[1])
            if found is not None and abs(found.shares[0] - shares[0]) < SAME:
                return True
        return False

    # -- one step ------------------------------------------------------------------------------------------------------

    def _advance(self, matrix: np.ndarray, tangent: np.ndarray, step: float) -> float:
        """Take a step; return the length to try next."""
        here, start = self.place, self._meetings.tests(self.place)
        found, reason = self._border_ahead(here, tangent, step)
        while found is None:
            found = self._ahead(here, matrix, tangent, step)
            if found is not None:
                found, reason = self._within(here, found)
                if found is None:
                    self.reason = reason
                    return step
                break
            step /= 2
            if step < SMALLEST_STEP:
                self.reason = f"no orbit is found beyond {self._words(here)}"
                return step
        if self._halves_meet(here, found) and (doubling := self._doubling_ahead(here, tangent)) is not None:
            self._end_at_doubling(doubling)
            return step
        scales, end = self.equations.scales, found
        length = float(tangent @ (found.scaled(scales) - here.scaled(scales)))

        def at(s: float) -> Place | None:
            return here if s == 0 else end if s == length else self._ahead(here, matrix, tangent, s)

        if self._meetings.least(found) <= 0:
            last = self._meetings.last_of_sequence(at, length)
            place = last and self._meetings.at_margin(*last[1:])
            if place is not None:
                self._note(self._meetings.located(at, last[0], start, last[1]))
                self._end_of_sequence(place, last[2])
            elif step > ROUGH_STEP:
                return step / 4
            else:
                kind = last[2].kind if last else "the end of its sequence of events"
                self.reason = f"at {self._words(here)} it can no longer be distinguished from {kind}"
            return step
        self._note(self._meetings.located(at, length, start, found))
        self.reason = reason
        self._accept(found)
        if not reason and self._returned():
            self.reason = CLOSES
        return min(1.5 * step, LARGEST_STEP)

    def _linearised(self, place: Place) -> tuple[np.ndarray, np.ndarray | None]:
        """The derivatives of the equations, and the tangent; None where there is none."""
        self.equations.condition.renewed()
        try:
            matrix = self.equations.matrix(place)
        except ValueError:
            return np.empty(0), None
        tangent = null_vector(matrix)
        return matrix, tangent if np.isfinite(tangent).all() else None

    def _ahead(self, here: Place, matrix: np.ndarray, tangent: np.ndarray, s: float) -> Place | None:
        """The place a distance ahead along the tangent; None if there is none."""
        scales = self.equations.scales
        target = here.scaled(scales) + s * tangent
        n = len(scales)
        try:
            guess = self.plane.at(replace(here.orbit, unknowns=target[:n] * scales), target[n:])
        except ValueError:
            return None
        found = self.equations.solved(guess, tangent, lambda there: tangent @ (there.scaled(scales) - target), matrix)
        far = np.inf if found is None else np.linalg.norm(found.scaled(scales) - target)
        return found if far <= FAR * abs(s) + ROUNDING else None

    def _border_ahead(self, here: Place, tangent: np.ndarray, step: float) -> tuple[Place | None, str]:
        """The place on the border that a step would cross, and why the curve ends there; None if it crosses none.

        Beyond the border there may be no problem, as with a restitution above one.
        """
        scales, n = self.equations.scales, len(self.equations.scales)
        for k, axis in enumerate(self.plane.axes):
            border = min(max(here.shares[k] + step * tangent[n + k], 0.0), 1.0)
            if border not in (0.0, 1.0) or border == here.shares[k]:
                continue
            s = (border - here.shares[k]) / tangent[n + k]
            target = here.scaled(scales) + s * tangent
            target[n + k] = border
            if (target[n:] < 0).any() or (target[n:] > 1).any():
                continue
            guess = self.plane.at(replace(here.orbit, unknowns=target[:n] * scales), target[n:])
            found = self._at_share(self.equations, guess, k, border)
            if found is not None and np.linalg.norm(found.scaled(scales) - target) <= FAR * step:
                return found, f"{axis.name} leaves the range"
        return None, ""

    def _within(self, here: Place, found: Place) -> tuple[Place | None, str]:
        """The place, or that on the border of the ranges if it lies outside, and then why the curve ends."""
        for k, axis in enumerate(self.plane.axes):
            border = min(max(found.shares[k], 0.0), 1.0)
            if border == found.shares[k]:
                continue
            part = (border - here.shares[k]) / (found.shares[k] - here.shares[k])
            guess = between(self.plane, here, found, part)
            at_border = guess and self._at_share(self.equations, guess, k, border)
            reason = f"{axis.name} leaves the range"
            if at_border is None:
                return None, reason
            inside = ((at_border.shares >= -SAME) & (at_border.shares <= 1 + SAME)).all()
            return (at_border, reason) if inside else self._within(here, at_border)
        return found, ""

    def _at_share(self, equations: Equations, guess: Place, k: int, share: float) -> Place | None:
        row = np.zeros(len(equations.scales) + 2)
        row[len(equations.scales) + k] = 1.0
        return equations.solved(guess, row, lambda there: there.shares[k] - share)

    def _accept(self, place: Place) -> None:
        """Add a place to the curve, with all its events within the cycle."""
        self.values.append(self.plane.values(place.shares))
        self.place, self.turn = place, 0
        orbit, turn = within_cycle(place.orbit, place.evaluation, self.plane.equations(place.shares))
        if turn:
            touch = self.equations.condition.touch
            touch = None if touch is None else (touch + turn) % len(orbit.kinds)
            equations = Equations(self.plane, Condition(self.kind, touch), orbit)
            moved = self._at_share(equations, self.plane.at(orbit, place.shares), 1, place.shares[1])
            if moved is not None and np.abs(moved.shares - place.shares).max() < SAME:
                self.equations, self.place, self.turn = equations, moved, turn
                self._meetings = Meetings(self.plane, equations)
        self._places.append((self.equations, self.place))

    def _note(self, met: list[tuple[str, Place]]) -> None:
        self.meetings += [(kind, *self.plane.values(place.shares)) for kind, place in met]

    def _end_of_sequence(self, place: Place, margin: Margin) -> None:
        """End at the point where a margin is zero."""
        self.values.append(self.plane.values(place.shares))
        kind = margin.point_at(place.orbit, self.plane.over.method)
        self._note([(kind, place)])
        self.reason = f"{kind} at {self._words(place)}: the sequence of events changes"

    def _halves_meet(self, here: Place, found: Place) -> bool:
        """Whether both halves of the cycle become the same between two places, or maybe ahead of them."""
        if self.kind != FOLD or here.orbit.period % 2:
            return False
        before = difference_of_halves(here)
        return difference_of_halves(found) @ before < MEETS * (before @ before)

    def _doubling_ahead(self, here: Place, tangent: np.ndarray) -> np.ndarray | None:
        """The shares of both numbers where the halves of the cycle become the same; None if it is not found.

        There a fold of 2p periods ends at a doubling of p, from which orbits of 2p begin in either direction on its two
        sides. The equations are singular there, as doublings solve them, too. On the curve both numbers are even in the
        difference of the halves, so that they are extrapolated in its square from orbits with a given difference.
        """
        before = difference_of_halves(here)
        size = np.linalg.norm(before)

        def difference(place: Place) -> float:
            return float(difference_of_halves(place) @ before) / size

        row = gradient_of(difference, self.plane, here, self.equations.scales)
        squares, shares = [size**2], [here.shares]
        for part in PARTS:
            along = -(1.0 - part) * size / float(row @ tangent)
            guess = moved(self.plane, here, self.equations.scales, along * tangent)
            found = self.equations.solved(guess, row, lambda there, part=part: difference(there) - part * size)
            if found is None:
                return None
            squares.append((part * size) ** 2)
            shares.append(found.shares)
        ends = extrapolated(np.array(squares), np.array(shares))
        return ends[-1] if np.abs(ends[-1] - ends[-2]).max() < EXTRAPOLATED else None

    def _end_at_doubling(self, shares: np.ndarray) -> None:
        """End where the curve meets that of the doublings of half the period."""
        value, along = self.plane.values(shares)
        over, second = self.plane.axes
        self.values.append((value, along))
        self.meetings.append((DOUBLING, value, along))
        where = f"{over.name} = {value:.8g}, {second.name} = {along:.8g}"
        self.reason = f"{DOUBLING} at {where}: both halves of the cycle become the same"

    def _returned(self) -> bool:
        """Whether the curve is back where it began."""
        if len(self._places) < 10:
            return False
        (_, start), (_, before), (_, here) = self._places[0], self._places[-2], self._places[-1]
        if not start.orbit.kinds == before.orbit.kinds == here.orbit.kinds:
            return False
        scales = self.equations.scales
        first, second, one, two = (place.scaled(scales) for place in (start, self._places[1][1], before, here))
        share = share_on_chord(first, one, two, CLOSED)
        return share is not None and 0 <= share <= 1 and (two - one) @ (second - first) > 0

    def _words(self, place: Place) -> str:
        value, along = self.plane.values(place.shares)
        over, second = self.plane.axes
        return f"{over.name} = {value:.8g}, {second.name} = {along:.8g}"


def extrapolated(squares: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (n, 2) at arguments (n,), extrapolated to zero by the polynomials through the first 1 … n (Neville)."""
    values = values.copy()
    for k in range(1, len(values)):
        near, far = squares[k:, None], squares[:-k, None]
        values[k:] = (far * values[k:] - near * values[k - 1 : -1]) / (far - near)
    return values


def between(plane: Plane, here: Place, there: Place, part: float) -> Place | None:
    """A guess between two places with the same sequence; None where a number is out of its range."""
    one, other = here.orbit.unknowns, there.orbit.unknowns
    orbit = replace(here.orbit, unknowns=one + part * (other - one))
    try:
        return plane.at(orbit, here.shares + part * (there.shares - here.shares))
    except ValueError:
        return None
