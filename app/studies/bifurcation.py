"""The bifurcation diagram, growing: from rest coarse points first, continued from one end to the other.

A diagram that is continued has no coarse picture that could be refined: where a motion goes on from depends on how far
its neighbour is. So it is run coarsely from end to end, and then again at the full resolution over it.
No panel import.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from vibroscope.app.studies.refine import COARSEST, batches, interlaced
from vibroscope.engine import Cells, Method, System, run_cells

COUNT = 480  # values of η
TRANSIENT, SAMPLE = 1000, 48
COORDINATES = {"xi1": 0, "v1": 1, "xi2": 2, "v2": 3}
# What one update sends is bounded: so many points are drawn at most, and so many of what it is compared with.
MOST_POINTS, MOST_BESIDE = 4200, 1500
_EQUAL = 1e-5  # points nearer than this share of the picture's height are one


class Diagram(NamedTuple):
    """What is asked."""

    system: System
    method: Method
    direction: str
    eta: tuple[float, float]

    @property
    def axis(self) -> np.ndarray:
        """η of the cells: (COUNT,), ascending."""
        return np.linspace(*self.eta, COUNT)


@dataclass(frozen=True, eq=False)
class DiagramStage:
    """As far as it has come.

    ``section`` is (COUNT, SAMPLE, 4), ``period`` and ``impacts`` (COUNT,), nan where nothing is known; ``settled`` says
    which cells are final.
    """

    question: Diagram
    settled: np.ndarray
    section: np.ndarray
    period: np.ndarray
    impacts: np.ndarray
    ended: np.ndarray  # which cells ended early

    @property
    def share(self) -> float:
        """Of all cells that are done."""
        return float(self.settled.mean())

    @property
    def known(self) -> np.ndarray:
        """Which cells hold something, final or coarse."""
        return np.isfinite(self.period) | self.ended

    def points(self, coordinate: str, most: int = MOST_POINTS) -> tuple[np.ndarray, np.ndarray]:
        """η and the coordinate at τ ≡ 0 mod T, each motion's points once; some of them where there are too many."""
        values = np.sort(self.section[:, :, COORDINATES[coordinate]], axis=1)
        height = np.nanmax(values, initial=-np.inf) - np.nanmin(values, initial=np.inf)
        new = np.isfinite(values)
        new[:, 1:] &= np.diff(values, axis=1) > _EQUAL * height
        row, column = np.nonzero(_thinned(new, most))
        return self.question.axis[row], values[row, column]

    def data(self) -> dict[str, object]:
        """What is known, for a file."""
        return {
            "direction": self.question.direction,
            "eta": self.question.axis[self.known],
            "period": self.period[self.known],
            "impacts_per_period": self.impacts[self.known],
            **{name: self.section[self.known, :, column] for name, column in COORDINATES.items()},
        }

    def stretches(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Intervals of η with one period: left, right, period; −1 where the run ended early."""
        known = np.flatnonzero(self.known)
        eta = self.question.axis[known]
        edges = np.concatenate([eta[:1], 0.5 * (eta[1:] + eta[:-1]), eta[-1:]])
        period = np.where(self.ended[known], -1, np.nan_to_num(self.period[known]))
        begin = np.flatnonzero(np.diff(period, prepend=np.nan) != 0)
        return edges[begin], np.append(edges[begin[1:]], edges[-1:]), period[begin]


def _thinned(chosen: np.ndarray, most: int) -> np.ndarray:
    """At most so many of the chosen entries: as many of each row as all rows can have, evenly out of it."""
    count = chosen.sum(axis=1)
    quota = next((q for q in range(chosen.shape[1], 1, -1) if np.minimum(count, q).sum() <= most), 1)
    rank = np.cumsum(chosen, axis=1)
    share = np.minimum(quota / np.maximum(count, 1), 1.0)[:, None]
    return chosen & (np.floor(rank * share + 1e-9) > np.floor((rank - 1) * share + 1e-9))


def refine_diagram(
    question: Diagram, last: DiagramStage | None, cancelled: Callable[[], bool]
) -> Iterator[DiagramStage]:
    """Stages of the diagram, from ``last`` on; raises `Cancelled`."""
    if last is not None:
        yield last
        if last.share == 1:
            return
    grown = _Growing(question, last if question.direction == "rest" else None, cancelled)
    if question.direction == "rest":
        order = interlaced((COUNT,))
        for chosen in batches(order[~grown.settled[order]]):
            yield grown.run(chosen)
        return
    every = np.arange(COUNT)[:: -1 if question.direction == "down" else 1]
    for stride in (COARSEST, 1):
        start = np.zeros(4)
        for chosen in batches(every[::stride]):
            stage = grown.run(chosen, start, settled=stride == 1)
            start = grown.end[chosen[-1]]
            yield stage


class _Growing:
    """The arrays that stages are copies of."""

    def __init__(self, question: Diagram, last: DiagramStage | None, cancelled: Callable[[], bool]) -> None:
        self.question = question
        self.cancelled = cancelled
        self.settled = np.zeros(COUNT, bool) if last is None else last.settled.copy()
        self.section = np.full((COUNT, SAMPLE, 4), np.nan) if last is None else last.section.copy()
        self.period = np.full(COUNT, np.nan) if last is None else last.period.copy()
        self.impacts = np.full(COUNT, np.nan) if last is None else last.impacts.copy()
        self.ended = np.zeros(COUNT, bool) if last is None else last.ended.copy()
        self.end = np.zeros((COUNT, 4))  # where a neighbour goes on; at rest where a run ended early

    def run(self, chosen: np.ndarray, start: np.ndarray | None = None, *, settled: bool = True) -> DiagramStage:
        """Run some cells, from rest or each from the end of the one before, the first from ``start``."""
        more = {}
        if start is not None:
            more = {"initial": np.tile(start, (len(chosen), 1)), "chain": np.zeros(len(chosen), int)}
        cells = Cells(self.question.system, self.question.axis[chosen], self.question.method, **more)
        found = run_cells(cells, transient=TRANSIENT, sample=SAMPLE, cancelled=self.cancelled)
        self.section[chosen] = found.section
        self.period[chosen] = np.where(found.ok, found.period, np.nan)
        self.impacts[chosen] = found.impacts_per_period
        self.ended[chosen] = ~found.ok
        self.end[chosen] = np.where(found.ok[:, None], found.end, 0.0)
        self.settled[chosen] |= settled
        arrays = self.settled, self.section, self.period, self.impacts, self.ended
        return DiagramStage(self.question, *(array.copy() for array in arrays))
