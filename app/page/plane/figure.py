"""The K–D plane: the penalty model with its step at the left, without one at the right; a click sets K and D."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from bokeh.events import Tap
from bokeh.models import LegendItem
from bokeh.plotting import figure
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.method_words import CUT
from vibroscope.app.explorer.state import Setting, slider_range, widened
from vibroscope.app.page.shared.cells import (
    add_cells,
    add_mark,
    cells_figure,
    cells_source,
    listen,
    rounded_view,
    write_cells,
)
from vibroscope.app.page.shared.figure import BLUE, INK, divisor, empty_source, legend_above, write
from vibroscope.app.page.shared.ranges import OwnedRange, UnitAxis
from vibroscope.app.page.shared.seen import say
from vibroscope.app.studies import cell_classes as classes
from vibroscope.app.studies.plane import SIDES, PartialPlane, PlaneQuestion
from vibroscope.engine import System, equal_restitution_damping

_VEIL = ["#00000000", classes.VEIL]  # drawn as stripes: some columns of a finer picture
_STRIPES = 4
_USUAL = {name: slider_range(name, System()) for name in ("K", "D")}


class PlaneView:
    """Two figures with the same axes and colours."""

    def __init__(self, on_cell: Callable[[float, float], None], on_zoom: Callable[[], None]) -> None:
        self._on_cell = on_cell
        self._limits = dict(_USUAL)
        self.ranges = {name: OwnedRange(*limits) for name, limits in _USUAL.items()}
        self.sources = {side: cells_source(f"plane_{side}_cells") for side in SIDES}
        self.veils = {side: cells_source() for side in SIDES}
        self.diverged = {side: empty_source(f"plane_{side}_diverged", "K", "D") for side in SIDES}
        self.mark = empty_source("plane_mark", "K", "D")
        self.curve = empty_source("plane_curve", "K", "D")
        self.figures = {side: self._figure(side) for side in SIDES}
        plots = list(self.figures.values())
        self._axes = {name: UnitAxis(self.ranges[name], side, *plots) for name, side in (("K", "x"), ("D", "y"))}
        listen(plots, self.on_tap, on_zoom)

    def _figure(self, side: str) -> figure:
        labels, axes = ("contact stiffness K", "contact damping D"), {"x_axis_type": "log", "y_axis_type": "log"}
        plot = cells_figure(f"plane_{side}", *self.ranges.values(), labels, **axes)
        add_cells(plot, self.sources[side], classes.PALETTE)
        add_cells(plot, self.veils[side], _VEIL)
        plot.scatter("K", "D", source=self.diverged[side], marker="x", size=5, line_color=INK, line_width=0.8)
        halo = plot.line("K", "D", source=self.curve, line_color="#FFFFFF", line_width=4, line_alpha=0.8)
        curve = plot.line("K", "D", source=self.curve, line_color=BLUE, line_width=2, line_dash="dashed")
        mark = add_mark(plot, "K", "D", self.mark)
        entries = [
            LegendItem(label="restitution as the reference's", renderers=[halo, curve]),
            LegendItem(label="set now", renderers=[mark]),
        ]
        legend_above(plot, entries)
        return plot

    def fit_axes(self, setting: Setting) -> None:
        """Let the axes reach as far as the setting: beyond the sliders' ranges by whole decades."""
        for name in _USUAL:
            self._limits[name] = widened(slider_range(name, setting.system), getattr(setting, name))
            self.ranges[name].put(*self._limits[name])

    @property
    def spans(self) -> dict[str, tuple[float, float]]:
        """K and D that are in view, within what can be set."""
        return {name: rounded_view(self.ranges[name].ends, *limits) for name, limits in self._limits.items()}

    def update(
        self, setting: Setting, result: PartialPlane | None, quantity: str, limit: float | None, error: float
    ) -> None:
        """Move the mark; draw the cells as far as they are known.

        ``error`` is that of what is set, if known: the cell that holds it shows this one, not that of its middle.
        """
        write(self.mark, dict(zip(("K", "D"), np.array(setting.place_in_plane, np.float32)[:, None], strict=True)))
        for name, words in (("K", "contact stiffness K"), ("D", "contact damping D")):
            field = shown_field(name, setting)
            words = words.replace("damping D", "damper 2D") if field.unit else words
            self._axes[name].show(f"{words} / {divisor(field.unit or field.natural)}", field.factor)
        curve_K = np.geomspace(*self._limits["K"], 41)
        curve_D = equal_restitution_damping(setting.system, curve_K)
        write(self.curve, {"K": curve_K.astype(np.float32), "D": curve_D.astype(np.float32)})
        if result is None:
            return
        place = result.cell(*setting.place_in_plane)
        for side in SIDES:
            image = classes.class_image(result, side, quantity)
            if (side, quantity) == ("penalty", "error") and math.isfinite(error) and place is not None:
                image[place] = classes.class_of(error, quantity)
            self._draw(result, side, image, limit)
            say(self.figures[side], self._title(result.question, side, setting), classes.most_frequent(image, quantity))

    def _title(self, question: PlaneQuestion, side: str, setting: Setting) -> str:
        step = f"{question.name} T/{question.steps}{f' {CUT}' if question.located else ''}"
        return f"{'No time step' if side == 'exact' else step}, {shown_field('eta', setting).words(question.eta)}"

    def _draw(self, result: PartialPlane, side: str, image: np.ndarray, limit: float | None) -> None:
        edges = result.question.K, result.question.D
        write_cells(self.sources[side], image, *edges)
        veil = np.zeros((1, 1), np.uint8)
        if limit is not None:
            veil = np.repeat(classes.sudden_contacts(result, side, limit), _STRIPES, axis=1)
            veil[:, np.arange(veil.shape[1]) % _STRIPES != 1] = 0
        write_cells(self.veils[side], veil, *edges)
        row, column = np.nonzero(result.diverged(side) & result.known)
        K, D = result.question.axis("K")[column], result.question.axis("D")[row]
        write(self.diverged[side], {"K": K.astype(np.float32), "D": D.astype(np.float32)})

    def on_tap(self, event: Tap) -> None:
        """Set K and D to the place of a tap."""
        if event.x and event.y and np.isfinite([event.x, event.y]).all():
            self._on_cell(*(float(f"{np.clip(v, *self._limits[n]):.3g}") for n, v in (("K", event.x), ("D", event.y))))
