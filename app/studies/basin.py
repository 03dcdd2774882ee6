"""Basins of attraction while they grow: of the reference, and beside it of the penalty model. No panel import."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.state import SOLVERS
from vibroscope.app.runtime.settings import current_settings
from vibroscope.app.studies.cell_classes import DIVERGED, NO_NUMBER, SPECIAL, UNKNOWN
from vibroscope.engine import Method, Reference, System
from vibroscope.engine.arguments import Poll
from vibroscope.engine.sweeps import (
    COORDINATES,
    KIND_FLAGS,
    MISSING,
    BasinDifference,
    BasinStudy,
    RunOptions,
    StartPlane,
    difference_of,
    grow_picture,
    nearest_known,
)
from vibroscope.engine.sweeps.basin_motions import ENDED, PHASE

COUNT, SLOW_COUNT = 96, 24  # cells along each axis; of a method whose cells are run one by one
TRANSIENT, SAMPLE = 1800, 256
PLANES = {  # of starts, by their name in a link
    "xi2-v2": ("xi2", "v2"),
    "xi1-v1": ("xi1", "v1"),
    "v1-v2": ("v1", "v2"),
    "xi1-xi2": ("xi1", "xi2"),
    **{f"phase-{name}": (PHASE, name) for name in COORDINATES},
}
AT_WALL = ("xi1-v1", "phase-xi1", "phase-v1")  # those there
# None of them has a counterpart in `theme.js`: the key has the same in light and dark.
COLOURS = ("#88CCEE", "#E69F00", "#117733", "#CC6677", "#F0E442", "#661100", "#332288", "#44AA99")
FURTHER = "#4D4D4D"  # motions beyond these
PALETTE = [*SPECIAL, *COLOURS, FURTHER]
_FIRST = len(SPECIAL)


class BasinQuestion(NamedTuple):
    """A plane of starts for two solvers."""

    system: System
    eta: float
    reference: Reference
    penalty: Method
    axes: tuple[str, str]
    x: tuple[float, float]  # edges of the plane
    y: tuple[float, float]
    start: tuple[float, float, float, float]  # ξ₁, ξ₁′, ξ₂, ξ₂′ at the phase 0, or that of an axis; 0 on the axes

    @property
    def count(self) -> int:
        """Cells along each axis."""
        slow = self.penalty.has_choices or not self.penalty.linear
        return SLOW_COUNT if slow else COUNT

    def method(self, side: str) -> Method:
        """The solver of a side."""
        return self.reference if side == "reference" else self.penalty

    def ends(self, name: str) -> tuple[float, float]:
        """The first and the last value of the cells along "x" or "y"."""
        low, high = getattr(self, name)
        half = 0.5 * (high - low) / self.count
        return low + half, high - half

    def axis(self, name: str) -> np.ndarray:
        """The values of the cells along "x" or "y", (count,)."""
        return np.linspace(*self.ends(name), self.count)

    def study(self, side: str) -> BasinStudy:
        """The study of a side."""
        x, y = self.axis("x"), self.axis("y")
        plane = StartPlane(self.axes, (self.ends("x"), self.ends("y")), self.start)
        method = self.method(side)
        return BasinStudy(self.system, method, self.eta, transient=TRANSIENT, sample=SAMPLE, plane=plane, x=x, y=y)


class FoundMotion(NamedTuple):
    """A motion of one side or of both."""

    name: str
    period: int
    shares: Mapping[str, float]  # of the starts, by side; one that is not there does not have it
    errors: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class PartialBasin:
    """Both basins so far; as pictures they are (count, count), rows over y."""

    question: BasinQuestion
    values: Mapping[str, dict[str, np.ndarray]]  # by side

    @cached_property
    def known(self) -> dict[str, np.ndarray]:
        """Whether each cell is computed."""
        return {side: (self.values[side]["status"] != MISSING).T for side in SOLVERS}

    @property
    def share(self) -> float:
        """The share of the cells that are computed."""
        return float(np.mean([self.known[side].mean() for side in SOLVERS]))

    @cached_property
    def concluded(self) -> dict[str, dict[str, np.ndarray]]:
        """The conclusions of each study, by name."""
        return {
            side: {
                name: np.asarray(each.values) for name, each in self.question.study(side).conclusions(values).items()
            }
            for side, values in self.values.items()
        }

    @cached_property
    def difference(self) -> BasinDifference:
        """The cells in which both solvers end on different motions."""
        return difference_of(*(self.concluded[side] for side in SOLVERS))

    @cached_property
    def numbers(self) -> dict[str, np.ndarray]:
        """For each motion of a side its place among all motions: those of the reference, then others of the penalty."""
        same = self.difference.same
        further, penalty = len(same), np.zeros(same.shape[1], int)
        for k, alike in enumerate(same.T):
            penalty[k] = np.argmax(alike) if alike.any() else further
            further += not alike.any()
        return {"reference": np.arange(len(same)), "penalty": penalty}

    @cached_property
    def motions(self) -> list[FoundMotion]:
        """All motions, in the order of `numbers`."""
        total = max((int(numbers.max()) + 1 for numbers in self.numbers.values() if len(numbers)), default=0)
        rows = [FoundMotion("", 0, {}, {}) for _ in range(total)]
        for side, numbers in self.numbers.items():
            found = self.concluded[side]
            for k, number in enumerate(numbers.tolist()):
                period = int(found["motion_period"][k])
                kind = f"period {period}" if period else kind_name(int(found["motion_kind"][k]))
                shares = {**rows[number].shares}
                shares[side] = shares.get(side, 0.0) + float(found["motion_share"][k])
                errors = {**rows[number].errors, side: float(found["motion_share_error"][k])}
                name = rows[number].name or f"motion {number + 1} ({kind})"
                rows[number] = FoundMotion(name, period, shares, errors)
        return rows

    @cached_property
    def cells(self) -> dict[str, np.ndarray]:
        """The motion of each cell as its place in `motions`, or a negative number of the engine."""
        found = {}
        for side, concluded in self.concluded.items():
            motion, numbers = concluded["motion"].T, np.append(self.numbers[side], 0)
            found[side] = np.where(motion >= 0, numbers[np.maximum(motion, -1)], motion)
        return found

    def shown(self, side: str) -> np.ndarray:
        """The motion of each cell, that of a coarser cell where it is not yet known; MISSING where there is none."""
        sources = nearest_known(self.known[side])
        return np.where(sources >= 0, self.cells[side].ravel()[sources], MISSING)

    def image(self, side: str) -> np.ndarray:
        """Index into `PALETTE` of each cell, uint8."""
        motion = self.shown(side)
        found = _FIRST + np.minimum(motion, len(COLOURS))
        found = np.where(motion == MISSING, UNKNOWN, found)
        found = np.where(motion == ENDED, DIVERGED, found)
        return np.where(motion < ENDED, NO_NUMBER, found).astype(np.uint8)

    def periods(self, side: str) -> np.ndarray:
        """The period of the motion of each cell, 0 where it does not repeat itself or there is none: int32."""
        motion = self.shown(side)
        periods = np.array([each.period for each in self.motions] + [0], np.int32)
        return np.where(motion >= 0, periods[np.maximum(motion, -1)], 0).astype(np.int32)

    def cell(self, x: float, y: float) -> tuple[int, int] | None:
        """Row and column of the cell that holds a start; None outside."""
        place = []
        for value, (low, high) in ((y, self.question.y), (x, self.question.x)):
            if not low <= value <= high:
                return None
            place.append(min(int((value - low) / (high - low) * self.question.count), self.question.count - 1))
        return place[0], place[1]

    def columns(self, side: str) -> dict[str, np.ndarray]:
        """A row for each cell that is known: the start, its motion and the period of that."""
        question = self.question
        grid = np.meshgrid(question.axis("x"), question.axis("y"))
        known = self.known[side]
        found = dict(zip(question.axes, (values[known] for values in grid), strict=True))
        found |= {name: self.values[side][name].T[known] for name in ("reached_period", "periods")}
        return found | {"motion": self.cells[side][known]}

    def data(self) -> dict[str, object]:
        """The results so far, for a file."""
        question = self.question
        found: dict[str, object] = {"eta": question.eta, "start": dict(zip(COORDINATES, question.start, strict=True))}
        found |= {side: self.columns(side) for side in SOLVERS}
        found["motions"] = {
            "name": np.array([each.name for each in self.motions]),
            "period": np.array([each.period for each in self.motions]),
            **{f"share_{side}": np.array([each.shares.get(side, 0.0) for each in self.motions]) for side in SOLVERS},
        }
        return found | {"share_different": self.difference.share, "share_different_error": self.difference.error}


def kind_name(number: int) -> str:
    """The name of a kind of motion by its number in a result."""
    return next(name for name, each in KIND_FLAGS.items() if each == number)


def grow_basin(question: BasinQuestion, last: PartialBasin | None, cancelled: Poll) -> Iterator[PartialBasin]:
    """Partial results of both basins in turns, from ``last`` on; raises `Cancelled`."""
    options = RunOptions(threads=current_settings().threads, cancelled=cancelled)
    values = dict(last.values) if last else {}
    growing = {side: grow_picture(question.study(side), options, values.get(side)) for side in SOLVERS}
    while growing:
        for side in list(growing):
            found = next(growing[side], None)
            if found is None:
                del growing[side]
                continue
            values[side] = found
            if len(values) == len(SOLVERS):
                yield PartialBasin(question, dict(values))
