"""The curves of folds, period doublings and grazing in the K–D plane, while they are searched for. No panel import.

They are those of the exact penalty solution. Branches are followed over K at some values of D, and each of their points
in both numbers, each curve once.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from vibroscope.app.runtime.settings import current_settings
from vibroscope.app.studies.branches import limited
from vibroscope.engine import (
    POINT_KINDS,
    BranchQuestion,
    ExactPenalty,
    Point,
    PointCurve,
    PointCurves,
    System,
    counted,
    search_branches,
)
from vibroscope.engine.arguments import Poll

KINDS = ("fold", "period doubling", "grazing", "contact opens")  # of points that are followed
ROWS = 3  # values of D at which branches are followed
SEARCH = {"max_period": 2, "most_orbits": 300}
SECONDS = 120.0  # of one search, without what others had meanwhile
MOST_CURVES = 80


class CurvesQuestion(NamedTuple):
    """The rectangle of K and D, and what holds in all of it."""

    system: System
    eta: float
    K: tuple[float, float]
    D: tuple[float, float]

    @property
    def rows(self) -> list[float]:
        """The values of D at which branches are followed."""
        return np.geomspace(*self.D, 2 * ROWS + 1)[1::2].tolist()

    def method(self, damping: float) -> ExactPenalty:
        """The exact penalty at the low end of K."""
        return ExactPenalty(self.K[0], damping)

    def search(self, damping: float) -> BranchQuestion:
        """The branches over K at a value of D."""
        method = self.method(damping)
        return BranchQuestion(self.system, self.eta, method, over="K", low=self.K[0], high=self.K[1], **SEARCH)


@dataclass(frozen=True, eq=False)
class PartialCurves:
    """The curves that were found so far.

    Attributes
    ----------
    question : CurvesQuestion
    curves : tuple of PointCurve
    share : float
        1 when the search is over.
    cut : str
        What was left out, in a sentence; empty if nothing was.
    """

    question: CurvesQuestion
    curves: tuple[PointCurve, ...]
    share: float
    cut: str = ""

    def words(self) -> str:
        """How many curves there are of each kind."""
        numbers = {kind: sum(curve.kind == kind for curve in self.curves) for kind in KINDS}
        parts = [f"{number} of {POINT_KINDS[kind].several}" for kind, number in numbers.items() if number]
        return f"{len(self.curves)} curve{'' if len(self.curves) == 1 else 's'}" + (
            f": {', '.join(parts)}" * bool(parts)
        )

    def table(self) -> dict[str, np.ndarray]:
        """Every vertex of every curve: the columns of a table."""
        sizes = [len(curve.values) for curve in self.curves]
        values = np.concatenate([curve.values for curve in self.curves] or [np.empty((0, 2))])
        columns = {
            "curve": np.arange(len(sizes)) + 1,
            "kind": np.array([curve.kind for curve in self.curves]),
            "period": np.array([curve.period for curve in self.curves]),
        }
        repeated = {name: np.repeat(column, sizes) for name, column in columns.items()}
        return {**repeated, "K": values[:, 0], "D": values[:, 1]}

    def data(self) -> dict[str, object]:
        """The results so far, for a file."""
        return {"curves": self.table(), "cut": self.cut}


def grow_curves(question: CurvesQuestion, last: PartialCurves | None, cancelled: Poll) -> Iterator[PartialCurves]:
    """The curves so far, after each. Raises `Cancelled`."""
    kept, lost = last.curves if last else (), []
    found = limited(lambda ends: _curves(question, ends, lost), SECONDS, MOST_CURVES, "curves", cancelled)
    for parts, cut in found:
        curves = tuple(curve for curve, _ in parts)
        if cut is None:
            yield PartialCurves(question, max(curves, kept, key=len), parts[-1][1])
    if lost and not cut:
        cut = f"{counted(len(lost), 'point')} of branches could not be followed."
    yield PartialCurves(question, curves, 1.0, cut)


def _curves(question: CurvesQuestion, ends: Poll, lost: list[Point]) -> Iterator[tuple[PointCurve, float]]:
    """Each curve, and how much of the search is over; ``lost`` gets the points that could not be followed."""
    rows = question.rows
    reach = {"along": "D", "along_low": question.D[0], "along_high": question.D[1]}
    plane = PointCurves(question.search(rows[0]), **reach, cancelled=ends)
    how = {"threads": current_settings().threads, "cancelled": ends}
    for number, damping in enumerate(rows):
        for branch in search_branches(question.search(damping), **how):
            for point in branch.points:
                if point.kind not in KINDS:
                    continue
                try:
                    curve = plane.follow(point, damping)
                except ValueError:
                    lost.append(point)
                    continue
                if curve is not None:
                    yield curve, number / len(rows)
