"""The K–D plane: where the penalty model moves as the reference does, and which motions are due to the time step."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import panel as pn
from vibroscope.app.explorer.explanation import DISPLACEMENTS, Explanation
from vibroscope.app.explorer.link import LOGARITHMIC
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import method_python, scheme_options, sweep_command, sweep_python
from vibroscope.app.page.explore.explainer import Explainer
from vibroscope.app.page.plane.curves import PlaneCurves
from vibroscope.app.page.plane.figure import PlaneView
from vibroscope.app.page.study.tab import StudyView, engine_obstacle, free_obstacle
from vibroscope.app.page.tab import TabHost
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies import cell_classes as classes
from vibroscope.app.studies.branches import why_none
from vibroscope.app.studies.plane import COUNT, SAMPLE, SIDES, TRANSIENT, PartialPlane, PlaneQuestion, grow_plane
from vibroscope.app.studies.plane_curves import KINDS, CurvesQuestion
from vibroscope.engine import counted, percent
from vibroscope.engine.facts import Statement, equation, joined, stated
from vibroscope.engine.sweeps import CellKind, kind_words

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
        K, D = (equation(name, x, 4) for name, x in zip("KD", setting.place_in_plane, strict=True))
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
    text += f", impacts per period {impacts:.3g}, longest contact {steps:.3g} steps"
    if result.question.errors:
        error = result.shown(side, "error")[place]
        text += f", error {percent(error)}" if math.isfinite(error) else ", no error: the motions keep no step"
    count = result.steps_without_solution(side)[place]
    if math.isfinite(count):
        text += f", {counted(count, 'step')} without a solution"
    return text + "."


def _repetition(result: PartialPlane, side: str, place: tuple[int, int]) -> str:
    """The motion of a cell in words; by its section alone if Newmark's is not judged."""
    period, near = (int(result.shown(side, name)[place]) for name in ("period", "near_period"))
    if side == "exact":
        return kind_words(CellKind.UNKNOWN, period, near)
    source = np.unravel_index(result.source(place), result.known.shape)
    kind, of = CellKind(result.kinds["kind"][source]), int(result.kinds["kind_period"][source])
    if kind is not CellKind.UNKNOWN:
        return kind_words(kind, of, near)
    return kind_words(kind, period, near) + " by its section alone"


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
