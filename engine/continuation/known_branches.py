"""The branches that a search has followed, and whether an orbit lies on one of them."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from vibroscope.engine.continuation.curve import Curve, CurvePoint
from vibroscope.engine.continuation.kinds import STICKING_BEGINS, STICKING_ENDS
from vibroscope.engine.continuation.orbit import Orbit
from vibroscope.engine.continuation.tolerances import MARGIN_ROUNDING, SAME_ORBIT
from vibroscope.engine.continuation.tracer import Trace
from vibroscope.engine.motions.poincare_map import size_of

MOST_WALK = 8  # steps from an orbit to one between it and its neighbour on the branch


class KnownBranches:
    """The orbits that were followed, piece by piece: the motion jumps where an impact begins or ceases to stick."""

    def __init__(self, curve: Curve) -> None:
        self.curve, self.traces = curve, 0
        self._pieces: list[tuple[Sequence[CurvePoint], np.ndarray]] = []

    def add(self, trace: Trace) -> None:
        """Add the orbits of a trace, in their order along it; between both ends of a jump there are none."""
        self.traces += 1
        jumps = {point.index + 1 for point, _ in trace.marks if point.kind in (STICKING_BEGINS, STICKING_ENDS)}
        for first, last in pairwise((0, *sorted(jumps), len(trace.points))):
            points = trace.points[first:last]
            self._pieces.append((points, np.array([point.value for point in points])))

    @property
    def orbits(self) -> int:
        """How many orbits there are on all of them."""
        return sum(len(points) for points, _ in self._pieces)

    def have(self, point: CurvePoint) -> bool:
        """Whether an orbit lies on one of them."""
        orbit, value, rows = point.orbit, point.value, point.evaluation.section
        size = size_of(rows)
        for points, values in self._pieces:
            for k in np.flatnonzero((values[:-1] - value) * (values[1:] - value) <= 0):
                a, b = points[k], points[k + 1]
                if a.orbit.period == orbit.period and self._is_between(a, b, rows, value, SAME_ORBIT * size):
                    return True
        return False

    def _is_between(self, a: CurvePoint, b: CurvePoint, rows: np.ndarray, value: float, same: float) -> bool:
        """Whether an orbit with this section is one of those between two neighbours on a branch, to a distance."""
        share = (value - a.value) / (b.value - a.value) if b.value != a.value else 0.5
        guesses = [(a.orbit, a.value, MOST_WALK), (b.orbit, b.value, MOST_WALK)]
        if a.orbit.kinds == b.orbit.kinds:
            chord = b.orbit.unknowns - a.orbit.unknowns
            between = replace(a.orbit, unknowns=a.orbit.unknowns + share * chord)
            off = np.linalg.norm(rows - between.unknowns[:4], axis=1).min()
            if off > np.linalg.norm(chord[:4]) + same:  # neighbours are close enough for the curve to turn little
                return False
            guesses.insert(0, (between, value, 1))
        for known, begin, steps in guesses:
            for there in np.linspace(begin, value, steps + 1)[1:]:
                known = known and self.curve.corrected(known, float(there))
            if known is not None and self._is_orbit_through(known, value, rows, same):
                return True
        return False

    def _is_orbit_through(self, known: Orbit, value: float, rows: np.ndarray, same: float) -> bool:
        """Whether a solution on the curve of a branch is an orbit with this section; next to a grazing it may be none.

        On the way to it events may have passed the ends of the cycle.
        """
        there = CurvePoint(self.curve, known, value).within_cycle()
        near = (np.abs(rows - there.orbit.unknowns[:4]).max(axis=1) < same).any()
        return bool(near) and there.least_margin > -MARGIN_ROUNDING
