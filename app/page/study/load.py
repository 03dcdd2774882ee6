"""Pulse or record: both solutions under a load that is no harmonic, with their peaks, and the shock response."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import panel as pn
from bokeh.core.properties import value
from bokeh.models import Line
from vibroscope.app.explorer.field_units import ShownField, beside_field
from vibroscope.app.explorer.link import ViewChoice
from vibroscope.app.explorer.load_words import words_of_difference, words_of_load, words_of_peak_force, words_of_run
from vibroscope.app.explorer.measured import LARGEST_FILE
from vibroscope.app.explorer.state import SOLVERS, Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import load_command, load_python
from vibroscope.app.page.shared.component import Upload, too_large
from vibroscope.app.page.shared.curves import Axis, Curves, Plot, curve
from vibroscope.app.page.shared.figure import INK, SOLUTIONS, SUBSCRIPTS, VIOLET, symbols
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.shared.seen import amount, largest, of_both
from vibroscope.app.page.study.peaks import peak_table
from vibroscope.app.page.study.tab import StudyView, refusal
from vibroscope.app.studies.load import COLUMNS, RATIOS, LoadQuestion, PartialRuns, Pulse, RecordFile, grow_load
from vibroscope.engine.facts import Statement, sentence, stated
from vibroscope.engine.load import ON, quantity_of

_ONE = {"line_color": INK, "line_width": 2}  # what is of neither solution, or of both
_MOTIONS = {f"{solver}{body}": (solver, body) for solver in SOLVERS for body in (1, 2)}
_DASHED = {"line_dash": "dashed"}
_FORCES = {solver: (solver, look) for solver, look in SOLUTIONS.items()}
_RESPONSES = {"with": ("with the stop", _ONE), "without": ("without it", _ONE | _DASHED | {"line_color": VIOLET})}


def _plot(name: str, title: str, x: str, y: str, entries: dict[str, tuple[str, dict]]) -> Plot:
    drawn = {
        entry: (words, [curve(Line, f"{name}_{entry}", x="x", y="y", hovered=True, **look)])
        for entry, (words, look) in entries.items()
    }
    return Plot(title, x, y, drawn, {"at": "@x", "value, without dimension": "@y"})


def _named(solver: str, body: int) -> tuple[str, dict]:
    return f"ξ{SUBSCRIPTS[body]} {solver}", SOLUTIONS[solver] | (_DASHED if body == 2 else {})


class LoadView(Curves):
    """Four figures, three of them with one axis of time."""

    axes = {  # noqa: RUF012 - read only
        "time": Axis(0.0, 1.0, "time τ", "time"),
        "load": Axis(0.0, 1.0, ON["base"], quantity_of("base")),
        "motion": Axis(0.0, 1.0, "displacements ξ₁, ξ₂", "displacement"),
        "force": Axis(0.0, 1.0, "contact force λ", "force"),
        "ratio": Axis(
            float(RATIOS[0]), float(RATIOS[-1]), "natural frequency of body 1", "frequency", logarithmic=True
        ),
        "response": Axis(0.0, 1.0, "largest acceleration of body 1", "acceleration"),
    }
    plots = {  # noqa: RUF012 - read only
        "load_course": _plot("load_course", "Load", "time", "load", {"load": ("", _ONE)}),
        "load_motion": _plot(
            "load_motion", "Displacements", "time", "motion", {entry: _named(*of) for entry, of in _MOTIONS.items()}
        ),
        "load_force": _plot(
            "load_force", "Contact force", "time", "force", {n: (n, look) for n, look in SOLUTIONS.items()}
        ),
        "load_shock": _plot("load_shock", "Shock response", "ratio", "response", _RESPONSES),
    }

    def update(self, setting: Setting, result: PartialRuns | None) -> None:
        """Draw what is known."""
        self._label(setting, "base" if result is None else result.question.source.on)
        if result is None:
            return
        curves = {} if result.load is None else _curves(setting, result)
        for source in self.sources:
            self.write(source, dict(zip("xy", curves.get(source, ((), ())), strict=True)))
        if result.load is None:
            return
        fresh = self.changes_to(result.question)
        self.follow("load", "motion", "force", "response", fresh=fresh)
        self.ranges["time"].put(0.0, float(curves["load_course_load"][0][-1]), fresh=fresh)
        for name, seen in self._seen(setting, result.load.on, curves).items():
            self.say(name, seen, setting)

    def _label(self, setting: Setting, on: str) -> None:
        wall = setting.bodies == "wall"
        others = {"motion": ("displacement ξ", "displacement")} if wall else {}
        self.label(setting, load=(ON[on], quantity_of(on)), **others)
        for entry, (_, body) in _MOTIONS.items():
            item, words = self.items["load_motion", entry], self.plots["load_motion"].entries[entry][0]
            item.label = value(symbols(setting, words.replace("₁", "") if wall else words))
            show_entry(item, not (wall and body == 2))
        if setting.scale is None:
            self.units["time"].show("time τ", 1.0)
            self.units["ratio"].show("natural frequency of body 1 / ω₁", 1.0)

    def _seen(self, setting: Setting, on: str, curves: dict) -> dict[str, str | Statement]:
        """What is seen in each figure."""
        of_load, scale = quantity_of(on), setting.scale

        def most(source: str, quantity: str) -> float | None:
            """The largest size of a curve; columns have no dimension, and the axes have the units."""
            return largest([(scale.factor(quantity) if scale else 1.0) * np.asarray(curves.get(source, ((), ()))[1])])

        seen = {"load_course": "", "load_shock": ""}
        if (peak := most("load_course_load", of_load)) is not None:
            seen["load_course"] = stated("at most {}", amount(peak, of_load, setting))
        both = [[most(f"load_motion_{solver}{body}", "displacement") for body in (1, 2)] for solver in SOLVERS]
        tops = [max((each for each in of_one if each is not None), default=None) for of_one in both]
        seen["load_motion"] = of_both("at most", tops, "displacement", setting)
        forces = [most(f"load_force_{solver}", "force") for solver in SOLVERS]
        seen["load_force"] = of_both("at most", forces, "force", setting)
        first, second = (most(f"load_shock_{entry}", "acceleration") for entry in ("with", "without"))
        if first is not None:
            numbers = amount(first, "acceleration", setting, bare=True), amount(second, "acceleration", setting)
            seen["load_shock"] = stated("{}, without the stop {}", *numbers)
        return seen


def _curves(setting: Setting, result: PartialRuns) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """What is known of each curve, by its source."""
    known, response = result.curves, result.response
    names = {("load", "load"): "load_course_load"} | {
        (solver, "contact_force"): f"load_force_{solver}" for solver in SOLVERS
    }
    names |= {
        (solver, f"displacement{body}"): f"load_motion_{entry}"
        for entry, (solver, body) in _MOTIONS.items()
        if body == 1 or setting.bodies != "wall"
    }
    curves = {source: known[name] for name, source in names.items() if name in known}
    if response:
        curves["load_shock_with"] = response["ratio"], response["acceleration"]
        curves["load_shock_without"] = response["ratio"], response["acceleration_without"]
    return curves


_KINDS = {
    "half_sine": "half-sine",
    "trapezoid": "trapezoid",
    "sawtooth": "sawtooth (terminal peak)",
    "sweep": "sine sweep",
    "record": "record from a file",
}
_NUMBERS = {  # of each kind, in the order in which its function takes them
    "half_sine": ("size", "duration"),
    "trapezoid": ("size", "duration", "rise"),
    "sawtooth": ("size", "duration"),
    "sweep": ("size", "begin", "end", "duration"),
    "record": (),
}
_MOST, _POSITIVE = 1e9, 1e-6  # ends of what can be typed
_TIME, _FREQUENCY = ("time", "1/ω₁"), ("frequency", "ω₁")  # quantities, and what one of them is without units
_FREE = 25.0  # 1/ω₁: some four natural periods of body 1


class LoadTab(StudyView):
    """The load, both motions, the contact force, the shock response, and the table of peaks."""

    key = "load"
    title = "Pulse or record"
    starts = True
    grow = staticmethod(grow_load)
    drawn, arrangement, listed = LoadView, ("halves", "load"), "Largest values of both solutions"
    needs = {"": "runs", "load_shock": "response"}  # noqa: RUF012 - read only
    choices = (
        ViewChoice("kind", "Load", "half_sine", _KINDS),
        ViewChoice("on", "it is", "base", ON, of_body_2=("force2",)),
        ViewChoice("size", "peak", 3.0, {}, (-_MOST, _MOST)),
        ViewChoice("duration", "duration", 3.0, {}, (_POSITIVE, _MOST), "", *_TIME),
        ViewChoice("rise", "rise", None, {}, (0.0, _MOST), "time to the peak; a tenth of the duration", *_TIME),
        ViewChoice("begin", "from", 0.5, {}, (_POSITIVE, _MOST), "frequency at the start", *_FREQUENCY),
        ViewChoice("end", "to", 3.0, {}, (_POSITIVE, _MOST), "frequency at the end", *_FREQUENCY),
        ViewChoice("free", "after it", _FREE, {}, (0.0, _MOST), "time of free motion", *_TIME),
    )
    extras = {  # noqa: RUF012 - read only
        "file": {
            "label": "Choose a file",
            "drop": "Drop the record: a column of times and one of the load",
            "largest": LARGEST_FILE,
        }
    }
    hint = (
        "Both solutions run from the start that is set; the load replaces harmonic motion and forces. Constant forces "
        "stay, and the time step is the one that is set. A record is CSV, as time [s], a [g], or .AT2 of PEER. In the "
        "shock response the spring of body 1 varies; its damping ratio, K, D and body 2 stay. What needs a period "
        "(kind of motion, diagrams, branches, basins) has no meaning here."
    )
    pictures = (
        Figure("load_course", "Load", "The load over time."),
        Figure("load_motion", "Displacements under the load", "Displacements of both solutions relative to the base."),
        Figure("load_force", "Contact force under the load", "Contact force of both solutions."),
        Figure(
            "load_shock",
            "Shock response",
            "Largest acceleration of body 1 over its natural frequency, with and without the stop; all else stays.",
        ),
        Figure("load_peaks", "Peaks under the load", "Largest values of both solutions.", drawn=False),
    )

    _record: tuple[str, bytes] | None = None  # name and content of the file
    _refused = ""  # why the last file is not taken

    def build(self) -> pn.Column:
        """See `StudyView`; the panel takes a file."""
        page = super().build()
        self.panel.listen(**Upload(self._begin, self._take_file).acts)
        return page

    def away(self, setting: Setting) -> dict[str, list[str]]:
        """The numbers that the load does not have, and body 2 beside a wall."""
        kind = self.panel.chosen["kind"]
        idle = [each.name for each in self.choices if each.bounds and each.name not in (*_NUMBERS[kind], "free")]
        idle += ["file"] if kind != "record" else []
        return super().away(setting) | {name: [] for name in idle}

    def obstacle(self, setting: Setting) -> str:
        """Why there is no such load."""
        chosen = self.panel.chosen
        if chosen["kind"] == "record" and self._record is None:
            return self._refused or "Choose the file of a record, or drop it on the page."
        most = chosen["duration"] / 2
        if chosen["kind"] == "trapezoid" and (chosen["rise"] or 0.0) > most:
            field = self.fields(setting)["rise"]
            rise, most = (f"{field.number(value)} {field.unit}".rstrip() for value in (chosen["rise"], most))
            return f"A rise of {rise} is more than half of the duration: give at most {most}."
        return refusal(lambda: self.question(setting))

    def question(self, setting: Setting) -> LoadQuestion:
        """All that the runs depend on; the steps are those of a natural period of body 1 with the same time step."""
        chosen, penalty = self.panel.chosen, setting.penalty
        on = "force1" if setting.bodies == "wall" and chosen["on"] == "force2" else chosen["on"]
        if chosen["kind"] == "record":
            source = RecordFile(*(self._record or ("", b"")), on, setting.own_units, setting.scale is not None)
        else:
            source = Pulse(chosen["kind"], on, tuple(chosen[name] for name in _NUMBERS[chosen["kind"]]))
        steps = max(1, math.ceil(setting.eta * setting.steps * (1.0 - 1e-9)))
        penalty = replace(penalty, steps=steps)
        return LoadQuestion(setting.system, source, setting.reference, penalty, chosen["free"], setting.own_start)

    def draw(self, setting: Setting, result: PartialRuns | None) -> None:
        """Figures and table."""
        self.view.update(setting, result)
        known = result is not None and "penalty" in result.runs
        self.list.param.update(near=peak_table(result, setting) if known else {}, visible=known)

    def fields(self, setting: Setting) -> dict[str, ShownField]:
        """See `StudyView`; the quantity of the peak is that of what is loaded."""
        peak = beside_field(setting, "peak", "largest value", quantity_of(self.panel.chosen["on"]))
        return super().fields(setting) | {"size": peak}

    # -- the file -----------------------------------------------------------------

    def _begin(self, name: str, size: float) -> None:
        self._record = None
        self._refused = too_large(size, "samples or fewer digits", "vibroscope transient")
        self.panel.file = name
        self._choose(self.panel.chosen | {"kind": "record"})

    def _take_file(self, content: bytes) -> None:
        self._record = self.panel.file, content
        self.refresh()

    # -- what it says ---------------------------------------------------------------

    def describe(self, setting: Setting, result: PartialRuns) -> list[list[str | Statement]]:
        """The load, the difference and its parts, and both motions."""
        if result.load is None:
            return [["Nothing to show", sentence(result.ended)]]
        end = max(run.response.window[1] for run in result.runs.values())
        lines = [["Load", sentence(words_of_load(result.load, end))]]
        if result.difference is not None:
            lines.insert(0, ["Do they agree?", f"They differ by {words_of_difference(result.difference)}."])
        if result.exact is not None and (text := words_of_peak_force(result.runs["penalty"], result.exact)):
            lines.append(["Largest contact force", stated("{}.", text)])
        if result.contact:
            lines.append(["Contact", sentence(result.contact)])
        elif result.ended:
            lines.insert(0, ["Do they agree?", sentence(result.ended)])
        for solver, run in result.runs.items():
            text = stated("{}.", words_of_run(run)) if run.ok else sentence(run.response.ending)
            lines.append([f"{solver.capitalize()} solution", text])
        if result.unanswered:
            lines.append(["Shock response", sentence(result.unanswered)])
        return lines

    def table(self, name: str) -> list[Series]:
        """The columns of a figure, in the units that are shown."""
        result = self.result
        tables = {
            "load_course": {"load": result.load_over_time()},
            "load_shock": {"shock response": result.response},
            "load_peaks": {
                solver: {n: np.array([peak]) for n, peak in run.peaks.items()} for solver, run in result.whole()
            },
        }
        found = tables.get(name) or result.over_time()
        series = (Series(label, columns) for label, columns in found.items())
        return [each._replace(columns=self._shown_in_units(each.columns)) for each in series]

    def data(self) -> dict[str, object]:
        """The numbers so far, in the units that are shown."""
        result = self.result
        if result.load is None:
            return {}
        return self._shown_in_units(
            {
                "load": result.load_over_time(),
                "runs": result.over_time(),
                "peaks": {solver: run.peaks for solver, run in result.whole()},
                "difference": None if result.difference is None else result.difference.parts,
                "shock_response": result.response,
            }
        )

    @property
    def quantities(self) -> Mapping[str, str]:
        """See `StudyView`."""
        return COLUMNS | {"load": quantity_of(self.result.load.on)}

    def python(self, setting: Setting) -> str:
        """A script that runs both solutions."""
        return "" if self.result is None else load_python(self.result.question)

    def command(self, setting: Setting) -> str:
        """``vibroscope transient``."""
        return "" if self.result is None else load_command(setting, self.result.question)
