"""The paper's figures, computed anew and drawn small."""

from collections.abc import Iterable
from functools import singledispatch

import numpy as np
from bokeh.models import BasicTickFormatter, LinearColorMapper, Range1d
from bokeh.plotting import figure
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.page.shared.figure import BLUE, CLICK, INK, SHADES, SOLUTIONS, VERMILLION, make_figure, scene_line
from vibroscope.app.page.shared.ranges import OwnedRange, extent
from vibroscope.app.paper.pictures import CellMap, PhasePlots, Picture, TimeHistory
from vibroscope.app.studies.bifurcation import raster
from vibroscope.engine import Diagram, Response, motion

_DOTS = {
    "reference": {"marker": "circle", "line_color": BLUE, "fill_color": None},
    "penalty": {"marker": "diamond", "line_color": VERMILLION, "fill_color": None},
}
_DASHES = ("dashed", "solid")  # pendulums 1 and 2
KINDS = [VERMILLION, "#C6CDD4", BLUE]  # wrong, in between, right
_TICKS = [digit * 10**power for power in range(6) for digit in (1, 2, 5)]  # of a logarithmic axis
_PIXELS = (640, 260)
# Small, without tools: the card's button opens the setting where it can be explored.
_OPTIONS = {"height": 230, "sizing_mode": "stretch_width", "tools": "", "active_drag": None, "toolbar_location": None}


@singledispatch
def draw(picture: Picture, name: str) -> figure:
    """The figure of a picture in the page's style; ``name`` is the name of the model."""
    raise TypeError(f"no figure for {type(picture).__name__}")


@draw.register
def _(picture: PhasePlots, name: str) -> figure:
    """Phase plots of pendulum 2, of both pendulums where there is only one solution."""
    alone = len(picture.runs) == 1
    curves = [(solver, n, run) for solver, run in picture.runs.items() for n in ((0, 1) if alone else (1,))]
    orbits = [_orbit(run, n) for _, n, run in curves]
    plot = _empty_figure(name, "displacement ξ / base amplitude", "velocity ξ′ / (Aω₁)", *zip(*orbits, strict=True))
    for (solver, n, run), orbit in zip(curves, orbits, strict=True):
        look = SOLUTIONS[solver] | ({"line_width": 1.3, "line_alpha": 1.0, "line_dash": _DASHES[n]} if alone else {})
        label = f"pendulum {n + 1}" if alone else f"{solver}, pendulum 2"
        plot.line(*orbit, **look, legend_label=label)
        points = run.section[:, 2 * n : 2 * n + 2].astype(np.float32).T
        plot.scatter(*points, size=6, **_DOTS[solver], legend_label=label)
    return _with_legend(plot)


def _orbit(run: Response, pendulum: int) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity over one cycle, or over all samples where there is no cycle."""
    samples = run.trajectory
    cycle = (motion(run).period or np.inf) * run.period
    kept = samples.time >= samples.time[-1] - 1.001 * cycle
    return tuple(series[pendulum, kept].astype(np.float32) for series in (samples.displacement, samples.velocity))


@draw.register
def _(picture: TimeHistory, name: str) -> figure:
    """Displacements over two periods, with the reference's force and impacts or the penalty's contacts as bands."""
    run, samples = picture.run, picture.run.trajectory
    series = {"ξ₁": samples.displacement[0], "ξ₂": samples.displacement[1]}
    exact = run.method.rigid
    if exact and samples.force.any():  # a penalty force is a hundred times as high
        series["force λ"] = samples.force
    series = {label: values.astype(np.float32) for label, values in series.items()}
    t = _in_periods(run, samples.time)
    plot = _empty_figure(
        name, "time τ / T", "displacement ξ" + ", force λ" * ("force λ" in series), [t], series.values()
    )
    looks = zip((BLUE, BLUE, VERMILLION), (*_DASHES, "solid"), strict=True)
    for (label, values), (colour, dash) in zip(series.items(), looks, strict=False):
        plot.line(t, values, line_color=colour, line_width=1.4, line_dash=dash, legend_label=label)
    if exact:
        _add_impacts(plot, run)
    else:
        _add_bands(plot, run)
    return _with_legend(plot)


def _add_impacts(plot: figure, run: Response) -> None:
    """Mark the impacts."""
    shown = run.impacts.time >= run.trajectory.time[0]
    where = run.impacts.position[shown].astype(np.float32)
    at = _in_periods(run, run.impacts.time[shown])
    plot.scatter(at, where, size=7, line_color=VERMILLION, fill_color=None, legend_label="impacts")


def _add_bands(plot: figure, run: Response) -> None:
    """Shade the intervals of contact."""
    low, high = plot.y_range.start, plot.y_range.end
    left, right = np.clip(_in_periods(run, run.contacts[run.contacts[:, 1] > run.trajectory.time[0]]), 0, None).T
    look = {"fill_color": VERMILLION, "fill_alpha": 0.3, "line_color": None, "legend_label": "contact"}
    plot.quad(left=left, right=right, bottom=low, top=high, **look)


def _in_periods(run: Response, time: np.ndarray) -> np.ndarray:
    """Time since the first sample, in excitation periods."""
    return ((time - run.trajectory.time[0]) / run.period).astype(np.float32)


@draw.register
def _(picture: CellMap, name: str) -> figure:
    """Cells coloured by kind; a cross marks the set that the claim is about."""
    x, y = _edges(picture.stiffness), _edges(picture.damping)
    axes = {"x_axis_type": "log", "y_axis_type": "log", "x_range": Range1d(*x), "y_range": Range1d(*y)}
    plot = make_figure("", "contact stiffness K / k₁", "contact damping D / (2m₁ω₁)", **_OPTIONS, name=name, **axes)
    for number, (kind, colour) in enumerate(zip(picture.names, KINDS, strict=True)):
        # The square is for the legend, in which an image draws nothing. An image for each kind, which its entry hides.
        look = {"marker": "square", "size": 9, "line_color": colour, "fill_color": colour}
        plot.scatter([np.nan], [np.nan], **look, legend_label=kind)
        mapper = LinearColorMapper(palette=["#FFFFFF00", colour], low=0, high=1)
        _add_image(plot, picture.kind == number, x, y, mapper, legend_label=kind)
    for axis in plot.axis:
        axis.ticker = _TICKS
        axis.formatter = BasicTickFormatter(use_scientific=False)
    K, D = picture.at
    plot.scatter([K], [D], marker="x", size=12, line_color=INK, line_width=3, legend_label=f"K = {K:g}, D = {D:g}")
    return _with_legend(plot)


def _edges(centres: np.ndarray) -> tuple[float, float]:
    """Ends of an axis whose cells are evenly spaced in their logarithms."""
    half = np.sqrt(centres[1] / centres[0])
    return float(centres[0] / half), float(centres[-1] * half)


@draw.register
def _(picture: Diagram, name: str) -> figure:
    """ξ₂ of the section over η as an image of how many points fall into each pixel."""
    values = picture.displacement[1]
    x, y = (float(picture.eta[0]), float(picture.eta[-1])), extent([values])
    axes = {"x_range": Range1d(*x), "y_range": Range1d(*y)}
    words = "", "excitation frequency η = Ω/ω₁", "displacement ξ₂ / base amplitude"
    plot = make_figure(*words, **_OPTIONS, name=name, **axes)
    shades = raster(picture.eta, values, x, y, *_PIXELS)
    _add_image(plot, shades, x, y, LinearColorMapper(palette=SHADES, low=0, high=255))
    for key in "ABCD":
        plot.add_layout(scene_line(scenes()[key].setting.eta))
    return plot


def _add_image(plot: figure, cells: np.ndarray, x: tuple, y: tuple, colours: LinearColorMapper, **more) -> None:
    """Fill the frame with an image."""
    plot.grid.visible = False
    place = {"x": x[0], "y": y[0], "dw": x[1] - x[0], "dh": y[1] - y[0]}
    plot.image([cells.astype(np.uint8)], **place, color_mapper=colours, **more)


def _empty_figure(name: str, x: str, y: str, xs: Iterable[np.ndarray], ys: Iterable[np.ndarray]) -> figure:
    """An empty figure whose ranges hold all of these columns, so that the browser need not choose and report them."""
    ranges = OwnedRange(0, 1), OwnedRange(0, 1)
    for owned, columns in zip(ranges, (xs, ys), strict=True):
        owned.follow(list(columns), fresh=True)
    return make_figure("", x, y, **_OPTIONS, name=name, x_range=ranges[0].range, y_range=ranges[1].range)


def _with_legend(plot: figure) -> figure:
    """The figure with its legend above the frame, where it hides nothing."""
    legend = plot.legend[0]
    legend.update(orientation="horizontal", click_policy=CLICK, ncols=2)
    plot.add_layout(legend, "above")
    return plot
