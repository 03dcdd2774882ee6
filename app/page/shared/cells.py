"""Cells of a study as a picture whose every pixel is a class of a palette."""

from collections.abc import Sequence
from functools import partial

import numpy as np
from bokeh.models import ColumnDataSource, Image, LinearColorMapper, Scatter
from vibroscope.app.page.shared.curves import Curve, Curves, curve
from vibroscope.app.page.shared.figure import VERMILLION

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
