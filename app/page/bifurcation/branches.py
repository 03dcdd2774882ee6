"""The branches of the diagram: searched for while the tab shows them, drawn, listed, and opened in Explore."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from bokeh.plotting import figure
from vibroscope.app.explorer.closed_orbit import ClosedOrbit
from vibroscope.app.explorer.field_units import ShownField, shown_field
from vibroscope.app.explorer.parameters import START_FIELDS
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.bifurcation.branch_lines import BranchLines, Place, place_named, value_text
from vibroscope.app.page.shared.stability import multiplier_words, orbit_words, point_multiplier, stability_words
from vibroscope.app.page.study.listed import ListedSearches, cell, row
from vibroscope.app.page.tab import TabHost
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies.branches import BranchesQuestion, PartialBranches, grow_branches, matched
from vibroscope.engine import POINT_KINDS, Branch, Point

NAMES = {"reference": "reference", "penalty": "exact penalty"}


class Branches(ListedSearches):
    """One search for each solver whose branches are shown.

    Parameters
    ----------
    host : TabHost
    plot : figure
        The diagram.
    on_result : callable
        Called when a search has found more.
    """

    head = "Branches of the {}"

    def __init__(self, host: TabHost, plot: figure, on_result: Callable[[], None]) -> None:
        super().__init__(host, NAMES, grow_branches, on_result)
        self.lines = BranchLines(plot)
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
        """Show none."""
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
