"""The branches of the diagram: searched for while the tab shows them, drawn, listed, and opened in Explore."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
import param
from bokeh.plotting import figure
from vibroscope.app.explorer.closed_orbit import ClosedOrbit
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.field_units import ShownField, shown_field
from vibroscope.app.explorer.parameters import START_FIELDS
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.bifurcation.branch_lines import (
    BranchLines,
    Place,
    place_named,
    value_text,
)
from vibroscope.app.page.files import esm, style
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.shared.stability import multiplier_words, orbit_words, point_multiplier, stability_words
from vibroscope.app.page.tab import TabHost, on_loop
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies.branches import BranchesQuestion, PartialBranches, grow_branches, matched
from vibroscope.app.studies.study_job import RESULTS, StudyJob
from vibroscope.engine import POINT_KINDS, Branch, Point
from vibroscope.engine.facts import Statement, joined

NAMES = {"reference": "reference", "penalty": "exact penalty"}


class BranchPanel(Component):
    """Tables, of what can be opened, too. Sends ``{"open": name of a `Place`}``, ``{"stop": true or false}``."""

    label = param.String(default="Branches of periodic motions", doc="For screen readers")
    status = param.Dict(default={}, doc="text, running, stopped, notes")
    near = param.Dict(default={}, doc="Motions at the value that is set: title, heads and rows")
    points = param.Dict(default={}, doc="All points: title, heads and rows")

    _esm = esm("bifurcation/branches")
    _stylesheets = [style("shared/scroll_cue", "bifurcation/branches")]  # noqa: RUF012 - Panel reads it from the class


class Branches:
    """One search for each solver whose branches are shown.

    Parameters
    ----------
    host : TabHost
    plot : figure
        The diagram.
    on_result : callable
        Called when a search has found more.
    """

    def __init__(self, host: TabHost, plot: figure, on_result: Callable[[], None]) -> None:
        self.host = host
        self.lines = BranchLines(plot)
        self.view = BranchPanel(visible=False)
        self.view.on_msg(lambda event: self._receive(event.data))
        self.results: dict[str, PartialBranches] = {}
        self._on_result = on_result
        self._questions: dict[str, BranchesQuestion] = {}
        self._jobs: dict[str, StudyJob] = {}
        self._failed: dict[str, str] = {}
        self._setting: Setting | None = None
        self._stopped = False  # by the user

    def ask(self, questions: Mapping[str, BranchesQuestion]) -> None:
        """Search for the branches of these solvers, and end what else is searched for."""
        if questions != self._questions:
            self._stopped = False
        for solver, before in self._questions.items():
            now = questions.get(solver)
            if now != before:  # what was found in another range stays until the first branch of this one
                self._forget(solver, wholly=now is None or now._replace(span=before.span) != before)
        for solver, question in questions.items():
            known = RESULTS.get(question)
            if known is not None:
                self._keep(solver, known)
            held = self._stopped or solver in self._jobs or solver in self._failed
            if not held and (known is None or known.share < 1):
                take = on_loop(self.host, partial(self._take, solver))
                self._jobs[solver] = StudyJob(question, grow_branches, take)
        self._questions = dict(questions)

    def cancel(self) -> None:
        """Stop all searches; what they have found stays."""
        for job in self._jobs.values():
            job.cancel()
        self._jobs = {}

    @property
    def running(self) -> bool:
        """Whether a search is under way."""
        return bool(self._jobs)

    def _forget(self, solver: str, *, wholly: bool = True) -> None:
        if solver in self._jobs:
            self._jobs.pop(solver).cancel()
        self._failed.pop(solver, None)
        if wholly:
            self.results.pop(solver, None)

    def _keep(self, solver: str, result: PartialBranches) -> None:
        """Keep what was found, in the order of `NAMES` whichever search was the quicker: tables and files follow it."""
        found = self.results | {solver: result}
        self.results = {name: found[name] for name in NAMES if name in found}

    def _take(self, solver: str, job: StudyJob, result: PartialBranches | Exception) -> None:
        if isinstance(result, Exception):
            self._failed[solver] = error_text(result)
            self._jobs.pop(solver, None)
        else:
            self._keep(solver, result)
            if result.share == 1:
                self._jobs.pop(solver, None)
        self._on_result()

    # -- what is shown -----------------------------------------------------------------

    def draw(self, setting: Setting, over: str, coordinate: str, notes: list[str]) -> None:
        """Draw lines, marks and tables; ``notes`` are sentences about what is shown and what is not."""
        self._setting, field = setting, shown_field(over, setting)
        self.lines.update(self.results, coordinate, field)
        shown = {solver: result for solver, result in self.results.items() if solver in self._questions}
        notes = [*notes, *(f"{NAMES[s].capitalize()}: {result.cut}" for s, result in shown.items() if result.cut)]
        notes += [
            f"{NAMES[solver].capitalize()}: the search ended early ({why}); what it had found stays."
            for solver, why in self._failed.items()
        ]
        new = {
            "status": {"text": self._status(), "running": self.running, "stopped": self._stopped, "notes": notes},
            "near": _near_table(shown, getattr(setting, over), field),
            "points": _shift_table(shown, field) if len(shown) == 2 else _point_table(shown, field),
            "visible": bool(self._questions or notes),
        }
        self.view.param.update({name: value for name, value in new.items() if value != getattr(self.view, name)})

    def clear(self) -> None:
        """Show none."""
        for solver in list(self._questions):
            self._forget(solver)
        self._questions = {}
        self.view.visible = False
        if self._setting is not None:
            self.lines.update({}, "xi2", shown_field("eta", self._setting))

    def _status(self) -> str:
        texts = [f"{NAMES[solver].capitalize()}: {result.words()}" for solver, result in self.results.items()]
        how = ["searching …"] if self.running else ["stopped"] if self._stopped else []
        return "; ".join([*texts, *how])

    def words(self) -> list[list[str | Statement]]:
        """Head and text for the panel, of each search that is over."""
        over = {solver: result for solver, result in self.results.items() if result.share == 1}
        return [
            [f"Branches of the {NAMES[solver]}", joined(" ", filter(None, (f"{result.words()}.", result.cut)))]
            for solver, result in over.items()
        ]

    # -- a motion in Explore -----------------------------------------------------------

    def _receive(self, message: object) -> None:
        if not isinstance(message, dict):
            return
        if isinstance(message.get("stop"), bool):
            self._stop(message["stop"])
        elif place := place_named(message.get("open")):
            self.open(place)

    def _stop(self, on: bool) -> None:
        self._stopped = on
        if on:
            self.cancel()
        else:
            self.ask(self._questions)
        self._on_result()

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


def _cell(text: str, place: Place | None = None, title: str = "") -> dict:
    """Without what is empty, since there may be hundreds."""
    return {"text": text} | ({"open": place.name} if place else {}) | ({"title": title} if title else {})


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
            cells = [
                _cell(name, Place(solver, number, "orbit", k), stability_words(largest, branch.period)),
                _cell(value_text(field, branch.values[k])),
                _cell(multiplier_words(largest)),
                _cell(NAMES[solver]),
            ]
            rows.append({"mark": "━" if stable else "╌", "kind": "motion", "cells": cells})
    heads = ["motion", _head(field), "largest multiplier", "solver"]
    return {"title": f"Motions of the branches near {field.words(value)}", "heads": heads, "rows": rows}


def _point_table(shown: Mapping[str, PartialBranches], field: ShownField) -> dict:
    """The points of one solver."""
    rows = [
        {
            "mark": POINT_KINDS[point.kind].sign,
            "kind": POINT_KINDS[point.kind].one,
            "cells": [
                _cell(POINT_KINDS[point.kind].one, Place(solver, number, "point", k)),
                _cell(value_text(field, point.value)),
                _cell(str(point.period)),
                _cell(point_multiplier(point)),
                _cell(NAMES[solver]),
            ],
        }
        for solver, result in shown.items()
        for number, k, point in result.points
    ]
    return {"title": "Points", "heads": ["kind", _head(field), "period", "multiplier", "solver"], "rows": rows}


def _shift_table(shown: Mapping[str, PartialBranches], field: ShownField) -> dict:
    """The points of both solvers in pairs, and how far the penalty model shifts each."""
    places = {
        id(point): Place(solver, number, "point", k)
        for solver, result in shown.items()
        for number, k, point in result.points
    }
    first, second = ([point for *_, point in shown[solver].points] for solver in NAMES)
    rows = [_pair(pair, places, field) for pair in matched(first, second)]
    heads = ["kind", "period", *NAMES.values(), "shift"]
    return {"title": "Points of both, and how far the penalty model shifts them", "heads": heads, "rows": rows}


def _pair(pair: tuple[Point | None, Point | None], places: Mapping[int, Place], field: ShownField) -> dict:
    point = pair[0] or pair[1]
    values = [_cell(value_text(field, each.value), places[id(each)]) if each else _cell("") for each in pair]
    shift = ""
    if all(pair):
        shift = f"{field.factor * (pair[1].value - pair[0].value):+.3g} {field.unit}".strip().replace("-", "−")
    cells = [_cell(POINT_KINDS[point.kind].one), _cell(str(point.period)), *values, _cell(shift)]
    return {"mark": POINT_KINDS[point.kind].sign, "kind": POINT_KINDS[point.kind].one, "cells": cells}
