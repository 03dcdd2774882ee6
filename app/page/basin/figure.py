"""Basins of attraction: the reference at the left, the penalty model at the right; a click starts Explore there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from bokeh.events import Tap
from bokeh.models import LegendItem
from bokeh.plotting import figure
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.link import LINEAR
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.cells import (
    add_cells,
    add_mark,
    cells_figure,
    cells_source,
    listen,
    rounded_view,
    write_cells,
)
from vibroscope.app.page.shared.figure import divisor, empty_source, hover_tool, legend_above, write
from vibroscope.app.page.shared.ranges import OwnedRange, UnitAxis
from vibroscope.app.page.shared.seen import say
from vibroscope.app.studies.basin import PALETTE, SIDES, BasinQuestion, PartialBasin
from vibroscope.engine import COORDINATES, System, percent
from vibroscope.engine.sweeps.basin_motions import PHASE

REACH = 8.0  # of the starts at first, in units of what drives the bodies
WHOLE = (0.0, 1.0)  # of a period
NAMES = {"reference": "Reference", "penalty": "Penalty model"}


class BasinView:
    """Two figures with the same axes and colours."""

    def __init__(self, on_start: Callable[[float, float], None], on_zoom: Callable[[], None]) -> None:
        self._on_start = on_start
        first = default_span(System(), 1.0)
        self.ranges = {name: OwnedRange(*first) for name in ("start_x", "start_y")}
        self.sources = {side: cells_source(f"basin_{side}_cells", "motion", "period") for side in SIDES}
        self.mark = empty_source("basin_mark", "x", "y")
        self.figures = {side: self._figure(side) for side in SIDES}
        plots = list(self.figures.values())
        self._axes = {name: UnitAxis(self.ranges[name], name[-1], *plots) for name in self.ranges}
        listen(plots, self.on_tap, on_zoom)

    def _figure(self, side: str) -> figure:
        plot = cells_figure(f"basin_{side}", *self.ranges.values())
        cells = add_cells(plot, self.sources[side], PALETTE)
        plot.add_tools(hover_tool([cells], {"motion": "@motion", "repeats after (periods)": "@period"}))
        mark = add_mark(plot, "x", "y", self.mark)
        legend_above(plot, [LegendItem(label="start that is set", renderers=[mark])])
        return plot

    def hold(self, setting: Setting, axes: tuple[str, str]) -> None:
        """Set the axes to the range of starts that suits the system, and that of a phase to one period."""
        span = default_span(setting.system, setting.eta)
        for owned, axis in zip(self.ranges.values(), axes, strict=True):
            owned.put(*(WHOLE if axis == PHASE else span))

    @property
    def spans(self) -> dict[str, tuple[float, float]]:
        """The parts of both axes that are in view."""
        return {name[-1]: rounded_view(owned.ends, *LINEAR) for name, owned in self.ranges.items()}

    def spans_of(self, axes: tuple[str, str]) -> dict[str, tuple[float, float]]:
        """The parts of these axes that are in view; that of a phase is at most a period."""
        return {
            name: (within(span) if axis == PHASE else span)
            for (name, span), axis in zip(self.spans.items(), axes, strict=True)
        }

    def update(self, setting: Setting, axes: tuple[str, str], result: PartialBasin | None) -> None:
        """Move the mark; draw the cells as far as they are known."""
        for name, axis in zip(self.ranges, axes, strict=True):
            if axis == PHASE:
                self._axes[name].show("start phase / period", 1.0)
                continue
            field = shown_field(f"start_{axis}", setting)
            self._axes[name].show(f"start {field.label} / {divisor(field.unit or field.natural)}", field.factor)
        place = start_on(setting, axes)
        write(self.mark, {name: np.array([value], np.float32) for name, value in zip("xy", place, strict=True)})
        if result is None:
            return
        at = shown_field("eta", setting).words(result.question.eta)
        for side in SIDES:
            say(self.figures[side], f"{NAMES[side]}{_method_words(side, result.question)}, {at}", _seen(result, side))
            motion = result.shown(side)
            more = {"motion": np.where(motion >= 0, motion + 1, 0).astype(np.int32), "period": result.periods(side)}
            write_cells(self.sources[side], result.image(side), result.question.x, result.question.y, **more)

    def on_tap(self, event: Tap) -> None:
        """Start Explore at the place of a tap."""
        if event.x is not None and event.y is not None and np.isfinite([event.x, event.y]).all():
            self._on_start(float(f"{event.x:.4g}"), float(f"{event.y:.4g}"))


def _seen(result: PartialBasin, side: str) -> str:
    """The share of the starts that leads to each motion."""
    shares = {each.name: each.shares[side] for each in result.motions if side in each.shares}
    return ", ".join(f"{name} {percent(share)}" for name, share in shares.items())


def default_span(system: System, eta: float) -> tuple[float, float]:
    """How far starts reach at first: REACH times the largest amplitude or clearance of the system."""
    drive = system.excitation
    size = max(abs(value) for value in (drive.base_amplitude(eta), drive.force1, drive.force2, system.clearance)) or 1.0
    reach = float(f"{REACH * size:.2g}")
    return -reach, reach


def start_on(setting: Setting, axes: tuple[str, str]) -> tuple[float, float]:
    """The numbers of the start that is set that belong to the axes; its phase is 0."""
    numbers = dict(zip(COORDINATES, setting.initial, strict=True)) | {PHASE: 0.0}
    return numbers[axes[0]], numbers[axes[1]]


def within(span: tuple[float, float]) -> tuple[float, float]:
    """The part of a view that lies within a period; all of the period if none does."""
    low, high = max(span[0], WHOLE[0]), min(span[1], WHOLE[1])
    return (low, high) if low < high else WHOLE


def _method_words(side: str, question: BasinQuestion) -> str:
    if side == "reference":
        return ""
    return f", T/{question.penalty.steps}" if question.penalty.has_step else " without a time step"
