"""A branch is followed from an orbit: steps along its curve, points located, and the sequence of events changed.

Steps grow where the curve is straight. Where an indicator changes its sign between two orbits, or a margin falls below
zero, the zero is located along the curve. At the zero of a margin the curve goes on as another sequence of events
(:mod:`.sequences`). It ends where the branch is back at its first orbit, or in a branch of half its period.
"""

from dataclasses import replace
from functools import partial
from operator import attrgetter

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.continuation.branch import KnownBranches, point_on_branch
from vibroscope.engine.continuation.curve import Curve, CurvePoint
from vibroscope.engine.continuation.kinds import (
    BIFURCATIONS,
    CHATTER_COMPLETES,
    DOUBLING,
    FOLD,
    GRAZING,
    OPENS,
    STICKING_BEGINS,
    STICKING_ENDS,
    bifurcations_ahead,
    indicators,
)
from vibroscope.engine.continuation.orbit import (
    LATER_SUM,
    Margin,
    Orbit,
    impacts_that_may_stick,
    least_period,
    parts_more_than_pressed,
)
from vibroscope.engine.continuation.roots import zero_ahead
from vibroscope.engine.continuation.sequences import after_chatter, beyond, where_contact_opens
from vibroscope.engine.continuation.tolerances import (
    ACCUMULATED,
    CLOSED_BRANCH,
    INSIDE_SEQUENCE,
    LONGEST_MEETING,
    REPEATED,
    ROUNDED_IMPACTS,
    SAME_DOUBLING,
    SAME_FOLD,
    SAME_ORBIT,
    VANISHING_MARGIN,
    VANISHING_STEP,
)
from vibroscope.engine.continuation.tracer import StepControl, Tracer
from vibroscope.engine.drivers.orbit import event
from vibroscope.engine.motions.poincare_map import SYMMETRY_BREAKING, size_of

SERIES = 6
MOST_SHORT = 200  # orbits, from where a new flight is long enough to be an orbit beyond rounding, back to its beginning
OTHER_END = {STICKING_BEGINS: STICKING_ENDS, STICKING_ENDS: STICKING_BEGINS}  # of a jump: its kind as a point


def share_on_chord(point: np.ndarray, here: np.ndarray, there: np.ndarray, aside: float) -> float | None:
    """The share of the way between two neighbours at which a point lies; None if it lies more than ``aside`` off."""
    along, off = there - here, point - here
    if not along.any():
        return None
    share = float(off @ along / (along @ along))
    return share if np.linalg.norm(off - share * along) < aside * np.linalg.norm(along) else None


def share_of_first(start: CurvePoint, here: CurvePoint, there: CurvePoint) -> float | None:
    """The share of the way between two neighbours at which the first orbit lies, if its events are the same."""
    if start.orbit.kinds != here.orbit.kinds:
        return None
    return share_on_chord(*(point.unknowns / start.scales for point in (start, here, there)), CLOSED_BRANCH)


def is_first(start: CurvePoint, orbit: Orbit) -> bool:
    """Whether an orbit passes through a state of the first one at τ ≡ 0, with as many events."""
    rows = start.evaluation.section
    near = np.abs(rows - orbit.unknowns[:4]).max(axis=1) < SAME_ORBIT * size_of(rows)
    return bool(near.any()) and sorted(orbit.kinds) == sorted(start.orbit.kinds)


def halves_meet(here: CurvePoint, there: CurvePoint) -> bool:
    """Whether both halves of the cycle become the same between two orbits.

    There a branch that began at a period doubling meets the branch of half the period. What follows is the same
    orbits, half a cycle later.
    """
    if here.orbit.period % 2:
        return False
    return difference_of_halves(here) @ difference_of_halves(there) < 0


def value_of_meeting(curve: Curve, here: CurvePoint, there: CurvePoint) -> float:
    """α₁ where the halves meet: the period doubling between two orbits, or next to them.

    The equations are singular there; near it α₁ varies with the square of the difference of the halves. So this leads
    to an orbit of half the period from which the doubling is located.
    """
    one, two = (float(np.square(difference_of_halves(point)).sum()) for point in (here, there))
    share = one / (one - two) if one != two else 0.5
    value = here.value + (there.value - here.value) * min(max(share, -1.0), 2.0)
    located = _doubling_near(curve, here.orbit, value)
    return value if located is None else located


def _doubling_near(curve: Curve, orbit: Orbit, value: float) -> float | None:
    """α₁ of the period doubling of the orbit whose cycle is half of another one; None if it is not found nearby."""
    half, m = orbit.period // 2, len(orbit.kinds) // 2
    if len(orbit.kinds) % 2 or orbit.kinds[:m] != orbit.kinds[m:]:  # an event lies at an end of the cycle
        return None
    instants = 0.5 * (orbit.instants[:m] + orbit.instants[m:] - half)
    guess = Orbit(half, orbit.kinds[:m], orbit.first, np.concatenate([orbit.unknowns[:4], instants]))
    point = curve.solved(guess, value)
    if point is None:
        return None
    for start, step in ((side, SAME_DOUBLING * 4.0**k) for k in range(5) for side in (point, point.turned())):
        ahead = curve.ahead(start, step)
        if ahead is None:
            continue
        for kind, there in bifurcations_ahead(curve, start, step, indicators(start), indicators(ahead)):
            if kind == DOUBLING:
                return there.value
    return None


def difference_of_halves(point: CurvePoint) -> np.ndarray:
    """ξ₁ and g half a cycle later less those at τ = 0, (2,): an impact there leaves them as they are."""
    rows = point.evaluation.section[:, [0, 2]]
    return rows[len(rows) // 2] - rows[0]


class BranchTracer(Tracer):
    """Follows one branch from an orbit in one direction.

    Parameters
    ----------
    curve : Curve
    start : CurvePoint
        The first orbit; its tangent gives the direction.
    cancelled : callable, optional
    """

    control = StepControl(first=0.005, largest=0.05, smallest=1e-9, growth=8.0, bend=0.12, turn=0.98)

    def __init__(self, curve: Curve, start: CurvePoint, cancelled: Poll | None = None) -> None:
        super().__init__(curve, start, cancelled)
        self._grazings: list[float] = []  # since the last other change of the sequence
        self._indicators = indicators(start)

    # -- one step ------------------------------------------------------------------------------------------------------

    def _vanishes(self, here: CurvePoint, step: float) -> bool:
        """Whether a phase vanishes at the last orbit, where rounding hides the zero of its margin."""
        vanishes = step < VANISHING_STEP and here.least_margin < VANISHING_MARGIN
        if not (vanishes and self._change_sequence(here, 0.0, rounded=True)):
            return False
        self.length += step
        return True

    def _why_lost(self, here: CurvePoint) -> str:
        chatters = event.CHATTER in here.orbit.at_any_stop and np.diff(here.orbit.instants).min() < ROUNDED_IMPACTS
        why = "the impacts of a chatter lie too close together" if chatters else "no orbit is found ahead"
        return f"the step shrinks to nothing at {self.curve.words(here)}: {why}"

    def _special(self, here: CurvePoint, there: CurvePoint, step: float) -> float | None:
        end = step if there.least_margin <= 0 else self._hidden_end(here, there, step)
        if end is not None:
            self.reason = ""
            if not self._change_sequence(here, end):
                return step / 4
            here.around.clear()
            self.length += end
            return self.control.first / 10
        if not halves_meet(here, there):
            return None
        if step > LONGEST_MEETING:
            return step / 4
        self._join(there.orbit.period // 2, value_of_meeting(self.curve, here, there))
        return step

    def _closed(self, here: CurvePoint, there: CurvePoint, step: float) -> tuple[CurvePoint, float]:
        end = self._first_orbit_between(here, there)
        return (there, step) if end is None else (end, here.way_to(end))

    def _accept(self, here: CurvePoint, there: CurvePoint, step: float) -> None:
        after = self._mark_bifurcations(here, there, step)
        self.points.append(there.within_cycle())
        self.length += step
        here.around.clear()
        if self.points[-1] is there:
            there.around[there.way_to(here)] = here
        self._indicators = after if self.points[-1] is there else indicators(self.points[-1])

    def _first_orbit_between(self, here: CurvePoint, there: CurvePoint) -> CurvePoint | None:
        """The first orbit of the branch, if it is between two neighbours, where the branch ends; else None."""
        start = self.points[0]
        if len(self.points) < 10 or self.reason or start.orbit.period != here.orbit.period:
            return None
        share, onwards = share_of_first(start, here, there), True
        if share is not None:
            onwards = start.tangent @ there.tangent > 0
        elif start.tangent[-1] * (there.value - here.value) > 0:  # maybe with its events counted from another one on
            share = (start.value - here.value) / (there.value - here.value)
        if share is None or not 0 <= share <= 1:
            return None
        chord = there.orbit.unknowns - here.orbit.unknowns
        guess = here.orbit.at(here.orbit.unknowns + share * chord)
        end = self.curve.solved(guess, start.value, here.tangent)
        if end is None or not is_first(start, end.orbit):
            return None
        self._close(onwards)
        return end

    def _ends_at(self, point: CurvePoint) -> bool:
        """Whether an orbit next to the end of a sequence is the first one of the branch, which then ends there."""
        start = self.points[0]
        near = abs(point.value - start.value) < SAME_ORBIT * self.curve.width
        if len(self.points) < 10 or not near or not is_first(start, point.orbit):
            return False
        self._close(start.tangent[-1] * point.tangent[-1] > 0)
        return True

    def _close(self, onwards: bool) -> None:
        self.reason = "the branch closes in itself" if onwards else "the branch comes back to where it began"

    # -- points --------------------------------------------------------------------------------------------------------

    def _mark_bifurcations(self, here: CurvePoint, there: CurvePoint, step: float) -> dict[str, float]:
        """Locate the bifurcations between two neighbouring orbits; return the indicators of the second."""
        after = indicators(there)
        for kind, point in bifurcations_ahead(self.curve, here, step, self._indicators, after):
            self.mark(kind, point)
            turns = kind == SYMMETRY_BREAKING and not here.orbit.is_symmetric
            if kind == FOLD or turns:  # the farthest orbit of its branch
                self.points.append(point.within_cycle())
        return after

    def mark(self, kind: str, point: CurvePoint, stop: int = 1, regular: CurvePoint | None = None) -> None:
        """Note a point of the branch; ``regular``: an orbit with the same multipliers, where a phase has no length."""
        point = point.within_cycle()
        noted = point_on_branch(self.curve, kind, point, len(self.points) - 1, stop)
        if regular is not None:
            noted = replace(noted, multipliers=regular.multipliers)
        self.marks.append((noted, point))

    def _limit_of_grazings(self) -> float | None:
        """Where a chatter completes, if grazing follows grazing, each with one more impact, ever closer; else None.

        Their distances tend to a geometric series: what is left of it follows from the last two (Aitken).
        """
        if len(self._grazings) < SERIES:
            return None
        steps = np.diff(self._grazings[-SERIES:])
        if not (np.diff(np.abs(steps)) < 0).all():
            return None
        left = steps[-1] ** 2 / (steps[-2] - steps[-1])
        return float(self._grazings[-1] + left) if abs(left) < ACCUMULATED * self.curve.width else None

    # -- other sequences -----------------------------------------------------------------------------------------------

    def _hidden_end(self, here: CurvePoint, there: CurvePoint, step: float) -> float | None:
        """How far ahead between two orbits of the same sequence another one does not have it; None if there is none."""
        for k in impacts_that_may_stick(here, there):
            both = zero_ahead(self.curve.along(here), step, partial(parts_more_than_pressed, k))
            if both is not None and both[1].least_margin <= 0:
                return both[0]
        return None

    def _change_sequence(self, here: CurvePoint, step: float, rounded: bool = False) -> bool:
        """Locate where the sequence of events ceases to hold within a step, and go on with the one that follows.

        False if the place is not found, since orbits on the way are missing: a shorter step may find it. ``rounded``:
        none can, since the equations have no digit left right ahead of the first orbit; there the place is.
        """
        zero = zero_ahead(self.curve.along(here), step, attrgetter("least_margin"))
        located, last = (None, None) if zero is None else (zero[0], self.curve.ahead(here, zero[0]))
        if last is None and rounded:
            located, last = 0.0, here
        if last is None and step > self.control.smallest:
            return False
        if last is None:
            where = self.curve.words(here)
            self.reason = f"the sequence of events ends near {where}, but the orbit at its end is not found"
            return True
        # on its own side of the end, where it is an orbit beyond rounding: at the end itself a new phase is of length
        # zero, which makes the equations singular although nothing bifurcates
        inside = (self.curve.ahead(here, (1 - INSIDE_SEQUENCE) * located) if located else None) or last
        end, way = self._first_orbit_between(here, inside), (1 - INSIDE_SEQUENCE) * located
        if end is not None:
            way = here.way_to(end)
        elif self._ends_at(inside):
            end = inside
        self._mark_bifurcations(here, end or inside, way)
        if end is not None:
            self.points.append(end.within_cycle())
            return True
        if inside is not here:
            self.points.append(inside.within_cycle())
        self._go_beyond(last, inside)
        return True

    def _go_beyond(self, last: CurvePoint, inside: CurvePoint) -> None:
        """Go on with the sequence of events that follows, or say why none does.

        ``last``: the orbit at which the one before ceases to hold; ``inside``: one right before it.
        """
        following, margin, arrival, by_run = beyond(self.curve, last)
        kind, stop = margin.point_at(last.orbit, self.curve.family.method), margin.stop(last.orbit)
        where = self.curve.words(last)
        more = 0 if following is None else len(following.orbit.kinds) - len(last.orbit.kinds)
        flight = kind == OPENS and self.curve.family.method.rigid  # begins where more > 0, or vanishes
        if margin.kind != LATER_SUM:
            at = (flight and more < 0 and where_contact_opens(self.curve, following)) or last
            self.mark(kind, at, stop, (following or inside) if self._is_singular(margin) else None)
        self._grazings = [*self._grazings, last.value] if margin.kind == GRAZING and margin.inside else []
        limit = self._limit_of_grazings()
        if limit is not None:
            self.mark(CHATTER_COMPLETES, last, stop)
            self.marks[-1] = replace(self.marks[-1][0], value=limit), last
            self._grazings = []
            kind, following = CHATTER_COMPLETES, after_chatter(self.curve, last)
            if following is not None and self._has_passed(following, following):
                self.reason = (
                    f"{kind} at {where}, where grazings accumulate: beyond are only the orbits of the branch before"
                )
                return
        if following is None:
            self.reason = f"{kind} at {where}: no orbit with another sequence of events goes on from there"
            return
        shortest = least_period(following.evaluation.section, REPEATED)
        if shortest < following.orbit.period:
            self._join(shortest, last.value)
            return
        self._ends_at(following)
        meets_shorter = least_period(last.evaluation.section, SAME_ORBIT) < last.orbit.period
        if (by_run or meets_shorter) and self._has_passed(following):
            self.reason = f"{kind} at {where}: the orbits that go on from there are those of the branch before"
            return
        if arrival is not None:
            self.mark(OTHER_END[margin.kind], arrival, stop)
        if flight and more > 0:
            self._pass_short_flight(following)
        self.points.append(following.within_cycle())
        self._indicators = indicators(self.points[-1])

    def _pass_short_flight(self, following: CurvePoint) -> None:
        """Add the orbits with a shorter flight than in the first one found, and their points: as met the other way."""
        back = BranchTracer(self.curve, following.turned(), self.cancelled)
        events = len(following.orbit.kinds)
        for _ in back.run(MOST_SHORT):
            if len(back.points[-1].orbit.kinds) != events:
                break
        n = sum(len(point.orbit.kinds) == events for point in back.points) - 1
        marks = [(replace(mark, index=len(self.points) + n - 1 - mark.index), at) for mark, at in back.marks]
        self.marks += [
            each for each in reversed(marks) if len(each[0].events) == events and each[0].kind in BIFURCATIONS
        ]
        self.points += back.points[n:0:-1]
        self.length += back.length

    def _has_passed(self, following: CurvePoint, ahead: CurvePoint | None = None) -> bool:
        """Whether the orbits beyond the end of a sequence lie on the branch already; ``ahead``: one of them.

        Of three sequences that end at a jump two may go on as the third. Where the branch meets one of a shorter
        period, more than two sequences end, and those of the same orbits some cycles later are among them.
        """
        ahead = ahead or self.curve.ahead(following, self.control.first / 10)
        values = [point.value for point in self.points]
        if ahead is None or not min(values) <= ahead.value <= max(values):
            return False
        passed = KnownBranches(self.curve)
        passed.add(self)
        return passed.have(ahead)

    def _is_singular(self, margin: Margin) -> bool:
        """Whether a contact of the penalty has no length at the zero of a margin."""
        vanishes = margin.kind == GRAZING and not margin.inside
        return vanishes and not self.curve.family.method.rigid

    def _join(self, period: int, value: float) -> None:
        """End the branch where it meets one of a shorter period; α₁ turns there, which is no fold."""
        self.joined = value
        near = SAME_FOLD * self.curve.width
        self.marks = [each for each in self.marks if each[0].kind != FOLD or abs(each[0].value - value) > near]
        self.reason = f"joins a branch of period {period} at {self.curve.family.over} = {value:.12g}"
