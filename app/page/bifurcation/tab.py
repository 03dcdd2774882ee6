"""The bifurcation diagram of each solver, from rest or continued, computed over the range that is in view."""

from __future__ import annotations

import numpy as np
import panel as pn
from vibroscope.app.explorer.link import LINEAR
from vibroscope.app.explorer.state import Explorer, Setting, print_number
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import method_options, sweep_command, sweep_python
from vibroscope.app.page.bifurcation.figure import SYMBOLS, BifurcationView, legend, name_of
from vibroscope.app.page.study.tab import StudyTab
from vibroscope.app.studies.bifurcation import (
    COUNT,
    SAMPLE,
    TRANSIENT,
    DiagramQuestion,
    PartialDiagram,
    grow_diagram,
    kind_names,
)
from vibroscope.app.studies.study_job import RESULTS
from vibroscope.engine import COORDINATES, ExactPenalty, Method
from vibroscope.engine.sweeps import CellKind

_DIRECTION_NAMES = {"rest": "from rest", "up": "continued upwards", "down": "continued downwards"}
_SOLVERS = {"reference": "reference", "exact": "exact penalty", "newmark": "penalty (Newmark)"}


class Bifurcation(StudyTab):
    """Figure 3 of the paper, at any K, D and step."""

    key = "bifurcation"
    title = "Bifurcation"
    grow = staticmethod(grow_diagram)
    chosen = {"solver": "reference", "direction": "rest", "coordinate": "xi2"}  # noqa: RUF012 - read only
    axes = {"eta": LINEAR, "value": LINEAR}  # noqa: RUF012 - read only
    pictures = (
        Figure("bifurcation", "Bifurcation diagram", "A coordinate at τ ≡ 0 (mod T) over the excitation frequency η."),
        Figure("bifurcation_strip", "Kinds of motion over η", "Period and kind of the motion over η: the page's key."),
    )

    def build(self) -> pn.viewable.Viewable:
        """The diagram, the strip of periods below it, the panel."""
        self.view = BifurcationView(self._set, self.refresh)
        return self.lay_out(self.stretch(self.view.figure, "wide"), self.stretch(self.view.strip, "wide", "low"))

    @classmethod
    def spec(cls) -> dict:
        """What can be chosen, and the line that can be dragged."""
        low, high = Explorer.param["eta"].softbounds
        return {
            "title": "Bifurcation diagram",
            "switches": [
                {"name": "solver", "label": "Solver", "choices": _SOLVERS},
                {"name": "direction", "label": "Start", "choices": _DIRECTION_NAMES},
                {"name": "coordinate", "label": "Coordinate", "choices": SYMBOLS},
            ],
            "limits": [],
            "hint": "Drag the line, click, or use the slider to set η. A zoom is computed anew at its own range. "
            "Hollow points are scatter that the time step causes. In grey, once computed: the other direction (motions "
            "coexist where they differ), or the reference.",
            "cursor": {
                "figure": "bifurcation",
                "span": "bifurcation_cursor",
                "label": "bifurcation_label",
                "name": "eta",
                "symbol": "η",
                "low": low,
                "high": high,
            },
        }

    def question(self, setting: Setting) -> DiagramQuestion:
        """All but η itself."""
        chosen = self.panel.chosen
        return DiagramQuestion(setting.system, _method(setting, chosen["solver"]), chosen["direction"], self.view.span)

    def draw(self, setting: Setting, result: PartialDiagram | None) -> None:
        """The diagram and the one to compare with."""
        other = None if result is None else _compared(setting, result.question)
        self.view.update(setting, result, self.panel.chosen["coordinate"], other)
        self.panel.key = legend()

    def describe(self, setting: Setting, result: PartialDiagram) -> list[list[str]]:
        """The nearest η, and the whole range."""
        return statements(setting, result)

    def table(self, name: str) -> list[Series]:
        """All points of the diagram, also of what is drawn in grey; or the stretches of η with one period."""
        if name == "bifurcation_strip":
            columns = dict(zip(("from_eta", "to_eta", "period", "kind"), self.result.stretches(), strict=True))
            columns["kind"] = kind_names(columns["kind"])
            return [Series(_label(self.result.question), columns)]
        other, coordinate = _compared(self._result_setting, self.result.question), self.panel.chosen["coordinate"]
        return [_points(result, coordinate) for result in (self.result, other) if result is not None]

    def python(self, setting: Setting) -> str:
        """`sweep_eta` over the range in view."""
        question = self.script_question(setting)
        how = f"direction={question.direction!r}, coordinates={tuple(COORDINATES)}"
        values = f"np.linspace({question.eta[0]!r}, {question.eta[1]!r}, {COUNT})"
        call = f"sweep_eta(\n    system, {question.method!r}, {values},\n"
        call += f"    {how}, transient={TRANSIENT}, sample={SAMPLE},\n)"
        return sweep_python({"diagram": call}, question.system, type(question.method).__name__)

    def command(self, setting: Setting) -> str:
        """``vibroscope sweep eta`` over the range in view."""
        question = self.script_question(setting)
        options = (
            f" --from {question.eta[0]!r} --to {question.eta[1]!r} --count {COUNT}{method_options(question.method)}"
        )
        options += f" --direction {question.direction} --coordinates {','.join(COORDINATES)}"
        return sweep_command("eta", question.system, f"{options} --transient {TRANSIENT} --sample {SAMPLE}")

    def _set(self, eta: float) -> None:
        self.host.set({"eta": print_number(eta)})


def _method(setting: Setting, solver: str) -> Method:
    if solver == "exact":
        return ExactPenalty(setting.K, setting.D)
    return setting.reference if solver == "reference" else setting.penalty


def _compared(setting: Setting, question: DiagramQuestion) -> PartialDiagram | None:
    """A diagram that was computed before: in the other direction, or of the reference beside a penalty solver."""
    if question.direction == "rest":
        reference = question._replace(method=setting.reference)
        return RESULTS.get(reference) if reference != question else None
    return RESULTS.get(question._replace(direction="down" if question.direction == "up" else "up"))


def _label(question: DiagramQuestion) -> str:
    return f"{name_of(question.method)} {_DIRECTION_NAMES[question.direction]}"


def _points(result: PartialDiagram, coordinate: str) -> Series:
    eta, values = result.points(coordinate, None)
    return Series(_label(result.question), {"eta": eta, coordinate: values})


def statements(setting: Setting, result: PartialDiagram) -> list[list[str]]:
    """Head and text of what the diagram says."""
    known = np.flatnonzero(result.known)
    axis = result.question.axis
    nearest = known[np.argmin(np.abs(axis[known] - setting.eta))]
    low, high = result.question.eta
    lines = []
    if low <= setting.eta <= high:
        lines.append([f"Near η = {axis[nearest]:.4g}", _motion(result, nearest)])
    return [*lines, [f"From η = {low:g} to {high:g}", f"{'; '.join(_shares(result, known))}."]]


_SHARES = {  # a kind of motion as the statement names it
    CellKind.ARTEFACT: "periodic but scattered by the time step",
    CellKind.QUASI_PERIODIC: "quasi-periodic",
    CellKind.CHAOTIC: "chaotic",
    CellKind.UNDECIDED: "aperiodic, kind not decided",
    CellKind.UNKNOWN: "aperiodic, being judged",
    CellKind.ENDED_EARLY: "ended early",
}


def _shares(result: PartialDiagram, known: np.ndarray) -> list[str]:
    """Which kinds of motion there are, and how much of the range they take."""
    kind, period = result.kinds["kind"][known], result.kinds["kind_period"][known]
    periodic = kind == CellKind.PERIODIC
    parts = {f"period {n}": periodic & (period == n) for n in (1, 2)}
    parts["longer periods"] = periodic & (period > 2)
    parts |= {name: kind == code for code, name in _SHARES.items()}
    return [f"{name} {_percent(float(cells.mean()))}" for name, cells in parts.items() if cells.any()]


def _motion(result: PartialDiagram, index: int) -> str:
    if result.ended[index]:
        return "the run ended early."
    impacts = f"impacts per period {result.impacts[index]:.3g}"
    return f"{kind_text(result, index)}, {impacts}."


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.005 else "below 1 %"


def kind_text(result: PartialDiagram, index: int) -> str:
    """Kind of motion of a cell, with its evidence."""
    kind, period = CellKind(result.kinds["kind"][index]), result.kinds["kind_period"][index]
    if kind is CellKind.PERIODIC:
        return f"period {period}"
    if kind is CellKind.ARTEFACT:
        return f"period {period} without a time step; the scatter is an artefact of the step"
    if kind is CellKind.UNKNOWN:
        return "does not repeat itself (kind being judged)"
    exponent, error = result.kinds["lyapunov"][index], result.kinds["lyapunov_error"][index]
    rate = f" (Lyapunov exponent {exponent:+.2g} ± {error:.1g} per period)" if np.isfinite(exponent) else ""
    return f"{_SHARES[kind]}{rate}"
