"""Speed against error: cost to the right, error up, both logarithmic; what is set is ringed and named."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, LabelSet, Legend, LegendItem, Line, Scatter
from bokeh.plotting import figure
from vibroscope.app.explorer.method_words import CUT, brief_name, name_of_integrator
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.curves import Axis, Curve, Curves, Plot, curve
from vibroscope.app.page.shared.figure import BLUE, CLICK, GREEN, GREY, INK, VERMILLION, VIOLET, add_glyph
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.shared.ranges import extent
from vibroscope.app.page.shared.seen import say
from vibroscope.app.studies.speed import CHECKED, KINDS, SWEPT, PartialSpeed, SolverKey
from vibroscope.engine import TimeStepping, written

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
