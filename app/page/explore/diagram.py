"""The bifurcation diagram: a picture of the reference's section over η, a cursor, and a click that sets η."""

from __future__ import annotations

from collections.abc import Callable

import holoviews as hv
import numpy as np
from bokeh.core.property.descriptors import UnsetValueError
from bokeh.events import RangesUpdate, Tap
from bokeh.models import ColumnDataSource, Label, Scatter, Span
from vibroscope.app.explorer.present import factor_of
from vibroscope.app.explorer.scenes import scenes
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import BLUE, FONT, INK, THEME, VERMILLION, draw, style
from vibroscope.app.page.shared.ranges import OwnedRange
from vibroscope.app.studies.raster import raster
from vibroscope.engine import Diagram, System

# Before the browser has told the frame's size.
_PIXELS = (480, 250)
_TITLE = "Reference over η: click sets η"
_NOT_OURS = "Reference over η (the paper's system)"
_ETA = (0.5, 4.0)
_SYMBOL = {"xi1": "ξ₁", "xi2": "ξ₂"}
_ROW = {"xi1": 0, "xi2": 1}
# From clear to Okabe–Ito blue; the darkest is where most points fall.
_SHADES = ["#FFFFFF00"] + [f"#0072B2{alpha:02X}" for alpha in range(1, 256)]


class DiagramView:
    """Built once; the picture is drawn anew when the zoom, the coordinate or the joint damping changes."""

    def __init__(
        self,
        sections: dict[str, ColumnDataSource],
        load: Callable[[str], Diagram | None],
        on_eta: Callable[[float], None],
    ) -> None:
        self._load = load
        self._on_eta = on_eta
        self._shown: tuple[str, str, float] | None = None
        self._drawn: tuple | None = None  # the view that the picture is of
        self.ready = False  # whether what is wanted has arrived
        self._ours = True
        self._sections = sections
        self.ranges = {"eta": OwnedRange(*_ETA), "section": OwnedRange(-10, 10)}
        self.figure, self.picture = _picture_figure()
        self.figure.x_range, self.figure.y_range = (owned.range for owned in self.ranges.values())
        self._marks = self._decorate()
        self.figure.on_event(Tap, self._tapped)
        self.figure.on_event(RangesUpdate, self._zoomed)
        self.figure.on_change("inner_width", self._resized)
        self.figure.on_change("inner_height", self._resized)

    def _decorate(self) -> list:
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
        # Overlays are repainted without the picture below them.
        self.cursor = Span(location=1.08, dimension="height", line_color=INK, line_width=1.5, level="overlay")
        plot.add_layout(self.cursor)
        look = {"x": "eta", "y": "x2"}
        dot = Scatter(marker="circle", size=7, fill_color=BLUE, line_color="white", **look)
        ring = Scatter(marker="diamond", size=10, fill_color=None, line_color=VERMILLION, line_width=1.5, **look)
        return [
            draw(plot, dot, self._sections["section_reference"], level="overlay"),
            draw(plot, ring, self._sections["section_penalty"], level="overlay"),
        ]

    def update(self, setting: Setting, *, fresh: bool) -> None:
        """Move the cursor; redraw the picture where it is another one. The phase plots write the sections.

        The shipped pictures are of the paper's system; with another the title says so.
        """
        self.cursor.location = setting.eta
        self._ours = setting.system == System()
        self._title(self._shown is None or self._points() is not None)
        wanted = setting.joint_damping, setting.coordinate, factor_of("displacement", setting)
        turned = self._shown is None or self._shown[1:] != wanted[1:]
        another, self._shown = self._shown != wanted, wanted
        if turned:
            self._label(setting)
        self.ranges["eta"].put(*_ETA, fresh=fresh)
        if turned or fresh:
            self._fit()
        if another or self._drawn != self._view:
            self._draw()

    def redraw(self) -> None:
        """A diagram has arrived: show it, if it is the one that is wanted."""
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
        """What of the plane is in view: the ends of both axes."""
        return tuple(owned.ends for owned in self.ranges.values())

    def _points(self) -> tuple[np.ndarray, np.ndarray] | None:
        joint_damping, coordinate, factor = self._shown
        diagram = self._load(joint_damping)
        if diagram is None:
            return None
        return diagram.eta, factor * diagram.displacement[_ROW[coordinate]]

    def in_view(self) -> dict[str, np.ndarray]:
        """η and the coordinate of the points that lie in view; nothing while it is not ready."""
        points = self._points() if self.ready else None
        if points is None:
            return {}
        value = points[1].astype(np.float32)
        eta = np.repeat(points[0], value.shape[1])
        x, y = self._view
        seen = (x[0] <= eta) & (eta <= x[1]) & (y[0] <= value.ravel()) & (value.ravel() <= y[1])
        return {"eta": eta[seen], self._shown[1]: value.ravel()[seen]}

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
        title = _TITLE if self._ours else _NOT_OURS
        self.figure.title.text = title if ready else "Reference over η: computing …"

    def _pixels(self) -> tuple[int, int]:
        """The frame's own size: a picture drawn larger or smaller would lose points or blur."""
        try:
            width, height = self.figure.inner_width, self.figure.inner_height
        except UnsetValueError:  # no browser has laid it out yet
            return _PIXELS
        return (min(width, 2000), min(height, 1500)) if width and height else _PIXELS

    def _tapped(self, event: Tap) -> None:
        if event.x is not None and np.isfinite(event.x):
            self._on_eta(float(np.clip(round(event.x, 4), *_ETA)))

    def _resized(self, attr: str, old: int, new: int) -> None:
        if self._shown is not None and old != new:
            self._draw()

    def _zoomed(self, event: RangesUpdate) -> None:
        if self._shown is not None:
            self._draw()


def _picture_figure():
    """The figure that HoloViews declares, and the source of its picture."""
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
    return style(plot), plot.renderers[0].data_source
