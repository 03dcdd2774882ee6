"""Shared by all figures: colours, fonts, margins, and changing the data of a source in place."""

import re
from collections.abc import Mapping

import numpy as np
from bokeh.models import (
    ColumnDataSource,
    Glyph,
    GlyphRenderer,
    HoverTool,
    Label,
    Legend,
    NoOverlap,
    Span,
)
from bokeh.plotting import figure
from bokeh.themes import Theme
from vibroscope.app.explorer.compute import free_text
from vibroscope.app.explorer.field_units import held_in_words, unit_of
from vibroscope.app.explorer.state import Setting
from vibroscope.engine import PART_NAMES

# Okabe–Ito colours, which colour-blind readers can distinguish. Width, dash and marker differ too.
BLUE = "#0072B2"
VERMILLION = "#D55E00"
INK = "#22303C"
GREEN, VIOLET = "#007A5A", "#8A5A9E"
GREY = "#76818C"  # of a study: another start
OCHRE, MAGENTA = "#8F6A00", "#B0327A"
FONT = "'Segoe UI', Roboto, 'Helvetica Neue', Arial, 'Liberation Sans', sans-serif"

REFERENCE = {"line_color": BLUE, "line_width": 4, "line_alpha": 0.7}
PENALTY = {"line_color": VERMILLION, "line_width": 1.3, "line_dash": "solid"}
SOLUTIONS = {"reference": REFERENCE, "penalty": PENALTY}
SUBSCRIPTS = {1: "₁", 2: "₂"}  # of the bodies
# The parts of the difference, in the order in which they arise.
PARTS = {
    "total": {"line_color": INK, "line_width": 2.4},
    "time_step": {"line_color": VERMILLION, "line_width": 1.4},
    "regularisation": {"line_color": GREEN, "line_width": 1.4, "line_dash": "dashed"},
    "joint_damping": {"line_color": VIOLET, "line_width": 1.8, "line_dash": "dotdash"},
}
# Pinned results, each with a colour and a dash of its own: the wide line is its reference, the thin one its penalty
# solution. `comparison.css` has the colours, too.
PINS = ((GREEN, "dashed"), (VIOLET, "dotdash"), (MAGENTA, "dotted"), (OCHRE, "dashdot"))
PIN_NAMES = ("pinned", *(f"pinned{number}" for number in range(2, len(PINS) + 1)))  # in a link

_APART = 4  # px between the labels of two ticks at least; where there is less room, some ticks have none

# A cloud of points as a picture, from transparent to blue: the more of them fall on a pixel, the darker it is.
SHADES = ["#FFFFFF00", *(f"{BLUE}{alpha:02X}" for alpha in range(1, 256))]

CLICK = "hide"  # what a click on a legend entry does to its curves; `muting.py` keeps it

BARE = {"tools": "", "active_drag": None, "toolbar_location": None}  # a figure that is no place to zoom

# Minimum margins of the time figures; `alignFrames` gives all of them the widest that one needs.
LEFT, RIGHT = 60, 64


# Colours of the dark page by those of the light one; files are made of them here, figures of the page in `theme.js`.
DARK = {
    "#FFFFFF": "#171E26",  # paper
    INK: "#E4E9EE",
    "#E4E8EC": "#2A343E",  # grid
    "#808D99": "#7F8C98",  # axes
    "#C6CDD4": "#3C4854",  # outline
    "#F1F3F5": "#222B34",  # background of the strip
    GREY: "#A7B1BB",
    OCHRE: "#D8C84A",  # pins, beside the colours of the parts
    MAGENTA: "#FF8AC4",
    BLUE: "#56B4E9",  # both are Okabe–Ito colours
    VERMILLION: "#F0A030",
    GREEN: "#3CC796",
    VIOLET: "#C79BD8",
}


def file_colour(colour: str | None, *, dark: bool) -> str:
    """A colour in a file, with its opacity if it has one."""
    if not dark or colour is None:
        return colour or "none"
    whole = "#FFFFFF" if colour == "white" else colour.upper()
    return DARK.get(whole[:7], whole[:7]) + whole[7:]


def file_style(*, dark: bool) -> dict[str, str]:
    """The colours of what surrounds the curves in a file, as parameters of matplotlib."""
    parts = {
        "#FFFFFF": ("figure.facecolor", "savefig.facecolor", "axes.facecolor"),
        INK: ("text.color", "axes.labelcolor", "xtick.labelcolor", "ytick.labelcolor"),
        "#808D99": ("xtick.color", "ytick.color"),
        "#C6CDD4": ("axes.edgecolor",),
        "#E4E8EC": ("grid.color",),
    }
    return {name: file_colour(colour, dark=dark) for colour, names in parts.items() for name in names}


# All colours of figures are defined here.
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
                "axis_line_color": "#808D99",
                "major_label_text_font": FONT,
                "major_label_text_font_size": "11px",
                "major_label_text_color": INK,
                "major_tick_line_color": "#808D99",
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
                "inactive_fill_color": "#FFFFFF",
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


def make_figure(title: str, x: str = "", y: str = "", **more) -> figure:
    """A figure in the page's style that fills its cell; a label that follows what is set comes later."""
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
    # Until a title that became longer has its room, its last lines are over the figure, not its first ones above it.
    plot.title.vertical_align = "top"
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    for axis in plot.axis:
        axis.major_label_policy = NoOverlap(min_distance=_APART)  # of numbers as long as −0.00025
    return plot


def add_glyph(plot: figure, glyph: Glyph, source: ColumnDataSource, **more) -> GlyphRenderer:
    """Add one glyph. The methods of `figure` add two more for selected data, which this page does not have."""
    return plot.add_glyph(source, glyph, nonselection_glyph=None, **more)


def scene_line(eta: float) -> Span:
    """A dotted line at the η of a scene."""
    return Span(location=eta, dimension="height", line_color="#808D99", line_dash="dotted")


def cursor_line(width: float = 1.5, **more) -> Span:
    """A line at what is set. As an overlay it is repainted without what is below it."""
    return Span(dimension="height", line_color=INK, line_width=width, level="overlay", **more)


def label_on(size: str = "11px", alpha: float = 0.8, **more) -> Label:
    """Words over a figure, at a height in pixels."""
    look = {"text_font": FONT, "text_font_size": size, "text_color": INK}
    ground = {"background_fill_color": "#FFFFFF", "background_fill_alpha": alpha}
    return Label(y_units="screen", **look, **ground, **more)


def legend(items: list, columns: int = 2) -> Legend:
    """A legend inside the frame, over the data; a click hides the curves of an entry."""
    return Legend(items=items, location="top_right", ncols=columns, click_policy=CLICK)


def legend_above(plot: figure, items: list) -> None:
    """Put a legend above the frame, which cells fill; its margin would move it into the frame."""
    key = legend(items)
    key.location, key.margin = "top_left", 0
    plot.add_layout(key, "above")


def hover_tool(renderers: list, tooltips: Mapping[str, str], **more) -> HoverTool:
    """A hover tool that shows each ``@column`` with four digits."""
    columns = dict.fromkeys(column for text in tooltips.values() for column in re.findall(r"@\w+", text))
    formatters = dict.fromkeys(columns, "printf")
    return HoverTool(renderers=renderers, tooltips=_rows(tooltips), formatters=formatters, **more)


def _rows(tooltips: Mapping[str, str]) -> list[tuple[str, str]]:
    return [(head, re.sub(r"(@\w+)", r"\1{%.4g}", text)) for head, text in tooltips.items()]


def eta_axis(setting: Setting) -> tuple[str, float]:
    """Label of an axis over η, and the factor of its numbers."""
    held = held_in_words(setting)
    begin, end = ("frequency", f", {held} held") if held else ("excitation frequency", "")
    if setting.scale is None:
        return f"{begin} η = Ω/ω₁{end}", 1.0
    return f"{begin} f / Hz{end}", setting.scale.factor("frequency")


def quantity_axis(setting: Setting, words: str, quantity: str) -> tuple[str, float]:
    """Label of an axis with the unit of its numbers, and their factor; ``words`` with the symbols of the model."""
    return label_of(setting, words, quantity), 1.0 if setting.scale is None else setting.scale.factor(quantity)


def label_of(setting: Setting, words: str, quantity: str) -> str:
    """A label with its unit; where units are shown, with their symbols in place of those of the model, ``words``."""
    return f"{symbols(setting, words)} / {divisor(unit_of(quantity, setting))}"


def symbols(setting: Setting, words: str) -> str:
    """Words with x and t in place of ξ and τ where units are shown."""
    return words if setting.scale is None else words.replace("ξ", "x").replace("τ", "t")


def divisor(unit: str) -> str:
    """A unit as a label has it behind "/"."""
    is_one = unit.isalpha() or " " in unit or unit == "k₁"
    return unit if is_one else f"({unit})"


def show_rows(tool: HoverTool, rows: Mapping[str, str]) -> None:
    """Give a `hover_tool` other heads where they have changed."""
    new = _rows(rows)
    if new != tool.tooltips:
        tool.tooltips = new


def name_of_part(part: str) -> str:
    """Name of one of the `PARTS`."""
    return PART_NAMES.get(part, "difference")


def time_label(setting: Setting) -> str:
    """Label of a time axis."""
    which = "the last two excitation periods"
    if not setting.is_driven:
        which = free_text(setting.system, setting.eta, setting.initial)
    return f"time {'τ/T' if setting.scale is None else 't / s'} in {which}"


def empty_source(name: str | None, *columns: str) -> ColumnDataSource:
    """A source with these columns and no rows."""
    return ColumnDataSource({column: np.empty(0, np.float32) for column in columns}, name=name)


def write(source: ColumnDataSource, columns: Mapping[str, np.ndarray]) -> None:
    """Put ``columns`` into ``source``; only those that differ are sent."""
    new = changed_columns(source, columns)
    if new:
        # In one event: the browser redraws for each, and must never see columns of unequal length.
        source.data.update(new)


def changed_columns(source: ColumnDataSource, columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The columns that differ from those of ``source``."""
    return {name: column for name, column in columns.items() if not _same(source.data[name], column)}


def _same(old: np.ndarray, new: np.ndarray) -> bool:
    return old.shape == new.shape and old.tobytes() == new.tobytes()
