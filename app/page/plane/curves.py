"""The curves of bifurcations over the cells of both planes: searched for while the tab shows them, drawn and listed."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from bokeh.models import HoverTool, LegendItem, Line, Scatter
from bokeh.plotting import figure
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.field_units import ShownField, shown_field
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.scripts import branch_command
from vibroscope.app.page.bifurcation.branches import BranchPanel
from vibroscope.app.page.shared.figure import INK, MAGENTA, VERMILLION, add_glyph, empty_source
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.tab import TabHost, on_loop
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies.plane_curves import KINDS, SEARCH, CurvesQuestion, PartialCurves, grow_curves
from vibroscope.app.studies.study_job import RESULTS, StudyJob
from vibroscope.engine import POINT_KINDS, PointCurve, written

_LOOKS = {
    "fold": {"line_color": INK, "line_width": 2.2, "line_dash": "solid"},
    "period doubling": {"line_color": MAGENTA, "line_width": 2.2, "line_dash": [8, 3]},
    "grazing": {"line_color": VERMILLION, "line_width": 1.6, "line_dash": [2, 2]},
    "contact opens": {"line_color": VERMILLION, "line_width": 1.6, "line_dash": [7, 2, 2, 2]},
}
_COLUMNS = ("K", "D", "kind", "period")
_MEETING_COLUMNS = ("K", "D", "kind", "other")


class PlaneCurves:
    """One search, and its glyphs in both figures.

    Parameters
    ----------
    host : TabHost
    plots : sequence of figure
    on_result : callable
        Called when the search has found more.
    """

    def __init__(self, host: TabHost, plots: Sequence[figure], on_result: Callable[[], None]) -> None:
        self.host = host
        self.view = BranchPanel(visible=False)
        self.view.on_msg(lambda event: self._receive(event.data))
        self.result: PartialCurves | None = None
        self.lines = {kind: empty_source(f"plane_curves_{kind.replace(' ', '_')}", *_COLUMNS) for kind in KINDS}
        self.meetings = empty_source("plane_curves_meetings", *_MEETING_COLUMNS)
        self._on_result = on_result
        self._question: CurvesQuestion | None = None
        self._job: StudyJob | None = None
        self._failed, self._stopped = "", False
        self._drawn: tuple[PointCurve, ...] | None = None
        self._items = [item for plot in plots for item in self._add(plot)]

    def _add(self, plot: figure) -> list[LegendItem]:
        """The glyphs in a figure; returns their entries in its legend."""
        entries, lines = [], []
        for kind, source in self.lines.items():
            line = add_glyph(plot, Line(x="K", y="D", **_LOOKS[kind]), source)
            lines.append(line)
            entries.append(LegendItem(label=POINT_KINDS[kind].several, renderers=[line], visible=False))
        look = {"marker": "circle", "size": 7, "fill_color": "#FFFFFF", "line_color": INK, "line_width": 1.3}
        marks = add_glyph(plot, Scatter(x="K", y="D", **look), self.meetings)
        plot.add_tools(
            HoverTool(renderers=lines, tooltips=[("curve of", "@kind"), ("period", "@period")], line_policy="nearest"),
            HoverTool(renderers=[marks], tooltips=[("curve of", "@kind"), ("meets", "@other")]),
        )
        plot.legend[0].items = [*plot.legend[0].items, *entries]
        return entries

    def ask(self, question: CurvesQuestion | None) -> None:
        """Search for the curves of this question, and end what else is searched for."""
        if question != self._question:
            self.cancel()
            self._stopped, self._failed, self._question = False, "", question
            if self.result is not None and (question is None or self.result.question[:2] != question[:2]):
                self.result = None  # in another range of the same system it stays until there is more
        if question is None:
            return
        self.result = RESULTS.get(question) or self.result
        done = self.result is not None and self.result.question == question and self.result.share == 1
        if not (done or self._stopped or self._failed or self._job):
            self._job = StudyJob(question, grow_curves, on_loop(self.host, self._take))

    def cancel(self) -> None:
        """Stop the search; what it has found stays."""
        if self._job is not None:
            self._job.cancel()
            self._job = None

    def _take(self, job: StudyJob, result: PartialCurves | Exception) -> None:
        if isinstance(result, Exception):
            self._failed, self._job = error_text(result), None
        else:
            self.result = result
            if result.share == 1 or job.out_of_time:
                self._job = None
        self._on_result()

    def draw(self, notes: list[str], setting: Setting) -> None:
        """Draw curves and list; ``notes`` are sentences about what is shown and what is not."""
        curves = self.result.curves if self.result is not None else ()
        shown = self._question is not None or bool(notes)
        if curves != self._drawn:
            self._drawn = curves
            for kind, source in self.lines.items():
                source.data = _line_columns([curve for curve in curves if curve.kind == kind])
            self.meetings.data = _meeting_columns(curves)
            for item in self._items:
                show_entry(item, any(POINT_KINDS[curve.kind].several == item.label.value for curve in curves))
        if self.result is not None and self.result.cut:
            notes = [*notes, self.result.cut]
        if self._failed:
            notes = [*notes, f"The search ended early ({self._failed}); what it had found stays."]
        running = self._job is not None
        new = {
            "status": {"text": self._status(), "running": running, "stopped": self._stopped, "notes": notes},
            "points": _table(curves, [shown_field(name, setting) for name in ("K", "D")]),
            "visible": shown,
        }
        self.view.param.update({name: value for name, value in new.items() if value != getattr(self.view, name)})

    def clear(self, setting: Setting) -> None:
        """Show none."""
        self.ask(None)
        self.draw([], setting)

    def _status(self) -> str:
        how = ["searching …"] if self._job else ["stopped"] if self._stopped else []
        found = [f"Exact penalty: {self.result.words()}"] if self.result is not None else []
        return "; ".join([*found, *how])

    def words(self) -> list[list[str]]:
        """Head and text for the panel, once the search is over."""
        if self.result is None or self.result.share < 1:
            return []
        return [["Curves of bifurcations", " ".join([f"{self.result.words()}.", self.result.cut]).strip()]]

    def python(self) -> str:
        """The lines of a script for the curves, to follow those for the cells, which make ``system``."""
        question = self.result.question
        made = f"CurvesQuestion(system, {question.eta!r}, {question.K!r}, {question.D!r})"
        return (
            "\nfrom vibroscope.app.studies.plane_curves import CurvesQuestion, grow_curves\n\n"
            f"*_, found = grow_curves({made}, None, lambda: False)\nprint(found.words(), *found.curves, sep='\\n')\n"
        )

    def command(self) -> str:
        """``vibroscope branch`` over K and along D: a row of the search each."""
        question = self.result.question
        (low, high), (first, last) = question.K, question.D
        limits = f"--max-period {SEARCH['max_period']} --most-orbits {SEARCH['most_orbits']}"
        reach = f"--over K --from {low!r} --to {high!r} --along D --along-from {first!r} --along-to {last!r} {limits}"
        options = {}
        for number, damping in enumerate(question.rows, start=1):
            row = f" --solver exact --eta {question.eta!r} --D {damping!r} {reach}"
            options |= {f"curves_{kind.replace(' ', '_')}{number}": f"{row} --point '{kind}'" for kind in KINDS}
        return branch_command(question.system, options)

    def _receive(self, message: object) -> None:
        if not isinstance(message, dict):
            return
        if isinstance(message.get("stop"), bool):
            self._stopped = message["stop"]
            if self._stopped:
                self.cancel()
            else:
                self.ask(self._question)
            self._on_result()
        elif isinstance(name := message.get("open"), str) and name.isdecimal() and len(name) < 6:
            self._open(int(name))

    def _open(self, number: int) -> None:
        """Open the middle of a curve in Explore."""
        if self.result is not None and number < len(self.result.curves):
            values = self.result.curves[number].values
            K, D = values[len(values) // 2].tolist()
            self.host.visit("explore", {"K": print_number(K), "D": print_number(D)})


def _line_columns(curves: Sequence[PointCurve]) -> dict[str, list]:
    """All curves of a kind, with gaps between them."""
    gap = np.full((1, 2), np.nan)
    values = np.concatenate([part for curve in curves for part in (curve.values, gap)] or [gap])
    sizes = [len(curve.values) + 1 for curve in curves] or [1]
    return {
        "K": values[:, 0].astype(np.float32),
        "D": values[:, 1].astype(np.float32),
        "kind": np.repeat([curve.kind for curve in curves] or [""], sizes).tolist(),
        "period": np.repeat([curve.period for curve in curves] or [0], sizes).tolist(),
    }


def _meeting_columns(curves: Sequence[PointCurve]) -> dict[str, list]:
    met = [(K, D, curve.kind, other) for curve in curves for other, K, D in curve.meetings]
    return {name: [each[k] for each in met] for k, name in enumerate(_MEETING_COLUMNS)}


def _table(curves: Sequence[PointCurve], fields: Sequence[ShownField]) -> dict:
    """Kind, period, and from where to where each curve goes; ``fields`` are those of K and D."""
    rows = [
        {
            "mark": POINT_KINDS[curve.kind].sign,
            "kind": curve.kind,
            "cells": [
                {"text": curve.kind, "open": str(number), "title": "Open the middle of this curve in Explore"},
                {"text": str(curve.period)},
                *({"text": _span(column, field)} for column, field in zip(curve.values.T, fields, strict=True)),
                {"text": ", ".join(sorted({other for other, *_ in curve.meetings}))},
            ],
        }
        for number, curve in enumerate(curves)
    ]
    return {"title": "Curves", "heads": ["kind", "period", *(field.column for field in fields), "meets"], "rows": rows}


def _span(values: np.ndarray, field: ShownField) -> str:
    low, high = (written(field.factor * float(end)) for end in (values.min(), values.max()))
    return f"{low} to {high}"
