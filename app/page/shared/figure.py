"""Shared by all figures: colours, fonts, margins, and changing the data of a source in place."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
from bokeh.models import ColumnDataSource, Glyph, GlyphRenderer, HoverTool, Legend, LegendItem
from bokeh.plotting import figure
from bokeh.themes import Theme
from vibroscope.app.explorer.state import Setting

# Okabe–Ito colours, which colour-blind readers can distinguish. Width, dash and marker differ too.
BLUE = "#0072B2"
VERMILLION = "#D55E00"
INK = "#22303C"
GREEN, VIOLET = "#007A5A", "#8A5A9E"
GREY = "#76818C"  # pinned curves
FONT = "'Segoe UI', Roboto, 'Helvetica Neue', Arial, 'Liberation Sans', sans-serif"

REFERENCE = {"line_color": BLUE, "line_width": 4, "line_alpha": 0.5}
PENALTY = {"line_color": VERMILLION, "line_width": 1.3, "line_dash": "solid"}
# The parts of the difference, in the order in which they arise.
PARTS = {
    "total": {"line_color": INK, "line_width": 2.4},
    "time_step": {"line_color": VERMILLION, "line_width": 1.4},
    "regularisation": {"line_color": GREEN, "line_width": 1.4, "line_dash": "dashed"},
    "joint_damping": {"line_color": VIOLET, "line_width": 1.8, "line_dash": "dotdash"},
}
PINNED = {
    "reference": {"line_color": GREY, "line_width": 2.4, "line_alpha": 0.35},
    "penalty": {"line_color": GREY, "line_width": 0.9},
}

CLICK = "hide"  # what a click on a legend entry does to its curves; `muting.py` keeps it

# Minimum margins of the time figures; `explore/instant.js` gives all of them the widest one that any of them needs.
LEFT, RIGHT = 60, 64


# All colours of figures are defined here; `theme.js` has the dark counterpart of each.
THEME = Theme(
    json={
        "attrs": {
            "Plot": {
                "background_fill_color": "#FFFFFF",
                "border_fill_color": "#FFFFFF",
                "outline_line_color": "#C6CDD4",
            },
            "Title": {
                "text_font": FONT,
                "text_font_size": "13px",
                "text_font_style": "bold",
                "text_color": INK,
                "standoff": 5,
            },
            "BasicTickFormatter": {"power_limit_low": -5},  # 0.002, not 2.000e-3
            "Grid": {"grid_line_color": "#E4E8EC"},
            "Axis": {
                "axis_label_text_font": FONT,
                "axis_label_text_font_size": "12px",
                "axis_label_text_font_style": "normal",
                "axis_label_text_color": INK,
                "axis_label_standoff": 3,
                "axis_line_color": "#8A97A3",
                "major_label_text_font": FONT,
                "major_label_text_font_size": "11px",
                "major_label_text_color": INK,
                "major_tick_line_color": "#8A97A3",
                "major_tick_in": 0,
                "major_tick_out": 4,
                "minor_tick_line_color": None,
            },
            "Legend": {
                "label_text_font": FONT,
                "label_text_font_size": "11px",
                "label_text_color": INK,
                "border_line_color": None,
                "background_fill_color": "#FFFFFF",
                "background_fill_alpha": 0.8,
                "padding": 2,
                "margin": 3,
                "spacing": 8,
                "glyph_width": 18,
                "glyph_height": 12,
                "label_standoff": 3,
                "label_height": 12,
            },
        }
    }
)


def make_figure(title: str, x: str, y: str, **more) -> figure:
    """A figure in the page's style that fills its cell."""
    options = {
        "title": title,
        "x_axis_label": x,
        "y_axis_label": y,
        "sizing_mode": "stretch_both",
        "output_backend": "canvas",
        "tools": "pan,box_zoom,wheel_zoom,reset,save",
        "active_drag": "box_zoom",
        "toolbar_location": "above",
        "min_border_left": LEFT,
        "min_border_right": 12,
        "min_border_bottom": 40,
        "min_border_top": 4,
        "height": 160,
        "width": 300,
        "lod_threshold": None,
    }
    return apply_style(figure(**(options | more)))


def apply_style(plot: figure) -> figure:
    """Set the properties of ``plot`` that a theme cannot set."""
    # Otherwise the enclosing grid gives all frames the widest margin among them.
    plot.frame_align = False
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    return plot


def add_glyph(plot: figure, glyph: Glyph, source: ColumnDataSource, **more) -> GlyphRenderer:
    """Add one glyph. The methods of `figure` add two more for selected data, which this page does not have."""
    return plot.add_glyph(source, glyph, nonselection_glyph=None, **more)


def legend(items: list, columns: int = 2) -> Legend:
    """A legend inside the frame, over the data; a click hides the curves of an entry."""
    return Legend(items=items, location="top_right", ncols=columns, click_policy=CLICK)


def hover_tool(renderers: list, tooltips: Mapping[str, str], **more) -> HoverTool:
    """A hover tool that shows each ``@column`` with four digits."""
    columns = dict.fromkeys(column for text in tooltips.values() for column in re.findall(r"@\w+", text))
    rows = [(head, re.sub(r"(@\w+)", r"\1{%.4g}", text)) for head, text in tooltips.items()]
    return HoverTool(renderers=renderers, tooltips=rows, formatters=dict.fromkeys(columns, "printf"), **more)


def unit_label(setting: Setting, quantity: str) -> str:
    """The unit of a quantity as a label has it behind "/"; with units only."""
    unit = setting.scale.unit(quantity)
    return f"({unit})" if "/" in unit or "·" in unit else unit


def time_label(setting: Setting) -> str:
    """Label of a time axis."""
    return f"time {'τ/T' if setting.scale is None else 't / s'} in the last two excitation periods"


class PinnedCurves:
    """The pinned result in some figures: a source with the same columns for each live source, and legend entries.

    ``names`` are the names of the live sources.
    """

    def __init__(self, *names: str) -> None:
        self.sources = {name: ColumnDataSource({}, name=f"pinned_{name}") for name in names}
        self._items: list[LegendItem] = []
        self._pinned, self._drawn = False, True

    def source_for(self, source: ColumnDataSource) -> ColumnDataSource:
        """The source for the pinned counterpart of a live source."""
        pinned = self.sources[source.name]
        pinned.data = {name: np.empty(0, np.float32) for name in source.data}
        return pinned

    def legend_item(self, renderers: list) -> LegendItem:
        """A legend entry that is visible only while a pinned result is drawn."""
        self._items.append(LegendItem(label="pinned", renderers=renderers, visible=False))
        return self._items[-1]

    def update(self, columns: Mapping[str, Mapping[str, np.ndarray]] | None) -> None:
        """Show these columns by source; None: nothing is pinned."""
        for name, source in self.sources.items():
            nothing = {column: np.empty(0, np.float32) for column in source.data}
            write(source, {column: columns[name][column] for column in source.data} if columns else nothing)
        self._pinned = columns is not None
        self._show()

    def draw(self, drawn: bool) -> None:
        """Whether a pinned result is drawn at all."""
        self._drawn = drawn
        self._show()

    def _show(self) -> None:
        for item in self._items:
            item.visible = self._pinned and self._drawn


def empty_source(name: str, *columns: str) -> ColumnDataSource:
    """A named source with these columns and no rows."""
    return ColumnDataSource({column: np.empty(0, np.float32) for column in columns}, name=name)


def empty_sources(shape: Mapping[str, tuple[str, ...]]) -> dict[str, ColumnDataSource]:
    """Empty sources by name; ``shape`` gives their columns."""
    return {name: empty_source(name, *columns) for name, columns in shape.items()}


def write(source: ColumnDataSource, columns: Mapping[str, np.ndarray]) -> None:
    """Put ``columns`` into ``source``; only those that differ are sent."""
    new = changed_columns(source, columns)
    if new:
        # In one event: the browser redraws for each, and must never see columns of unequal length.
        source.data.update(new)


def changed_columns(source: ColumnDataSource, columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Those of ``columns`` that differ from the columns of ``source``."""
    return {name: column for name, column in columns.items() if not _same(source.data[name], column)}


def _same(old: np.ndarray, new: np.ndarray) -> bool:
    return old.shape == new.shape and old.tobytes() == new.tobytes()
