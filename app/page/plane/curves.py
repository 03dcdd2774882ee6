"""The curves of bifurcations over the cells of both planes: searched for while the tab shows them, drawn and listed."""

from collections.abc import Callable, Sequence

import numpy as np
from bokeh.models import HoverTool, Line, Scatter
from vibroscope.app.explorer.field_units import ShownField, shown_field
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.scripts import branch_command
from vibroscope.app.page.shared.curves import Curves, curve
from vibroscope.app.page.shared.figure import INK, MAGENTA, VERMILLION
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.study.listed import ListedSearches, cell, row
from vibroscope.app.page.tab import TabHost
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies.plane_curves import KINDS, SEARCH, CurvesQuestion, PartialCurves, grow_curves
from vibroscope.engine import POINT_KINDS, PointCurve, written

_LOOKS = {
    "fold": {"line_color": INK, "line_width": 2.2, "line_dash": "solid"},
    "period doubling": {"line_color": MAGENTA, "line_width": 2.2, "line_dash": [8, 3]},
    "grazing": {"line_color": VERMILLION, "line_width": 1.6, "line_dash": [2, 2]},
    "contact opens": {"line_color": VERMILLION, "line_width": 1.6, "line_dash": [7, 2, 2, 2]},
}
_SOLVER = "exact"
_MEETINGS = "plane_curves_meetings"
_MEETING_COLUMNS = ("K", "D", "kind", "other")
_RING = {"marker": "circle", "size": 7, "fill_color": "#FFFFFF", "line_color": INK, "line_width": 1.3}


def _source(kind: str) -> str:
    return f"plane_curves_{kind.replace(' ', '_')}"


# Entries of the legend, and what is drawn, in the figure of each side; columns of the sources that no glyph has.
BIFURCATIONS = {
    kind.replace(" ", "_"): (POINT_KINDS[kind].several, [curve(Line, _source(kind), x="K", y="D", **_LOOKS[kind])])
    for kind in KINDS
} | {"meetings": ("", [curve(Scatter, _MEETINGS, x="K", y="D", **_RING)])}
COLUMNS = dict.fromkeys(map(_source, KINDS), ("kind", "period")) | {_MEETINGS: ("kind", "other")}


class PlaneCurves(ListedSearches):
    """One search, that of the exact penalty solution, and its glyphs in both figures."""

    names = {_SOLVER: "exact penalty"}  # noqa: RUF012 - read only
    grow = staticmethod(grow_curves)
    switch, head, kept = "curves", "Curves of bifurcations", "curves"

    def __init__(self, host: TabHost, figures: Curves, on_result: Callable[[], None]) -> None:
        super().__init__(host, figures, on_result)
        self._drawn: tuple[PointCurve, ...] | None = None
        for name, plot in figures.figures.items():
            lines = [figures.items[name, kind.replace(" ", "_")].renderers[0] for kind in KINDS]
            marks = [part for part in plot.renderers if part.data_source.name == _MEETINGS]
            rows = [("curve of", "@kind"), ("period", "@period")], [("curve of", "@kind"), ("meets", "@other")]
            plot.add_tools(
                HoverTool(renderers=lines, tooltips=rows[0], line_policy="nearest"),
                HoverTool(renderers=marks, tooltips=rows[1]),
            )
        self._show(set())

    def _show(self, entries: set[str]) -> None:
        """Have these kinds of curves in the legends, and no others."""
        for (_, entry), item in self.figures.items.items():
            if entry in BIFURCATIONS:
                show_entry(item, entry in entries)

    def ask(self, question: CurvesQuestion | None) -> None:
        """Search for the curves of this question, and end what else is searched for."""
        if self.result is not None and (question is None or self.result.question[:2] != question[:2]):
            self.studies[_SOLVER].result = None  # in another range of the same system it stays until there is more
        self.studies[_SOLVER].follow(question)

    @property
    def result(self) -> PartialCurves | None:
        """What is shown."""
        return self.studies[_SOLVER].result

    def draw(self, notes: list[str], setting: Setting) -> None:
        """Draw curves and list; ``notes`` are sentences about what is shown and what is not."""
        curves = self.result.curves if self.result is not None else ()
        if curves != self._drawn:
            self._drawn = curves
            sources = self.figures.sources
            for kind in KINDS:
                sources[_source(kind)].data = _line_columns([each for each in curves if each.kind == kind])
            sources[_MEETINGS].data = _meeting_columns(curves)
            self._show({each.kind.replace(" ", "_") for each in curves})
        self._list(notes, points=_table(curves, [shown_field(name, setting) for name in ("K", "D")]))

    def clear(self) -> None:
        """See `ListedSearches`."""
        self.ask(None)
        self.draw([], Setting())

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

    def open_named(self, name: object) -> None:
        """See `ListedSearches`."""
        if isinstance(name, str) and name.isdecimal() and len(name) < 6:
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
        row(
            curve.kind,
            cell(curve.kind, str(number), "Open the middle of this curve in Explore"),
            str(curve.period),
            *(_span(column, field) for column, field in zip(curve.values.T, fields, strict=True)),
            ", ".join(sorted({other for other, *_ in curve.meetings})),
            mark=POINT_KINDS[curve.kind].sign,
        )
        for number, curve in enumerate(curves)
    ]
    return {"title": "Curves", "heads": ["kind", "period", *(field.column for field in fields), "meets"], "rows": rows}


def _span(values: np.ndarray, field: ShownField) -> str:
    low, high = (written(field.factor * float(end)) for end in (values.min(), values.max()))
    return f"{low} to {high}"
