"""Three small curves: what is left of the difference if K, D or the time step alone is changed; a click sets it."""

import math
from collections.abc import Callable, Iterable, Mapping

import numpy as np
import panel as pn
import param
from bokeh.events import Tap
from bokeh.models import BasicTickFormatter, ColumnDataSource, FixedTicker, HSpan, Line, Range1d, Scatter, VSpan, VStrip
from bokeh.plotting import figure
from vibroscope.app.explorer.explanation import AloneFacts
from vibroscope.app.explorer.field_units import ShownField, shown_field
from vibroscope.app.explorer.present import as_float32
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Series
from vibroscope.app.page.files import style
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.shared.figure import (
    BARE,
    BLUE,
    GREEN,
    INK,
    PARTS,
    VERMILLION,
    add_glyph,
    divisor,
    empty_source,
    hover_tool,
    make_figure,
    show_rows,
    write,
)
from vibroscope.app.runtime.number_text import print_number
from vibroscope.engine import percent, written

Put = Callable[[ColumnDataSource, Mapping[str, np.ndarray]], None]

NUMBERS = ("K", "D", "steps")
_CURVE = ("x", "left")
_MARKS = ("now", "now_left", "best", "best_left", "equal", "floor", "from", "to")  # one row; nan where there is none
_UNRESOLVED = "#E4E8EC"
_LIMIT = 2.0  # times the most steps, where "no time step" is drawn
_TOP = 3.0  # times the difference, and of the reference: what is left is drawn up to here
_LEAST = 1e-4  # what is left is drawn down to here
_NEAR = 0.04  # of the axis: a click so near to a mark means it
_MARGIN = 1.25  # of the axes, times


class AloneHead(Component):
    """Title, state of the search, and key of the marks."""

    state = param.String(default="", doc="What is known so far; empty once all is")
    floor = param.Boolean(default=False, doc="Whether there is a part that no number mends")

    script = "explore/alone"


class AloneView:
    """The figures and what stands above them.

    Attributes
    ----------
    view : Row
        Hidden where there is nothing to search for; the figures come when they are looked at (`add_figures`).
    facts : dict or None
        What is drawn: `app.explorer.explanation.alone_facts`.
    set_texts : callable
        Sets the number of a click.
    """

    def __init__(self) -> None:
        self.set_texts: Callable[[dict[str, str]], None] = lambda texts: None
        self.facts: AloneFacts | None = None
        self._setting: Setting | None = None
        self.head = AloneHead(css_classes=["alone-head"])
        self.curves = {name: empty_source(f"left_over_{name}", *_CURVE) for name in NUMBERS}
        self.marks = {name: empty_source(f"marks_over_{name}", *_MARKS) for name in NUMBERS}
        self._left, self._ticks = Range1d(1.0, 100.0), FixedTicker(ticks=[1.0, 10.0, 100.0])
        self.figures = {name: self._build(name) for name in NUMBERS}
        panes = [pn.pane.Bokeh(plot, sizing_mode="stretch_both") for plot in self.figures.values()]
        self.panes = dict(zip(NUMBERS, panes, strict=True))
        for pane in panes:
            pane.css_classes = [*pane.css_classes, "alone-figure"]
        sheet = style("explore/alone_row")
        self._row = pn.Row(*panes, css_classes=["alone-row"], stylesheets=[sheet])
        self.view = pn.Column(self.head, css_classes=["alone-card"], stylesheets=[sheet], visible=False)

    def _build(self, name: str) -> figure:
        axes = {"x_axis_type": "log", "y_axis_type": "log", "x_range": Range1d(1.0, 10.0), "y_range": self._left}
        room = {"height": 110, "min_border_left": 44, "min_border_right": 8, "min_border_bottom": 34}
        plot = make_figure("", "", "left / %", name=f"alone_{name}", **axes, **room, **BARE)
        plot.title.text_font_size, plot.title.text_font_style = "11px", "normal"
        # that of a logarithmic axis gives multiples of one number where there are less than two decades
        plot.yaxis[0].ticker = plot.ygrid[0].ticker = self._ticks
        plot.yaxis[0].formatter = BasicTickFormatter(power_limit_low=-5)
        marks = self.marks[name]
        for glyph in (
            VStrip(x0="from", x1="to", fill_color=_UNRESOLVED, line_color=None),
            HSpan(y="floor", **PARTS["joint_damping"]),
            VSpan(x="equal", line_color=BLUE, line_width=1.4, line_dash="dashed"),
            VSpan(x="now", line_color=VERMILLION, line_width=1.0, line_dash="dotted"),
        ):
            add_glyph(plot, glyph, marks)
        line = add_glyph(plot, Line(x="x", y="left", line_color=INK, line_width=1.5), self.curves[name])
        dots = Scatter(x="x", y="left", size=3, fill_color=INK, line_color=None)
        add_glyph(plot, dots, self.curves[name])
        now = {"marker": "diamond", "size": 10, "fill_color": VERMILLION, "line_color": "white"}
        add_glyph(plot, Scatter(x="now", y="now_left", **now), marks)
        best = {"marker": "circle", "size": 9, "fill_color": None, "line_color": GREEN, "line_width": 2.2}
        add_glyph(plot, Scatter(x="best", y="best_left", **best), marks)
        plot.add_tools(hover_tool([line], {"": "@x", "left": "@left %"}, mode="vline", line_policy="nearest"))
        plot.on_event(Tap, lambda event: self.take(name, event.x))
        return plot

    @property
    def has_figures(self) -> bool:
        """Whether the figures are on the page."""
        return self._row in self.view

    def add_figures(self) -> None:
        """Add the figures to the page, unless they are there: a third of all of Explore, and folded at first."""
        if not self.has_figures:
            self.view.append(self._row)

    def _put(self, put: Put) -> Put:
        """The browser does not know the sources of figures that are not on the page."""
        return put if self.has_figures else write

    def wait(self, put: Put) -> None:
        """Draw nothing: the curves of another setting would be wrong."""
        self.facts = None
        if self.view.visible:
            self.head.state = "computing …"
        for name in NUMBERS:
            self._clear(name, self._put(put))

    def show(self, facts: AloneFacts | None, setting: Setting, put: Put) -> None:
        """Draw what is known; None: there is nothing to search for."""
        self.facts, self._setting = facts, setting
        self.view.visible = facts is not None
        if facts is None:
            return
        self.head.param.update(state=_state(facts), floor=_floor(facts) is not None)
        low, high = _left_ends(facts)
        self._left.update(start=low, end=high)
        self._ticks.ticks = _ticks(low, high)
        has_d = setting.penalty.damping is not None
        self.panes["D"].visible = has_d
        for name in NUMBERS:
            if name in facts["curves"]:
                self._draw(name, facts, self._put(put))
            else:
                self._clear(name, self._put(put))

    def table(self, name: str) -> list[Series]:
        """The columns of the figure of a number, in the numbers of the model, what is left as a share."""
        curve = self.facts["curves"][name]
        known = {"alone": (curve["values"], curve["left"]), "present": ([curve["present"]], [self.facts["total"]])}
        if curve["best"]:
            known["at best"] = [curve["best"]["value"]], [curve["best"]["left"]]
        known["equal restitution"] = [curve["equal_restitution"]], [None]
        known["resolved up to" if name == "K" else "resolved from"] = [curve["resolved"]], [None]
        return [
            Series(label, {name: _floats(values), "left": _floats(left)})
            for label, (values, left) in known.items()
            if values != [None] or label == "at best"
        ]

    @property
    def numbers(self) -> list[str]:
        """The numbers whose curve is known."""
        return [*self.facts["curves"]] if self.facts else []

    def _clear(self, name: str, put: Put) -> None:
        for source in (self.curves[name], self.marks[name]):
            put(source, {column: np.empty(0, np.float32) for column in source.data})
        self.figures[name].title.text = ""

    def _draw(self, name: str, facts: AloneFacts, put: Put) -> None:
        curve, field, plot = facts["curves"][name], shown_field(name, self._setting), self.figures[name]
        low, high = _ends(curve, name)
        plot.x_range.update(start=field.factor * low, end=field.factor * high)
        unit = field.unit or field.natural
        plot.xaxis[0].axis_label = f"{field.hint} {field.label}" + (f" / {divisor(unit)}" if unit else "")
        plot.title.text = _title(curve, field, facts["total"], done=facts["done"])
        show_rows(plot.hover[0], {plot.xaxis[0].axis_label: "@x", "left": "@left %"})
        x, left = _floats(curve["values"]), _floats(curve["left"])
        put(self.curves[name], as_float32({"x": field.factor * x, "left": 100 * left}))
        marks = _marks(curve, name, facts)
        share = dict.fromkeys(("now_left", "best_left", "floor"), 100.0)
        scaled = {n: [math.nan if marks.get(n) is None else share.get(n, field.factor) * marks[n]] for n in _MARKS}
        put(self.marks[name], as_float32(scaled))

    def take(self, name: str, x: float | None) -> None:
        """Set the number of a click, that of a mark if it is near."""
        if self.facts is None or name not in self.facts["curves"] or x is None or not x > 0:
            return
        curve, factor = self.facts["curves"][name], shown_field(name, self._setting).factor
        low, high = _ends(curve, name)

        def off(mark: float | None) -> float:
            """How far the click is from a mark, relative to what counts as near."""
            return math.inf if mark is None else abs(math.log(x / (factor * mark))) / math.log(high / low) / _NEAR

        best = off(_best_at(curve, name)) if curve["set"] else math.inf
        equal = off(curve["equal_restitution"])
        if best <= min(1.0, equal):
            self.set_texts(curve["set"])
        elif equal <= 1.0:
            self._set(name, curve["equal_restitution"], 3)
        else:
            self._set(name, x / factor, 2)

    def _set(self, name: str, value: float, digits: int) -> None:
        rounded = float(f"{value:.{digits}g}")
        self.set_texts({name: str(round(rounded)) if name == "steps" else print_number(rounded)})


def _floats(column: Iterable[float | None]) -> np.ndarray:
    """A column with nan for what is not known, or ends early."""
    return np.array([math.nan if value is None else value for value in column])


def _state(facts: AloneFacts) -> str:
    """How far a search is."""
    if facts["done"]:
        return ""
    found = [name for name, curve in facts["curves"].items() if curve["best"]]
    return f"searching: {', '.join(found)} known …" if found else "searching: coarse so far …"


def _title(curve: Mapping, field: ShownField, total: float, *, done: bool) -> str:
    """What is left now, and at best with which value."""
    now, best = f"now {percent(total)}", curve["best"]
    if best is None:
        return f"{now}; no value leaves less with its neighbours" if done else now
    value = best["value"]
    at = "no time step" if value is None else f"{field.label} = {written(float(f'{field.factor * value:.4g}'))}"
    return f"{now}; at best {percent(best['left'])}: {at}"


def _best_at(curve: Mapping, name: str) -> float | None:
    """Where the best value is drawn: no step beyond the most steps."""
    if curve["best"] is None:
        return None
    return curve["best"]["value"] or _ends(curve, name)[1] / _MARGIN


def _ends(curve: Mapping, name: str) -> tuple[float, float]:
    """The ends of the axis of a number, with room for "no step" beside the most steps."""
    known = [*curve["values"], curve["present"]]
    positive = [value for value in known if value > 0]
    return min(positive) / _MARGIN, max(positive) * _MARGIN * (_LIMIT if name == "steps" else 1.0)


def _left_ends(facts: AloneFacts) -> tuple[float, float]:
    """The ends, in per cent, of the axis that all curves share."""
    left = [value for curve in facts["curves"].values() for value in curve["left"]]
    left += [curve["best"]["left"] for curve in facts["curves"].values() if curve["best"]]
    known = [max(value, _LEAST) for value in (*left, facts["total"], _floor(facts)) if value]
    top = min(max(known), _TOP * max(facts["total"], 1.0))
    return 100 * min(known) / _MARGIN**2, 100 * top * _MARGIN


def _floor(facts: AloneFacts) -> float | None:
    """The part of the joint damping if it is worth a line."""
    return facts["floor"] if facts["floor"] > _LEAST else None


def _ticks(low: float, high: float) -> list[float]:
    """The ticks of a logarithmic axis, few enough for a small figure."""
    decades = math.log10(high / low)
    digits = (1, 2, 5) if decades < 0.9 else (1, 3) if decades < 2.2 else (1,)
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    return [digit * 10.0**power for power in powers for digit in digits]


def _marks(curve: Mapping, name: str, facts: AloneFacts) -> dict[str, float | None]:
    """The marks of a curve: numbers of the model, and what is left."""
    low, high = _ends(curve, name)
    unresolved = {"from": curve["resolved"], "to": high} if name == "K" else {"from": low, "to": curve["resolved"]}
    return {
        "now": curve["present"],
        "now_left": facts["total"],
        "best": _best_at(curve, name),
        "best_left": curve["best"] and curve["best"]["left"],
        "equal": curve["equal_restitution"],
        "floor": _floor(facts),
        **(unresolved if curve["resolved"] is not None else {}),
    }
