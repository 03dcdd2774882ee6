"""The map over η: the bifurcation diagram of the reference as a picture, a cursor, and a click that sets η.

The points of the map over η: from the shipped diagram of the paper's system, else from a study of the present one.

That study is the one of the tab Bifurcation from rest, so each of the two finds what the other has computed.
"""

import threading
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import holoviews as hv
import numpy as np
from bokeh.core.property.descriptors import UnsetValueError
from bokeh.events import RangesUpdate, Tap
from bokeh.models import ColumnDataSource, Label, Scatter, Span
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.present import unit_factor
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.explorer.shipped import is_shipped, load_diagram
from vibroscope.app.explorer.state import Setting, slider_range
from vibroscope.app.page.asker import Asker
from vibroscope.app.page.shared.curves import write_cells
from vibroscope.app.page.shared.figure import (
    BLUE,
    SHADES,
    THEME,
    VERMILLION,
    add_glyph,
    apply_style,
    cursor_line,
    eta_axis,
    label_of,
    label_on,
    scene_line,
)
from vibroscope.app.page.shared.ranges import OwnedRange, UnitAxis, extent
from vibroscope.app.page.shared.seen import amount, between, say
from vibroscope.app.page.tab import TabHost, on_loop
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies.bifurcation import DiagramQuestion, PartialDiagram, grow_diagram, raster
from vibroscope.app.studies.study_job import RESULTS, StudyJob
from vibroscope.engine import System
from vibroscope.engine.facts import Statement, Symbol, stated

_REST = 400  # ms without another system before its diagram is computed


class MapPoints(NamedTuple):
    """Points of the map.

    Attributes
    ----------
    eta : (n,) ndarray
    displacement : (2, n, keep) ndarray
        ξ₁ and ξ₂ at τ ≡ 0 mod T.
    share : float
        Of all η that are computed.
    """

    eta: np.ndarray
    displacement: np.ndarray
    share: float


NOTHING = MapPoints(np.empty(0), np.empty((2, 0, 1)), 0.0)


class MapSource(Asker):
    """Finds the points of the setting that is followed; ``show`` gets those that come later."""

    def __init__(self, host: TabHost, show: Callable[[MapPoints], None]) -> None:
        super().__init__(host, _REST)
        self._show = show
        self._question: DiagramQuestion | None = None
        self._points = NOTHING

    def follow(self, setting: Setting) -> MapPoints:
        """The points of the setting that are known now; the rest comes later."""
        question = DiagramQuestion(setting.system, setting.reference, "rest", slider_range("eta", setting.system))
        if question != self._question:
            self.drop()
            self._question, self._points = question, NOTHING
        if self._points.share < 1 and setting.is_driven:  # a free vibration decays, whatever η is
            self._find(setting)
        return self._points

    def _find(self, setting: Setting) -> None:
        if is_shipped(setting):
            self._load(setting.joint_damping)
            return
        known = RESULTS.get(self._question)
        if known is not None:
            self._points = _points_of(known)
        if self._points.share < 1 and self.job is None:
            self.ask(lambda: StudyJob(self._question, grow_diagram, on_loop(self._host, self._take)))

    def _load(self, joint_damping: str) -> None:
        future, question = load_diagram(joint_damping), self._question
        if not future.done():
            future.add_done_callback(lambda _: self._host.call_later(partial(self._loaded, question, joint_damping)))
        elif future.exception() is None:
            self._points = MapPoints(future.result().eta, future.result().displacement, 1.0)

    def _loaded(self, question: DiagramQuestion, joint_damping: str) -> None:
        if question == self._question and self._points is NOTHING:
            self._load(joint_damping)
            self._show(self._points)

    def _take(self, job: StudyJob, result: PartialDiagram | Exception) -> None:
        if isinstance(result, Exception):
            self._host.report_error(f"The map over η could not be computed ({error_text(result)}).")
            return
        self._points = _points_of(result)
        if self._points.share == 1:  # the map does not show kinds of motion, which the study finds last
            job.cancel()
        self._show(self._points)


def _points_of(result: PartialDiagram) -> MapPoints:
    known = result.known
    sections = [result.section(name)[known] for name in ("xi1", "xi2")]
    return MapPoints(result.question.axis[known], np.stack(sections), result.computed)


_holoviews_lock = threading.Lock()  # its options are global, and pages are built in threads
_PIXELS = (480, 250)  # of the picture, until the browser has sent the size of the frame
_NAME = "Reference over frequency"
_TITLE = f"{_NAME} (click sets it)"  # `declared.py` leaves out what holds on the page only
_FREE = "Free vibration: no motion over frequency"
_ONE_POINT = 0.01  # of the axis: points as near as that are seen as one
_ETA = slider_range("eta", System())
_SYMBOL = {"xi1": "ξ₁", "xi2": "ξ₂"}
_ROW = {"xi1": 0, "xi2": 1}


class EtaMapView:
    """The figure; its picture is drawn again when the zoom, the coordinate or the points change.

    Attributes
    ----------
    set_texts : callable
        Sets the η of a click.
    """

    def __init__(self, sections: dict[str, ColumnDataSource]) -> None:
        self.set_texts: Callable[[dict[str, str]], None] = lambda texts: None
        self._setting = Setting()
        self._points = NOTHING
        self._eta = _ETA  # the whole axis
        self._driven = True
        self._shown: tuple[str, float] | None = None  # coordinate, and the value of one unit of it
        self._drawn_points = NOTHING  # of the picture; kept, since another object could get the place of a freed one
        self._drawn: tuple | None = None  # what else the picture shows: quantity, and the ends of its axes
        self._sections = sections
        self.ranges = {"eta": OwnedRange(*_ETA), "section": OwnedRange(-10, 10)}
        self.figure, self.picture = _picture_figure()
        self.figure.x_range, self.figure.y_range = (owned.range for owned in self.ranges.values())
        self._frequency = UnitAxis(self.ranges["eta"], "x", self.figure)
        self._marks = self._add_marks()
        self.figure.on_event(Tap, self._tap)
        self.figure.on_event(RangesUpdate, self.zoom)
        self.figure.on_change("inner_width", self._resize)
        self.figure.on_change("inner_height", self._resize)

    def _add_marks(self) -> list:
        plot = self.figure
        self._has_scenes = True  # the paper's η mean nothing for another system
        self._scenes: list[Span | Label] = []
        for scene in scenes().values():
            if scene.group == "motion":
                label = label_on(x=scene.setting.eta, y=4, text=scene.label, text_align="center")
                self._scenes += [scene_line(scene.setting.eta), label]
        for mark in self._scenes:
            plot.add_layout(mark)
        self.cursor = cursor_line(location=1.08)
        plot.add_layout(self.cursor)
        look = {"x": "eta", "y": "x2"}
        dot = Scatter(marker="circle", size=7, fill_color=BLUE, line_color="white", **look)
        ring = Scatter(marker="diamond", size=10, fill_color=None, line_color=VERMILLION, line_width=1.5, **look)
        return [
            add_glyph(plot, dot, self._sections["section_reference"], level="overlay"),
            add_glyph(plot, ring, self._sections["section_penalty"], level="overlay"),
        ]

    @property
    def ready(self) -> bool:
        """Whether all points are there."""
        return self._points.share == 1

    def update(self, setting: Setting, points: MapPoints, *, fresh: bool) -> None:
        """Move the cursor; draw the picture again if another one is wanted."""
        self._setting = setting
        self.cursor.location = setting.eta
        self._has_scenes = setting.system == System()
        self._show_scenes()
        wanted = setting.coordinate, unit_factor("displacement", setting)
        other_quantity, self._shown = self._shown != wanted, wanted
        if other_quantity:
            self._label(setting)
        self._eta, self._driven = slider_range("eta", setting.system), setting.is_driven
        self.ranges["eta"].put(*self._eta, fresh=fresh)
        self._frequency.show(*eta_axis(setting))
        self._show(points, fresh=other_quantity or fresh)

    def redraw(self, points: MapPoints) -> None:
        """More points have come."""
        if self._shown is not None:
            self._show(points)

    def _show(self, points: MapPoints, *, fresh: bool = False) -> None:
        """Draw these points, with the axis fitted to them once they are there; ``fresh`` ends its zoom."""
        changed, self._points = points is not self._points, points
        if self.ready:
            say(self.figure, _TITLE, self._seen(), self._setting)
        elif self._driven:
            say(self.figure, _NAME, "computing …" if points is NOTHING else f"{100 * points.share:.0f} % computed")
        else:
            say(self.figure, _FREE)
        awaited = points is NOTHING and self._driven  # the axis would jump twice
        if fresh or (not awaited and (changed or points is NOTHING)):
            self.ranges["section"].follow([self._values], fresh=fresh)
        self._draw()

    def _seen(self) -> str | Statement:
        """Where the present motion is on the map."""
        column = "x" + self._setting.coordinate[-1]
        ends = extent([self._sections["section_reference"].data[column]])
        if ends is None:
            return ""
        low, high = self.ranges["section"].home
        is_one = ends[1] - ends[0] < _ONE_POINT * (high - low)
        quantity = "displacement", self._setting
        value = amount(ends[0], *quantity) if is_one else between(*ends, *quantity)
        return stated("{} = {}", Symbol(_SYMBOL[self._setting.coordinate]), value)

    def _show_scenes(self) -> None:
        """Show the marks in view: beside the frame they would stand on the labels of the ticks."""
        low, high = self.ranges["eta"].ends
        for mark in self._scenes:
            at = mark.x if isinstance(mark, Label) else mark.location
            mark.visible = self._has_scenes and low <= at <= high

    def _label(self, setting: Setting) -> None:
        for mark in self._marks:
            mark.glyph.y = "x1" if setting.coordinate == "xi1" else "x2"
        label = label_of(setting, f"{_SYMBOL[setting.coordinate]} once a period", "displacement")
        self.figure.yaxis[0].axis_label = label

    @property
    def _view(self) -> tuple[tuple[float, float], ...]:
        """The ends of both axes."""
        return tuple(owned.ends for owned in self.ranges.values())

    @property
    def _values(self) -> np.ndarray:
        """The coordinate of the points, in the units of the axis: (n, keep)."""
        coordinate, factor = self._shown
        return factor * self._points.displacement[_ROW[coordinate]]

    def in_view(self) -> dict[str, np.ndarray]:
        """η and the coordinate of the points in view, without dimension; empty until all are there."""
        if not self.ready:
            return {}
        value = self._values.astype(np.float32)
        eta = np.repeat(self._points.eta, value.shape[1])
        x, y = self._view
        visible = (x[0] <= eta) & (eta <= x[1]) & (y[0] <= value.ravel()) & (value.ravel() <= y[1])
        coordinate, factor = self._shown
        return {"eta": eta[visible], coordinate: value.ravel()[visible] / np.float32(factor)}

    def _draw(self) -> None:
        """Draw the picture again if what it shows has changed."""
        wanted = (*self._shown, self._view)
        if self._points is self._drawn_points and wanted == self._drawn:
            return
        self._drawn_points, self._drawn = self._points, wanted
        self._show_scenes()
        x, y = self._view
        picture = raster(self._points.eta, self._values, x, y, *self._pixels())
        write_cells(self.picture, picture, x, y)

    def _pixels(self) -> tuple[int, int]:
        """The size of the frame; a picture of another size would lose points or be blurred."""
        try:
            width, height = self.figure.inner_width, self.figure.inner_height
        except UnsetValueError:  # no browser has laid it out yet
            return _PIXELS
        return (min(width, 2000), min(height, 1500)) if width and height else _PIXELS

    def _tap(self, event: Tap) -> None:
        if event.x is not None and np.isfinite(event.x):
            self.set_texts({"eta": print_number(float(np.clip(float(f"{event.x:.5g}"), *self._eta)))})

    def _resize(self, attr: str, old: int, new: int) -> None:
        if self._shown is not None and old != new:
            self._drawn = None
            self._draw()

    def zoom(self, event: RangesUpdate | None = None) -> None:
        """Draw what is in view, since the ranges have moved."""
        if self._shown is not None:
            self._draw()


def _picture_figure():
    """A figure with a picture, made by HoloViews, and the source of the picture."""
    import holoviews.plotting.bokeh  # noqa: F401 - registers the backend

    with _holoviews_lock:
        plot = _rendered()
    plot.name = "diagram"
    plot.sizing_mode = "stretch_both"
    plot.toolbar_location = "above"
    plot.min_border_left, plot.min_border_right, plot.min_border_bottom, plot.min_border_top = 48, 12, 40, 4
    return apply_style(plot), plot.renderers[0].data_source


def _rendered():
    axes = [hv.Dimension("eta", label="excitation frequency η = Ω/ω₁"), hv.Dimension("xi", label="ξ")]
    image = hv.Image(np.zeros((2, 2), np.uint8), bounds=(_ETA[0], -10, _ETA[1], 10), kdims=axes, vdims="shade").opts(
        cmap=SHADES,
        clim=(0, 255),
        responsive=True,
        min_height=100,
        title=_TITLE,
        default_tools=[],
        tools=["pan", "box_zoom", "wheel_zoom", "reset", "save"],
        active_tools=["box_zoom"],
    )
    # As in a notebook the figure gets its own document. Else HoloViews gives its theme to the current one of Bokeh,
    # which in a thread is that of whichever session the loop serves meanwhile, or of one that has ended.
    renderer = hv.renderer("bokeh").instance(theme=THEME, webgl=False)
    renderer.notebook_context = True
    return renderer.get_plot(image).state
