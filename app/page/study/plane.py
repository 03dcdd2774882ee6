"""The K–D plane: where the penalty model moves as the reference does, and which motions are due to the time step.

The curves of bifurcations over the cells of both planes: searched for while the tab shows them, drawn and listed.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from bokeh.models import HoverTool, Line, Scatter
from vibroscope.app.explorer.explanation import DISPLACEMENTS, Explanation
from vibroscope.app.explorer.field_units import ShownField, shown_field
from vibroscope.app.explorer.link import ViewChoice
from vibroscope.app.explorer.method_words import CUT
from vibroscope.app.explorer.state import Setting, slider_range, widened
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import branch_command, method_python, scheme_options, sweep_command, sweep_python
from vibroscope.app.page.explore.explainer import Explainer
from vibroscope.app.page.shared.curves import (
    AWAITED,
    Axis,
    CellsView,
    Curves,
    Plot,
    cells,
    curve,
    mark,
    rounded_view,
    write_cells,
)
from vibroscope.app.page.shared.figure import BLUE, INK, MAGENTA, VERMILLION, legend_above
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.shared.seen import say
from vibroscope.app.page.study.listed import ListedSearches, cell, row
from vibroscope.app.page.study.tab import StudyView, engine_obstacle, free_obstacle
from vibroscope.app.page.tab import TabHost
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies import cell_classes as classes
from vibroscope.app.studies.branches import why_none
from vibroscope.app.studies.plane import COUNT, SAMPLE, SIDES, TRANSIENT, PartialPlane, PlaneQuestion, grow_plane
from vibroscope.app.studies.plane_curves import KINDS, SEARCH, CurvesQuestion, PartialCurves, grow_curves
from vibroscope.engine import POINT_KINDS, PointCurve, System, counted, equal_restitution_damping, percent, written
from vibroscope.engine.facts import Statement, equation, joined, stated
from vibroscope.engine.sweeps import CellKind, kind_words

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


_VEIL = ["#00000000", classes.VEIL]  # drawn as stripes: some columns of a finer picture
_STRIPES = 4
_USUAL = {name: slider_range(name, System()) for name in ("K", "D")}
_PLACE = {"x": "K", "y": "D"}


def _plane(side: str) -> Plot:
    diverged = {"marker": "x", "size": 5, "line_color": INK, "line_width": 0.8}
    pictures = [cells(f"plane_{side}_cells", classes.PALETTE), cells(f"_plane_{side}_veil", _VEIL)]
    equal = [
        curve(Line, "plane_curve", **_PLACE, line_color="#FFFFFF", line_width=4, line_alpha=0.8),
        curve(Line, "plane_curve", **_PLACE, line_color=BLUE, line_width=2, line_dash="dashed"),
    ]
    entries = {
        "cells": ("", [*pictures, curve(Scatter, f"plane_{side}_diverged", **_PLACE, **diverged)]),
        "equal_restitution": ("restitution as the reference's", equal),
        "set_now": ("set now", [mark("plane_mark", **_PLACE)]),
    }
    return Plot(AWAITED, **_PLACE, entries=entries | BIFURCATIONS, legend=legend_above)


class PlaneView(CellsView):
    """Two figures with the same axes and colours."""

    axes = {  # noqa: RUF012 - read only
        "K": Axis(*_USUAL["K"], "contact stiffness K", "contact_stiffness", logarithmic=True),
        "D": Axis(*_USUAL["D"], "contact damping D", "contact_damping", logarithmic=True),
    }
    plots = {f"plane_{side}": _plane(side) for side in SIDES}  # noqa: RUF012 - read only
    beside = COLUMNS

    def __init__(self) -> None:
        super().__init__()
        self.limits = dict(_USUAL)  # of the axes

    def fit_axes(self, setting: Setting) -> None:
        """See `Curves`: beyond the sliders' ranges by whole decades."""
        for name in _USUAL:
            self.limits[name] = widened(slider_range(name, setting.system), getattr(setting, name))
            self.ranges[name].put(*self.limits[name])

    @property
    def in_view(self) -> dict[str, tuple[float, float]]:
        """K and D that are in view, within what can be set."""
        return {name: rounded_view(self.ranges[name].ends, *limits) for name, limits in self.limits.items()}

    def update(
        self, setting: Setting, result: PartialPlane | None, quantity: str, limit: float | None, error: float
    ) -> None:
        """Move the mark; draw the cells as far as they are known.

        ``error`` is that of what is set, if known: the cell that holds it shows this one, not that of its middle.
        """
        K, D = setting.place_in_plane
        self.write("plane_mark", {"K": [K], "D": [D]})
        self.label(setting, str if setting.scale is None else lambda words: words.replace("damping D", "damper 2D"))
        curve_K = np.geomspace(*self.limits["K"], 41)
        self.write("plane_curve", {"K": curve_K, "D": equal_restitution_damping(setting.system, curve_K)})
        if result is None:
            return
        place = result.cell(*setting.place_in_plane)
        for side in SIDES:
            image = classes.class_image(result, side, quantity)
            if (side, quantity) == ("penalty", "error") and math.isfinite(error) and place is not None:
                image[place] = classes.class_of(error, quantity)
            self._draw(result, side, image, limit)
            title, seen = self._title(result.question, side, setting), classes.most_frequent(image, quantity)
            say(self.figures[f"plane_{side}"], title, seen)

    def _title(self, question: PlaneQuestion, side: str, setting: Setting) -> str:
        step = f"{question.name} T/{question.steps}{f' {CUT}' if question.located else ''}"
        return f"{'No time step' if side == 'exact' else step}, {shown_field('eta', setting).words(question.eta)}"

    def _draw(self, result: PartialPlane, side: str, image: np.ndarray, limit: float | None) -> None:
        edges = result.question.K, result.question.D
        write_cells(self.sources[f"plane_{side}_cells"], image, *edges)
        veil = np.zeros((1, 1), np.uint8)
        if limit is not None:
            veil = np.repeat(classes.sudden_contacts(result, side, limit), _STRIPES, axis=1)
            veil[:, np.arange(veil.shape[1]) % _STRIPES != 1] = 0
        write_cells(self.sources[f"_plane_{side}_veil"], veil, *edges)
        row, column = np.nonzero(result.diverged(side) & result.known)
        diverged = {"K": result.question.axis("K")[column], "D": result.question.axis("D")[row]}
        self.write(f"plane_{side}_diverged", diverged)


_SUDDEN = 30  # steps: the paper takes a contact of fewer for one sudden impact


class Plane(StudyView):
    """Figures 11 and 12 of the paper, at any η."""

    key = "plane"
    title = "K–D plane"
    grow = staticmethod(grow_plane)
    drawn, place, searched = PlaneView, "tall", PlaneCurves
    tapped = keyed = ("plane_penalty", "plane_exact")
    zoomed = "plane_penalty"
    choices = (
        ViewChoice("quantity", "Colour", "error", {name: each.label for name, each in classes.COLOURINGS.items()}),
        ViewChoice("curves", "Curves", "off", {"off": "not shown", "on": "of bifurcations"}),
        ViewChoice("limit", "Short contact below (steps)", _SUDDEN, bounds=(2, 200), when={"quantity": "contact"}),
    )
    hint = "A click sets K and D; so do their sliders, which the arrow keys move."
    pictures = (
        Figure(
            "plane_penalty",
            "Plane with a time step",
            "The penalty model over K and D: the colours of the page's key.",
        ),
        Figure("plane_exact", "Plane without one", "The exact penalty model over K and D, which has no time step."),
        Figure("plane_curves", "Curves of bifurcations", "Folds, doublings and grazing over K and D.", drawn=False),
    )

    def __init__(self, host: TabHost) -> None:
        super().__init__(host)
        self._explainer = Explainer(host, lambda: self._visible, self._explained)
        self._marked: Setting | None = None
        self._explanation: Explanation | None = None  # of what is marked

    def obstacle(self, setting: Setting) -> str:
        """Why there is no study: nothing drives the bodies, or the engine has no study of the method."""
        return free_obstacle(setting, "each cell of this plane") or engine_obstacle(setting, self.question(setting))

    def question(self, setting: Setting) -> PlaneQuestion:
        """All but K and D themselves."""
        quantity, located = self.panel.chosen["quantity"], setting.located == "yes"
        more = {"errors": quantity == "error", "judged": quantity == "near_period"}
        penalty = setting.penalty
        if penalty.has_choices:  # what it computes does not depend on its K and D
            more["other"] = replace(penalty, stiffness=1.0, damping=1.0)
        return PlaneQuestion(setting.system, setting.eta, setting.steps, located, **more, **self.view.in_view)

    def search_questions(self, setting: Setting) -> tuple[CurvesQuestion | None, list[str]]:
        """The curves to search for, and sentences about what they are, or why there are none."""
        if not self._searches:
            return None, []
        method = setting.penalty.limit
        if why := why_none("K", method):
            return None, [why]
        asked = CurvesQuestion(setting.system, setting.eta, **self.view.in_view)
        return asked, ["The curves are those of the exact penalty: at the left they show what the time step moves."]

    def data(self) -> dict[str, object]:
        """The planes and the curves."""
        curves = self.searches.result
        return super().data() | self._shown_in_units({"curves": curves.data()} if curves is not None else {})

    def _explain(self, setting: Setting) -> Explanation | None:
        """What Explore says of a setting, if that is known by now; else it comes later."""
        if setting != self._marked:
            self._marked, self._explanation = setting, self._explainer.follow(setting)
        return self._explanation

    def _explained(self, explanation: Explanation) -> None:
        self._explanation = explanation
        self._push()

    def hide(self) -> None:
        """See `TabView.hide`."""
        super().hide()
        self._explainer.drop()
        self._marked = None

    def away(self, setting: Setting) -> dict[str, list[str]]:
        """See `StudyView`: only a contact status iterated to the end of a step can leave it without a solution."""
        return {} if self.question(setting).counted else {"quantity": ["without_solution"]}

    def draw(self, setting: Setting, result: PartialPlane | None) -> None:
        """Both planes and the key."""
        if self._searches:
            self.searches.draw(self.search_questions(setting)[1], setting)
        quantity = self.panel.chosen["quantity"]
        if result is not None:
            missing = {
                "error": not result.has_errors,
                "near_period": not result.question.judged,
                "without_solution": not result.question.counted,
            }
            quantity = "period" if missing.get(quantity) else quantity  # what there is, until the others come
        limit = self.panel.chosen["limit"] if quantity == "contact" else None
        self.view.update(setting, result, quantity, limit, error_of(self._explain(setting)))
        self.panel.key_title = classes.COLOURINGS[quantity].label.capitalize()
        self.panel.key = classes.legend(quantity, limit)

    def describe(self, setting: Setting, result: PartialPlane) -> list[list[str]]:
        """The cell that is set, and both planes together."""
        return [*statements(setting, result, self._explain(setting)), *self.searches.words()]

    def table(self, name: str) -> list[Series]:
        """A row for each cell that is known, or for each vertex of the curves."""
        if name == "plane_curves":
            return [Series("Exact penalty", self.searches.result.table())]
        side, known = name.removeprefix("plane_"), self.result.known
        K, D = np.meshgrid(self.result.question.axis("K"), self.result.question.axis("D"))
        tables = {"K": K, "D": D, **self.result.columns(side), "contact_steps": self.result.contact_steps(side)}
        columns = {column: table[known] for column, table in tables.items()}
        return [Series(_side_names(self.result.question)[side], columns)]

    def python(self, setting: Setting) -> str:
        """`PlaneStudy` over the rectangle in view, with and without a time step."""
        question = self.script_question(setting)
        ends = {name: question.ends(name) for name in ("K", "D")}
        axes = ", ".join(f"{name}=np.geomspace({a!r}, {b!r}, {COUNT})" for name, (a, b) in ends.items())
        how = f"transient={TRANSIENT}, sample={SAMPLE}, parts={question.errors}"
        method = replace(question.study().method, stiffness=1.0, damping=1.0)  # in place of which are those of the axes
        methods = {"penalty": method_python(method), "exact": repr(method.limit)}
        calls = {
            side: f"sweep(PlaneStudy(\n    system, {own}, {question.eta!r}, {axes},\n    {how},\n))"
            for side, own in methods.items()
        }
        script = sweep_python(calls, question.system)
        return script if self.searches.result is None else script + self.searches.python()

    def command(self, setting: Setting) -> str:
        """``vibroscope sweep plane`` over the rectangle in view, with and without a time step."""
        question = self.script_question(setting)
        axes = "".join(f" --{name} {':'.join(map(repr, question.ends(name)))}:{COUNT}" for name in ("K", "D"))
        how = f"{'' if question.errors else ' --no-error'} --transient {TRANSIENT} --sample {SAMPLE}"
        other = scheme_options(question.other) if question.other is not None else ""
        located = " --located" if question.located and not other else ""
        newmark, exact = f" --steps {question.steps}{located}{other}", f" --solver exact{other}"
        given = f" --eta {print_number(question.eta)}{axes}"
        sweep = sweep_command("plane", question.system, *(given + own + how for own in (newmark, exact)))
        return sweep if self.searches.result is None else sweep + self.searches.command()

    def take_over(self, name: str, x: float, y: float) -> None:
        """Set K and D of a cell."""
        places = zip(self.view.limits.items(), (x, y), strict=True)
        self.host.set({each: print_number(float(f"{np.clip(at, *ends):.3g}")) for (each, ends), at in places})


def _side_names(question: PlaneQuestion) -> dict[str, str]:
    return {"penalty": question.name, "exact": "Exact penalty"}


def error_of(explanation: Explanation | None) -> float:
    """The difference of the displacements as Explore gives it; nan where there is none, or it is not known."""
    shown = explanation is not None and explanation.measure == DISPLACEMENTS
    return explanation.parts.get("total", math.nan) if shown else math.nan


def statements(
    setting: Setting, result: PartialPlane, explanation: Explanation | None = None
) -> list[list[str | Statement]]:
    """Head and text: what is set as Explore has it, the cell that holds it on both sides, and both planes together."""
    lines = []
    names, place = _side_names(result.question), result.cell(*setting.place_in_plane)
    if explanation is not None:
        K, D = (equation(name, x) for name, x in zip("KD", setting.place_in_plane, strict=True))
        kind, error = explanation.kinds.get("penalty", ""), error_of(explanation)
        total = f"Error {percent(error)}." if math.isfinite(error) else explanation.note
        count = math.nan if place is None else result.steps_without_solution("penalty")[place]
        none = f"In its cell {counted(count, 'step')} without a solution." if math.isfinite(count) else ""
        head = stated("{}, what is set: {}, {}", names["penalty"], K, D)
        lines.append([head, joined(" ", filter(None, (kind, total, none)))])
    if place is not None:
        K, D = (equation(name, x, 3, " ≈ ") for name, x in zip("KD", result.centre(place), strict=True))
        lines += [
            [stated("{}, cell at {}, {}", names[side], K, D), _cell(result, side, place)]
            for side in SIDES
            if side == "exact" or explanation is None
        ]
    if result.question.errors and result.share >= 1 and not result.has_errors:
        lines.append(["No error", "The reference does not repeat itself here: the colours show the period."])
    return [*lines, ["The whole plane" + ("" if result.share >= 1 else " so far"), _whole(result)]]


def _cell(result: PartialPlane, side: str, place: tuple[int, int]) -> str:
    if result.diverged(side)[place]:
        return "blown up."
    period, impacts, steps = (
        table[place]
        for table in (
            result.shown(side, "period"),
            result.shown(side, "impacts_per_period"),
            result.contact_steps(side),
        )
    )
    if not math.isfinite(period):
        return "not computed yet."
    text = _repetition(result, side, place)
    text += f", impacts per period {impacts:.3g}, longest contact {written(steps, 3)} steps"
    if result.question.errors:
        error = result.shown(side, "error")[place]
        text += f", error {percent(error)}" if math.isfinite(error) else ", no error: the motions keep no step"
    count = result.steps_without_solution(side)[place]
    if math.isfinite(count):
        text += f", {counted(count, 'step')} without a solution"
    return text + "."


def _repetition(result: PartialPlane, side: str, place: tuple[int, int]) -> str:
    """The motion of a cell in words."""
    period, near = (int(result.shown(side, name)[place]) for name in ("period", "near_period"))
    if side == "exact" and period:  # no step that scatters it
        return kind_words(CellKind.PERIODIC, period)
    if side == "exact":
        return kind_words(CellKind.UNKNOWN, period, near)
    source = np.unravel_index(result.source(place), result.known.shape)
    kind, of = CellKind(result.kinds["kind"][source]), int(result.kinds["kind_period"][source])
    return kind_words(kind, period if kind is CellKind.UNKNOWN else of, near)


def _whole(result: PartialPlane) -> str:
    known = result.known
    one = {side: result.shown(side, "period")[known] for side in SIDES}
    shares = {side: 100 * (one[side] == 1).mean() for side in SIDES}
    scatter = 100 * ((one["exact"] > 0) & (one["penalty"] == 0)).mean()
    blown = 100 * result.diverged("penalty")[known].mean()
    text = (
        f"Period one in {shares['exact']:.0f} % of the cells without a time step, in {shares['penalty']:.0f} % with it"
        f"{_without_scatter(result)}. In {scatter:.0f} % the motion repeats itself without a time step and not with "
        "it: there the step is to blame."
    )
    counts = result.steps_without_solution("penalty")[known]
    if np.isfinite(counts).any():
        text += f" In {100 * (counts > 0).mean():.0f} % a step has no solution."
    return f"{text} {blown:.0f} % blew up." if blown else text


def _without_scatter(result: PartialPlane) -> str:
    """How many cells have period one but for the blur by the step, once that is known."""
    if not result.question.judged or result.share < 1:
        return ""
    return f" ({100 * (result.kinds['kind_period'] == 1).mean():.0f} % without its blur)"
