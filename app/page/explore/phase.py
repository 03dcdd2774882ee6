"""Phase plots of both bodies: velocity over displacement, with marks at the Poincaré section."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from bokeh.models import LegendItem, Line, Scatter
from vibroscope.app.explorer.present import Columns
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import (
    BLUE,
    INK,
    SOLUTIONS,
    SUBSCRIPTS,
    VERMILLION,
    PinnedCurves,
    add_glyph,
    axes_of,
    empty_source,
    empty_sources,
    hover_tool,
    label_of,
    legend,
    make_figure,
    show_rows,
    write,
)
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.shared.ranges import OwnedRange
from vibroscope.app.page.shared.seen import amplitude, of_both, say

_TITLE = "Phase plot, body {}"
_PHASES = tuple(f"phase_{solver}" for solver in SOLUTIONS)
_THIN, _THIN_FROM = 1.0, 700  # px; points from which lines are thin, so that many loops do not merge into an area
_STATE = ("x1", "v1", "x2", "v2")


class PhaseView:
    """Two figures that share four sources."""

    def __init__(self) -> None:
        phases = dict.fromkeys(_PHASES, _STATE)
        sections = dict.fromkeys(("section_reference", "section_penalty"), ("eta", *_STATE))
        self.sources = empty_sources(phases | sections)
        self.sections = {name: self.sources[name] for name in sections}
        self.ranges = {name: OwnedRange(-8, 8) for name in ("x1", "x2")}
        self.ranges |= {name: OwnedRange(-8, 8, headroom=0.16) for name in ("v1", "v2")}
        self._lines: list = []
        self._hovers: list = []
        self.measured: Columns = {}  # points of a measurement
        self.closed = empty_source("phase_closed", *_STATE)  # a motion of a branch
        self._closed_items: list[LegendItem] = []
        self.on_legend: Callable[[str, str, LegendItem], None] = lambda *_: None  # called with each new legend entry
        self.figures = [self._figure(1), self._figure(2)]
        self.pinned = PinnedCurves(
            {
                plot: [(self.sources[f"phase_{solver}"], f"x{n}", f"v{n}", solver) for solver in SOLUTIONS]
                for n, plot in enumerate(self.figures, 1)
            }
        )

    def _figure(self, number: int):
        x, y = f"x{number}", f"v{number}"
        axes = axes_of(self.ranges, x, y)
        plot = make_figure(_TITLE.format(number), name=f"phase{number}", **axes, min_border_left=48)
        plot.xaxis.ticker.desired_num_ticks = 4  # a phase plot is narrow beside numbers such as −0.002
        curves = {
            solver: add_glyph(plot, Line(x=x, y=y, **look), self.sources[f"phase_{solver}"])
            for solver, look in SOLUTIONS.items()
        }
        self._lines += [(line, solver) for solver, line in curves.items()]
        dot = Scatter(x=x, y=y, marker="circle", size=7, fill_color=BLUE, line_color="white", line_width=0.8)
        ring = Scatter(x=x, y=y, marker="diamond", size=9, fill_color=None, line_color=VERMILLION, line_width=1.3)
        dots = add_glyph(plot, dot, self.sources["section_reference"])
        rings = add_glyph(plot, ring, self.sources["section_penalty"])
        entries = {"reference": [curves["reference"], dots], "penalty": [curves["penalty"], rings]}
        plot.add_layout(legend([LegendItem(label=name, renderers=drawn) for name, drawn in entries.items()], 3))
        self._hovers.append(hover_tool([dots, rings], {"displacement": f"@{x}", "velocity": f"@{y}"}))
        plot.add_tools(self._hovers[-1])
        return plot

    def _label(self, setting: Setting) -> None:
        for figure, tool, (number, sub) in zip(self.figures, self._hovers, SUBSCRIPTS.items(), strict=True):
            x = label_of(setting, f"displacement ξ{sub}", "displacement")
            y = label_of(setting, f"velocity ξ{sub}′", "velocity")
            figure.xaxis[0].axis_label, figure.yaxis[0].axis_label = x, y
            show_rows(tool, {x: f"@x{number}", y: f"@v{number}"})

    def update(self, columns: dict[str, Columns], setting: Setting, *, fresh: bool) -> None:
        """Fit ranges, line widths and labels to ``columns``, which the sources hold already."""
        self._label(setting)
        for number, plot in enumerate(self.figures, 1):
            seen = [amplitude(columns[source][f"x{number}"]) for source in _PHASES]
            say(plot, _TITLE.format(number), of_both("amplitude", seen, "displacement", setting), setting)
        for line, solver in self._lines:
            points = len(columns[f"phase_{solver}"]["x1"])
            line.glyph.line_width = SOLUTIONS[solver]["line_width"] if points <= _THIN_FROM else _THIN
        for name, owned in self.ranges.items():
            shown = [columns[source][name] for source in self.sources]
            shown += [self.measured[name]] if self.measured else []
            shown += [each for source in _PHASES for each in self.pinned.columns(source, name)]
            shown.append(self.closed.data[name])
            owned.follow(shown, fresh=fresh)

    def draw_closed(self, columns: Columns) -> None:
        """Draw one cycle of a motion over both solutions, or none, once there is a curve for it (`add_closed`)."""
        none = dict.fromkeys(self.closed.data, np.empty(0, np.float32))
        write(self.closed, columns or none)
        for item in self._closed_items:
            show_entry(item, bool(columns))

    def add_closed(self) -> None:
        """Add the curve that `draw_closed` draws, unless it is there."""
        if not self.has_closed:
            self._closed_items = [self._add_closed(number, plot) for number, plot in enumerate(self.figures, 1)]

    @property
    def has_closed(self) -> bool:
        """Whether there is a curve that `draw_closed` draws."""
        return bool(self._closed_items)

    def _add_closed(self, number: int, plot) -> LegendItem:
        line = Line(x=f"x{number}", y=f"v{number}", line_color=INK, line_width=1.8, line_dash="dotted")
        item = LegendItem(label="branch", renderers=[add_glyph(plot, line, self.closed)])
        plot.legend[0].items = [*plot.legend[0].items, item]
        self.on_legend(plot.name, "branch", item)
        return item
