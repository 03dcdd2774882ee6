"""The bifurcation diagram, below it the period of the motion, and a cursor that the browser moves.

A few thousand points are drawn as points: at the same sharpness a picture of them would be several times the bytes.
The cursor is an overlay, which is repainted without the points below it.
"""

from collections.abc import Iterable

import numpy as np
from bokeh.models import ColumnDataSource, HoverTool, Line, Quad, Range1d, Scatter
from bokeh.plotting import figure
from vibroscope.app.explorer.field_units import ShownField, shown_field
from vibroscope.app.explorer.method_words import CUT, name_of_method
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.explorer.state import Setting, slider_range
from vibroscope.app.page.bifurcation.panel import motion_at, nearest_cell, shares
from vibroscope.app.page.shared.curves import AWAITED, Axis, Curves, Plot, curve
from vibroscope.app.page.shared.figure import (
    BARE,
    BLUE,
    GREY,
    INK,
    VERMILLION,
    add_glyph,
    cursor_line,
    divisor,
    eta_axis,
    label_on,
    make_figure,
    quantity_axis,
    scene_line,
    write,
)
from vibroscope.app.page.shared.ranges import UnitAxis
from vibroscope.app.page.shared.seen import say
from vibroscope.app.studies.bifurcation import MOST_BESIDE, MOST_POINTS, SAMPLE, PartialDiagram, kind_names, points_of
from vibroscope.app.studies.cell_classes import KINDS, PERIODS, period_class
from vibroscope.engine import Diagram, System
from vibroscope.engine.facts import stated
from vibroscope.engine.sweeps import CellKind

COORDINATES = {"xi1": "displacement ξ₁", "v1": "velocity ξ₁′", "xi2": "displacement ξ₂", "v2": "velocity ξ₂′"}
# Bokeh's hatch, in the short form since an update repeats it for each stretch, and what the key in `study.css` calls
# it: colour is not the only sign.
_PERIOD_HATCHES = (
    (" ", ""),
    (" ", ""),
    ("-", "lines"),
    (".", "dots"),
    ("+", "grid"),
    ("/", "slant"),
    ("\\", "back"),
)
_KIND_HATCHES = {
    CellKind.ARTEFACT: ("|", "bars"),
    CellKind.QUASI_PERIODIC: ("o", "rings"),
    CellKind.ENDED_EARLY: ("x", "cross"),
}
_PLAIN = (" ", "")
_DIRECTION = {"rest": "from rest", "own": "from an own start", "up": "upwards", "down": "downwards"}
_STRIP = "Kinds of motion"
_SHIPPED = "Shipped result: Reference from rest, until the solvers are compiled"
_ETA_LABEL = "excitation frequency η = Ω/ω₁"
_SHOWN = ("shown_eta", "shown_value")  # columns of the hover with units; the others are those of the model
_COLOURS = {"reference": BLUE, "penalty": VERMILLION}


_DOTS = {"x": "eta", "y": "value", "hovered": True}
_LINES = {
    "reference": {"line_color": BLUE, "line_width": 2.4},
    "penalty": {"line_color": VERMILLION, "line_width": 1.5},
}
DASHES = {"stable": "solid", "unstable": [5, 4]}  # of branches
_POINT = ("kind", "where", "period", "multiplier")  # columns of a point of a branch for its hover
_REPEATS = "repeats, but for the blur by the step, after so many periods (0: not, or not judged)"


def _cloud() -> Plot:
    """Points of the diagram and of another one in grey; over them branches of each solver, and their points."""
    square = {"marker": "square", "size": 2.2, "line_color": None}
    hollow = {"marker": "circle", "size": 4.2, "fill_color": None, "line_color": VERMILLION, "line_alpha": 0.45}
    colours = {"other": GREY} | _COLOURS
    drawn = [curve(Scatter, f"bifurcation_{n}", fill_color=each, **square, **_DOTS) for n, each in colours.items()]
    drawn.append(curve(Scatter, "bifurcation_artefacts", **hollow, **_DOTS))
    drawn += [
        curve(Line, f"branches_{solver}_{kind}", x="eta", y="value", line_dash=dash, **look)
        for solver, look in _LINES.items()
        for kind, dash in DASHES.items()
    ]
    inks = _COLOURS | {"reference": INK}
    mark = {"x": "eta", "y": "value", "marker": "marker", "size": "size", "fill_color": "#FFFFFF", "line_width": 1.3}
    drawn += [curve(Scatter, f"branch_points_{solver}", line_color=inks[solver], **mark) for solver in _COLOURS]
    tips = {"η": "@eta", "value": "@value", _REPEATS: "@period"}
    return Plot(AWAITED, "eta", "value", {"": ("", drawn)}, tips, {"limit": 1})


class BifurcationView(Curves):
    """Two figures over the same number, η at first; their range and columns keep that name."""

    axes = {  # noqa: RUF012 - read only
        "eta": Axis(*slider_range("eta", System()), _ETA_LABEL),
        "value": Axis(-10, 10, COORDINATES["xi2"], "displacement"),
    }
    plots = {"bifurcation": _cloud()}  # noqa: RUF012 - read only
    beside = {f"branch_points_{solver}": ("marker", "size", *_POINT) for solver in _COLOURS}  # noqa: RUF012

    def __init__(self) -> None:
        self.over = "eta"
        self._system = System()
        super().__init__()
        self.figure = self.figures["bifurcation"]
        self.strip_source = ColumnDataSource(
            {name: [] for name in ("left", "right", "colour", "hatch", "period", "kind")}, name="bifurcation_periods"
        )
        self.strip = self.figures["bifurcation_strip"] = self._strip()
        self.units["eta"] = UnitAxis(self.ranges["eta"], "x", self.figure, self.strip)
        self._add_marks()

    def _add_marks(self) -> None:
        plot = self.figure
        self.hover = plot.hover[0]
        self.hover.formatters |= dict.fromkeys((f"@{name}" for name in _SHOWN), "printf")
        of_points = [part for part in plot.renderers if part.data_source.name.startswith("branch_points_")]
        heads = ("point", "at", "period", "multiplier")
        rows = [(head, f"@{name}") for head, name in zip(heads, _POINT, strict=True)]
        plot.add_tools(HoverTool(renderers=of_points, tooltips=rows))
        self._scenes = [  # the paper's η, which mean nothing for another system
            scene_line(scene.setting.eta) for scene in scenes().values() if scene.group == "motion"
        ]
        for line in self._scenes:
            plot.add_layout(line)
        self.cursor = cursor_line(2, name="bifurcation_cursor")
        place = {"x": 0, "y": 6, "x_offset": 6, "level": "overlay"}
        self.label = label_on("12px", 0.85, text="", name="bifurcation_label", **place)
        plot.add_layout(self.cursor)
        plot.add_layout(self.label)

    def _strip(self) -> figure:
        axes = {"x_range": self.ranges["eta"].range, "y_range": Range1d(0, 1)}
        # The title is for screen readers; below the diagram it needs none.
        plot = make_figure(_STRIP, name="bifurcation_strip", **axes, **BARE, height=60, min_border_bottom=22)
        plot.title.visible = plot.yaxis.visible = plot.ygrid.visible = plot.xgrid.visible = False
        plot.background_fill_color = "#F1F3F5"
        plot.css_classes = ["low"]
        area = {"left": "left", "right": "right", "bottom": 0, "top": 1, "fill_color": "colour", "line_color": None}
        hatch = {"hatch_pattern": "hatch", "hatch_color": INK, "hatch_alpha": 0.55, "hatch_scale": 8}
        add_glyph(plot, Quad(**area, **hatch), self.strip_source)
        return plot

    def sweep(self, over: str) -> None:
        """Sweep another number, over its whole range."""
        if over != self.over:
            self.over = over
            self.ranges["eta"].unzoom()
            self.ranges["eta"].put(*self._home, fresh=True)

    def fit_axes(self, setting: Setting) -> None:
        """See `Curves`: what the slider covers for the system."""
        if setting.system != self._system:
            self._system = setting.system
            self.ranges["eta"].put(*self._home)

    @property
    def _home(self) -> tuple[float, float]:
        return slider_range(self.over, self._system)

    @property
    def axis_label(self) -> str:
        """The label of the horizontal axis."""
        return self.units["eta"].label

    @property
    def span(self) -> tuple[float, float]:
        """The values in view, within what can be set."""
        low, high = (float(np.clip(end, *FIELDS[self.over].bounds)) for end in self.ranges["eta"].ends)
        return (low, high) if high - low > 1e-7 * (abs(low) + abs(high)) else self._home

    def update(
        self,
        setting: Setting,
        result: PartialDiagram | None,
        coordinate: str,
        other: PartialDiagram | None,
        beside: Iterable[np.ndarray] = (),
        shipped: Diagram | None = None,
    ) -> None:
        """Move the cursor; draw what is known, and in grey another diagram to compare with.

        ``beside``: values of the coordinate that are drawn beside the diagram, for the range of the axis. ``shipped``:
        what is drawn while nothing is known.
        """
        value, field = getattr(setting, self.over), shown_field(self.over, setting)
        self.cursor.location = self.label.x = value
        self.label.text = field.words(value) if field.unit else f"{field.label} = {value:.7g}"
        factors = self._label_axes(setting, field, coordinate)
        if result is None:
            self._draw_shipped(shipped, coordinate, factors)
            return
        for line in self._scenes:
            line.visible = self.over == "eta" and result.question.system == System()
        self._title(result, setting)
        values, scattered = (_columns(result, coordinate, factors, artefacts=chosen) for chosen in (False, True))
        none = dict.fromkeys(values, values["eta"][:0])
        drawn = "reference" if result.question.method.rigid else "penalty"
        for solver in _COLOURS:
            self._put(solver, values if solver == drawn else none)
        self._put("artefacts", scattered)
        self._put("other", none if other is None else _columns(other, coordinate, factors, MOST_BESIDE))
        fresh = self._drawn != (drawn, coordinate, result.question.over)
        drawn_values = [values["value"], scattered["value"], *beside]
        self.ranges["value"].follow(drawn_values, fresh=fresh)
        self._drawn = drawn, coordinate, result.question.over
        self._write_strip(result)

    def _draw_shipped(self, shipped: Diagram | None, coordinate: str, factors: tuple[float, float]) -> None:
        """Draw a diagram that has no velocities, and not the kinds of its motions; None: nothing."""
        section = {} if shipped is None else dict(zip(("xi1", "xi2"), shipped.displacement, strict=True))
        known = coordinate in section
        eta, value = points_of(shipped.eta, section[coordinate]) if known else np.empty((2, 0))
        self._put("reference", _scaled(eta, value, np.zeros(len(eta)), factors))
        say(self.figure, _SHIPPED if known else AWAITED)
        if known:
            drawn = "reference", coordinate, "eta"
            self.ranges["value"].follow([value], fresh=self._drawn != drawn)
            self._drawn = drawn

    def _label_axes(self, setting: Setting, field: ShownField, coordinate: str) -> tuple[float, float]:
        """Label axes and hover; returns what one of the model's units is worth on both axes."""
        unit = field.unit or field.natural
        head = f"{field.hint} {field.label}" + (f" / {divisor(unit)}" if unit else "")
        self.units["eta"].show(eta_axis(setting)[0] if self.over == "eta" and setting.is_driven else head, field.factor)
        self.strip.xaxis[0].axis_label = ""
        quantity = "velocity" if coordinate.startswith("v") else "displacement"
        shown = quantity_axis(setting, f"{COORDINATES[coordinate]} once a period", quantity)
        self.units["value"].show(*shown)
        columns = ("@eta", "@value") if setting.scale is None else tuple(f"@{name}{{%.4g}}" for name in _SHOWN)
        rows = [*zip((self.axis_label, shown[0]), columns, strict=True), *self.hover.tooltips[2:]]
        if rows != self.hover.tooltips:
            self.hover.tooltips = rows
        return (1.0, 1.0) if setting.scale is None else (field.factor, shown[1])

    def _title(self, result: PartialDiagram, setting: Setting) -> None:
        question = result.question
        periods = f"{int(result.known.sum())} values, {question.transient} + {SAMPLE} periods each"
        at = "" if question.over == "eta" else f", {shown_field('eta', setting).words(question.eta)}"
        start = "own" if question.initial is not None else question.direction
        name, nearest = name_of(question.method, question.over), nearest_cell(setting, result)
        seen = "" if nearest is None else stated("at the line {}", motion_at(result, nearest))
        say(self.figure, f"{name} {_DIRECTION[start]}{at}, {periods}", seen, setting)
        say(self.strip, _STRIP, "; ".join(shares(result)))

    def _write_strip(self, result: PartialDiagram) -> None:
        left, right, period, kind = result.stretches()
        looks = [_look(*each) for each in zip(period.tolist(), kind.tolist(), strict=True)]
        self.strip_source.data = {
            "left": left.astype(np.float32),
            "right": right.astype(np.float32),
            "colour": [colour for colour, _ in looks],
            "hatch": [hatch for _, hatch in looks],
            "period": period.astype(np.float32),
            "kind": kind_names(kind).tolist(),
        }

    def fade(self, faded: bool) -> None:
        """Draw the cloud paler, so that lines over it can be told from it."""
        for part in self.figure.renderers[: 1 + len(_COLOURS)]:
            part.glyph.fill_alpha = 0.3 if faded else 1.0

    def _put(self, name: str, columns: dict[str, np.ndarray]) -> None:
        """Put columns into a source of points, also where units come or go, and with them columns."""
        source = self.sources[f"bifurcation_{name}"]
        if source.data.keys() == columns.keys():
            write(source, columns)
        else:
            source.data = dict(columns)


def name_of(method, over: str = "eta") -> str:
    """A solver as the figures call it, without the number that is swept."""
    if method.has_step:
        steps = "" if over == "steps" else f" T/{method.steps}"
        name, _, located = name_of_method(method).partition(f", {CUT}")
        return f"{name}{steps}{f', {CUT}' if located or method.located else ''}"
    return "Reference" if method.rigid else "Exact penalty"


def _look(period: int, kind: int) -> tuple[str, str]:
    """Colour and hatch of a stretch."""
    if kind != CellKind.PERIODIC:
        return KINDS[kind][1], _KIND_HATCHES.get(kind, _PLAIN)[0]
    place = int(period_class(period))
    return PERIODS[place][1], _PERIOD_HATCHES[place][0]


def legend() -> list[list[str]]:
    """Colour, name and pattern of each period, and of each kind of motion without one."""
    periods = [
        [colour, f"period {text}", pattern]
        for (text, colour), (_, pattern) in list(zip(PERIODS, _PERIOD_HATCHES, strict=True))[1:]
    ]
    return periods + [[colour, text, _KIND_HATCHES.get(kind, _PLAIN)[1]] for kind, (text, colour) in KINDS.items()]


def _columns(
    result: PartialDiagram,
    coordinate: str,
    factors: tuple[float, float],
    most: int = MOST_POINTS,
    artefacts: bool | None = None,
) -> dict[str, np.ndarray]:
    """The points of a diagram; where units are shown, their ``factors`` times the numbers, too."""
    eta, value = result.points(coordinate, most, artefacts)
    return _scaled(eta, value, result.kinds["kind_period"][np.searchsorted(result.question.axis, eta)], factors)


def _scaled(
    eta: np.ndarray, value: np.ndarray, period: np.ndarray, factors: tuple[float, float]
) -> dict[str, np.ndarray]:
    pairs = zip(_SHOWN, factors, (eta, value), strict=True)
    shown = {name: (factor * column).astype(np.float32) for name, factor, column in pairs if factors != (1.0, 1.0)}
    return shown | {
        "eta": eta.astype(np.float32),
        "value": value.astype(np.float32),
        "period": period.astype(np.uint16),
    }
