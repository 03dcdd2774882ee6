"""The map over η: the bifurcation diagram of the reference as a picture, a cursor, and a click that sets η."""

from __future__ import annotations

from collections.abc import Callable

import holoviews as hv
import numpy as np
from bokeh.core.property.descriptors import UnsetValueError
from bokeh.events import RangesUpdate, Tap
from bokeh.models import ColumnDataSource, Label, Scatter, Span
from vibroscope.app.explorer.present import unit_factor
from vibroscope.app.explorer.scenes import scenes
from vibroscope.app.explorer.state import Setting, print_number
from vibroscope.app.page.shared.figure import BLUE, FONT, INK, THEME, VERMILLION, add_glyph, apply_style
from vibroscope.app.page.shared.ranges import OwnedRange
from vibroscope.app.studies.raster import raster
from vibroscope.engine import Diagram, System

_PIXELS = (480, 250)  # of the picture, until the browser has sent the size of the frame
_TITLE = "Reference over η: click sets η"
_TITLE_OTHER_SYSTEM = "Reference over η (the paper's system)"
_ETA = (0.5, 4.0)
_SYMBOL = {"xi1": "ξ₁", "xi2": "ξ₂"}
_ROW = {"xi1": 0, "xi2": 1}
# From transparent to blue; the more points fall on a pixel, the darker it is.
_SHADES = ["#FFFFFF00"] + [f"#0072B2{alpha:02X}" for alpha in range(1, 256)]


class EtaMapView:
    """The figure; its picture is drawn again when the zoom, the coordinate or the joint damping changes.

    ``load(joint_damping)`` gives a diagram, or None until it is there; ``set_texts`` sets the η of a click.
    """

    def __init__(
        self,
        sections: dict[str, ColumnDataSource],
        load: Callable[[str], Diagram | None],
        set_texts: Callable[[dict[str, str]], None],
    ) -> None:
        self._load = load
        self._set_texts = set_texts
        self._shown: tuple[str, str, float] | None = None
        self._drawn: tuple | None = None  # ends of both axes of the picture
        self.ready = False  # whether the diagram is there
        self._default_system = True
        self._sections = sections
        self.ranges = {"eta": OwnedRange(*_ETA), "section": OwnedRange(-10, 10)}
        self.figure, self.picture = _picture_figure()
        self.figure.x_range, self.figure.y_range = (owned.range for owned in self.ranges.values())
        self._marks = self._add_marks()
        self.figure.on_event(Tap, self._tap)
        self.figure.on_event(RangesUpdate, self._zoom)
        self.figure.on_change("inner_width", self._resize)
        self.figure.on_change("inner_height", self._resize)

    def _add_marks(self) -> list:
        plot = self.figure
        for scene in scenes().values():
            if scene.group == "motion":
                plot.add_layout(Span(location=scene.eta, dimension="height", line_color="#8A97A3", line_dash="dotted"))
                plot.add_layout(
                    Label(
                        x=scene.eta,
                        y=4,
                        y_units="screen",
                        text=f"[{scene.label}]",
                        text_font=FONT,
                        text_font_size="11px",
                        text_color=INK,
                        text_align="center",
                        background_fill_color="#FFFFFF",
                        background_fill_alpha=0.8,
                    )
                )
        # An overlay is repainted without the picture below it.
        self.cursor = Span(location=1.08, dimension="height", line_color=INK, line_width=1.5, level="overlay")
        plot.add_layout(self.cursor)
        look = {"x": "eta", "y": "x2"}
        dot = Scatter(marker="circle", size=7, fill_color=BLUE, line_color="white", **look)
        ring = Scatter(marker="diamond", size=10, fill_color=None, line_color=VERMILLION, line_width=1.5, **look)
        return [
            add_glyph(plot, dot, self._sections["section_reference"], level="overlay"),
            add_glyph(plot, ring, self._sections["section_penalty"], level="overlay"),
        ]

    def update(self, setting: Setting, *, fresh: bool) -> None:
        """Move the cursor; draw the picture again if another one is wanted.

        The diagrams are those of the paper's system; with another system, the title says so.
        """
        self.cursor.location = setting.eta
        self._default_system = setting.system == System()
        self._title(self._shown is None or self._points() is not None)
        wanted = setting.joint_damping, setting.coordinate, unit_factor("displacement", setting)
        other_quantity = self._shown is None or self._shown[1:] != wanted[1:]
        other_picture, self._shown = self._shown != wanted, wanted
        if other_quantity:
            self._label(setting)
        self.ranges["eta"].put(*_ETA, fresh=fresh)
        if other_quantity or fresh:
            self._fit()
        if other_picture or self._drawn != self._view:
            self._draw()

    def redraw(self) -> None:
        """A diagram has arrived: show it if it is the one that is wanted."""
        if self._shown is not None:
            self._fit()
            self._draw()

    def _label(self, setting: Setting) -> None:
        for mark in self._marks:
            mark.glyph.y = "x1" if setting.coordinate == "xi1" else "x2"
        unit = "base amplitude" if setting.scale is None else "mm"
        self.figure.yaxis[0].axis_label = f"{_SYMBOL[setting.coordinate]} at τ ≡ 0 (mod T) / {unit}"

    @property
    def _view(self) -> tuple[tuple[float, float], ...]:
        """The ends of both axes."""
        return tuple(owned.ends for owned in self.ranges.values())

    def _points(self) -> tuple[np.ndarray, np.ndarray] | None:
        joint_damping, coordinate, factor = self._shown
        diagram = self._load(joint_damping)
        if diagram is None:
            return None
        return diagram.eta, factor * diagram.displacement[_ROW[coordinate]]

    def in_view(self) -> dict[str, np.ndarray]:
        """η and the coordinate of the points in view; empty while the diagram is not there."""
        points = self._points() if self.ready else None
        if points is None:
            return {}
        value = points[1].astype(np.float32)
        eta = np.repeat(points[0], value.shape[1])
        x, y = self._view
        visible = (x[0] <= eta) & (eta <= x[1]) & (y[0] <= value.ravel()) & (value.ravel() <= y[1])
        return {"eta": eta[visible], self._shown[1]: value.ravel()[visible]}

    def _fit(self) -> None:
        points = self._points()
        if points is not None:
            self.ranges["section"].follow([points[1]], fresh=True)

    def _draw(self) -> None:
        points = self._points()
        self.ready = points is not None
        self._title(self.ready)
        if points is None:
            return
        x, y = self._drawn = self._view
        picture = raster(*points, x, y, *self._pixels())
        self.picture.data = {
            "image": [picture],
            "x": [x[0]],
            "y": [y[0]],
            "dw": [x[1] - x[0]],
            "dh": [y[1] - y[0]],
        }

    def _title(self, ready: bool) -> None:
        title = _TITLE if self._default_system else _TITLE_OTHER_SYSTEM
        self.figure.title.text = title if ready else "Reference over η: computing …"

    def _pixels(self) -> tuple[int, int]:
        """The size of the frame; a picture of another size would lose points or be blurred."""
        try:
            width, height = self.figure.inner_width, self.figure.inner_height
        except UnsetValueError:  # no browser has laid it out yet
            return _PIXELS
        return (min(width, 2000), min(height, 1500)) if width and height else _PIXELS

    def _tap(self, event: Tap) -> None:
        if event.x is not None and np.isfinite(event.x):
            self._set_texts({"eta": print_number(float(np.clip(round(event.x, 4), *_ETA)))})

    def _resize(self, attr: str, old: int, new: int) -> None:
        if self._shown is not None and old != new:
            self._draw()

    def _zoom(self, event: RangesUpdate) -> None:
        if self._shown is not None:
            self._draw()


def _picture_figure():
    """A figure with a picture, made by HoloViews, and the source of the picture."""
    import holoviews.plotting.bokeh  # noqa: F401 - registers the backend

    hv.renderer("bokeh").webgl = False
    hv.renderer("bokeh").theme = THEME
    axes = [hv.Dimension("eta", label="excitation frequency η = Ω/ω₁"), hv.Dimension("xi", label="ξ")]
    image = hv.Image(np.zeros((2, 2), np.uint8), bounds=(_ETA[0], -10, _ETA[1], 10), kdims=axes, vdims="shade").opts(
        cmap=_SHADES,
        clim=(0, 255),
        responsive=True,
        min_height=100,
        title=_TITLE,
        default_tools=[],
        tools=["pan", "box_zoom", "wheel_zoom", "reset", "save"],
        active_tools=["box_zoom"],
    )
    plot = hv.render(image, backend="bokeh")
    plot.name = "diagram"
    plot.sizing_mode = "stretch_both"
    plot.toolbar_location = "above"
    plot.min_border_left, plot.min_border_right, plot.min_border_bottom, plot.min_border_top = 48, 12, 40, 4
    return apply_style(plot), plot.renderers[0].data_source
