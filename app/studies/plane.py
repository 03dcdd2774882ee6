"""The K–D plane while it grows: the penalty model with its time step, and beside it without one. No panel import.

If its question says so, the cells whose section does not show what Newmark's motion is are judged once all are computed
(:mod:`engine.sweeps.motion_kinds`): after how many periods does the motion repeat itself, but for the scatter of the
step?
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.method_words import brief_name
from vibroscope.app.runtime.settings import current_settings
from vibroscope.app.studies.bifurcation import coarse_to_fine, kind_names
from vibroscope.app.studies.study_job import RESULTS
from vibroscope.engine import STATUSES, Newmark, Status, System, TimeStepping
from vibroscope.engine.arguments import Poll
from vibroscope.engine.sweeps import (
    MISSING,
    CellKind,
    PlaneStudy,
    RunOptions,
    grow_kinds,
    grow_picture,
    nearest_known,
    unknown_kinds,
)

COUNT = 64  # cells along each axis
TRANSIENT, SAMPLE = 450, 50
SIDES = {"penalty": "", "exact": "exact_"}  # and how the names of their variables begin
_SHOWN = ("status", "period", "near_period", "impacts_per_period", "longest_contact")
_WITHOUT_SOLUTION = "steps_without_solution"
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
    judged: bool = False  # also what each motion of Newmark's is without the scatter of the step
    other: TimeStepping | None = None  # another penalty solution than Newmark's

    def axis(self, name: str) -> np.ndarray:
        """K or D of the cells, evenly spaced in the logarithm from edge to edge: (COUNT,)."""
        low, high = np.log(getattr(self, name))
        return np.exp(low + (np.arange(COUNT) + 0.5) / COUNT * (high - low))

    def ends(self, name: str) -> tuple[float, float]:
        """The first and the last of ``axis``."""
        axis = self.axis(name)
        return float(axis[0]), float(axis[-1])

    @property
    def name(self) -> str:
        """The penalty solution in a title."""
        return "Newmark" if self.other is None else brief_name(self.other)

    @property
    def counted(self) -> bool:
        """Whether a step may have no solution, since its contact status is that of its end."""
        return self.other is not None and self.other.status == "end"

    def quantities(self, side: str) -> tuple[str, ...]:
        """Names of what is computed on a side."""
        names = (*_SHOWN, "error") if self.errors else _SHOWN
        return (*names, _WITHOUT_SOLUTION) if side == "penalty" and self.counted else names

    def study(self) -> PlaneStudy:
        """The study that answers it."""
        K, D = self.axis("K"), self.axis("D")
        method = Newmark(K[0], D[0], self.steps, located=self.located)
        if self.other is not None:
            method = replace(self.other, stiffness=K[0], damping=D[0])
        only = tuple(prefix + name for side, prefix in SIDES.items() for name in self.quantities(side))
        only += ("end",)  # from which a motion is judged
        return PlaneStudy(self.system, method, self.eta, transient=TRANSIENT, sample=SAMPLE, K=K, D=D, only=only)


@dataclass(frozen=True, eq=False)
class PartialPlane:
    """A plane so far: the values of its study, (K, D); as pictures they are (COUNT, COUNT), rows over D."""

    question: PlaneQuestion
    values: dict[str, np.ndarray]
    judged: dict[str, np.ndarray] | None = None  # (cells,) in the order of the pictures

    @cached_property
    def known(self) -> np.ndarray:
        """Whether each cell is computed."""
        return (self.values["status"] != MISSING).T

    @cached_property
    def tables(self) -> dict[str, dict[str, np.ndarray]]:
        """Each quantity of both sides, nan where nothing is known."""
        return {
            side: {name: self._table(prefix + name) for name in self.question.quantities(side)}
            for side, prefix in SIDES.items()
        }

    def _table(self, name: str) -> np.ndarray:
        return np.where(self.known, self.values[name].T, np.nan)

    @property
    def share(self) -> float:
        """The share of the cells that are computed; if kinds are asked for, its mean with the share of cells judged."""
        computed = float(self.known.mean())
        return 0.5 * (computed + self._judged.mean()) if self.question.judged else computed

    @cached_property
    def kinds(self) -> dict[str, np.ndarray]:
        """Kind of Newmark's motion in each cell as far as it is known: see `engine.sweeps.motion_kinds.KIND_VARIABLES`.

        A motion that repeats itself as that without a time step does is plain; so is one with the excitation's period.
        """
        found = unknown_kinds(self.known.size) if self.judged is None else self.judged
        found = {name: column.reshape(self.known.shape).copy() for name, column in found.items()}
        status, own, exact = (self._table(name) for name in ("status", "period", "exact_period"))
        plain = (status == 0) & ((own == 1) | ((own == exact) & (own > 0)))
        found["kind"][plain], found["kind_period"][plain] = CellKind.PERIODIC, own[plain]
        found["kind"][self.known & (status != 0)] = CellKind.ENDED_EARLY
        return found

    @cached_property
    def _judged(self) -> np.ndarray:
        return self.known & (self.kinds["kind"] != CellKind.UNKNOWN)

    @property
    def open_cells(self) -> np.ndarray:
        """The computed cells whose kind is not known yet, from coarse to fine, in the order of the pictures."""
        return coarse_to_fine(self.known & ~self._judged)

    @cached_property
    def has_errors(self) -> bool:
        """Whether any cell has an error so far: where the reference does not repeat itself, none has."""
        return self.question.errors and bool(np.isfinite(self.tables["penalty"]["error"]).any())

    def true_period(self, side: str) -> np.ndarray:
        """Periods after which the motion repeats itself but for the scatter of the step; nan where it is not known."""
        if side == "exact":
            return self.shown(side, "period")
        sources = nearest_known(self._judged)
        return np.where(sources >= 0, self.kinds["kind_period"].ravel()[sources].astype(float), np.nan)

    @cached_property
    def _sources(self) -> np.ndarray:
        return nearest_known(self.known)

    def shown(self, side: str, name: str) -> np.ndarray:
        """A table with the coarser cells in place of those that are not known yet; nan where there is none at all."""
        return np.where(self._sources >= 0, self.tables[side][name].ravel()[self._sources], np.nan)

    def diverged(self, side: str) -> np.ndarray:
        """Whether each cell diverged."""
        return self.shown(side, "status") == _DIVERGED

    def contact_steps(self, side: str) -> np.ndarray:
        """The longest contact in steps of T/n (exact penalty: in what would be steps)."""
        step = 2 * math.pi / self.question.eta / self.question.steps
        return self.shown(side, "longest_contact") / step

    def steps_without_solution(self, side: str) -> np.ndarray:
        """Steps of the run in which neither contact status agrees with the step's end; nan where that cannot be."""
        if _WITHOUT_SOLUTION in self.tables[side]:
            return self.shown(side, _WITHOUT_SOLUTION)
        return np.full(self.known.shape, np.nan)

    def data(self) -> dict[str, object]:
        """The results so far, for a file."""
        question = self.question
        numbers = {"eta": question.eta, "steps": question.steps, "located": question.located}
        return {
            **numbers,
            "K": question.axis("K"),
            "D": question.axis("D"),
            **{side: self.columns(side) for side in SIDES},
        }

    def columns(self, side: str) -> dict[str, np.ndarray]:
        """The tables of a side, with the kinds of motion if they are asked for."""
        if side == "exact" or not self.question.judged:
            return self.tables[side]
        kind, period = kind_names(self.kinds["kind"].ravel()), self.kinds["kind_period"]
        return self.tables[side] | {"kind": kind.reshape(period.shape), "period_without_scatter": period}

    def cell(self, K: float, D: float) -> tuple[int, int] | None:
        """Row and column of the cell that holds K and D; None outside."""
        place = []
        for value, (low, high) in ((D, self.question.D), (K, self.question.K)):
            if not low <= value <= high:
                return None
            share = math.log(value / low) / math.log(high / low)
            place.append(min(int(share * COUNT), COUNT - 1))
        return place[0], place[1]

    def source(self, place: tuple[int, int]) -> int:
        """Flat index of the cell whose numbers are shown: that of a coarser cell until this one is computed."""
        source = int(self._sources[place])
        return source if source >= 0 else int(np.ravel_multi_index(place, self.known.shape))

    def centre(self, place: tuple[int, int]) -> tuple[float, float]:
        """K and D that the numbers shown of a cell were computed with: of the coarser cell while that stands for it."""
        row, column = np.unravel_index(self.source(place), self.known.shape)
        return float(self.question.axis("K")[column]), float(self.question.axis("D")[row])


def grow_plane(question: PlaneQuestion, last: PartialPlane | None, cancelled: Poll) -> Iterator[PartialPlane]:
    """Partial results of the plane, from ``last`` on; raises `Cancelled`."""
    options = RunOptions(threads=current_settings().threads, cancelled=cancelled)
    if last is None and question.judged:
        last = RESULTS.get(question._replace(judged=False))
    judged = last and last.judged
    study = question.study()
    for values in grow_picture(study, options, last and last.values):
        result = PartialPlane(question, values, judged)
        yield result
    if not question.judged:
        return

    def in_study(places: np.ndarray) -> np.ndarray:
        return np.ravel_multi_index(np.unravel_index(places, result.known.shape)[::-1], study.shape)

    how = {"threads": options.threads, "cancelled": cancelled}
    for kinds in grow_kinds(study, result.values, result.open_cells, result.judged, in_study, **how):
        yield replace(result, judged=kinds)
