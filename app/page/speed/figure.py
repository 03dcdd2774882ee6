"""Speed against error: cost to the right, error up, both logarithmic; what is set is ringed and named."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, LabelSet, Legend, LegendItem
from bokeh.plotting import figure
from vibroscope.app.explorer.method_words import CUT, brief_name, name_of_integrator
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import (
    BLUE,
    CLICK,
    GREEN,
    GREY,
    INK,
    VERMILLION,
    VIOLET,
    axes_of,
    empty_source,
    hover_tool,
    make_figure,
    write,
)
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.shared.ranges import OwnedRange
from vibroscope.app.page.shared.seen import say
from vibroscope.app.studies.speed import CHECKED, KINDS, SWEPT, PartialSpeed, SolverKey
from vibroscope.engine import TimeStepping, written

_LINES = {"reference": (BLUE, "solid", 4), "exact": (VIOLET, "dashed", 2)}
_MARKS = {
    "fixed": (VERMILLION, "diamond", "solid"),
    "plain": (GREY, "square", "dotted"),
    "located": (GREEN, "circle", "dashed"),
}
_FLOOR = 1e-16  # of a double; an error of 0 lies here
_PRESENT = ("cost", "error", "text", "align", "right", "up")  # the two last: from the ring to its text, px
_EMPTY = {"cost": (0.1, 1e3), "error": (1e-10, 1.0)}  # ends of the axes without data
_ALL = (1e-30, 1e30)  # a cost without an error: a line over any error that is shown


class SpeedView:
    """The figure of error over cost."""

    def __init__(self) -> None:
        self._result: PartialSpeed | None = None
        self.ranges = {name: OwnedRange(*ends) for name, ends in _EMPTY.items()}
        self.stepless = {kind: empty_source(f"speed_{kind}", "cost", "error") for kind in _LINES}
        self.swept = {kind: empty_source(f"speed_{kind}", "cost", "error", "n", "solves") for kind in SWEPT}
        self.present = ColumnDataSource({name: [] for name in _PRESENT}, name="speed_present")
        self.figure = self._make()

    def _make(self) -> figure:
        words = "processor time per period / µs (further left: faster)", error_label(Setting())
        plot = make_figure("Being measured …", *words, name="speed", **axes_of(self.ranges, "cost", "error", "xy"))
        names, items, hovered = names_of(Setting().constant_step, KINDS), [], []
        for kind, (colour, dash, width) in _LINES.items():
            look = {"line_color": colour, "line_dash": dash, "line_width": width, "line_alpha": 0.75}
            drawn = plot.line("cost", "error", source=self.stepless[kind], **look)
            items.append(LegendItem(label=names[kind], renderers=[drawn]))
        for kind, (colour, marker, dash) in _MARKS.items():
            source = self.swept[kind]
            line = plot.line("cost", "error", source=source, line_color=colour, line_width=1.5, line_dash=dash)
            marks = plot.scatter("cost", "error", source=source, marker=marker, size=10, color=colour)
            items.append(LegendItem(label=names[kind], renderers=[line, marks]))
            hovered.append(marks)
        tips = {"steps per period": "@n", "solves": "@solves", "µs per period": "@cost", "error": "@error"}
        plot.add_tools(hover_tool(hovered, tips))
        self._mark(plot)
        plot.add_layout(Legend(items=items, orientation="horizontal", ncols=2, click_policy=CLICK), "above")
        return plot

    def _mark(self, plot: figure) -> None:
        ring = {"marker": "circle", "size": 22, "fill_color": None, "line_color": INK, "line_width": 2.2}
        plot.scatter("cost", "error", source=self.present, **ring)
        place = {"x_offset": "right", "y_offset": "up", "text_align": "align", "text_baseline": "middle"}
        look = {"text_color": INK, "text_font_size": "12px", "text_font_style": "bold"}
        look |= {"background_fill_color": "#FFFFFF", "background_fill_alpha": 0.8}
        plot.add_layout(LabelSet(x="cost", y="error", text="text", source=self.present, **place, **look))

    def update(self, setting: Setting, result: PartialSpeed | None) -> None:
        """Draw what is known; the ring follows the switch between fixed and located steps."""
        if result is None:
            return
        fresh = self._result is None or self._result.question != result.question
        self._result = result
        self._name(result)
        self.figure.yaxis.axis_label = error_label(setting)
        turns = f"{result.rounds} run{'s' if result.rounds > 1 else ''}"
        say(self.figure, f"Error against time, medians of {turns}", _seen(setting, result))
        for kind, source in self.stepless.items():
            write(source, {"cost": np.full(2, result.stepless(kind)), "error": np.array(_ALL)})
        for kind, source in self.swept.items():
            write(source, _columns(result, result.curve(kind)))  # empty for a kind that the law does not have
        self._follow(fresh)
        self._ring(setting, result)

    def _ring(self, setting: Setting, result: PartialSpeed) -> None:
        named = _ringed(setting, result)
        shown = [key for key in named if math.isfinite(result.errors.get(key, math.nan))]
        columns = _columns(result, shown)
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

    def _follow(self, fresh: bool) -> None:
        swept = self.swept.values()
        costs = np.concatenate([source.data["cost"] for source in (*self.stepless.values(), *swept)])
        errors = np.concatenate([source.data["error"] for source in swept])
        for (name, owned), sizes in zip(self.ranges.items(), (costs, errors), strict=True):
            owned.put(*(_decades(sizes) if len(sizes) else _EMPTY[name]), fresh=fresh and len(sizes) > 0)


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


def _decades(sizes: np.ndarray) -> tuple[float, float]:
    """Whole decades that hold all sizes, with room for a mark at either end."""
    low, high = np.log10([sizes.min(), sizes.max()])
    return float(10.0 ** (math.floor(low - 0.15))), float(10.0 ** (math.ceil(high + 0.15)))
