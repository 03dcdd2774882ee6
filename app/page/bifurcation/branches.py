"""The branches of the diagram: searched for while the tab shows them, drawn, listed, and opened in Explore.

Branches of periodic motions over the cloud: stable ones solid, unstable ones dashed, points marked by their kind.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from bokeh.core.property.descriptors import UnsetValueError
from vibroscope.app.explorer.closed_orbit import ClosedOrbit
from vibroscope.app.explorer.field_units import ShownField, shown_field
from vibroscope.app.explorer.parameters import START_FIELDS
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.bifurcation.figure import DASHES, BifurcationView
from vibroscope.app.page.shared.figure import write
from vibroscope.app.page.shared.seen import multiplier_words, orbit_words, point_multiplier, stability_words
from vibroscope.app.page.study.listed import ListedSearches, cell, row
from vibroscope.app.page.tab import TabHost
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies.branches import BIFURCATIONS, BranchesQuestion, PartialBranches, grow_branches, matched
from vibroscope.engine import COORDINATES, POINT_KINDS, Branch, Point

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
    """The branches in the figure of the diagram."""

    def __init__(self, figures: BifurcationView) -> None:
        self._plot, self._sources = figures.figure, figures.sources
        self._drawn: tuple = ()
        self._results: Mapping[str, PartialBranches] = {}
        self._column = 0

    def update(self, results: Mapping[str, PartialBranches], coordinate: str, field: ShownField) -> None:
        """Draw the branches of each solver, with values as ``field`` shows the number that varies."""
        branches = tuple((solver, *map(id, result.branches)) for solver, result in results.items())
        if (branches, coordinate, field) == self._drawn:
            return
        self._drawn = branches, coordinate, field
        self._results, self._column = dict(results), COORDINATES.index(coordinate)
        for solver in NAMES:
            branches = results[solver].branches if solver in results else ()
            for kind in DASHES:
                source = self._sources[f"branches_{solver}_{kind}"]
                write(source, _line_columns(branches, self._column, stable=kind == "stable"))
            columns, source = {}, self._sources[f"branch_points_{solver}"]
            if solver in results:
                columns = _point_columns(results[solver], self._column, field)
            source.data = {name: columns.get(name, []) for name in source.data}

    @property
    def values(self) -> list[np.ndarray]:
        """The values of the coordinate that are drawn."""
        return [source.data["value"] for name, source in self._sources.items() if name.startswith("branches_")]

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


NAMES = {"reference": "reference", "penalty": "exact penalty"}


class Branches(ListedSearches):
    """One search for each solver whose branches are shown."""

    names = NAMES
    grow = staticmethod(grow_branches)
    switch, head, kept = "branches", "Branches of the {}", "branches"

    def __init__(self, host: TabHost, figures: BifurcationView, on_result: Callable[[], None]) -> None:
        super().__init__(host, figures, on_result)
        self.lines = BranchLines(figures)
        self._setting: Setting | None = None

    def ask(self, questions: Mapping[str, BranchesQuestion]) -> None:
        """Search for the branches of these solvers, and end what else is searched for."""
        for solver, study in self.studies.items():
            now, before = questions.get(solver), study.question
            if now != before and (now is None or before is None or now._replace(span=before.span) != before):
                study.result = None  # what was found in another range stays until the first branch of this one
            study.follow(now)

    # -- what is shown -----------------------------------------------------------------

    def draw(self, setting: Setting, over: str, coordinate: str, notes: list[str]) -> None:
        """Draw lines, marks and tables; ``notes`` are sentences about what is shown and what is not."""
        self._setting, field = setting, shown_field(over, setting)
        self.lines.update(self.results, coordinate, field)
        shown = self.results
        points = _shift_table(shown, field) if len(shown) == 2 else _point_table(shown, field)
        self._list(notes, near=_near_table(shown, getattr(setting, over), field), points=points)

    def clear(self) -> None:
        """See `ListedSearches`."""
        self.ask({})
        self.view.visible = False
        if self._setting is not None:
            self.lines.update({}, "xi2", shown_field("eta", self._setting))

    # -- a motion in Explore -----------------------------------------------------------

    def open_named(self, name: object) -> None:
        """See `ListedSearches`."""
        if place := place_named(name):
            self.open(place)

    def tapped(self, x: float, y: float) -> bool:
        """Open what a tap on the diagram means; returns whether it means anything."""
        place = self.lines.at(x, y)
        return place is not None and self.open(place)

    def open(self, place: Place) -> bool:
        """Open the motion at a place in Explore; returns whether there is such a place."""
        result = self.results.get(place.solver)
        if result is None or place.branch >= len(result.branches):
            return False
        branch = result.branches[place.branch]
        if place.number >= (len(branch.points) if place.kind == "point" else len(branch.values)):
            return False
        texts, words, orbit = opened(result.question, place, branch)
        self.host.visit("explore", texts, lambda tab: tab.announce(texts, words, orbit))
        return True


def opened(question: BranchesQuestion, place: Place, branch: Branch) -> tuple[dict[str, str], str, ClosedOrbit]:
    """Texts that set a motion of a branch, what to know of it, and the motion itself."""
    if place.kind == "point":
        point = branch.points[place.number]
        value, starts, multipliers = point.value, point.state[None], point.multipliers
    else:
        k = place.number
        value, starts, multipliers = branch.values[k], branch.sections[k], branch.multipliers[k]
    system, eta, method = question.search.at(float(value))
    over = [system.overlap_of(start) for start in starts]
    start = np.array(starts[int(np.argmin(over))])
    exact = start.copy()
    if min(over) > 0:
        start[0] = start[2] + system.clearance
    if system.wall:
        start[2:] = 0.0
    orbit = ClosedOrbit(system, eta, method, start if place.solver == "reference" else exact, branch.period)
    texts = {"zero_start": "zero", **dict(zip(START_FIELDS, map(print_number, start.tolist()), strict=True))}
    texts[question.over] = print_number(float(value))
    if question.over != "eta":
        texts["eta"] = print_number(question.eta)
    return texts, orbit_words(orbit, multipliers[0]), orbit


# ---- tables: heads, and rows of cells --------------------------------------------------------------------------------


def _head(field: ShownField) -> str:
    """Symbol and name; the unit stands in the cells."""
    return f"{field.label} ({field.hint})"


def _near_table(shown: Mapping[str, PartialBranches], value: float, field: ShownField) -> dict:
    """The motions that branches have at the value that is set."""
    rows = []
    for solver, result in shown.items():
        for number, k in result.near(value):
            branch = result.branches[number]
            stable, largest = bool(branch.stable[k]), branch.multipliers[k, 0]
            name = f"{'stable' if stable else 'unstable'}, period {branch.period}"
            motion = cell(name, Place(solver, number, "orbit", k).name, stability_words(largest, branch.period))
            value_there, mark = value_text(field, branch.values[k]), "━" if stable else "╌"
            rows.append(row("motion", motion, value_there, multiplier_words(largest), NAMES[solver], mark=mark))
    heads = ["motion", _head(field), "largest multiplier", "solver"]
    return {"title": f"Motions of the branches near {field.words(value)}", "heads": heads, "rows": rows}


def _point_table(shown: Mapping[str, PartialBranches], field: ShownField) -> dict:
    """The points of one solver."""
    rows = [
        _row(
            point,
            Place(solver, number, "point", k).name,
            *(value_text(field, point.value), str(point.period), point_multiplier(point), NAMES[solver]),
        )
        for solver, result in shown.items()
        for number, k, point in result.points
    ]
    return {"title": "Points", "heads": ["kind", _head(field), "period", "multiplier", "solver"], "rows": rows}


def _row(point: Point, opens: str, *cells: str | dict) -> dict:
    kind = POINT_KINDS[point.kind]
    return row(kind.one, cell(point.words, opens), *cells, mark=kind.sign)


def _shift_table(shown: Mapping[str, PartialBranches], field: ShownField) -> dict:
    """The points of both solvers in pairs, and how far the penalty model shifts each."""
    places = {
        id(point): Place(solver, number, "point", k).name
        for solver, result in shown.items()
        for number, k, point in result.points
    }
    first, second = ([point for *_, point in shown[solver].points] for solver in NAMES)
    rows = [_pair(pair, places, field) for pair in matched(first, second)]
    heads = ["kind", "period", *NAMES.values(), "shift"]
    return {"title": "Points of both, and how far the penalty model shifts them", "heads": heads, "rows": rows}


def _pair(pair: tuple[Point | None, Point | None], places: Mapping[int, str], field: ShownField) -> dict:
    point = pair[0] or pair[1]
    values = [cell(value_text(field, each.value), places[id(each)]) if each else "" for each in pair]
    shift = ""
    if all(pair):
        shift = f"{field.factor * (pair[1].value - pair[0].value):+.3g} {field.unit}".strip().replace("-", "−")
    return _row(point, "", str(point.period), *values, shift)
