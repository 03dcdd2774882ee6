"""The branch that traces make: one, or two from the same orbit both ways."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..drivers.event_driven import displaced_state
from ..drivers.orbit import multipliers_of
from .branch import Branch
from .curve import CurvePoint
from .family import Family
from .follow import Tracer
from .journal import Trace


def branch_of_traces(family: Family, forwards: Tracer | Trace, backwards: Tracer | Trace | None, begins: str) -> Branch:
    """The branch, from the end of the second trace to that of the first.

    Parameters
    ----------
    family : Family
    forwards, backwards : Tracer or Trace
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
