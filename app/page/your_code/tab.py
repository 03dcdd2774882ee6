"""Your code: what a simulation code shows by default, whether its steps have solutions, and what its rules give."""

import math

import numpy as np
import panel as pn
from bokeh.models import Line, Scatter
from vibroscope.app.codes.catalogue import Code, codes
from vibroscope.app.codes.rules import rules
from vibroscope.app.codes.translation import translated_codes
from vibroscope.app.explorer.compute import SHOWN_PERIODS, RunPair, shown_periods
from vibroscope.app.explorer.explanation import describe, motion_texts
from vibroscope.app.explorer.field_units import ShownField, shown_content
from vibroscope.app.explorer.link import ViewChoice
from vibroscope.app.explorer.method_words import name_of_method, words_of_method
from vibroscope.app.explorer.present import present
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.tables import column_title
from vibroscope.app.page.shared.curves import Axis, Curve, Curves, Plot, curve
from vibroscope.app.page.shared.figure import BLUE, SOLUTIONS, SUBSCRIPTS, VERMILLION, label_of, time_label
from vibroscope.app.page.shared.seen import amplitude, apart, of_both, say
from vibroscope.app.page.study.tab import StudyView
from vibroscope.app.page.tab import Move
from vibroscope.app.page.your_code import words
from vibroscope.app.page.your_code.rules import RulesTable, rows_of
from vibroscope.app.runtime.number_text import sizes
from vibroscope.app.studies.your_code import (
    CodeQuestion,
    PartialCode,
    code_lines,
    code_texts,
    grow_code,
    question_of,
    rule_texts,
    small_orbit,
)
from vibroscope.engine import QUANTITIES, counted
from vibroscope.engine.facts import Statement, joined, message_of, sentence

_DOTS = {
    "reference": {"marker": "circle", "line_color": BLUE, "fill_color": BLUE},
    "penalty": {"marker": "diamond", "line_color": VERMILLION, "fill_color": None},
}


def _phase(solver: str) -> list[Curve]:
    line = curve(Line, f"code_phase_{solver}", x="x", y="v", **SOLUTIONS[solver])
    return [line, curve(Scatter, f"code_section_{solver}", x="x", y="v", size=8, **_DOTS[solver])]


class YourCodeView(Curves):
    """Two figures; at a wall they show body 1, else body 2."""

    axes = {  # noqa: RUF012 - read only
        "x": Axis(-8, 8),
        "v": Axis(-8, 8, headroom=0.16),
        "time": Axis(0, SHOWN_PERIODS),
        "displacement": Axis(-8, 8, headroom=0.16),
    }
    plots = {  # noqa: RUF012 - read only
        "code_phase": Plot("Phase plot", "x", "v", {solver: (solver, _phase(solver)) for solver in SOLUTIONS}),
        "code_displacement": Plot(
            "Displacement",
            "time",
            "displacement",
            {
                solver: (solver, [curve(Line, f"code_trace_{solver}", x="t", y="x", **look)])
                for solver, look in SOLUTIONS.items()
            },
        ),
    }

    def update(self, setting: Setting, runs: RunPair | None, title: str) -> None:
        """Draw runs in the units of the setting; None: nothing is known yet."""
        body = setting.system.observed_body
        sub = SUBSCRIPTS[body]
        phase, displacement = self.figures.values()
        position = label_of(setting, f"displacement ξ{sub}", "displacement")
        phase.xaxis[0].axis_label = displacement.yaxis[0].axis_label = position
        phase.yaxis[0].axis_label = label_of(setting, f"velocity ξ{sub}′", "velocity")
        displacement.xaxis[0].axis_label = time_label(setting)
        name = f"{title}, body {body}"
        if runs is None:
            say(phase, name)
            return
        columns, fresh = present(RunPair(setting, runs.reference, runs.penalty)), self.changes_to(runs.setting)
        for solver in SOLUTIONS:
            for kind in ("phase", "section"):
                of = columns[f"{kind}_{solver}"]
                self.write(f"code_{kind}_{solver}", {"x": of[f"x{body}"], "v": of[f"v{body}"]})
            of = columns["displacements"]
            self.write(f"code_trace_{solver}", {"t": of["t"], "x": of[f"{solver}{body}"]})
        swings, traces = (
            [self.sources[f"code_{kind}_{s}"].data["x"] for s in SOLUTIONS] for kind in ("phase", "trace")
        )
        say(phase, name, of_both("amplitude", [*map(amplitude, swings)], "displacement", setting), setting)
        self.say("code_displacement", apart([np.subtract(*traces)], setting), setting)
        self.ranges["time"].put(0, shown_periods(setting) * setting.period, fresh=fresh)
        self.follow("x", "v", "displacement", fresh=fresh)


_NUMBER = (0.0, {}, (0.0, 1e15))  # 0: not known
_WITHOUT_UNITS = "Without dimension; the damper of the force is 2D. Choose units under “Units” for those of your model."
NONE = "none"  # no code is chosen: the page's own choice of integrator, status and law
_TARGETS = {key: code.name for key, code in translated_codes(write=True).items() if key in codes()}
_NEWMARK = "Newmark (β = 0.25, γ = 0.5); contact status from the start of the step; contact law Kelvin–Voigt"


class YourCode(StudyView):
    """One code at a time, over the reference; its rules of thumb, one after the other."""

    key = "code"
    title = "Your code"
    grow = staticmethod(grow_code)
    drawn, arrangement = YourCodeView, ("codes",)
    needs = {"code_rules": "judged"}  # noqa: RUF012 - read only
    choices = (
        ViewChoice(
            "code", "Code", NONE, {NONE: "choose a code …", **{key: code.name for key, code in codes().items()}}
        ),
        ViewChoice("target", "Translate into", NONE, {NONE: "physical numbers", **_TARGETS}),
        ViewChoice("area", "A", *_NUMBER, "contact area; 0: not known", "area", "A²"),
        ViewChoice(
            "elements", "EA/h", *_NUMBER, "stiffness of the elements in contact; 0: not known", "stiffness", "k₁"
        ),
        ViewChoice(words.KEY, "Its words", "", linked=False),
        ViewChoice("mass", "m*", *_NUMBER, "reduced mass; 0: of the bodies", "mass"),
        ViewChoice("speed", "v", *_NUMBER, "closing speed; 0: not known", "velocity"),
    )
    hint = (
        "Choosing a code sets its integrator, contact status and law. K, D and the step stay as they are: what its "
        "rules of thumb give is tried in the table, and “Set” takes it over; so with what its words for a contact say."
    )
    pictures = (
        Figure("code_phase", "Phase plot of your code", "Velocity over displacement, with the reference."),
        Figure("code_displacement", "Displacement of your code", "Displacement over the periods that are shown."),
        Figure("code_rules", "Rules of thumb", "What each rule of thumb gives, and what follows.", drawn=False),
    )

    def build(self) -> pn.Column:
        """See `StudyView`; the table of rules below the figures."""
        page = super().build()
        self.rules = RulesTable(self._set_rule)
        self.rules.css_classes = ["cell", "wide"]
        page.insert(2, self.rules)
        return page

    def show(self, move: Move) -> None:
        """See `StudyView`; the other tabs get the code, too."""
        self.host.code = self.choice().get("code", "")
        super().show(move)

    def _choose(self, chosen: dict) -> None:
        """Take a code, and set what it does by default."""
        before, code = self.panel.chosen["code"], codes().get(chosen["code"])
        self.host.code = code.key if code else ""
        if code is None or chosen["code"] == before:
            super()._choose(chosen)
            return
        self.panel.chosen = chosen
        self.host.set(code_texts(code))

    def away(self, setting: Setting) -> dict[str, list[str]]:
        """What is about words, while no code is chosen that has them."""
        code = codes().get(self.panel.chosen["code"])
        return {} if code and code.contact else {name: [] for name in (words.KEY, *words.FIELDS)}

    def reset(self) -> None:
        """Choose no code."""
        self.panel.chosen = dict(self.chosen)

    def _set_rule(self, key: str) -> None:
        """Set what a rule, or the words that are typed, give."""
        if key == words.KEY and isinstance(found := self._translated(self._move.setting), words.Translation):
            self.host.set(words.texts(found, self._move.setting))
        if key in rules() and self._move is not None:
            try:
                self.host.set(rule_texts(rules()[key], self.question(self._move.setting)))
            except ValueError as error:
                self.host.report_error(f"This rule gives no number here: {error}.")

    def _translated(self, setting: Setting) -> words.Translation | str:
        """What the words that are typed say, or why they say nothing; empty while there are none."""
        code = codes().get(self.panel.chosen["code"])
        if code is None or not code.contact or not self.panel.chosen.get(words.KEY):
            return ""
        try:
            return words.translation(code, self.panel.chosen, setting)
        except ValueError as problem:
            return sentence(message_of(problem))

    def question(self, setting: Setting) -> CodeQuestion:
        """All that is set but how it is drawn, and what is known of the elements."""
        return question_of(setting, self.panel.chosen["elements"] or None)

    def fields(self, setting: Setting) -> dict[str, ShownField]:
        """See `StudyView`; what stands beside the words of a code is in SI units, whatever is shown."""
        si = {each.name: each for each in self.choices if each.name in words.FIELDS}
        fields = super().fields(setting) | {
            name: ShownField(
                *(each.label, each.hint, QUANTITIES[each.quantity].units[0], 1.0),
                typed={"": 1.0, **sizes(each.quantity, 1.0)},
            )
            for name, each in si.items()
        }
        if (code := codes().get(self.panel.chosen["code"])) and code.contact:
            fields[words.KEY] = ShownField("Its words", f"for a contact, as {words.example(code)}", "", 1.0, {})
        return fields

    def draw(self, setting: Setting, result: PartialCode | None) -> None:
        """Figures and table."""
        shown = result if result is not None and result.question == self.question(setting) else None
        self.view.update(setting, shown and shown.runs, name_of_method(setting.penalty))
        self.rules.param.update(**self._content(setting, shown))

    def _content(self, setting: Setting, result: PartialCode | None) -> dict:
        code = codes().get(self.panel.chosen["code"])
        own = {}
        if code is not None:
            own = {
                "name": code.name,
                "units": "" if setting.scale else _WITHOUT_UNITS,
                "lines": list(code_lines(code, setting, self.panel.chosen["area"] or None)),
                "leaves_out": code.leaves_out,
                "sources": [vars(source) for source in code.sources],
            }
        reference = small_orbit(result.runs.reference.orbit, setting) if result else np.empty((2, 0))
        judged = result.judged if result else ()
        marked = () if code is None else code.rules
        found, table = self._translated(setting), rows_of(judged, reference, marked, setting)
        if isinstance(found, words.Translation):
            table["rows"].insert(0, words.row(found, setting))
        return {"code": own, **table}

    def describe(self, setting: Setting, result: PartialCode) -> list[list[str | Statement]]:
        """The setting, its motion, and whether its steps have solutions, in words."""
        lines = [["What is set", f"{words_of_method(setting.penalty) or _NEWMARK}."]]
        code = codes().get(self.panel.chosen["code"])
        if code is not None and (other := _other(setting, code)):
            lines.append([f"Other than in {code.name}", f"{', '.join(other).capitalize()}."])
        if said := self._translated(setting):
            lines += [["Words", said]] if isinstance(said, str) else words.statements(said)
        described = describe(result.runs)
        texts = {"penalty": described.penalty[0], "reference": described.reference[0]}
        if result.judged:
            known = motion_texts(result.runs, result.judged[0].outcome.motions)  # with evidence
            texts |= known
        lines += [["Penalty", texts["penalty"]], ["Reference", texts["reference"]]]
        if result.judged:
            lines.append(["Do they agree?", result.judged[0].outcome.brief])
        if result.solvable:
            response = result.runs.penalty.response
            counts = {"without a solution": response.steps_without_solution, "with two": response.steps_with_two}
            said = " ".join(f"{counted(count, 'step')} {what} in this run." for what, count in counts.items() if count)
            lines.append(["Do its steps have solutions?", joined(" ", filter(None, (result.solvable, said)))])
        return lines

    def table(self, name: str) -> list[Series]:
        """The curves that are drawn, or a row for each rule."""
        if name == "code_rules":
            rules = self.data()["rules"]
            return [Series(key, {n: np.array([_cell(v)]) for n, v in row.items()}) for key, row in rules.items()]
        kind = "phase" if name == "code_phase" else "trace"
        sources = {solver: self.view.sources[f"code_{kind}_{solver}"] for solver in SOLUTIONS}
        body, scale = self._result_setting.system.observed_body, self._move.setting.scale
        names = {"t": "time", "x": f"xi{body}", "v": f"velocity{body}"}
        return [
            Series(solver, {column_title(names[n], n, scale): each for n, each in source.data.items()})
            for solver, source in sources.items()
        ]

    def data(self) -> dict[str, object]:
        """The results so far; sentences, too, in the units that are shown."""
        return shown_content(super().data(), self._move.setting.scale)


def _cell(value: object) -> object:
    return "" if value is None else ", ".join(value) if isinstance(value, list) else value


def _other(setting: Setting, code: Code) -> list[str]:
    """The known defaults of a code that are set otherwise, in the words of the controls."""
    own, texts = setting.texts(), code.texts()
    names = {"integrator": "integrator", "status": "contact status", "law": "contact law"}
    names |= {
        "damper": "damper",
        "initial_acceleration": "first acceleration",
        "without_solution": "steps without a solution",
    }
    numbers = [
        f"{name} of the integrator"
        for name in ("beta", "gamma", "alpha", "rho")
        if name in code.numbers and not math.isclose(float(own[name]), float(texts[name]), rel_tol=1e-12, abs_tol=1e-15)
    ]
    return [word for name, word in names.items() if getattr(code, name) and own[name] != texts[name]] + numbers
