"""Branches of periodic motions over the cloud: stable ones solid, unstable ones dashed, points marked by their kind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from bokeh.core.property.descriptors import UnsetValueError
from bokeh.models import HoverTool, Line, Scatter
from bokeh.plotting import figure
from vibroscope.app.explorer.field_units import ShownField
from vibroscope.app.page.shared.figure import BLUE, INK, VERMILLION, add_glyph, empty_source, write
from vibroscope.app.page.shared.stability import point_multiplier
from vibroscope.app.studies.branches import BIFURCATIONS, PartialBranches
from vibroscope.engine import COORDINATES, POINT_KINDS, Branch

_LOOKS = {
    "reference": {"line_color": BLUE, "line_width": 2.4},
    "penalty": {"line_color": VERMILLION, "line_width": 1.5},
}
_DASHES = {"stable": "solid", "unstable": [5, 4]}
_POINT_COLUMNS = ("eta", "value", "marker", "size", "kind", "where", "period", "multiplier")
_RESOLUTION = 5e-4  # of the picture's width or height: a line is drawn as exactly
_USUAL = (800, 450)  # px
_NEAR_POINT, _NEAR_LINE = 9, 11  # px within which a tap means it


class Place(NamedTuple):
    """An orbit of a branch, or a point on it: solver, number of the branch, "orbit" or "point", number there."""

    solver: str
    branch: int
    kind: str
    number: int

    @property
    def name(self) -> str:
        """As `place_named` reads it."""
        return ":".join(map(str, self))


def place_named(text: object) -> Place | None:
    """The place that a message names; None if it names none."""
    parts = text.split(":") if isinstance(text, str) and len(text) < 60 else []
    if len(parts) != 4 or parts[2] not in ("orbit", "point") or not (parts[1] + parts[3]).isdecimal():
        return None
    return Place(parts[0], int(parts[1]), parts[2], int(parts[3]))


class BranchLines:
    """The glyphs in the figure of the diagram."""

    def __init__(self, plot: figure) -> None:
        self._plot = plot
        self._drawn: tuple = ()
        self._results: Mapping[str, PartialBranches] = {}
        self._column = 0
        self.lines = {
            (solver, kind): empty_source(f"branches_{solver}_{kind}", "eta", "value")
            for solver in _LOOKS
            for kind in _DASHES
        }
        for (solver, kind), source in self.lines.items():
            add_glyph(plot, Line(x="eta", y="value", line_dash=_DASHES[kind], **_LOOKS[solver]), source)
        self.points = {solver: empty_source(f"branch_points_{solver}", *_POINT_COLUMNS) for solver in _LOOKS}
        marks = [
            add_glyph(
                plot,
                Scatter(
                    x="eta",
                    y="value",
                    marker="marker",
                    size="size",
                    fill_color="#FFFFFF",
                    line_color=INK if solver == "reference" else _LOOKS[solver]["line_color"],
                    line_width=1.3,
                ),
                source,
            )
            for solver, source in self.points.items()
        ]
        rows = [("point", "@kind"), ("at", "@where"), ("period", "@period"), ("multiplier", "@multiplier")]
        plot.add_tools(HoverTool(renderers=marks, tooltips=rows))

    def update(self, results: Mapping[str, PartialBranches], coordinate: str, field: ShownField) -> None:
        """Draw the branches of each solver, with values as ``field`` shows the number that varies."""
        branches = tuple((solver, *map(id, result.branches)) for solver, result in results.items())
        if (branches, coordinate, field) == self._drawn:
            return
        self._drawn = branches, coordinate, field
        self._results, self._column = dict(results), COORDINATES.index(coordinate)
        for (solver, kind), source in self.lines.items():
            branches = results[solver].branches if solver in results else ()
            write(source, _line_columns(branches, self._column, stable=kind == "stable"))
        for solver, source in self.points.items():
            columns = _point_columns(results[solver], self._column, field) if solver in results else {}
            source.data = {name: columns.get(name, []) for name in _POINT_COLUMNS}

    @property
    def values(self) -> list[np.ndarray]:
        """The values of the coordinate that are drawn."""
        return [source.data["value"] for source in self.lines.values()]

    def at(self, x: float, y: float) -> Place | None:
        """The point or the orbit that a tap at (x, y) means; None if it is near neither."""
        ends = [(axis.start, axis.end) for axis in (self._plot.x_range, self._plot.y_range)]
        scale = np.array([size / (high - low) for size, (low, high) in zip(self._pixels, ends, strict=True)])
        tap, best, near = np.array([x, y]) * scale, None, _NEAR_POINT
        for solver, result in self._results.items():
            for number, branch in enumerate(result.branches):
                for k, point in enumerate(branch.points):
                    far = np.hypot(*(np.array([point.value, point.state[self._column]]) * scale - tap))
                    if far < near:
                        best, near = Place(solver, number, "point", k), far
        if best is not None:
            return best
        near = _NEAR_LINE
        for solver, result in self._results.items():
            for number, branch in enumerate(result.branches):
                for j in range(branch.sections.shape[1]):
                    line = np.stack([branch.values, branch.sections[:, j, self._column]], axis=1) * scale
                    k, far = _nearest(line, tap)
                    if far < near:
                        best, near = Place(solver, number, "orbit", k), far
        return best

    @property
    def _pixels(self) -> tuple[int, int]:
        """Width and height of the frame; of a usual one until the browser has drawn it."""
        try:
            return self._plot.inner_width, self._plot.inner_height
        except UnsetValueError:
            return _USUAL


def _line_columns(branches: tuple[Branch, ...], column: int, *, stable: bool) -> dict[str, np.ndarray]:
    """All lines of one kind, with gaps between them, as exact as can be seen."""
    if not branches:
        return dict.fromkeys(("eta", "value"), np.empty(0, np.float32))
    sections = np.concatenate([branch.sections[..., column].ravel() for branch in branches])
    values = np.concatenate([branch.values for branch in branches])
    size = np.array([np.ptp(values) or 1.0, np.ptp(sections) or 1.0])
    parts = []
    for branch in branches:
        for j in range(branch.sections.shape[1]):
            line = np.stack([branch.values, branch.sections[:, j, column]], axis=1)
            for begin, end in stretches(branch.stable, stable):
                parts += [line[begin:end][thinned(line[begin:end] / size)], np.full((1, 2), np.nan)]
    drawn = np.concatenate([*parts, np.full((1, 2), np.nan)]).astype(np.float32)
    return {"eta": drawn[:, 0], "value": drawn[:, 1]}


def stretches(is_stable: np.ndarray, stable: bool) -> list[tuple[int, int]]:
    """First orbit and the one behind the last of each stretch of a branch that is stable, or is not.

    Between a stable orbit and an unstable one the branch is drawn as unstable, so that it has no gaps.
    """
    both = is_stable[:-1] & is_stable[1:]
    chosen = np.concatenate([[False], both == stable, [False]])
    edges = np.flatnonzero(np.diff(chosen.astype(int)))
    return [(int(begin), int(end) + 1) for begin, end in edges.reshape(-1, 2)]


def thinned(line: np.ndarray) -> np.ndarray:
    """Indices of (n, 2) vertices that are enough to draw a line within `_RESOLUTION` (Ramer, Douglas and Peucker)."""
    keep, open_parts = {0, len(line) - 1}, [(0, len(line) - 1)]
    while open_parts:
        begin, end = open_parts.pop()
        if end - begin < 2:
            continue
        far = _distances(line[begin + 1 : end], line[begin], line[end])
        k = int(np.argmax(far))
        if far[k] > _RESOLUTION:
            middle = begin + 1 + k
            keep.add(middle)
            open_parts += [(begin, middle), (middle, end)]
    return np.array(sorted(keep))


def _distances(points: np.ndarray, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distance of points from the stretch between two others."""
    along = end - begin
    length = along @ along
    share = np.clip((points - begin) @ along / length, 0, 1) if length else np.zeros(len(points))
    return np.hypot(*(points - begin - share[:, None] * along).T)


def _nearest(line: np.ndarray, tap: np.ndarray) -> tuple[int, float]:
    """The vertex that is nearest along a line to a point, and the distance of the line."""
    along = np.diff(line, axis=0)
    length = np.maximum((along**2).sum(axis=1), 1e-30)
    share = np.clip(((tap - line[:-1]) * along).sum(axis=1) / length, 0, 1)
    far = np.hypot(*(line[:-1] + share[:, None] * along - tap).T)
    k = int(np.argmin(far))
    return k + int(share[k] > 0.5), float(far[k])


def _point_columns(result: PartialBranches, column: int, field: ShownField) -> dict[str, list]:
    points = [point for *_, point in result.points]
    return {
        "eta": [point.value for point in points],
        "value": [float(point.state[column]) for point in points],
        "marker": [POINT_KINDS[point.kind].marker for point in points],
        "size": [9 if point.kind in BIFURCATIONS else 5 for point in points],
        "kind": [point.words for point in points],
        "where": [f"{field.label} = {value_text(field, point.value)}" for point in points],
        "period": [point.period for point in points],
        "multiplier": [point_multiplier(point) for point in points],
    }


def value_text(field: ShownField, value: float) -> str:
    """A value of the number that varies, with nine digits, in the unit that is shown."""
    return f"{field.factor * value:.9g} {field.unit}".strip().replace("-", "−")
