"""The bifurcation diagram of each solver, from rest or continued, computed over the range that is in view."""

from dataclasses import replace

import panel as pn
from vibroscope.app.explorer.field_units import ShownField, shown_field
from vibroscope.app.explorer.link import View
from vibroscope.app.explorer.parameters import FIELDS, START_FIELDS
from vibroscope.app.explorer.shipped import diagram_for_now
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.page.bifurcation.branches import NAMES, Branches
from vibroscope.app.page.bifurcation.figure import BifurcationView, legend, name_of
from vibroscope.app.page.bifurcation.panel import (
    CHOICES,
    CURSOR,
    DIRECTION_NAMES,
    HINT,
    SWEPT,
    Followed,
    diagram_command,
    diagram_python,
    linked_motion,
    statements,
    without_motion,
)
from vibroscope.app.page.study.tab import StudyView, engine_obstacle, free_obstacle
from vibroscope.app.page.tab import Move
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies.bifurcation import (
    DiagramQuestion,
    PartialDiagram,
    grow_diagram,
    kind_names,
)
from vibroscope.app.studies.branches import BranchesQuestion, why_none
from vibroscope.app.studies.study_job import RESULTS
from vibroscope.engine import METHOD_NUMBERS, Diagram, ExactPenalty, Method, System

_NOTHING_SWEPT = (
    "Nothing drives the bodies, so that no motion belongs to a frequency: let the base or a force move them under "
    "System, or sweep another number from an own start."
)


class Bifurcation(StudyView):
    """Figure 3 of the paper, at any K, D and step."""

    key = "bifurcation"
    title = "Diagram and branches"
    grow = staticmethod(grow_diagram)
    drawn, place, searched = BifurcationView, "wide", Branches
    tapped, zoomed = ("bifurcation", "bifurcation_strip"), "bifurcation"
    head, choices, hint = "Bifurcation diagram", CHOICES, HINT
    extras = {"aligned": ["bifurcation", "bifurcation_strip"], "cursor": CURSOR}  # noqa: RUF012 - read only
    keyed = ("bifurcation_strip",)
    pictures = (
        Figure("bifurcation", "Bifurcation diagram", "A coordinate at τ ≡ 0 (mod T) over the excitation frequency η."),
        Figure("bifurcation_strip", "Kinds of motion over η", "Period and kind of the motion over η: the page's key."),
        Figure("bifurcation_branches", "Branches", "Every orbit of the branches, at τ ≡ 0 (mod T).", drawn=False),
        Figure("bifurcation_points", "Points of the branches", "Bifurcations, and changes of events.", drawn=False),
    )

    _followed: Followed | None = None
    _followed_in: System | None = None  # whose motion that is; None: the system that is shown next

    def choice(self) -> dict[str, str | float]:
        """See `StudyView`, and the motion that is followed; the range stands in the address as a zoom."""
        return super().choice() | (self._followed.linked() if self._followed else {})

    def restore(self, view: View) -> None:
        """Take a view from a link; the range is that of the number that is swept."""
        self.view.sweep(view.choice.get("over", "eta"))
        if (followed := linked_motion(view.choice)) is not None:
            self._followed, self._followed_in = followed, None
        super().restore(view._replace(choice=without_motion(view.choice)))

    def show(self, move: Move) -> None:
        """See `StudyView`; the motion that is followed is one of its system alone."""
        if self._followed_in not in (None, move.setting.system):
            self._followed = None
        self._followed_in = move.setting.system
        super().show(move)

    def _choose(self, chosen: dict) -> None:
        """Take what was chosen; solver and swept number go together, the one chosen last first."""
        before = self.panel.chosen
        if chosen["solver"] not in SWEPT[chosen["over"]].solvers:
            if chosen["over"] != before["over"]:
                chosen["solver"] = SWEPT[chosen["over"]].solvers[0]
            else:
                chosen["over"] = "eta"
        with pn.io.hold(self.host.doc):
            if chosen["over"] != before["over"]:
                self.view.sweep(chosen["over"])
            elif any(chosen.get(end) != before.get(end) for end in ("from", "to")):
                self._type_range(chosen["from"], chosen["to"])
            super()._choose(chosen)

    def _type_range(self, low: float, high: float) -> None:
        bounds, field = FIELDS[self.view.over].bounds, shown_field(self.view.over, self._move.setting)
        if not bounds[0] <= low < high <= bounds[1]:
            ends = " to ".join(field.number(end) for end in bounds) + (field.unit and f" {field.unit}")
            self.panel.refused = f"{field.label} must go from a smaller to a larger number, within {ends}."
            return
        self.ranges["eta"].restore(low, high)

    def obstacle(self, setting: Setting) -> str:
        """Why there is no diagram: free bodies have no frequency to sweep, and stay at rest.

        And the engine may have no study of the integrator, status or law that is set.
        """
        if setting.is_driven:
            return engine_obstacle(setting, self.question(setting))
        if self.view.over == "eta":
            return _NOTHING_SWEPT
        return "" if self.panel.chosen["direction"] == "own" else free_obstacle(setting, "this diagram")

    def question(self, setting: Setting) -> DiagramQuestion:
        """All but the swept number itself."""
        chosen, over = self.panel.chosen, self.view.over
        system, method, span = setting.system, _method(setting, chosen["solver"]), self.view.span
        if over in METHOD_NUMBERS:
            method = replace(method, **{METHOD_NUMBERS[over]: span[0]})
        elif over == "restitution":
            system = replace(system, restitution=span[0])
        own = chosen["direction"] == "own"
        return DiagramQuestion(
            system=system,
            method=method,
            direction="rest" if own else chosen["direction"],
            span=span,
            over=over,
            eta=1.0 if over == "eta" else setting.eta,
            count=chosen["count"],
            transient=chosen["transient"],
            initial=self._start(setting) if own else None,
        )

    def search_questions(self, setting: Setting) -> tuple[dict[str, BranchesQuestion], list[str]]:
        """The branches to search for, by solver, and sentences about those that there are not."""
        chosen = self.panel.chosen
        if not self._searches:
            return {}, []
        wanted = NAMES if chosen["branches"] == "both" else [_branch_solver(chosen["solver"])]
        diagram, questions, notes = self.question(setting), {}, []
        for solver in wanted:
            method = setting.reference if solver == "reference" else setting.penalty.limit
            if solver == "penalty" and chosen["solver"] == "exact":
                method = ExactPenalty(setting.K, setting.D)
            if why := why_none(diagram.over, method):
                notes.append(why)
                continue
            if diagram.over in ("K", "D"):
                method = replace(method, **{METHOD_NUMBERS[diagram.over]: diagram.span[0]})
            followed = self._followed if diagram.over == "eta" else None
            questions[solver] = BranchesQuestion(
                diagram.system, method, diagram.span, diagram.over, diagram.eta, followed
            )
        if "penalty" in questions and chosen["solver"] != "exact":
            notes.append(_STANDS_FOR.format(name_of(setting.penalty)))
        return questions, notes

    def follow(self, setting: Setting) -> None:
        """Show the branches over η, first that of the motion from the start of a setting, in a range with its η."""
        eta, shown = setting.eta, self.panel.chosen["branches"]
        self._followed, self._followed_in = Followed.of(setting), setting.system
        self.restore(View(choice={"over": "eta", "branches": "on" if shown == "off" else shown}))
        low, high = self.view.span
        if not low <= eta <= high:
            self.unzoom()

    def _show_chosen(self, setting: Setting) -> None:
        """Show the range in view and the coordinate in the panel, also of a setting that has no diagram."""
        low, high = self.view.span
        self.panel.chosen = self.panel.chosen | {"from": low, "to": high, "coordinate": self._coordinate(setting)}

    def fields(self, setting: Setting) -> dict[str, ShownField]:
        """The ends of the range, in the units of what is swept, and the own start."""
        swept = shown_field(self.view.over, setting)
        ends = {name.lower(): swept._replace(label=name, hint="") for name in ("From", "To")}
        return ends | {name: shown_field(name, setting) for name in START_FIELDS}

    def _show(self) -> None:
        self._show_chosen(self._move.setting)
        super()._show()
        self.view.fade(self.searches.view.visible)

    def _start(self, setting: Setting) -> tuple[float, ...]:
        """The own start that is typed; a wall has none."""
        away = self.away(setting)
        return tuple(0.0 if name in away else self.panel.chosen[name] for name in START_FIELDS)

    def draw(self, setting: Setting, result: PartialDiagram | None) -> None:
        """The diagram and the one to compare with."""
        other = None if result is None else _compared(setting, result.question)
        if self._searches:
            notes = self.search_questions(setting)[1]
            self.searches.draw(setting, self.view.over, self._coordinate(setting), notes)
        shipped = self._shipped(setting) if result is None else None
        self.view.update(setting, result, self._coordinate(setting), other, self.searches.lines.values, shipped)
        self.panel.key_title, self.panel.key = f"Motion over {self.view.axis_label}", legend()

    def _shipped(self, setting: Setting) -> Diagram | None:
        """The shipped diagram of what is asked, as long as the solvers are being compiled."""
        chosen = self.panel.chosen
        if (chosen["solver"], chosen["direction"], self.view.over) != ("reference", "rest", "eta"):
            return None
        return diagram_for_now(setting, lambda: self.host.call_later(self._push))

    def _coordinate(self, setting: Setting) -> str:
        """The chosen coordinate; of body 1 where body 2 is a wall."""
        chosen = self.panel.chosen["coordinate"]
        return chosen.replace("2", "1") if setting.bodies == "wall" else chosen

    def describe(self, setting: Setting, result: PartialDiagram) -> list[list[str]]:
        """The nearest η, the whole range, and the branches that were found."""
        return [*statements(setting, result), *self.searches.words()]

    def data(self) -> dict[str, object]:
        """The diagram and the branches."""
        results = self.searches.results
        branches = {f"branches_{solver}": result.data() for solver, result in results.items()}
        return super().data() | self._shown_in_units(branches)

    def table(self, name: str) -> list[Series]:
        """All points of the diagram, also of what is drawn in grey; or the stretches of η with one period."""
        if name in _BRANCH_TABLES:
            tables = {solver: getattr(result, _BRANCH_TABLES[name])() for solver, result in self.searches.found.items()}
            return [Series(NAMES[solver], table) for solver, table in tables.items()]
        if name == "bifurcation_strip":
            over = self.result.question.over
            columns = dict(zip((f"from_{over}", f"to_{over}", "period", "kind"), self.result.stretches(), strict=True))
            columns["kind"] = kind_names(columns["kind"])
            return [Series(_label(self.result.question), columns)]
        other = _compared(self._result_setting, self.result.question)
        coordinate = self._coordinate(self._result_setting)
        return [_points(result, coordinate) for result in (self.result, other) if result is not None]

    def python(self, setting: Setting) -> str:
        """`EtaStudy` over the range in view."""
        return diagram_python(self.script_question(setting), self._asked())

    def command(self, setting: Setting) -> str:
        """``vibroscope sweep eta`` over the range in view."""
        return diagram_command(self.script_question(setting), self._asked())

    def _asked(self) -> dict[str, BranchesQuestion]:
        """The branches that are shown, by the name of their result."""
        return {f"branches_{solver}": result.question for solver, result in self.searches.results.items()}

    def take_over(self, name: str, x: float, y: float) -> None:
        """Open the motion of a branch where a click in the diagram means one; else set the swept number."""
        if name != "bifurcation" or not self.searches.tapped(x, y):
            over = self.view.over
            self.host.set(self._move.setting.with_contact({over: print_number(SWEPT[over].rounded(x))}))


_BRANCH_TABLES = {"bifurcation_branches": "orbit_table", "bifurcation_points": "point_table"}
_STANDS_FOR = (
    "The exact penalty stands for {}, which has a time step: its K and D are the same, and it is what the motions tend "
    "to as the step falls."
)


def _branch_solver(solver: str) -> str:
    return "reference" if solver == "reference" else "penalty"


def _method(setting: Setting, solver: str) -> Method:
    if solver == "exact":
        return ExactPenalty(setting.K, setting.D)
    return setting.reference if solver == "reference" else setting.penalty


def _compared(setting: Setting, question: DiagramQuestion) -> PartialDiagram | None:
    """A diagram that was computed before: in the other direction, or of the reference beside a penalty solver."""
    if question.direction == "rest":
        if question.over in METHOD_NUMBERS:
            return None
        reference = question._replace(method=setting.reference)
        return RESULTS.get(reference) if reference != question else None
    return RESULTS.get(question._replace(direction="down" if question.direction == "up" else "up"))


def _label(question: DiagramQuestion) -> str:
    return f"{name_of(question.method)} {DIRECTION_NAMES[question.direction]}"


def _points(result: PartialDiagram, coordinate: str) -> Series:
    eta, values = result.points(coordinate, None)
    return Series(_label(result.question), {result.question.over: eta, coordinate: values})
