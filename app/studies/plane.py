"""The K–D plane, growing: the penalty model with its step, and beside it without one. No panel import."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from vibroscope.app.studies.refine import batches, interlaced, nearest
from vibroscope.engine import STATUSES, CellResults, Cells, ExactPenalty, Newmark, Status, System, parts_of, run_cells

COUNT = 64  # cells along each axis
TRANSIENT, SAMPLE = 450, 50
SIDES = ("penalty", "exact")
_DESCRIBED = ("status", "period", "near_period", "impacts_per_period", "longest_contact")
_DIVERGED = STATUSES.index(Status.DIVERGED)


class Plane(NamedTuple):
    """What is asked: the rectangle of K and D, and what holds in all of it."""

    system: System
    eta: float
    steps: int
    located: bool
    errors: bool  # also the error against the reference: it takes several times as long
    K: tuple[float, float]
    D: tuple[float, float]

    def axis(self, name: str) -> np.ndarray:
        """K or D of the cells, evenly spaced in the logarithm from edge to edge: (COUNT,)."""
        low, high = np.log(getattr(self, name))
        return np.exp(low + (np.arange(COUNT) + 0.5) / COUNT * (high - low))

    def ends(self, name: str) -> tuple[float, float]:
        """The first and the last of ``axis``."""
        axis = self.axis(name)
        return float(axis[0]), float(axis[-1])


@dataclass(frozen=True, eq=False)
class PlaneStage:
    """As far as it has come; tables are (COUNT, COUNT), rows over D, columns over K, nan where nothing is known.

    ``known`` says which cells are computed; ``tables[side][name]`` has the names of `CellResults` and ``error``.
    """

    question: Plane
    known: np.ndarray
    tables: dict[str, dict[str, np.ndarray]]

    @property
    def share(self) -> float:
        """Of all cells that are done."""
        return float(self.known.mean())

    def shown(self, side: str, name: str) -> np.ndarray:
        """A table with the coarser cells in place of those that are not known yet; nan where there is none at all."""
        source = nearest(self.known)
        return np.where(source >= 0, self.tables[side][name].ravel()[source], np.nan)

    def diverged(self, side: str) -> np.ndarray:
        """Cells that blew up, (COUNT, COUNT) of bool."""
        return self.shown(side, "status") == _DIVERGED

    def contact_steps(self, side: str) -> np.ndarray:
        """The longest contact in steps of T/n (exact penalty: in what would be steps)."""
        step = 2 * math.pi / self.question.eta / self.question.steps
        return self.shown(side, "longest_contact") / step

    def data(self) -> dict[str, object]:
        """What is known, for a file."""
        asked = self.question
        numbers = {"eta": asked.eta, "steps": asked.steps, "located": asked.located}
        return {**numbers, "K": asked.axis("K"), "D": asked.axis("D"), **self.tables}

    def cell(self, K: float, D: float) -> tuple[int, int] | None:
        """Row and column of the cell that holds K and D; None outside."""
        place = []
        for value, (low, high) in ((D, self.question.D), (K, self.question.K)):
            share = math.log(value / low) / math.log(high / low)
            if not 0 <= share <= 1:
                return None
            place.append(min(int(share * COUNT), COUNT - 1))
        return place[0], place[1]

    def centre(self, place: tuple[int, int]) -> tuple[float, float]:
        """K and D that the numbers shown of a cell were computed with: of the coarser cell while that stands for it."""
        source = int(nearest(self.known)[place])
        row, column = np.unravel_index(source, self.known.shape) if source >= 0 else place
        return float(self.question.axis("K")[column]), float(self.question.axis("D")[row])


def refine_plane(question: Plane, last: PlaneStage | None, cancelled: Callable[[], bool]) -> Iterator[PlaneStage]:
    """Stages of the plane, from ``last`` on; raises `Cancelled`."""
    order = interlaced((COUNT, COUNT))
    known = np.zeros(COUNT * COUNT, bool) if last is None else last.known.ravel().copy()
    names = (*_DESCRIBED, "error") if question.errors else _DESCRIBED
    tables = {
        side: {n: np.full(known.shape, np.nan) if last is None else last.tables[side][n].ravel().copy() for n in names}
        for side in SIDES
    }
    stiffness, damping = (grid.ravel() for grid in np.meshgrid(question.axis("K"), question.axis("D")))
    if known.all():
        yield last
    for chosen in batches(order[~known[order]]):
        for side, found in _run(question, stiffness[chosen], damping[chosen], cancelled).items():
            for name, values in found.items():
                tables[side][name][chosen] = values
        known[chosen] = True
        yield PlaneStage(
            question,
            known.reshape(COUNT, COUNT).copy(),
            {s: {n: t.reshape(COUNT, COUNT).copy() for n, t in own.items()} for s, own in tables.items()},
        )


def _run(question: Plane, stiffness: np.ndarray, damping: np.ndarray, cancelled) -> dict[str, dict[str, np.ndarray]]:
    """Both sides of some cells."""
    eta = np.full(len(stiffness), question.eta)
    methods = Newmark(1.0, 1.0, question.steps, located=question.located), ExactPenalty(1.0, 1.0)
    cells = [Cells(question.system, eta, m, stiffness=stiffness, damping=damping) for m in methods]
    how = {"transient": TRANSIENT, "sample": SAMPLE, "coordinates": (2,), "cancelled": cancelled}
    penalty, exact = (run_cells(own, **how) for own in cells)
    told = {"penalty": _told(penalty), "exact": _told(exact)}
    if question.errors:
        parts = parts_of(question.system, question.eta)
        told["penalty"]["error"] = parts.errors(cells[0], penalty, exact, cancelled=cancelled)[0]
        told["exact"]["error"] = parts.errors(cells[1], exact, exact, cancelled=cancelled)[0]
    return told


def _told(found: CellResults) -> dict[str, np.ndarray]:
    return {name: getattr(found, name).astype(float) for name in _DESCRIBED}
