"""Speed against error: what a period costs at the present setting and its error, measured while a user watches."""

import math
from collections.abc import Sequence

import numpy as np
import panel as pn
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, LabelSet, Legend, LegendItem, Line, Scatter
from bokeh.plotting import figure
from vibroscope.app.explorer.method_words import CUT, brief_name, name_of_integrator
from vibroscope.app.explorer.present import as_float32
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import speed_python
from vibroscope.app.page.files import style
from vibroscope.app.page.shared.curves import Axis, Curve, Curves, Plot, curve
from vibroscope.app.page.shared.figure import BLUE, CLICK, GREEN, GREY, INK, VERMILLION, VIOLET, add_glyph
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.shared.ranges import extent
from vibroscope.app.page.shared.seen import say
from vibroscope.app.page.study.tab import StudyView, free_obstacle, method_lines
from vibroscope.app.studies.speed import (
    CHECKED,
    KINDS,
    PERIODS,
    SWEPT,
    PartialSpeed,
    SolverKey,
    SpeedQuestion,
    grow_speed,
)
from vibroscope.engine import TimeStepping, Units, written

_LOOKS = {  # colour and dash of each kind; width of a line, or marker of points over the steps
    "reference": (BLUE, "solid", 4),
    "exact": (VIOLET, "dashed", 2),
    "fixed": (VERMILLION, "solid", "diamond"),
    "plain": (GREY, "dotted", "square"),
    "located": (GREEN, "dashed", "circle"),
}
_FLOOR = 1e-16  # of a double; an error of 0 lies here
_PRESENT = ("cost", "error", "text", "align", "right", "up")  # the two last: from the ring to its text, px
_NO_ERRORS = (1e-10, 1.0)  # ends of the axis without data
_ALL = (1e-30, 1e30)  # a cost without an error: a line over any error that is shown


def _decades(least: float, greatest: float) -> tuple[float, float]:
    """Whole decades that hold all sizes, with room for a mark at either end."""
    low, high = np.log10([least, greatest])
    return float(10.0 ** (math.floor(low - 0.15))), float(10.0 ** (math.ceil(high + 0.15)))


def _drawn(kind: str) -> list[Curve]:
    colour, dash, more = _LOOKS[kind]
    place = {"x": "cost", "y": "error", "line_color": colour}
    if kind not in SWEPT:
        return [curve(Line, f"speed_{kind}", **place, line_dash=dash, line_width=more, line_alpha=0.75)]
    line = curve(Line, f"speed_{kind}", **place, line_dash=dash, line_width=1.5)
    return [line, curve(Scatter, f"speed_{kind}", **place, fill_color=colour, marker=more, size=10, hovered=True)]


def _key(plot: figure, items: list[LegendItem]) -> None:
    plot.add_layout(Legend(items=items, orientation="horizontal", ncols=2, click_policy=CLICK), "above")


class SpeedView(Curves):
    """The figure of error over cost."""

    axes = {  # noqa: RUF012 - read only
        "cost": Axis(0.1, 1e3, "processor time per period / µs (further left: faster)", logarithmic=True, fit=_decades),
        "error": Axis(*_NO_ERRORS, logarithmic=True),
    }
    plots = {  # noqa: RUF012 - read only
        "speed": Plot(
            "Being measured …",
            "cost",
            "error",
            {kind: (kind, _drawn(kind)) for kind in KINDS},
            {"steps per period": "@n", "solves": "@solves", "µs per period": "@cost", "error": "@error"},
            legend=_key,
        )
    }

    def __init__(self) -> None:
        super().__init__()
        self.present = ColumnDataSource({name: [] for name in _PRESENT}, name="speed_present")
        self.figure = self.figures["speed"]
        ring = {"marker": "circle", "size": 22, "fill_color": None, "line_color": INK, "line_width": 2.2}
        add_glyph(self.figure, Scatter(x="cost", y="error", **ring), self.present)
        place = {"x_offset": "right", "y_offset": "up", "text_align": "align", "text_baseline": "middle"}
        look = {"text_color": INK, "text_font_size": "12px", "text_font_style": "bold"}
        look |= {"background_fill_color": "#FFFFFF", "background_fill_alpha": 0.8}
        self.figure.add_layout(LabelSet(x="cost", y="error", text="text", source=self.present, **place, **look))

    def update(self, setting: Setting, result: PartialSpeed | None) -> None:
        """Draw what is known; the ring follows the switch between fixed and located steps."""
        if result is None:
            return
        fresh = self.changes_to(result.question)
        self._name(result)
        self.figure.yaxis.axis_label = error_label(setting)
        turns = f"{result.rounds} run{'s' if result.rounds > 1 else ''}"
        say(self.figure, f"Error against time, medians of {turns}", _seen(setting, result))
        for kind in KINDS:
            if kind in SWEPT:  # empty for a kind that the law does not have
                self.write(f"speed_{kind}", _columns(result, result.curve(kind)))
            else:
                self.write(f"speed_{kind}", {"cost": np.full(2, result.stepless(kind)), "error": np.array(_ALL)})
        self.follow("cost", fresh=fresh)
        errors = extent([self.sources[f"speed_{kind}"].data["error"] for kind in SWEPT])
        self.ranges["error"].put(*(_decades(*errors) if errors else _NO_ERRORS), fresh=fresh and errors is not None)
        self._ring(setting, result)

    def _ring(self, setting: Setting, result: PartialSpeed) -> None:
        named = _ringed(setting, result)
        shown = [key for key in named if math.isfinite(result.errors.get(key, math.nan))]
        columns = as_float32(_columns(result, shown))  # as the marks that it rings have them
        # Errors fall as costs rise, so there are no points above and to the right of one: the text goes there. In the
        # right half of the figure it goes below and to the left, so that it stays inside a narrow figure.
        half = math.sqrt(self.figure.x_range.start * self.figure.x_range.end)
        right = columns["cost"] < half
        now = {
            "cost": columns["cost"].tolist(),
            "error": columns["error"].tolist(),
            "text": [named[key] for key in shown],
            "align": np.where(right, "left", "right").tolist(),
            "right": np.where(right, 7, -7).tolist(),
            "up": np.where(right, 17, -17).tolist(),
        }
        if now != self.present.data:
            self.present.data = now

    def _name(self, result: PartialSpeed) -> None:
        """Name the entries of the legend after the method; those of kinds that its law does not have are left out."""
        names = names_of(result.question.method, result.question.kinds)
        for kind, item in zip(KINDS, self.figure.legend[0].items, strict=True):
            show_entry(item, kind in names)
            item.label = value(names.get(kind, kind))


def _ringed(setting: Setting, result: PartialSpeed) -> dict[SolverKey, str]:
    """What is set, and the same step in a code that takes every one."""
    n = result.question.method.steps
    if setting.located == "yes":
        return {SolverKey("located", n): "set"}
    return {SolverKey("fixed", n): "set", SolverKey("plain", n): "in an FE code"}


def _seen(setting: Setting, result: PartialSpeed) -> str:
    """Error and cost of what is set."""
    key = next(iter(_ringed(setting, result)))
    if not math.isfinite(result.errors.get(key, math.nan)):
        return f"T/{key.steps} ended early"
    return f"T/{key.steps} errs by {written(result.errors[key], 2)} in {written(result.cost(key), 2)} µs per period"


def error_label(setting: Setting) -> str:
    """The label of the axis of errors, with the amplitude that they are multiples of."""
    return f"error after {CHECKED} periods / {_error_unit(setting)} (further down: more exact)"


def error_column(setting: Setting) -> str:
    """Name of the column of errors in a file: with units it says what they are multiples of, as the axis does."""
    return "error" if setting.scale is None else f"error [{_error_unit(setting)}]"


def _error_unit(setting: Setting) -> str:
    scale = setting.scale
    ones = ("A", "Aω₁") if scale is None else tuple(scale.text(name, 1.0) for name in ("displacement", "velocity"))
    return f"{ones[0]}, or {ones[1]} of a velocity"


def names_of(method: TimeStepping, kinds: Sequence[str]) -> dict[str, str]:
    """The name of each kind of solver in the legend."""
    name = brief_name(method)
    names = {
        "reference": "reference",
        "exact": "exact penalty",
        "fixed": f"{name}, {'steps skipped' if 'plain' in kinds else 'every step taken'}",
        "plain": f"{name}, plain loop",
        "located": f"{name_of_integrator(method.integrator.name)}, {CUT}",
    }
    return {kind: names[kind] for kind in kinds}


def _columns(result: PartialSpeed, keys: list[SolverKey]) -> dict[str, np.ndarray]:
    return {
        "cost": np.array([result.cost(key) for key in keys]),
        "error": np.array([max(result.errors[key], _FLOOR) for key in keys]),
        "n": np.array([float(key.steps) for key in keys]),
        "solves": np.array([result.solves[key] for key in keys]),
    }


# Served from assets/speed; `benchmarks/work_precision.py --write` renews it.
FIGURE = "speed/work-precision.svg"
_SHIPPED = f"""
<article class="text shipped">
<details>
<summary>Six problems and other solvers, as measured and shipped</summary>
<p>Error after ten periods against 60-digit solutions, over the time that one period takes. The solvers in closed form
are single points: they have no time step. Newmark's error falls about as the step, and irregularly, since each contact
change is missed by a part of a step; that of steps that are cut where contact changes falls as its
square.</p>
<img class="figure" src="{FIGURE}" alt="Error after ten periods against time per period for six problems: the closed
form solvers lie furthest to the lower left, plain Newmark furthest to the upper right.">
</details>
<p><a class="figure-link" href="{FIGURE}" target="_blank" rel="noopener">Open the figure by itself</a></p>
</article>
"""


class Speed(StudyView):
    """Work and precision at the present η, K, D and n; what was shipped is behind a disclosure."""

    key = "speed"
    title = "Speed against error"
    grow = staticmethod(grow_speed)
    drawn, place, arrangement = SpeedView, "wide", ("speed",)
    hint = (
        f"Error: the largest of the four state components after {CHECKED} periods, against the exact penalty model, "
        f"divided by what the axis names. Cost: processor time of this machine over {PERIODS} periods, all solvers in "
        "turn. Vertical lines: the reference and the exact penalty model, without a time step and without this error. "
        "Integrator, contact status and law are those that are set under Solver."
    )
    pictures = (Figure("speed", "Speed against error", "Error after ten periods over processor time per period."),)

    def build(self) -> pn.Column:
        """See `StudyView`; the shipped figure below."""
        page = super().build()
        shipped = pn.pane.HTML(
            _SHIPPED, stylesheets=[style("shared/text")], sizing_mode="stretch_width", sanitize_html=False
        )
        shipped.css_classes = ["cell", "wide"]
        page.append(shipped)
        return page

    def obstacle(self, setting: Setting) -> str:
        """Why there is no study: nothing drives the bodies."""
        return free_obstacle(setting, "this measurement") if setting.from_rest else ""

    def question(self, setting: Setting) -> SpeedQuestion:
        """All that costs or errors depend on; fixed or located, both are measured."""
        asked = setting.system, setting.eta, setting.constant_step, setting.reference, setting.own_start
        return SpeedQuestion(*asked, setting.step_scale if setting.follows_step else None)

    def table(self, name: str) -> list[Series]:
        """A row for each solver and n."""
        found = self.result.data()
        columns = {"steps": found["solver_steps"]} | {n: found[n] for n in ("us_per_period", "solves_per_period")}
        columns[self._error_column()] = found["error"]
        kinds = np.array(found["solver"])
        return [
            Series(kind, {name: np.asarray(column)[kinds == kind] for name, column in columns.items()})
            for kind in dict.fromkeys(found["solver"])
        ]

    def data(self) -> dict[str, object]:
        """The results so far, in the units that are shown; the errors under the name that they have in the table."""
        return {self._error_column() if n == "error" else n: each for n, each in super().data().items()}

    def _error_column(self) -> str:
        return error_column(self.shown_setting() or Setting())

    def describe(self, setting: Setting, result: PartialSpeed) -> list[list[str]]:
        """The measurement and the figure in words."""
        return [*method_lines(result.question, "an exact model"), *statements(setting, result)]

    def python(self, setting: Setting) -> str:
        """A script of the same measurement; it runs on another machine or at another time, so its numbers differ."""
        return speed_python(self.script_question(setting))


def statements(setting: Setting, result: PartialSpeed) -> list[list[str]]:
    """Head and text: the setting, what an FE code pays for it, what the located step would, no time step."""
    n, scale = result.question.method.steps, setting.scale
    kind = "located" if setting.located == "yes" else "fixed"
    step = "step cut where contact changes" if kind == "located" else "constant step"
    lines = [
        [f"Present setting: T/{n}, {step}", _cost(result, SolverKey(kind, n), scale)],
        ["What an FE code pays", _plain_cost(result, n)],
    ]
    if "located" in result.question.kinds:
        lines.append(["With the step cut where contact changes", _located(result, n, scale)])
    return [*lines, ["Without a time step", _stepless(result)]]


def _cost(result: PartialSpeed, key: SolverKey, scale: Units | None) -> str:
    if not math.isfinite(result.errors[key]):
        other = ", or another choice for steps without a solution" if result.question.method.status == "end" else ""
        return (
            f"No error: this run or the exact penalty model's gave up within {CHECKED} periods. "
            f"Take a smaller step{other}."
        )
    return (
        f"error {_error(result.errors[key], scale)} after {CHECKED} periods, for {result.cost(key):.3g} µs per period."
    )


def _error(error: float, scale: Units | None) -> str:
    """An error of any of the four state components, with its unit."""
    if scale is None:
        return f"{written(error, 2)} A (Aω₁ of a velocity)"
    return f"at most {scale.text('displacement', error, 2)} and {scale.text('velocity', error, 2)}"


def _plain_cost(result: PartialSpeed, n: int) -> str:
    plain, skipping = SolverKey("plain", n), SolverKey("fixed", n)
    if "plain" not in result.question.kinds:
        return (
            f"{n} steps per period, one by one: {result.cost(skipping):.3g} µs for two bodies, "
            f"{1000 * result.cost(skipping) / n:.3g} ns a step, in which this law is solved for. A code with more "
            "unknowns pays more for each step: count steps."
        )
    return (
        f"{n} steps per period, one by one: {result.cost(plain):.3g} µs in a plain loop over two bodies, "
        f"{1000 * result.cost(plain) / n:.3g} ns a step. This page skips steps and finds the same solution "
        f"{result.times(plain, skipping):.3g} times as fast, but an FE code cannot skip. A code with more unknowns "
        "pays more for each step: count steps."
    )


def _located(result: PartialSpeed, n: int, scale: Units | None) -> str:
    """The located step with the fewest solves that is as exact as the fixed step at n, or all there is to say."""
    fixed = result.errors[SolverKey("fixed", n)]
    if not math.isfinite(fixed):
        return f"T/{n}: {_cost(result, SolverKey('located', n), scale)}"
    enough = [key for key in result.curve("located") if result.errors[key] <= fixed]
    if not enough:
        this = _cost(result, SolverKey("located", n), scale)
        return f"None of those tried is as exact as the fixed step of T/{n}. T/{n}: {this}"
    best, solves = min(enough, key=result.solves.get), result.solves[SolverKey("fixed", n)]
    return (
        f"T/{best.steps}: {_cost(result, best, scale)} That is no worse than the fixed step of T/{n}. Steps are cut "
        f"at the contact changes, so it takes {result.solves[best]:.0f} solves per period beside {solves:.0f}, "
        f"{_share(result.solves[best] / solves)}."
    )


def _share(ratio: float) -> str:
    return f"{1 / ratio:.2g} times fewer" if ratio < 1 else f"{ratio:.2g} times as many"


def _stepless(result: PartialSpeed) -> str:
    return (
        f"the reference takes {result.stepless('reference'):.3g} µs per period, the exact penalty model "
        f"{result.stepless('exact'):.3g} µs."
    )
