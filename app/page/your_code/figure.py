"""The motion of a code over the reference: phase plot and displacement of the observed body."""

from __future__ import annotations

import numpy as np
from bokeh.models import LegendItem, Line, Scatter
from bokeh.plotting import figure
from vibroscope.app.explorer.compute import RunPair
from vibroscope.app.explorer.present import WINDOW, Columns, present
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import (
    BLUE,
    SOLUTIONS,
    SUBSCRIPTS,
    VERMILLION,
    add_glyph,
    axes_of,
    empty_source,
    label_of,
    legend,
    make_figure,
    time_label,
    write,
)
from vibroscope.app.page.shared.ranges import OwnedRange
from vibroscope.app.page.shared.seen import amplitude, apart, of_both, say


class YourCodeView:
    """Two figures; at a wall they show body 1, else body 2."""

    def __init__(self) -> None:
        self.phases = {name: empty_source(f"code_phase_{name}", "x", "v") for name in SOLUTIONS}
        self.sections = {name: empty_source(f"code_section_{name}", "x", "v") for name in SOLUTIONS}
        self.traces = {name: empty_source(f"code_trace_{name}", "t", "x") for name in SOLUTIONS}
        self.ranges = {
            "x": OwnedRange(-8, 8),
            "v": OwnedRange(-8, 8, headroom=0.16),
            "time": OwnedRange(0, WINDOW),
            "displacement": OwnedRange(-8, 8, headroom=0.16),
        }
        self.phase = self._figure("code_phase", "Phase plot", "x", "v")
        self.displacement = self._figure("code_displacement", "Displacement", "time", "displacement")
        self._drawn: RunPair | None = None

    @property
    def figures(self) -> list[figure]:
        """The phase plot at the left."""
        return [self.phase, self.displacement]

    def _figure(self, name: str, title: str, x: str, y: str) -> figure:
        plot = make_figure(title, name=name, **axes_of(self.ranges, x, y))
        items = []
        for solver, look in SOLUTIONS.items():
            columns = ("x", "v") if name == "code_phase" else ("t", "x")
            source = (self.phases if name == "code_phase" else self.traces)[solver]
            drawn = [add_glyph(plot, Line(x=columns[0], y=columns[1], **look), source)]
            if name == "code_phase":
                colour = BLUE if solver == "reference" else VERMILLION
                marker = "circle" if solver == "reference" else "diamond"
                fill = colour if solver == "reference" else None
                dots = Scatter(x="x", y="v", marker=marker, size=8, line_color=colour, fill_color=fill)
                drawn.append(add_glyph(plot, dots, self.sections[solver]))
            items.append(LegendItem(label=solver, renderers=drawn))
        plot.add_layout(legend(items))
        return plot

    def update(self, setting: Setting, runs: RunPair | None, title: str) -> None:
        """Draw runs in the units of the setting; None: nothing is known yet."""
        body = setting.system.observed_body
        sub = SUBSCRIPTS[body]
        position = label_of(setting, f"displacement ξ{sub}", "displacement")
        self.phase.xaxis[0].axis_label = self.displacement.yaxis[0].axis_label = position
        self.phase.yaxis[0].axis_label = label_of(setting, f"velocity ξ{sub}′", "velocity")
        self.displacement.xaxis[0].axis_label = time_label(setting)
        name = f"{title}, body {body}"
        if runs is None:
            say(self.phase, name)
            return
        columns = present(RunPair(setting, runs.reference, runs.penalty))
        fresh = self._drawn is None or self._drawn.setting != runs.setting
        self._drawn = runs
        for solver in SOLUTIONS:
            self._write(solver, body, columns)
        swings = [amplitude(source.data["x"]) for source in self.phases.values()]
        say(self.phase, name, of_both("amplitude", swings, "displacement", setting), setting)
        between = np.subtract(*(source.data["x"] for source in self.traces.values()))
        say(self.displacement, "Displacement", apart([between], setting), setting)
        self.ranges["time"].put(0, WINDOW * setting.period, fresh=fresh)
        sources = [*self.phases.values(), *self.sections.values()]
        for name in ("x", "v"):
            self.ranges[name].follow([source.data[name] for source in sources], fresh=fresh)
        self.ranges["displacement"].follow([source.data["x"] for source in self.traces.values()], fresh=fresh)

    def _write(self, solver: str, body: int, columns: dict[str, Columns]) -> None:
        for sources, source in ((self.phases, "phase"), (self.sections, "section")):
            of = columns[f"{source}_{solver}"]
            write(sources[solver], {"x": of[f"x{body}"], "v": of[f"v{body}"]})
        of = columns["displacements"]
        write(self.traces[solver], {"t": of["t"], "x": of[f"{solver}{body}"]})
