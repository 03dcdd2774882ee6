"""The K–D plane: where the penalty model moves as the reference does, and which motions are due to the time step."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import panel as pn
from bokeh.events import Tap
from bokeh.models import LegendItem
from bokeh.plotting import figure
from vibroscope.app.explorer.explanation import DISPLACEMENTS, Explanation
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.link import LOGARITHMIC
from vibroscope.app.explorer.method_words import CUT
from vibroscope.app.explorer.state import Setting, slider_range, widened
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import method_python, scheme_options, sweep_command, sweep_python
from vibroscope.app.page.explore.explainer import Explainer
from vibroscope.app.page.plane.curves import PlaneCurves
from vibroscope.app.page.shared.cells import (
    add_cells,
    add_mark,
    cells_figure,
    cells_source,
    listen,
    rounded_view,
    write_cells,
)
from vibroscope.app.page.shared.figure import BLUE, INK, divisor, empty_source, legend_above, write
from vibroscope.app.page.shared.ranges import OwnedRange, UnitAxis
from vibroscope.app.page.shared.seen import say
from vibroscope.app.page.study.tab import StudyView, engine_obstacle, free_obstacle
from vibroscope.app.page.tab import TabHost
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies import cell_classes as classes
from vibroscope.app.studies.branches import why_none
from vibroscope.app.studies.plane import COUNT, SAMPLE, SIDES, TRANSIENT, PartialPlane, PlaneQuestion, grow_plane
from vibroscope.app.studies.plane_curves import KINDS, CurvesQuestion
from vibroscope.engine import System, counted, equal_restitution_damping, percent, written
from vibroscope.engine.facts import Statement, equation, joined, stated
from vibroscope.engine.sweeps import CellKind, kind_words

_VEIL = ["#00000000", classes.VEIL]  # drawn as stripes: some columns of a finer picture
_STRIPES = 4
_USUAL = {name: slider_range(name, System()) for name in ("K", "D")}


class PlaneView:
    """Two figures with the same axes and colours."""

    def __init__(self, on_cell: Callable[[float, float], None], on_zoom: Callable[[], None]) -> None:
        self._on_cell = on_cell
        self._limits = dict(_USUAL)
        self.ranges = {name: OwnedRange(*limits) for name, limits in _USUAL.items()}
        self.sources = {side: cells_source(f"plane_{side}_cells") for side in SIDES}
        self.veils = {side: cells_source() for side in SIDES}
        self.diverged = {side: empty_source(f"plane_{side}_diverged", "K", "D") for side in SIDES}
        self.mark = empty_source("plane_mark", "K", "D")
        self.curve = empty_source("plane_curve", "K", "D")
        self.figures = {side: self._figure(side) for side in SIDES}
        plots = list(self.figures.values())
        self._axes = {name: UnitAxis(self.ranges[name], side, *plots) for name, side in (("K", "x"), ("D", "y"))}
        listen(plots, self.on_tap, on_zoom)

    def _figure(self, side: str) -> figure:
        labels, axes = ("contact stiffness K", "contact damping D"), {"x_axis_type": "log", "y_axis_type": "log"}
        plot = cells_figure(f"plane_{side}", *self.ranges.values(), labels, **axes)
        add_cells(plot, self.sources[side], classes.PALETTE)
        add_cells(plot, self.veils[side], _VEIL)
        plot.scatter("K", "D", source=self.diverged[side], marker="x", size=5, line_color=INK, line_width=0.8)
        halo = plot.line("K", "D", source=self.curve, line_color="#FFFFFF", line_width=4, line_alpha=0.8)
        curve = plot.line("K", "D", source=self.curve, line_color=BLUE, line_width=2, line_dash="dashed")
        mark = add_mark(plot, "K", "D", self.mark)
        entries = [
            LegendItem(label="restitution as the reference's", renderers=[halo, curve]),
            LegendItem(label="set now", renderers=[mark]),
        ]
        legend_above(plot, entries)
        return plot

    def fit_axes(self, setting: Setting) -> None:
        """Let the axes reach as far as the setting: beyond the sliders' ranges by whole decades."""
        for name in _USUAL:
            self._limits[name] = widened(slider_range(name, setting.system), getattr(setting, name))
            self.ranges[name].put(*self._limits[name])

    @property
    def spans(self) -> dict[str, tuple[float, float]]:
        """K and D that are in view, within what can be set."""
        return {name: rounded_view(self.ranges[name].ends, *limits) for name, limits in self._limits.items()}

    def update(
        self, setting: Setting, result: PartialPlane | None, quantity: str, limit: float | None, error: float
    ) -> None:
        """Move the mark; draw the cells as far as they are known.

        ``error`` is that of what is set, if known: the cell that holds it shows this one, not that of its middle.
        """
        write(self.mark, dict(zip(("K", "D"), np.array(setting.place_in_plane, np.float32)[:, None], strict=True)))
        for name, words in (("K", "contact stiffness K"), ("D", "contact damping D")):
            field = shown_field(name, setting)
            words = words.replace("damping D", "damper 2D") if field.unit else words
            self._axes[name].show(f"{words} / {divisor(field.unit or field.natural)}", field.factor)
        curve_K = np.geomspace(*self._limits["K"], 41)
        curve_D = equal_restitution_damping(setting.system, curve_K)
        write(self.curve, {"K": curve_K.astype(np.float32), "D": curve_D.astype(np.float32)})
        if result is None:
            return
        place = result.cell(*setting.place_in_plane)
        for side in SIDES:
            image = classes.class_image(result, side, quantity)
            if (side, quantity) == ("penalty", "error") and math.isfinite(error) and place is not None:
                image[place] = classes.class_of(error, quantity)
            self._draw(result, side, image, limit)
            say(self.figures[side], self._title(result.question, side, setting), classes.most_frequent(image, quantity))

    def _title(self, question: PlaneQuestion, side: str, setting: Setting) -> str:
        step = f"{question.name} T/{question.steps}{f' {CUT}' if question.located else ''}"
        return f"{'No time step' if side == 'exact' else step}, {shown_field('eta', setting).words(question.eta)}"

    def _draw(self, result: PartialPlane, side: str, image: np.ndarray, limit: float | None) -> None:
        edges = result.question.K, result.question.D
        write_cells(self.sources[side], image, *edges)
        veil = np.zeros((1, 1), np.uint8)
        if limit is not None:
            veil = np.repeat(classes.sudden_contacts(result, side, limit), _STRIPES, axis=1)
            veil[:, np.arange(veil.shape[1]) % _STRIPES != 1] = 0
        write_cells(self.veils[side], veil, *edges)
        row, column = np.nonzero(result.diverged(side) & result.known)
        K, D = result.question.axis("K")[column], result.question.axis("D")[row]
        write(self.diverged[side], {"K": K.astype(np.float32), "D": D.astype(np.float32)})

    def on_tap(self, event: Tap) -> None:
        """Set K and D to the place of a tap."""
        if event.x and event.y and np.isfinite([event.x, event.y]).all():
            self._on_cell(*(float(f"{np.clip(v, *self._limits[n]):.3g}") for n, v in (("K", event.x), ("D", event.y))))


_SUDDEN = 30  # steps: the paper takes a contact of fewer for one sudden impact


class Plane(StudyView):
    """Figures 11 and 12 of the paper, at any η."""

    key = "plane"
    title = "K–D plane"
    grow = staticmethod(grow_plane)
    chosen = {"quantity": "error", "limit": _SUDDEN, "curves": "off"}  # noqa: RUF012 - read only
    axes = {"K": LOGARITHMIC, "D": LOGARITHMIC}  # noqa: RUF012 - read only
    legends = dict.fromkeys(
        ("plane_penalty", "plane_exact"), ("equal_restitution", "set_now", *(kind.replace(" ", "_") for kind in KINDS))
    )
    keyed = ("plane_penalty", "plane_exact")
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

    def build(self) -> pn.viewable.Viewable:
        """Two planes, the panel, and the list of the curves."""
        self.view = PlaneView(self._set, self.refresh)
        self.curves = self.searches = PlaneCurves(self.host, list(self.view.figures.values()), self._push)
        cells = (self.stretch(plot, "tall") for plot in self.view.figures.values())
        return self.lay_out(*cells, below=self.curves.view)

    @classmethod
    def spec(cls) -> dict:
        """The choices of the tab."""
        quantities = {name: quantity.label for name, quantity in classes.COLOURINGS.items()}
        limit = {"name": "limit", "label": "Short contact below (steps)", "low": 2, "high": 200}
        return {
            "switches": [
                {"name": "quantity", "label": "Colour", "choices": quantities},
                {"name": "curves", "label": "Curves", "choices": {"off": "not shown", "on": "of bifurcations"}},
            ],
            "limits": [limit | {"when": {"quantity": "contact"}}],
            "hint": "A click sets K and D; so do their sliders, which the arrow keys move.",
        }

    def fit_axes(self, setting: Setting) -> None:
        """Widen the axes so that K and D beyond the usual range are in view."""
        self.view.fit_axes(setting)

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
        return PlaneQuestion(setting.system, setting.eta, setting.steps, located, **more, **self.view.spans)

    def search_questions(self, setting: Setting) -> tuple[CurvesQuestion | None, list[str]]:
        """The curves to search for, and sentences about what they are, or why there are none."""
        if not self._searches:
            return None, []
        method = setting.penalty.limit
        if why := why_none("K", method):
            return None, [why]
        asked = CurvesQuestion(setting.system, setting.eta, **self.view.spans)
        return asked, ["The curves are those of the exact penalty: at the left they show what the time step moves."]

    def figures(self) -> list[Figure]:
        """The figures of the planes, and the table of the curves once there are any."""
        return [each for each in super().figures() if each.drawn or (self.curves.result and self.curves.result.curves)]

    def data(self) -> dict[str, object]:
        """The planes and the curves."""
        curves = self.curves.result
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
        self._explainer.cancel()
        self._marked = None

    def away(self, setting: Setting) -> dict[str, list[str]]:
        """See `StudyView`: only a contact status iterated to the end of a step can leave it without a solution."""
        return {} if self.question(setting).counted else {"quantity": ["without_solution"]}

    def draw(self, setting: Setting, result: PartialPlane | None) -> None:
        """Both planes and the key."""
        if self._searches:
            self.curves.draw(self.search_questions(setting)[1], setting)
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
        return [*statements(setting, result, self._explain(setting)), *self.curves.words()]

    def table(self, name: str) -> list[Series]:
        """A row for each cell that is known, or for each vertex of the curves."""
        if name == "plane_curves":
            return [Series("Exact penalty", self.curves.result.table())]
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
        return script if self.curves.result is None else script + self.curves.python()

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
        return sweep if self.curves.result is None else sweep + self.curves.command()

    def _set(self, K: float, D: float) -> None:
        self.host.set({"K": print_number(K), "D": print_number(D)})


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
