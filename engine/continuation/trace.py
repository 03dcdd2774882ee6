"""What following a curve one way gives, and the branch that two traces make, or one that closes."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..drivers.event_driven import displaced_state
from ..drivers.orbit import multipliers_of
from .branch import Branch, Point
from .curve import Curve, CurvePoint
from .family import Family


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
    marks: list[tuple[Point, CurvePoint]] = field(default_factory=list)
    reason: str = ""
    length: float = 0.0
    joined: float | None = None


def point_on_branch(curve: Curve, kind: str, point: CurvePoint, index: int) -> Point:
    """The point of a branch at an orbit of its curve."""
    system, _, _ = curve.family.at(point.value)
    return Point(
        kind=kind,
        value=point.value,
        period=point.orbit.period,
        multipliers=point.multipliers,
        state=displaced_state(system, point.evaluation.section[0]),
        events=point.orbit.events,
        instants=point.orbit.instants,
        index=index,
    )


def branch_of_traces(family: Family, forwards: Trace, backwards: Trace | None, begins: str) -> Branch:
    """The branch, from the end of the second trace to that of the first.

    Parameters
    ----------
    family : Family
    forwards, backwards : Trace
        The second is None if the branch closes in itself, or begins at another one.
    begins : str
        The kind of the point of another branch at which this one begins; empty if it begins at none.
    """
    points, marks = list(forwards.points), [mark for mark, _ in forwards.marks]
    if backwards is not None:
        shift = len(backwards.points) - 1
        marks = [replace(mark, index=mark.index + shift) for mark in marks]
        before = [replace(mark, index=shift - 1 - mark.index) for mark, _ in backwards.marks]
        marks = before[::-1] + marks
        points = backwards.points[:0:-1] + points
    orbits = [point.orbit for point in points]
    changes = (k for k in range(1, len(orbits)) if not orbits[k].has_sequence_of(orbits[k - 1]))
    sequences = tuple((k, orbits[k].sequence) for k in (0, *changes))
    first = backwards.reason if backwards is not None else (f"begins at a {begins}" if begins else forwards.reason)
    return Branch(
        over=family.over,
        period=points[0].orbit.period,
        values=np.array([point.value for point in points]),
        sections=_sections(family, points),
        multipliers=multipliers_of([point.evaluation for point in points]),
        sequences=sequences,
        points=tuple(marks),
        ends=(first, forwards.reason),
    )


def _sections(family: Family, points: Sequence[CurvePoint]) -> np.ndarray:
    """ξ₁, ξ₁′, ξ₂, ξ₂′ of orbits at τ ≡ 0 mod T, (n, p, 4)."""
    sections = np.array([point.evaluation.section for point in points])
    if family.changes_system:
        systems = (family.at(point.value)[0] for point in points)
        return np.array([displaced_state(*each) for each in zip(systems, sections, strict=True)])
    return displaced_state(family.system, sections)
