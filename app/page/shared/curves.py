"""Figures that a view declares: axes that they share, and the curves, the legend and the hover of each.

A view derives from `Curves`, gives its ``axes`` and ``plots`` as tables, and in `update` writes columns and says what
is seen. Its sources, ranges and legend entries follow from the tables, and so does what a link may hold.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import ClassVar, NamedTuple

import numpy as np
from bokeh.models import ColumnDataSource, Glyph, Image, LegendItem, LinearAxis, LinearColorMapper, Scatter
from bokeh.plotting import figure
from vibroscope.app.explorer.link import LINEAR, LOGARITHMIC, Span
from vibroscope.app.explorer.present import as_float32
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import (
    VERMILLION,
    add_glyph,
    apply_style,
    empty_source,
    hover_tool,
    legend,
    make_figure,
    quantity_axis,
    write,
)
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.shared.ranges import MARGIN, OwnedRange, UnitAxis, extent
from vibroscope.app.page.shared.seen import say
from vibroscope.engine.facts import Statement

AWAITED = "Being computed …"  # the title of a figure in which there is nothing yet
_PLACES = {  # of a glyph: along each side, and of a picture
    "x": ("x", "x0", "x1", "left", "right"),
    "y": ("y", "y0", "y1", "bottom", "top"),
    "picture": ("image", "dw", "dh"),
}


class Axis(NamedTuple):
    """An axis of one figure or more.

    Attributes
    ----------
    low, high : float
        Its ends without data.
    words : str
        Its label; the unit of the quantity is put behind it.
    quantity : str
        Of its numbers, whose columns are without dimension; empty: they have no unit.
    logarithmic : bool
    headroom : float
        See `OwnedRange`.
    fit : callable, optional
        The ends for the least and the greatest of its data; `OwnedRange.follow` finds them if there is none.
    """

    low: float
    high: float
    words: str = ""
    quantity: str = ""
    logarithmic: bool = False
    headroom: float = MARGIN
    fit: Callable[[float, float], tuple[float, float]] | None = None


class Curve(NamedTuple):
    """A glyph over a source.

    Attributes
    ----------
    glyph : callable
        Makes the glyph.
    source : str
        Its name; that of one which nothing in the browser asks for begins with "_".
    look : mapping
        Properties of the glyph.
    hovered : bool
        Whether the hover is of it.
    layer : int
        It is drawn over what has a smaller one.
    on_right : bool
        Whether the axis at the right is its vertical one.
    level : str
        Of Bokeh: it is drawn over what has a lower one.
    """

    glyph: Callable[..., Glyph]
    source: str
    look: Mapping[str, object]
    hovered: bool = False
    layer: int = 0
    on_right: bool = False
    level: str = "glyph"

    def columns(self, *sides: str) -> list[str]:
        """The columns that place it along these sides."""
        names = (self.look.get(place) for side in sides for place in _PLACES[side])
        return list(dict.fromkeys(name for name in names if isinstance(name, str)))


def curve(glyph: Callable[..., Glyph], source: str, **look: object) -> Curve:
    """A `Curve` with these properties."""
    own = {name: look.pop(name) for name in Curve._fields if name in look}
    return Curve(glyph, source, look, **own)


def inside(columns: int) -> Callable[[figure, list[LegendItem]], None]:
    """A legend over the data, with so many columns."""
    return lambda plot, items: plot.add_layout(legend(items, columns))


class Plot(NamedTuple):
    """A figure.

    Attributes
    ----------
    title : str
    x, y : str
        Its axes by name.
    entries : mapping of str to (str, sequence of Curve)
        Of its legend, by their names in a link: words, and what is drawn. One without words has no place in the legend.
    tips : mapping of str to str
        Heads and columns of its hover, as `hover_tool` takes them.
    hover : mapping
        More of the hover tool.
    legend : callable
        Puts the entries into a legend.
    right : str
        A second vertical axis.
    room : mapping
        More of `make_figure`.
    """

    title: str
    x: str
    y: str
    entries: Mapping[str, tuple[str, Sequence[Curve]]]
    tips: Mapping[str, str] = {}
    hover: Mapping[str, object] = {}
    legend: Callable[[figure, list[LegendItem]], None] = inside(2)
    right: str = ""
    room: Mapping[str, object] = {}

    @property
    def curves(self) -> list[tuple[str, Curve]]:
        """What is drawn, from below, with its entry."""
        drawn = [(entry, each) for entry, (_, curves) in self.entries.items() for each in curves]
        return sorted(drawn, key=lambda each: each[1].layer)

    def axis(self, side: str, drawn: Curve) -> str:
        """The axis of a curve along one side."""
        return self.right if side == "y" and drawn.on_right else getattr(self, side)


def _on(plot: Plot, drawn: Curve) -> dict[str, str]:
    return {"level": drawn.level} | ({"y_range_name": plot.right} if drawn.on_right else {})


class Curves:
    """The figures of a view.

    Attributes
    ----------
    ranges : dict of str to OwnedRange
        By the names of the axes.
    units : dict of str to UnitAxis
        Of axes whose numbers have a unit.
    sources : dict of str to ColumnDataSource
    items : dict of (str, str) to LegendItem
        By figure and entry.
    figures : dict of str to figure
    """

    axes: ClassVar[Mapping[str, Axis]]
    plots: ClassVar[Mapping[str, Plot]]
    beside: ClassVar[Mapping[str, Sequence[str]]] = {}  # columns of sources that no curve has

    def __init__(self) -> None:
        self.ranges = {
            name: OwnedRange(axis.low, axis.high, headroom=axis.headroom) for name, axis in self.axes.items()
        }
        self.sources = {
            name: empty_source(None if name.startswith("_") else name, *columns)
            for name, columns in self._columns().items()
        }
        self.items: dict[tuple[str, str], LegendItem] = {}
        self.figures = {name: self._build(name, plot) for name, plot in self.plots.items()}
        self.units = {name: self._unit_axis(name) for name, axis in self.axes.items() if axis.quantity}
        self._drawn: object = None

    @classmethod
    def spans(cls) -> dict[str, Span]:
        """The axes as `TabView` has them."""
        return {name: LOGARITHMIC if axis.logarithmic else LINEAR for name, axis in cls.axes.items()}

    @classmethod
    def legends(cls) -> dict[str, tuple[str, ...]]:
        """The entries of the legends as `TabView` has them."""
        found = {
            name: tuple(key for key, (words, _) in plot.entries.items() if words) for name, plot in cls.plots.items()
        }
        return {name: entries for name, entries in found.items() if entries}

    @classmethod
    def _columns(cls) -> dict[str, list[str]]:
        """The columns of each source."""
        found = {source: list(columns) for source, columns in cls.beside.items()}
        for plot in cls.plots.values():
            shown = re.findall(r"@(\w+)", " ".join(plot.tips.values()))
            for _, each in plot.curves:
                found.setdefault(each.source, []).extend([*each.columns(*_PLACES), *(shown if each.hovered else ())])
        return {source: list(dict.fromkeys(columns)) for source, columns in found.items()}

    def _build(self, name: str, plot: Plot) -> figure:
        sides = {"x": self.axes[plot.x], "y": self.axes[plot.y]}
        axes = {f"{side}_axis_type": "log" for side, axis in sides.items() if axis.logarithmic}
        axes |= {"x_range": self.ranges[plot.x].range, "y_range": self.ranges[plot.y].range}
        made = make_figure(plot.title, *(axis.words for axis in sides.values()), name=name, **axes, **plot.room)
        if plot.right:
            made.extra_y_ranges = {plot.right: self.ranges[plot.right].range}
            made.add_layout(LinearAxis(y_range_name=plot.right, axis_label=self.axes[plot.right].words), "right")
            apply_style(made)
        drawn = [
            (entry, each, add_glyph(made, each.glyph(**each.look), self.sources[each.source], **_on(plot, each)))
            for entry, each in plot.curves
        ]
        for entry, (words, _) in plot.entries.items():
            if words:
                self.items[name, entry] = LegendItem(
                    label=words, renderers=[part for of, _, part in drawn if of == entry]
                )
        if items := [item for (of, _), item in self.items.items() if of == name]:
            plot.legend(made, items)
        if hovered := [part for _, each, part in drawn if each.hovered]:
            made.add_tools(hover_tool(hovered, plot.tips, **plot.hover))
        return made

    def _unit_axis(self, name: str) -> UnitAxis:
        side = "x" if any(plot.x == name for plot in self.plots.values()) else "y"
        plots = (self.figures[key] for key, plot in self.plots.items() if getattr(plot, side) == name)
        return UnitAxis(self.ranges[name], side, *plots)

    def label(self, setting: Setting, reword: Callable[[str], str] = str, **others: tuple[str, str]) -> None:
        """Label the axes in the units of the setting.

        ``reword`` changes the words that are declared; ``others`` are words and quantities in their place, by axis.
        """
        for name, shown in self.units.items():
            words, quantity = others.get(name, self.axes[name][2:4])
            shown.show(*quantity_axis(setting, reword(words), quantity))

    def fit_axes(self, setting: Setting) -> None:
        """Let the axes cover what a setting needs that is shown next."""

    def changes_to(self, drawn: object) -> bool:
        """Whether this is not what was drawn before, such as another question: it is what is drawn now."""
        before, self._drawn = self._drawn, drawn
        return before != drawn

    def write(self, source: str, columns: Mapping[str, np.ndarray]) -> None:
        """Put columns into a source; those that are left out are empty."""
        held = self.sources[source]
        write(held, as_float32({name: columns.get(name, ()) for name in held.data}))

    def say(self, figure: str, seen: str | Statement = "", setting: Setting | None = None) -> None:
        """Say behind the title of a figure what is seen in it."""
        say(self.figures[figure], self.plots[figure].title, seen, setting)

    def follow(self, *names: str, fresh: bool, beside: Iterable[np.ndarray] = (), always: Iterable[float] = ()) -> None:
        """Fit these axes to what is drawn over them, and to data ``beside`` and values that are ``always`` in view."""
        for name in names:
            columns, axis, owned = [*self._over(name), *beside], self.axes[name], self.ranges[name]
            ends = extent(columns)
            if axis.fit is None:
                owned.follow(columns, fresh=fresh, always=always)
            elif ends is None:
                owned.put(axis.low, axis.high)
            else:
                owned.put(*axis.fit(*ends), fresh=fresh)

    def _over(self, name: str) -> list[np.ndarray]:
        """The columns that are drawn over an axis."""
        return [
            self.sources[each.source].data[column]
            for plot in self.plots.values()
            for _, each in plot.curves
            for side in "xy"
            if plot.axis(side, each) == name
            for column in each.columns(side)
        ]


class AddedCurves:
    """Curves that come to the figures of a view when there is something to draw: of a pin, a branch, a measurement.

    Each has an entry in the legend of each of its figures.

    Parameters
    ----------
    entry, label : str
        Name of the entries in a link, and in the legends.
    curves : mapping of str to sequence of Curve
        By figure; their sources are theirs alone.
    """

    def __init__(self, entry: str, label: str, curves: Mapping[str, Sequence[Curve]]) -> None:
        self.entry, self._label, self._curves = entry, label, curves
        columns: dict[str, list[str]] = {}
        for each in chain(*curves.values()):
            columns.setdefault(each.source, []).extend(each.columns(*_PLACES))
        self.sources = {name: empty_source(name, *of) for name, of in columns.items()}
        self.items: dict[str, LegendItem] = {}  # by figure, once they are there
        self._drawn: set[str] = set()  # sources with something to draw
        self._away: set[str] = set()  # figures that draw none

    @property
    def missing(self) -> bool:
        """Whether there is something to draw, and no curve for it: `add` adds them."""
        return bool(self._drawn) and not self.items

    def add(self, figures: Mapping[str, figure]) -> None:
        """Add the curves and their entries to the figures, unless they are there."""
        for name, curves in self._curves.items() if not self.items else ():
            plot = figures[name]
            parts = [add_glyph(plot, c.glyph(**c.look), self.sources[c.source], level=c.level) for c in curves]
            self.items[name] = LegendItem(label=self._label, renderers=parts)
            plot.legend[0].items = [*plot.legend[0].items, self.items[name]]
        self._show()

    def show(self, columns: Mapping[str, Mapping[str, np.ndarray]]) -> None:
        """Draw the columns of these sources; entries of others are hidden."""
        for name, source in self.sources.items():
            write(source, as_float32({each: columns.get(name, {}).get(each, ()) for each in source.data}))
        self._drawn = {*columns}
        self._show()

    def draw(self, name: str, drawn: bool) -> None:
        """Whether they are drawn in this figure."""
        (self._away.discard if drawn else self._away.add)(name)
        self._show()

    def along(self, name: str, side: str) -> list[np.ndarray]:
        """What is drawn along a side of a figure, for the range of its axis."""
        curves = self._curves.get(name, ())
        return [self.sources[each.source].data[column] for each in curves for column in each.columns(side)]

    def _show(self) -> None:
        for name, item in self.items.items():
            drawn = any(each.source in self._drawn for each in self._curves[name])
            show_entry(item, drawn and name not in self._away)


# ---- cells of a study, as a picture whose every pixel is a class of a palette ----------------------------------------

_PLACE = ("x", "y", "dw", "dh")


class CellsView(Curves):
    """Figures of cells with the same axes; these fill them, so that they have no grid."""

    def __init__(self) -> None:
        super().__init__()
        for plot in self.figures.values():
            plot.xgrid.visible = plot.ygrid.visible = False


def cells(source: str, palette: Sequence[str], **more: object) -> Curve:
    """The picture of a source."""
    return curve(partial(_picture, palette), source, **{name: name for name in ("image", *_PLACE)}, **more)


def _picture(palette: Sequence[str], **place: str) -> Image:
    return Image(color_mapper=LinearColorMapper(palette=list(palette), low=-0.5, high=len(palette) - 0.5), **place)


def mark(source: str, x: str, y: str) -> Curve:
    """The setting of the page over the cells, at these columns of a source."""
    look = {"marker": "diamond_cross", "size": 17, "fill_color": "#FFFFFF", "fill_alpha": 0.85}
    return curve(Scatter, source, x=x, y=y, **look, line_color=VERMILLION, line_width=2.2, level="overlay")


def write_cells(
    source: ColumnDataSource,
    picture: np.ndarray,
    x: tuple[float, float],
    y: tuple[float, float],
    **more: np.ndarray,
) -> None:
    """Show a picture, (rows over y, columns over x), between these edges, where it differs from what is shown."""
    place = dict(zip(_PLACE, (x[0], y[0], x[1] - x[0], y[1] - y[0]), strict=True))
    arrays = {"image": picture} | more
    same = all(_same(source.data[name], array) for name, array in arrays.items())
    if not same or any(source.data[name] != [value] for name, value in place.items()):
        source.data = {name: [value] for name, value in (arrays | place).items()}


def _same(old: Sequence[np.ndarray], new: np.ndarray) -> bool:
    return bool(len(old)) and old[0].shape == new.shape and bool((old[0] == new).all())


def rounded_view(shown: tuple[float, float], low: float, high: float) -> tuple[float, float]:
    """The part of an axis in view, rounded so that the same view is the same question; all of it where none is left."""
    ends = [float(f"{np.clip(end, low, high):.4g}") for end in shown]
    least = 0.001 * max(abs(end) for end in ends)
    return tuple(ends) if ends[1] - ends[0] > least else (low, high)
