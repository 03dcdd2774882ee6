"""Contact force over two periods, and on a second axis the impulses, since the force of an impact is infinite."""

from __future__ import annotations

import math

from bokeh.models import LegendItem, Line, LinearAxis, Range1d, Scatter, Segment
from vibroscope.app.explorer.present import Columns, unit_factor
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import (
    BLUE,
    RIGHT,
    SOLUTIONS,
    VERMILLION,
    PinnedCurves,
    add_glyph,
    apply_style,
    empty_sources,
    hover_tool,
    label_of,
    legend,
    make_figure,
    show_rows,
    time_label,
)
from vibroscope.app.page.shared.ranges import OwnedRange, extent, fitted_range
from vibroscope.app.page.shared.seen import largest, of_both, say
from vibroscope.engine.facts import Statement, joined

_TITLE = "Contact force"
_NO_IMPULSE = 10.0  # end of the axis of impulses where there is none
_OVER_IMPULSES = 0.2  # free space above the impulses, relative to the largest
_WORDS = {"force": ("contact force", " λ"), "impulse": ("impulse", " ∫λ dτ")}  # and symbols, without units


class ForceView:
    """λ of both solvers as lines; the impulse of each impact, and of each contact of the penalty solution, as stems."""

    def __init__(self, time: Range1d) -> None:
        quantities = {f"{what}_{solver}": what for what in _WORDS for solver in ("reference", "penalty")}
        self.sources = empty_sources({name: ("t", what) for name, what in quantities.items()})
        self.force = OwnedRange(-1, 20, headroom=0.22)
        self.impulse = OwnedRange(-0.5, _NO_IMPULSE)
        self.figure = self._build(time)
        lines = [(self.sources[f"force_{solver}"], "t", "force", solver) for solver in ("reference", "penalty")]
        self.pinned = PinnedCurves({self.figure: lines})

    def _build(self, time: Range1d):
        axes = {"x_range": time, "y_range": self.force.range}
        plot = make_figure(_TITLE, name="force", **axes, min_border_right=RIGHT)
        plot.extra_y_ranges = {"impulse": self.impulse.range}
        plot.add_layout(LinearAxis(y_range_name="impulse", axis_label=""), "right")
        apply_style(plot)
        lines = [
            add_glyph(plot, Line(x="t", y="force", **look), self.sources[f"force_{solver}"])
            for solver, look in reversed(SOLUTIONS.items())
        ]
        stems = [self._stems(plot, "penalty", VERMILLION), self._stems(plot, "reference", BLUE)]
        entries = (
            ("reference", lines[1:]),
            ("its impulses", stems[1]),
            ("penalty", lines[:1]),
            ("its impulses", stems[0]),
        )
        plot.add_layout(legend([LegendItem(label=name, renderers=drawn) for name, drawn in entries], 5))
        heads = [stem[1] for stem in stems]
        self._hovers = {
            name: hover_tool(drawn, {"time": "@t", name: f"@{name}"})
            for name, drawn in (("force", lines), ("impulse", heads))
        }
        plot.add_tools(*self._hovers.values())
        return plot

    def _stems(self, plot, solver: str, colour: str) -> list:
        source = self.sources[f"impulse_{solver}"]
        exact = solver == "reference"
        line = {"line_width": 2, "line_dash": "solid"} if exact else {"line_width": 1, "line_dash": "dotted"}
        stem = Segment(x0="t", y0=0, x1="t", y1="impulse", line_color=colour, **line)
        marker, size, fill = ("circle", 7, colour) if exact else ("diamond", 11, None)
        look = {"marker": marker, "size": size, "fill_color": fill, "line_color": colour, "line_width": 1.4}
        head = Scatter(x="t", y="impulse", **look)
        return [add_glyph(plot, glyph, source, y_range_name="impulse") for glyph in (stem, head)]

    def update(self, columns: dict[str, Columns], setting: Setting, *, fresh: bool) -> None:
        """Fit ranges and labels to ``columns``, which the sources hold already; zero force is always in view."""
        self.figure.xaxis[0].axis_label = time_label(setting)
        labels = {
            name: label_of(setting, words + (symbol if setting.scale is None else ""), name)
            for name, (words, symbol) in _WORDS.items()
        }
        if setting.stops == "two":
            labels["force"] += ", below 0: second stop"
        self.figure.yaxis[0].axis_label, self.figure.right[0].axis_label = labels.values()
        # A located step resolves contacts that are shorter than the samples: their mean is drawn.
        mean = ", its mean where a contact is too short to sample" if setting.located == "yes" else ""
        time = "time τ/T" if setting.scale is None else "time t / s"
        for name, tool in self._hovers.items():
            show_rows(tool, {time: "@t", labels[name] + (mean if name == "force" else ""): f"@{name}"})
        sources = [f"force_{solver}" for solver in ("reference", "penalty")]
        forces = [columns[source]["force"] for source in sources]
        forces += [column for source in sources for column in self.pinned.columns(source, "force")]
        impulses = [columns[f"impulse_{solver}"]["impulse"] for solver in ("reference", "penalty")]
        say(self.figure, _TITLE, _seen(forces[:2], impulses, setting), setting)
        # in view at least, where there is no contact, too; the forces of some systems are far below it
        one = min(largest(forces) or math.inf, unit_factor("force", setting))
        self.force.follow(forces, fresh=fresh, always=(-one if setting.stops == "two" else 0.0, one))
        self._follow_impulses(impulses, fresh)

    def _follow_impulses(self, impulses: list, fresh: bool) -> None:
        """Fit the range of the impulses so that both axes have their zero at the same height."""
        low, high = self.force.home
        ends = extent(impulses)
        most = max(ends[1], ends[0] * high / low) if ends else 0.0  # those at a second stop are negative
        top = fitted_range((0.0, most), _OVER_IMPULSES)[1] if ends else _NO_IMPULSE
        self.impulse.put(top * low / high, top, fresh=fresh)


def _seen(forces: list, impulses: list, setting: Setting) -> str | Statement:
    """The largest force of each solution that has one, and the largest impulses."""
    most = [largest([force]) or None for force in forces]
    struck = [largest([impulse]) or None for impulse in impulses]
    parts = [of_both("up to", most, "force", setting), of_both("impulse up to", struck, "impulse", setting)]
    return joined("; ", filter(None, parts)) or "no contact"
