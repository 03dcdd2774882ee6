"""Cells of a study as a picture whose every pixel is a class of a palette."""

from collections.abc import Callable, Sequence

import numpy as np
from bokeh.events import RangesUpdate, Tap
from bokeh.models import ColumnDataSource, GlyphRenderer, LinearColorMapper
from bokeh.plotting import figure
from vibroscope.app.page.shared.figure import VERMILLION, make_figure
from vibroscope.app.page.shared.ranges import OwnedRange

_PLACE = ("x", "y", "dw", "dh")


def cells_source(name: str | None = None, *more: str) -> ColumnDataSource:
    """A source of one picture that is not there yet; ``more``: further numbers of each cell, for a hover."""
    return ColumnDataSource({column: [] for column in ("image", *_PLACE, *more)}, name=name)


def cells_figure(name: str, x: OwnedRange, y: OwnedRange, labels: tuple[str, str] = ("", ""), **more) -> figure:
    """A figure for cells, which fill it, so that it has no grid."""
    plot = make_figure("Being computed …", *labels, name=name, x_range=x.range, y_range=y.range, **more)
    plot.xgrid.visible = plot.ygrid.visible = False
    return plot


def listen(plots: Sequence[figure], on_tap: Callable[[Tap], None], on_zoom: Callable[[], None]) -> None:
    """Call these for a tap, and for a zoom, of figures that have the same ranges."""
    for plot in plots:
        plot.on_event(Tap, on_tap)
    plots[0].on_event(RangesUpdate, lambda event: on_zoom())  # the events of one are enough


def add_cells(plot: figure, source: ColumnDataSource, palette: Sequence[str]) -> GlyphRenderer:
    """Draw the picture of a source."""
    colours = LinearColorMapper(palette=list(palette), low=-0.5, high=len(palette) - 0.5)
    return plot.image("image", **{name: name for name in _PLACE}, source=source, color_mapper=colours)


def add_mark(plot: figure, x: str, y: str, source: ColumnDataSource) -> GlyphRenderer:
    """Draw the setting of the page over the cells, at these columns of a source."""
    look = {"marker": "diamond_cross", "size": 17, "fill_color": "#FFFFFF", "fill_alpha": 0.85}
    return plot.scatter(x, y, source=source, **look, line_color=VERMILLION, line_width=2.2, level="overlay")


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
