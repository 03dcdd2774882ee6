"""The K–D plane while it grows: the penalty model with its time step, and beside it without one. No panel import."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from vibroscope.app.runtime.settings import current_settings
from vibroscope.engine import STATUSES, Newmark, Status, System
from vibroscope.engine.sweeps import MISSING, PlaneStudy, RunOptions, grow, nearest_known

COUNT = 64  # cells along each axis
TRANSIENT, SAMPLE = 450, 50
SIDES = {"penalty": "", "exact": "exact_"}  # and how the names of their variables begin
_SHOWN = ("status", "period", "near_period", "impacts_per_period", "longest_contact")
_DIVERGED = STATUSES.index(Status.DIVERGED)


class PlaneQuestion(NamedTuple):
    """A plane to compute: the rectangle of K and D, and what holds in all of it."""

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

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of what is computed on both sides."""
        return (*_SHOWN, "error") if self.errors else _SHOWN

    def study(self) -> PlaneStudy:
        """The study that answers it."""
        K, D = self.axis("K"), self.axis("D")
        method = Newmark(K[0], D[0], self.steps, located=self.located)
        only = tuple(prefix + name for prefix in SIDES.values() for name in self.quantities)
        return PlaneStudy(self.system, method, self.eta, TRANSIENT, SAMPLE, K=K, D=D, only=only)


@dataclass(frozen=True, eq=False)
class PartialPlane:
    """A plane so far: the values of its study, (K, D); as pictures they are (COUNT, COUNT), rows over D."""

    question: PlaneQuestion
    values: dict[str, np.ndarray]

    @cached_property
    def known(self) -> np.ndarray:
        """Which cells are computed."""
        return (self.values["status"] != MISSING).T

    @cached_property
    def tables(self) -> dict[str, dict[str, np.ndarray]]:
        """Each quantity of both sides, nan where nothing is known."""
        return {
            side: {name: self._table(prefix + name) for name in self.question.quantities}
            for side, prefix in SIDES.items()
        }

    def _table(self, name: str) -> np.ndarray:
        return np.where(self.known, self.values[name].T, np.nan)

    @property
    def share(self) -> float:
        """Of all cells that are done."""
        return float(self.known.mean())

    @cached_property
    def _sources(self) -> np.ndarray:
        return nearest_known(self.known)

    def shown(self, side: str, name: str) -> np.ndarray:
        """A table with the coarser cells in place of those that are not known yet; nan where there is none at all."""
        return np.where(self._sources >= 0, self.tables[side][name].ravel()[self._sources], np.nan)

    def diverged(self, side: str) -> np.ndarray:
        """Which cells diverged, of bool."""
        return self.shown(side, "status") == _DIVERGED

    def contact_steps(self, side: str) -> np.ndarray:
        """The longest contact in steps of T/n (exact penalty: in what would be steps)."""
        step = 2 * math.pi / self.question.eta / self.question.steps
        return self.shown(side, "longest_contact") / step

    def data(self) -> dict[str, object]:
        """What is known, for a file."""
        question = self.question
        numbers = {"eta": question.eta, "steps": question.steps, "located": question.located}
        return {**numbers, "K": question.axis("K"), "D": question.axis("D"), **self.tables}

    def cell(self, K: float, D: float) -> tuple[int, int] | None:
        """Row and column of the cell that holds K and D; None outside."""
        place = []
        for value, (low, high) in ((D, self.question.D), (K, self.question.K)):
            if not low <= value <= high:
                return None
            share = math.log(value / low) / math.log(high / low)
            place.append(min(int(share * COUNT), COUNT - 1))
        return place[0], place[1]

    def centre(self, place: tuple[int, int]) -> tuple[float, float]:
        """K and D that the numbers shown of a cell were computed with: of the coarser cell while that stands for it."""
        source = int(self._sources[place])
        row, column = np.unravel_index(source, self.known.shape) if source >= 0 else place
        return float(self.question.axis("K")[column]), float(self.question.axis("D")[row])


def grow_plane(
    question: PlaneQuestion, last: PartialPlane | None, cancelled: Callable[[], bool]
) -> Iterator[PartialPlane]:
    """Partial results of the plane, from ``last`` on; raises `Cancelled`."""
    options = RunOptions(threads=current_settings().threads, cancelled=cancelled)
    for partial in grow(question.study(), options, picture=True, known=last and last.values):
        yield PartialPlane(question, partial.values())
