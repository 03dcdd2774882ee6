"""A figure of the page as calls of matplotlib, for its files: what is drawn now, in the part that is in view."""

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import singledispatch
from typing import NamedTuple

import numpy as np
from bokeh.core.property.descriptors import UnsetValueError
from bokeh.core.property.vectorization import Field, Value
from bokeh.models import (
    Axis,
    BasicTickFormatter,
    FactorRange,
    FixedTicker,
    GlyphRenderer,
    HBar,
    HSpan,
    Image,
    Label,
    LabelSet,
    LegendItem,
    Line,
    LogScale,
    Model,
    Plot,
    Quad,
    Scatter,
    Segment,
    Span,
    VSpan,
    VStrip,
)
from vibroscope.app.export.drawing import MANY, PT, Call, Drawing
from vibroscope.app.page.shared.figure import file_colour, file_style

_FOLDED = 360  # px, width of a figure that is folded, and so has none on the page
_LEVELS = ("image", "underlay", "glyph", "guide", "annotation", "overlay")
_MARKERS = {"circle": "o", "square": "s", "triangle": "^", "inverted_triangle": "v", "cross": "+", "star": "*"}
_MARKERS |= {"x": "x", "diamond": "D", "diamond_cross": "D", "plus": "P", "hex": "h", "asterisk": "*"}
_SLIM = 0.7  # a diamond of Bokeh, of one of matplotlib
_DASHES = {"solid": [], "dashed": [6, 6], "dotted": [2, 4], "dotdash": [2, 4, 6, 4], "dashdot": [6, 4, 2, 4]}
_ON_THE_PAGE = re.compile(r" \(click .*?\)")  # words of a title that hold there only
_DENSE = 3  # signs of a hatch
_HATCHES = {"right_diagonal_line": "/", " ": ""}  # others are called as in matplotlib
_KEY = {"dots": ".", "lines": "-", "slant": "/", "back": "\\", "bars": "|", "rings": "o", "grid": "+", "cross": "x"}


class Key(NamedTuple):
    """The key of the colours of a figure, which stands beside it: its head, and colour, name, pattern of each class."""

    head: str = ""
    rows: Sequence[Sequence[str]] = ()


class _Look:
    """What a model says of its look, with the columns of its source."""

    def __init__(self, plot: Plot, model: Model, source: Mapping, dark: bool) -> None:
        self.model, self.dark, self._source = model, dark, source
        self.factors, self.logs = _factors(plot), _are_log(plot)

    def __call__(self, name: str) -> object:
        """A property: one value, or a column."""
        given = getattr(self.model, name)
        if isinstance(given, Value):
            return given.value
        given = given.field if isinstance(given, Field) else given
        is_column = isinstance(given, str) and given in self._source and not (name == "marker" and given in _MARKERS)
        return self._source[given] if is_column else given

    def at(self, name: str, axis: str = "") -> np.ndarray:
        """A column of places, in the units of their axis."""
        return np.array(np.atleast_1d(self(name))) * self.factors[axis or name[0]]

    def colour(self, given: str | None) -> str:
        return file_colour(given, dark=self.dark)

    @property
    def line(self) -> dict[str, object]:
        """The look of a line."""
        dash, width = self("line_dash"), self("line_width")
        lengths = _DASHES[dash] if isinstance(dash, str) else dash
        lengths = tuple(part / width for part in (lengths if len(lengths) % 2 == 0 else [*lengths, *lengths]))
        style = (0, lengths) if lengths else "-"
        look = {"color": self.colour(self("line_color")), "linewidth": PT * width, "linestyle": style}
        return look | ({"alpha": self("line_alpha")} if self("line_alpha") < 1 else {})

    def groups(self, *names: str) -> Iterator[tuple[object, tuple]]:
        """The rows that have the same of some properties, and what they have."""
        given = [self(name) for name in names]
        count = next((len(each) for each in given if isinstance(each, list | np.ndarray)), None)
        if count is None:  # as nearly always
            yield slice(None), tuple(given)
            return
        columns = [each if isinstance(each, list | np.ndarray) else [each] * count for each in given]
        rows = list(zip(*columns, strict=True))
        for look in dict.fromkeys(rows):
            yield [n for n, each in enumerate(rows) if each == look], look


def declared(plot: Plot, key: Key = Key(), *, dark: bool = False) -> Drawing:  # noqa: B008 - it does not change
    """The figure as it is on the page; ``dark`` in the colours of the dark page."""
    entries = [item for legend in plot.legend for item in legend.items if item.visible]
    parts = [part for part in plot.renderers if isinstance(part, GlyphRenderer)]
    drawn: list[Call] = []
    for number, part in sorted(enumerate(parts), key=lambda each: _place(each[1], entries)):
        if part.visible:
            look = _Look(plot, part.glyph, part.data_source.data, dark)
            name = "axes" if part.y_range_name == "default" else "right"
            layer = 2 + _LEVELS.index(part.level) + number / len(parts)
            made = [Call(name, *call) for call in _calls(part.glyph, look)]
            drawn += [call._replace(options={**call.options, "zorder": round(layer, 3)}) for call in made]
            label = next((_text(item) for item in entries if item.renderers[0] is part), "")
            if label and made:
                first = drawn[-len(made)]
                drawn[-len(made)] = first._replace(options={**first.options, "label": label})
    for part in plot.center:
        if isinstance(part, Span | Label | LabelSet) and part.visible:
            look = _Look(plot, part, part.source.data if isinstance(part, LabelSet) else {}, dark)
            drawn += [Call("axes", *call) for call in _calls(part, look)]
    labels = {side: axis.axis_label or "" for side, axis in _axes(plot) if axis.visible}
    title = _ON_THE_PAGE.sub("", plot.title.text) if plot.title and plot.title.visible else ""
    calls = [*drawn, *_key_calls(key, dark), *_axis_calls(plot, dark)]
    return Drawing(_size(plot), title, labels, calls, file_style(dark=dark))


def _place(part: GlyphRenderer, entries: Sequence[LegendItem]) -> int:
    """The place in the legend; what has none comes last."""
    return next((n for n, item in enumerate(entries) if part in item.renderers), len(entries))


def _text(item: LegendItem) -> str:
    label = item.label
    return label.value if isinstance(label, Value) else str(label)


def _size(plot: Plot) -> tuple[float, float]:
    try:
        width, height = plot.outer_width, plot.outer_height
    except UnsetValueError:  # no browser has laid it out
        width = 0
    return (width, height) if width > 1 else (_FOLDED, plot.height or _FOLDED / 2)


# ---- axes -----------------------------------------------------------------------------------------------------------


def _axes(plot: Plot) -> list[tuple[str, Axis]]:
    sides = {"x": plot.below, "y": plot.left, "right": plot.right}
    return [(side, axis) for side, parts in sides.items() for axis in parts if isinstance(axis, Axis)]


def _are_log(plot: Plot) -> tuple[bool, bool]:
    return isinstance(plot.x_scale, LogScale), isinstance(plot.y_scale, LogScale)


def _factors(plot: Plot) -> dict[str, float]:
    """What the numbers of each axis are, of those that are drawn over it (`UnitAxis`)."""
    found = {}
    for side in "xy":
        data, name = getattr(plot, f"{side}_range"), getattr(getattr(plot, f"{side}axis")[0], f"{side}_range_name")
        shown = data if name == "default" else getattr(plot, f"extra_{side}_ranges")[name]
        found[side] = 1.0 if shown is data else shown.end / data.end if data.end else shown.start / data.start
    return found


def _axis_calls(plot: Plot, dark: bool) -> Iterator[Call]:
    """Scales, ends, numbers and grid of the axes."""
    logs, factors = dict(zip("xy", _are_log(plot), strict=True)), _factors(plot)
    for side, axis in _axes(plot):
        on, letter = ("right", "y") if side == "right" else ("axes", side)
        data = plot.extra_y_ranges[axis.y_range_name] if side == "right" else getattr(plot, f"{letter}_range")
        if isinstance(data, FactorRange):
            yield Call(on, f"set_{letter}ticks", (list(range(len(data.factors))), data.factors))
            yield Call(on, f"set_{letter}lim", (-0.5, len(data.factors) - 0.5))
            continue
        is_log = side != "right" and logs[letter]
        if is_log:
            yield Call(on, f"set_{letter}scale", ("log",))
        if isinstance(axis.ticker, FixedTicker):
            yield Call(on, f"set_{letter}ticks", (list(axis.ticker.ticks),))
            yield Call(on, f"{letter}axis.set_minor_formatter", ("",))
        if is_log and isinstance(axis.formatter, BasicTickFormatter):
            yield Call(on, f"{letter}axis.set_major_formatter", ("{x:g}",))
        factor = 1.0 if side == "right" else factors[letter]
        yield Call(on, f"set_{letter}lim", (float(data.start) * factor, float(data.end) * factor))
        if not axis.visible:
            edge = {"x": "bottom", "y": "left"}[letter]
            yield Call(on, f"{letter}axis.set_tick_params", (), {edge: False, f"label{edge}": False, "which": "both"})
    for letter in "xy":
        if not any(grid.visible and grid.grid_line_color for grid in getattr(plot, f"{letter}grid")):
            yield Call("axes", "grid", (), {"visible": False, "axis": letter})
    yield Call("axes", "set_facecolor", (file_colour(plot.background_fill_color, dark=dark),))


def _key_calls(key: Key, dark: bool) -> Iterator[Call]:
    """Entries of the legend for the key of the colours."""
    ink = file_style(dark=dark)["text.color"]
    if key.rows:
        yield Call("axes", "plot", ([], []), {"linestyle": "none", "label": f"{key.head}:"})
    for colour, name, pattern in key.rows:
        veiled = pattern == "veil"
        look = {"facecolor": file_colour(colour, dark=dark), "edgecolor": "#35456C" if veiled else ink}
        hatch = "||" if veiled else _KEY.get(pattern, "") * _DENSE
        yield Call("axes", "fill", ([], []), look | {"hatch": hatch, "linewidth": 0.5, "label": name})


# ---- glyphs: method, arguments and options of each call -------------------------------------------------------------

_Made = Iterator[tuple[str, tuple, dict]]


@singledispatch
def _calls(model: Model, look: _Look) -> _Made:
    raise TypeError(f"no file can be made of {type(model).__name__}")


@_calls.register
def _(model: Line, look: _Look) -> _Made:
    if look("line_alpha"):
        yield "plot", (look.at("x"), look.at("y")), look.line


@_calls.register
def _(model: Segment, look: _Look) -> _Made:
    ends = np.broadcast_arrays(*(look.at(name) for name in ("x0", "x1", "y0", "y1")))
    x0, x1, y0, y1 = (each.astype(float) for each in ends)
    gap = np.full(len(x0), np.nan)
    yield "plot", tuple(np.stack(part, axis=1).ravel() for part in ((x0, x1, gap), (y0, y1, gap))), look.line


@_calls.register
def _(model: Scatter, look: _Look) -> _Made:
    x, y = look.at("x"), look.at("y")
    for rows, (marker, size, fill, edge) in look.groups("marker", "size", "fill_color", "line_color"):
        slim = _SLIM if str(marker).startswith("diamond") else 1.0
        options = {
            "linestyle": "none",
            "marker": _MARKERS.get(marker, "o"),
            "markersize": round(PT * slim * (size or 1), 3),
            "markerfacecolor": look.colour(fill),
            "markeredgecolor": look.colour(edge),
            "markeredgewidth": PT * look("line_width"),
        }
        options |= {"alpha": look("line_alpha")} if look("line_alpha") < 1 else {}
        yield "plot", (x[rows], y[rows]), options | ({"rasterized": True} if len(x) > MANY else {})


@_calls.register
def _(model: Quad, look: _Look) -> _Made:
    sides = (look.at(name, axis) for name, axis in (("left", "x"), ("right", "x"), ("bottom", "y"), ("top", "y")))
    left, right, bottom, top = np.broadcast_arrays(*sides)
    for rows, (fill, hatch) in look.groups("fill_color", "hatch_pattern"):
        options = {"width": (right - left)[rows], "bottom": bottom[rows], "align": "edge", **_filled(look, fill, hatch)}
        yield "bar", (left[rows], (top - bottom)[rows]), options


@_calls.register
def _(model: HBar, look: _Look) -> _Made:
    left, right = np.broadcast_arrays(look.at("left", "x"), look.at("right", "x"))
    edge = {"edgecolor": look.colour(look("line_color")), "linewidth": PT * look("line_width")}
    options = _filled(look, look("fill_color"), look("hatch_pattern")) | (edge if look("line_color") else {})
    at = ["penalty", "reference"].index(look("y"))  # of the factors of the only axis with such
    yield "barh", (np.full(len(left), at), right - left), {"left": left, "height": look("height"), **options}


def _filled(look: _Look, fill: str | None, hatch: str | None) -> dict[str, object]:
    alpha = {"alpha": look("fill_alpha")} if look("fill_alpha") < 1 else {}
    signs = _HATCHES.get(hatch, hatch) if hatch else ""
    signs = {"hatch": _DENSE * signs, "edgecolor": look.colour(look("hatch_color"))} if signs else {}
    return {"color": look.colour(fill), "linewidth": 0, **alpha, **signs}


@_calls.register
def _(model: Image, look: _Look) -> _Made:
    mapper = model.color_mapper
    shades = {"cmap": [look.colour(each) for each in mapper.palette], "vmin": mapper.low, "vmax": mapper.high}
    places = (look.at(name, axis) for name, axis in (("x", "x"), ("dw", "x"), ("y", "y"), ("dh", "y")))
    for image, x, wide, y, high in zip(look("image"), *places, strict=True):
        (left, right, low, top), cells = map(float, (x, x + wide, y, y + high)), np.array(image)
        if not any(look.logs):
            where = {"extent": (left, right, low, top), "origin": "lower", "aspect": "auto"}
            yield "imshow", (cells,), {**where, "interpolation": "nearest", **shades}
            continue
        edges = [
            (np.geomspace if log else np.linspace)(*ends, count + 1)
            for log, ends, count in zip(look.logs, ((left, right), (low, top)), cells.shape[::-1], strict=True)
        ]
        yield "pcolormesh", (*edges, cells), {"rasterized": True, **shades}


@_calls.register
def _(model: HSpan, look: _Look) -> _Made:
    return (("axhline", (float(at),), look.line) for at in look.at("y"))


@_calls.register
def _(model: VSpan, look: _Look) -> _Made:
    return (("axvline", (float(at),), look.line) for at in look.at("x"))


@_calls.register
def _(model: VStrip, look: _Look) -> _Made:
    ends = zip(look.at("x0"), look.at("x1"), strict=True)
    area = _filled(look, look("fill_color"), None)
    return (("axvspan", (float(begin), float(end)), area) for begin, end in ends)


@_calls.register
def _(model: Span, look: _Look) -> _Made:
    upright = model.dimension == "height"
    if model.location is not None:
        at = float(model.location) * look.factors["x" if upright else "y"]
        yield "axvline" if upright else "axhline", (at,), look.line


@_calls.register(Label)
@_calls.register(LabelSet)
def _(model: Label | LabelSet, look: _Look) -> _Made:
    for x, y, text in zip(look.at("x"), look.at("y"), np.atleast_1d(look("text")), strict=True):
        is_set = isinstance(model, LabelSet)
        at = (float(x), PT * model.y if model.y_units == "screen" else float(y))
        options = {
            "xycoords": ("data", "axes points") if model.y_units == "screen" else "data",
            "xytext": (9, 9) if is_set else (PT * model.x_offset, 0),
            "textcoords": "offset points",
            "ha": "center" if look("text_align") == "center" else "left",
            "bbox": {"facecolor": look.colour(look("background_fill_color")), "alpha": 0.8, "linewidth": 0, "pad": 1},
            "zorder": 8,
        }
        yield "annotate", (str(text), at), options
