"""Points of codimension two: where another bifurcation, or a change of the sequence of events, lies on a curve.

Both conditions are solved together, so that such a point is the same from either curve. That of a point that grazes,
too, is solved on the curve of grazings, whose touch is an event.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
from vibroscope.engine.continuation.kinds import BIFURCATIONS, BRANCH_POINT, FOLD, GRAZING, NEIMARK_SACKER, indicator
from vibroscope.engine.continuation.margins import Margin
from vibroscope.engine.continuation.points import PointProblem
from vibroscope.engine.continuation.points.at_event import Grazing, touched_at
from vibroscope.engine.continuation.points.problem import Place
from vibroscope.engine.continuation.points.singular import regular, short_pairs
from vibroscope.engine.continuation.roots import changes_ahead, zero_ahead
from vibroscope.engine.continuation.tolerances import NEAR_MEETING, ON_CIRCLE
from vibroscope.engine.motions.floquet import SYMMETRY_BREAKING

CUSP = "cusp"

Key = tuple[str, bool]  # kind of the other bifurcation, and whether it is one of the orbit without the touch
At = Callable[[float], Place | None]  # the place a distance ahead


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
