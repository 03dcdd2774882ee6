"""Displacements over two periods, and a strip of the intervals in contact, as the paper's sensor shows them."""

from __future__ import annotations

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, FactorRange, HBar, LegendItem, Line, Range1d
from vibroscope.app.explorer.field_units import unit_of
from vibroscope.app.explorer.present import WINDOW, Columns, unit_factor
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import (
    BARE,
    BLUE,
    PARTS,
    RIGHT,
    SOLUTIONS,
    SUBSCRIPTS,
    VERMILLION,
    PinnedCurves,
    add_glyph,
    divisor,
    empty_source,
    empty_sources,
    hover_tool,
    label_of,
    legend,
    make_figure,
    name_of_part,
    show_rows,
    symbols,
    time_label,
    write,
)
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.shared.ranges import OwnedRange
from vibroscope.app.page.shared.seen import amount, apart, largest, say
from vibroscope.engine import counted, percent
from vibroscope.engine.facts import stated

_TITLE, _STRIP = "Displacements", "Contact strip"
_LABELS = {
    "relative": "displacements ξ₁, ξ₂",
    "absolute": "displacements with the base",
    "difference": "difference of ξ{number}",
}


_AT_WALL = "displacement ξ₁"  # relative to the base, which the wall stands on

_CURVES = {f"{solver}{number}": (solver, number) for solver in ("reference", "penalty") for number in (1, 2)}


def _entry(solver: str, number: int) -> str:
    return f"ξ{SUBSCRIPTS[number]} {solver}"


class DisplacementView:
    """The displacement figure and the contact strip below it, on one time axis."""

    def __init__(self, time: Range1d) -> None:
        curves = (f"{solver}{what}" for solver in ("reference", "penalty") for what in ("1", "2", "_v1", "_v2"))
        strips = dict.fromkeys(("strip_reference", "strip_penalty"), ("left", "right"))
        self.sources = empty_sources({"displacements": ("t", *curves), **strips})
        self.difference = empty_source("difference", "t", *PARTS)
        self._items: dict[str, list[LegendItem]] = {}  # legend of the displacements, and of their difference
        self._backgrounds: list[ColumnDataSource] = []  # of the strip
        self.measured: Columns = {}  # points of a measurement
        self.range = OwnedRange(-10, 10, headroom=0.16)
        self.figure = self._displacement(time)
        self.strip = self._strip(time)
        source = self.sources["displacements"]
        self.pinned = PinnedCurves({self.figure: [(source, "t", name, _CURVES[name][0]) for name in _CURVES]})

    def _displacement(self, time: Range1d):
        axes = {"x_range": time, "y_range": self.range.range}
        plot = make_figure(_TITLE, name="displacement", **axes, min_border_right=RIGHT)
        items = []
        for solver, look in SOLUTIONS.items():
            for number, dash in ((1, "solid"), (2, "dashed")):
                glyph = Line(x="t", y=f"{solver}{number}", **(look | {"line_dash": dash}))
                line = add_glyph(plot, glyph, self.sources["displacements"])
                items.append(LegendItem(label=_entry(solver, number), renderers=[line]))
        parts = [
            LegendItem(
                label=name_of_part(name),
                visible=False,
                renderers=[add_glyph(plot, Line(x="t", y=name, **look), self.difference)],
            )
            for name, look in PARTS.items()
        ]
        self._items = {"displacements": items, "difference": parts}
        self._of_body_2 = items[1::2]
        plot.add_layout(legend([*items, *parts], 8))
        lines = [item.renderers[0] for item in items]
        # What the hover tool belongs to, without ink: were its renderers changed, Bokeh would walk over all models.
        unseen = Line(x="t", y=next(iter(_CURVES)), line_alpha=0)
        self._hovered = add_glyph(plot, unseen, self.sources["displacements"])
        self._hover = hover_tool([self._hovered], {"time": "@t"}, mode="vline", line_policy="nearest")
        self._hover.formatters = {f"@{name}": "printf" for name in ("t", *_CURVES)}
        for line in lines:  # a click in the legend
            line.on_change("visible", lambda attr, old, new: self._follow_visible())
        plot.add_tools(self._hover)
        return plot

    def _follow_visible(self) -> None:
        """Let the hover tool follow the first line that is visible; it shows all four, which share their times."""
        lines = zip(_CURVES, self._items["displacements"], strict=True)
        first = next((column for column, item in lines if item.renderers[0].visible), "")
        self._hovered.visible = bool(first)
        if first and self._hovered.glyph.y != first:
            self._hovered.glyph.y = first

    def _strip(self, time: Range1d):
        axes = {"x_range": time, "y_range": FactorRange("penalty", "reference")}
        room = {"min_border_right": RIGHT, "min_border_bottom": 4, "height": 70}
        plot = make_figure(_STRIP, name="strip", **axes, **room, **BARE)  # with a title for screen readers
        for solver, colour, hatch in (("reference", BLUE, None), ("penalty", VERMILLION, "right_diagonal_line")):
            background = ColumnDataSource({"right": np.array([WINDOW], float)})
            self._backgrounds.append(background)
            where = {"y": value(solver), "right": "right", "height": 0.6}
            add_glyph(plot, HBar(left=0, fill_color="#F1F3F5", line_color=None, **where), background)
            # The outline keeps an impact visible, which has length zero.
            alpha = 0.85 if hatch is None else 0.35
            look = {"fill_color": colour, "fill_alpha": alpha, "line_color": colour, "line_width": 1.6}
            look |= {"hatch_pattern": hatch, "hatch_color": colour, "hatch_scale": 6, "hatch_weight": 1.2}
            add_glyph(plot, HBar(left="left", **where, **look), self.sources[f"strip_{solver}"])
        plot.title.visible = plot.xaxis.visible = False
        plot.ygrid.grid_line_color = None
        return plot

    def update(self, columns: dict[str, Columns], setting: Setting, *, fresh: bool) -> None:
        """Fit ranges and labels to ``columns``, which the sources hold already."""
        for background in self._backgrounds:
            write(background, {"right": np.array([WINDOW * setting.period], float)})
        self.figure.xaxis[0].axis_label = time_label(setting)
        self._name_curves(setting)
        say(self.strip, _STRIP, _seen_in_strip(columns, setting))
        if setting.frame == "difference":
            return
        switched = self._switch(setting)
        drawn = columns["displacements"]
        between = [drawn[f"reference{n}"] - drawn[f"penalty{n}"] for n in (1, 2)]
        say(self.figure, _TITLE, apart(between, setting), setting)
        shown = [drawn[name] for name in _CURVES]
        shown += [self.measured[name] for name in ("x1", "x2") if self.measured]
        self.range.follow([*shown, *self.pinned.columns("displacements", *_CURVES)], fresh=fresh or switched)

    def _name_curves(self, setting: Setting) -> None:
        """Legend and hover with the symbols and units that are shown."""
        unit = divisor(unit_of("displacement", setting))
        rows = {"time τ/T" if setting.scale is None else "time t / s": "@t"}
        for item, (solver, number) in zip(self._items["displacements"], _CURVES.values(), strict=True):
            name = symbols(setting, _entry(solver, number))
            if item.label != value(name):
                item.label = value(name)
            rows[f"{name} / {unit}"] = f"@{solver}{number}"
        show_rows(self._hover, rows)

    def explain(self, series: dict[str, np.ndarray], setting: Setting) -> None:
        """Draw the parts of the difference, each (2, n), if they are to be shown; without ``series``, draw nothing."""
        if setting.frame != "difference":
            return
        switched = self._switch(setting)
        row = 0 if setting.coordinate == "xi1" else 1
        count = len(series["total"][row]) if series else 0
        factor = np.float32(unit_factor("displacement", setting))
        columns = {"t": np.linspace(0, WINDOW * setting.period, count, dtype=np.float32)}
        columns |= {
            name: factor * series[name][row] if name in series else np.full(count, np.nan, "f4") for name in PARTS
        }
        write(self.difference, columns)
        most = largest([columns["total"]])
        seen = "" if most is None else stated("up to {}", amount(most, "displacement", setting))
        say(self.figure, "Difference", seen, setting)
        self.range.follow([columns[name] for name in PARTS], fresh=switched)

    def _switch(self, setting: Setting) -> bool:
        """Show the displacements or their difference; returns whether that has changed the quantity of the axis."""
        words = _LABELS[setting.frame].format(number=SUBSCRIPTS[int(setting.coordinate[-1])])
        words = _AT_WALL if setting.bodies == "wall" and setting.frame == "relative" else words
        label = label_of(setting, words, "displacement")
        switched = self.figure.yaxis[0].axis_label != label
        self.figure.yaxis[0].axis_label = label
        for kind, items in self._items.items():
            visible = (kind == "difference") == (setting.frame == "difference")
            for item in items:
                show_entry(item, visible and not (setting.bodies == "wall" and item in self._of_body_2))
        self._follow_visible()
        self.pinned.draw(setting.frame != "difference")
        return switched


def _seen_in_strip(columns: dict[str, Columns], setting: Setting) -> str:
    """How often each solution is in contact, and for how long."""

    def words(solver: str) -> str:
        spans = columns[f"strip_{solver}"]
        share = float((spans["right"] - spans["left"]).sum()) / (WINDOW * setting.period)
        return f"{solver} {counted(len(spans['left']), 'contact')}, {percent(share)} of the time"

    return "; ".join(map(words, ("reference", "penalty")))
