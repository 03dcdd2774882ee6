"""The bifurcation diagram while it grows. No panel import.

From rest its cells come in a coarse-to-fine order. A continued diagram has no coarse picture that could be refined: how
far a motion can be followed depends on how far apart the cells are. So a coarse study is run from end to end for a
preview, and then the study itself. Once a diagram is complete, the cells that do not repeat themselves are judged
(:mod:`engine.sweeps.motion_kinds`): is it chaos, a torus, or an artefact of the time step?

The bifurcation diagram as a picture of counts: drawn as circles, so many points would be slow to move.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from vibroscope.app.runtime.settings import current_settings
from vibroscope.engine import COORDINATES, Kind, Method, System
from vibroscope.engine.arguments import Poll
from vibroscope.engine.sweeps import (
    COARSEST,
    MISSING,
    CellKind,
    EtaStudy,
    RunOptions,
    empty_values,
    grow,
    grow_kinds,
    grow_picture,
    kind_words,
    known_kinds,
)


def raster(
    eta: np.ndarray,
    values: np.ndarray,
    x_range: tuple[float, float],
    y_range: tuple[float, float],
    width: int,
    height: int,
) -> np.ndarray:
    """Shades 0–255 of ``values`` (n, keep) over ``eta`` (n,), row 0 at the bottom.

    Each column of the picture is scaled by its own number of points: a period-one
    line and a chaotic band of as many points are both plain to see. When zoomed
    so far that a column would hold no η at all, columns widen to one η each.
    """
    low, high = x_range
    seen = (eta >= low) & (eta <= high)
    picture = np.zeros((height, width), np.uint8)
    if not seen.any():
        return picture
    columns = min(width, max(1, int(seen.sum())))
    counts = _counts(eta[seen], values[seen], x_range, y_range, columns, height)
    shades = _shade(counts)
    return _thicken(shades[:, np.arange(width) * columns // width])


def _thicken(shades: np.ndarray) -> np.ndarray:
    """Make every point two pixels high and wide: a line of one pixel is hard to see beside the grid."""
    thick = shades.copy()
    thick[1:] = np.maximum(thick[1:], shades[:-1])
    thick[:, 1:] = np.maximum(thick[:, 1:], thick[:, :-1])
    return thick


def _counts(eta, values, x_range, y_range, columns, height) -> np.ndarray:
    column = _bin(eta, *x_range, columns)
    inside = (values >= y_range[0]) & (values <= y_range[1])
    row = _bin(values, *y_range, height)
    flat = row * columns + column[:, None]
    return np.bincount(flat[inside], minlength=height * columns).reshape(height, columns)


def _bin(values: np.ndarray, low: float, high: float, count: int) -> np.ndarray:
    with np.errstate(invalid="ignore"):  # a diverged point is NaN, falls outside and is not counted
        return np.clip((values - low) / (high - low) * count, 0, count - 1).astype(np.intp)


def _shade(counts: np.ndarray) -> np.ndarray:
    # Square root: single points stay visible beside lines that hold all 50.
    share = counts / np.maximum(counts.max(axis=0, keepdims=True), 1)
    shades = np.where(counts > 0, 70 + 185 * np.sqrt(share), 0)
    return shades.astype(np.uint8)


COUNT = 480  # values of the swept number, unless another count is typed
TRANSIENT, SAMPLE = 1000, 48
# What one update sends is bounded: so many points are drawn at most, and so many of what it is compared with.
MOST_POINTS, MOST_BESIDE = 3400, 1000
_EQUAL = 1e-5  # points nearer than this share of the picture's height are one


class DiagramQuestion(NamedTuple):
    """A diagram to compute: ``over`` is swept from end to end of ``span``; ``eta`` holds where it is not swept."""

    system: System
    method: Method
    direction: str
    span: tuple[float, float]
    over: str = "eta"
    eta: float = 1.0
    count: int = COUNT
    transient: int = TRANSIENT
    initial: tuple[float, float, float, float] | None = None  # rest

    @property
    def axis(self) -> np.ndarray:
        """The swept number of the cells, ascending; of whole numbers each once."""
        values = np.linspace(*self.span, self.count)
        return np.unique(np.round(values)) if self.over == "steps" else values

    def study(self) -> EtaStudy:
        """The study that answers it."""
        values = self.axis
        choices = {"values": values, "direction": self.direction, "coordinates": COORDINATES, "over": self.over}
        if self.initial is not None:
            choices["initial"] = np.tile(self.initial, (len(values), 1))
        return EtaStudy(self.system, self.method, self.eta, transient=self.transient, sample=SAMPLE, **choices)

    @property
    def preview_cells(self) -> np.ndarray:
        """The cells of the preview of a continued diagram, ascending, from the one that comes first."""
        return np.sort(np.arange(len(self.axis))[:: -COARSEST if self.direction == "down" else COARSEST])


@dataclass(frozen=True, eq=False)
class PartialDiagram:
    """A diagram so far: the values of its study, those of the preview of a continued one, and the judged kinds."""

    question: DiagramQuestion
    values: dict[str, np.ndarray]
    preview: dict[str, np.ndarray] | None = None
    judged: dict[str, np.ndarray] | None = None

    @property
    def computed(self) -> float:
        """Share of all cells that are computed; a preview does not count."""
        return float((self.values["status"] != MISSING).mean())

    @property
    def share(self) -> float:
        """The mean of the shares of cells computed and of cells judged; a preview does not count."""
        computed = self.values["status"] != MISSING
        return float(0.5 * (self.computed + (computed & (self.kinds["kind"] != CellKind.UNKNOWN)).mean()))

    @cached_property
    def _shown(self) -> dict[str, np.ndarray]:
        """The values, those of the preview where no others are known."""
        if self.preview is None:
            return self.values
        shown = {name: array.copy() for name, array in self.values.items()}
        cells = self.question.preview_cells
        missing = shown["status"][cells] == MISSING
        for name, array in self.preview.items():
            shown[name][cells[missing]] = array[missing]
        return shown

    @property
    def known(self) -> np.ndarray:
        """Whether each cell is computed, in the study or in its preview: (n,) of bool."""
        return self._shown["status"] != MISSING

    @property
    def ended(self) -> np.ndarray:
        """Whether each cell ended early: (n,) of bool."""
        return self.known & (self._shown["status"] != 0)

    @property
    def period(self) -> np.ndarray:
        """Period of the motion, (n,): 0 if it does not repeat itself, nan where none is known."""
        return np.where(self.known & ~self.ended, self._shown["period"], np.nan)

    @cached_property
    def kinds(self) -> dict[str, np.ndarray]:
        """Kind of motion of each cell as far as it is known: see `engine.sweeps.motion_kinds.KIND_VARIABLES`."""
        found = known_kinds(self._shown["status"], self._shown["period"])
        for name, array in (self.judged or {}).items():
            found[name] = np.where(self.judged["kind"] != CellKind.UNKNOWN, array, found[name])
        return found

    @property
    def open_cells(self) -> np.ndarray:
        """The computed cells whose kind is not known yet, from coarse to fine."""
        return coarse_to_fine((self.kinds["kind"] == CellKind.UNKNOWN) & self.known)

    @property
    def impacts(self) -> np.ndarray:
        """Impacts per period, (n,), nan where nothing is known."""
        return self._shown["impacts_per_period"]

    def section(self, coordinate: str) -> np.ndarray:
        """A coordinate at τ ≡ 0 mod T, (n, SAMPLE), nan where nothing is known."""
        return self._shown[coordinate]

    def section_of(self, index: int) -> np.ndarray:
        """All coordinates of the section of a cell, (SAMPLE, 4)."""
        return np.stack([self.section(name)[index] for name in COORDINATES], axis=1)

    def motion_words(self, index: int) -> str:
        """The motion of a cell; by its section alone where it is not judged."""
        period, near = (int(self._shown[name][index]) for name in ("period", "near_period"))
        kind = CellKind(self.kinds["kind"][index])
        if kind is not CellKind.UNKNOWN:
            period = int(self.kinds["kind_period"][index])
        return kind_words(kind, period, near, self.section_of(index), self.question.system.observed_body)

    def points(
        self, coordinate: str, most: int | None = MOST_POINTS, artefacts: bool | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """The swept number and the coordinate at τ ≡ 0 mod T, each motion's points once; at most so many (None: all).

        ``artefacts`` chooses the cells whose scatter the time step causes, or (False) the others.
        """
        of_kind = None if artefacts is None else (self.kinds["kind"] == CellKind.ARTEFACT) == artefacts
        return points_of(self.question.axis, self.section(coordinate), most, of_kind)

    def data(self) -> dict[str, object]:
        """The results so far, for a file."""
        return {
            "direction": self.question.direction,
            self.question.over: self.question.axis[self.known],
            "period": self.period[self.known],
            "kind": kind_names(self.kinds["kind"][self.known]),
            "period_without_scatter": self.kinds["kind_period"][self.known],
            "lyapunov": self.kinds["lyapunov"][self.known],
            "lyapunov_error": self.kinds["lyapunov_error"][self.known],
            "impacts_per_period": self.impacts[self.known],
            **{name: self.section(name)[self.known] for name in COORDINATES},
        }

    def stretches(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Intervals with one kind of motion and one period: left, right, period without scatter, `CellKind`."""
        known = np.flatnonzero(self.known)
        at = self.question.axis[known]
        edges = np.concatenate([at[:1], 0.5 * (at[1:] + at[:-1]), at[-1:]])
        kind, period = self.kinds["kind"][known], self.kinds["kind_period"][known]
        changes = (np.diff(kind, prepend=kind[:1] - 1) != 0) | (np.diff(period, prepend=period[:1] - 1) != 0)
        begin = np.flatnonzero(changes)
        return edges[begin], np.append(edges[begin[1:]], edges[-1:]), period[begin], kind[begin]


def points_of(
    axis: np.ndarray, section: np.ndarray, most: int | None = MOST_POINTS, of_kind: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """A swept number (n,) and a section (n, keep), each motion's points once: thinned, then of some cells."""
    values = np.sort(section, axis=1)
    height = np.nanmax(values, initial=-np.inf) - np.nanmin(values, initial=np.inf)
    distinct = np.isfinite(values)
    distinct[:, 1:] &= np.diff(values, axis=1) > _EQUAL * height
    chosen = distinct if most is None else _thinned(distinct, most)
    if of_kind is not None:
        chosen &= of_kind[:, None]
    row, column = np.nonzero(chosen)
    return axis[row], values[row, column]


def coarse_to_fine(chosen: np.ndarray) -> np.ndarray:
    """Indices of the chosen cells of a flattened grid: first those of its coarsest grid, then of finer ones."""
    either = np.bitwise_or.reduce(np.nonzero(chosen))
    stride = np.where(either == 0, len(chosen), either & -either)
    return np.flatnonzero(chosen)[np.argsort(-stride, kind="stable")]


def kind_names(kinds: np.ndarray) -> np.ndarray:
    """`CellKind` as words for files: "chaotic", "step artefact"."""
    names = {Kind.ARTEFACT: "step artefact", Kind.ENDED_EARLY: "ended early"}
    found = (Kind[CellKind(number).name] for number in kinds.tolist())
    return np.array([names.get(kind, str(kind)) for kind in found])


def _thinned(chosen: np.ndarray, most: int) -> np.ndarray:
    """At most so many of the chosen entries: as many of each row as all rows can have, evenly out of it."""
    count = chosen.sum(axis=1)
    quota = next((q for q in range(chosen.shape[1], 1, -1) if np.minimum(count, q).sum() <= most), 1)
    rank = np.cumsum(chosen, axis=1)
    share = np.minimum(quota / np.maximum(count, 1), 1.0)[:, None]
    return chosen & (np.floor(rank * share + 1e-9) > np.floor((rank - 1) * share + 1e-9))


def grow_diagram(question: DiagramQuestion, last: PartialDiagram | None, cancelled: Poll) -> Iterator[PartialDiagram]:
    """Partial results of the diagram, from ``last`` on; raises `Cancelled`."""
    study = question.study()
    options = RunOptions(threads=current_settings().threads, cancelled=cancelled)
    values, preview, judged = (last.values, last.preview, last.judged) if last else (empty_values(study), None, None)
    if study.sequential:
        coarse = replace(study, values=study.values[question.preview_cells])
        for partial in grow(coarse, options, picture=True, known=preview):
            preview = partial.values()
            yield PartialDiagram(question, values, preview, judged)
    for found in grow_picture(study, options, values):
        result = PartialDiagram(question, found, preview, judged)
        yield result
    how = {"threads": options.threads, "cancelled": cancelled}
    for kinds in grow_kinds(study, result.values, result.open_cells, result.judged, **how):
        yield replace(result, judged=kinds)
