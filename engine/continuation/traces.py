"""The branch that traces make: one, or two from the same orbit both ways."""

from dataclasses import replace

import numpy as np

from ..drivers.event_driven import displaced_state
from .branch import Branch
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
    names = [point.orbit.sequence for point in points]
    sequences = tuple((k, name) for k, name in enumerate(names) if k == 0 or names[k - 1] != name)
    first = backwards.reason if backwards is not None else (f"begins at a {begins}" if begins else forwards.reason)
    return Branch(
        over=family.over,
        period=points[0].orbit.period,
        values=np.array([point.value for point in points]),
        sections=np.array([displaced_state(family.at(point.value)[0], point.evaluation.section) for point in points]),
        multipliers=np.array([point.evaluation.multipliers for point in points]),
        sequences=sequences,
        points=tuple(marks),
        ends=(first, forwards.reason),
    )
