"""The restitution over the instant of touch and over the steps in a contact, and the force over time."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from bokeh.core.properties import value
from bokeh.events import Tap
from bokeh.models import HSpan, LegendItem, Line, Quad, Scatter, Segment, VSpan
from bokeh.plotting import figure
from vibroscope.app.explorer.present import as_float32
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import (
    GREEN,
    INK,
    VERMILLION,
    VIOLET,
    add_glyph,
    axes_of,
    empty_source,
    hover_tool,
    legend_above,
    make_figure,
    quantity_axis,
    write,
)
from vibroscope.app.page.shared.ranges import OwnedRange
from vibroscope.app.page.shared.seen import amount, largest, say
from vibroscope.app.studies.one_impact import STEPS, PartialImpact
from vibroscope.engine import written
from vibroscope.engine.facts import stated

LEGENDS = {  # entries of each figure by their names in a link, as they are written
    "impact_instant": {"step": "with this step", "asked": "asked for", "exact": "without a step"},
    "impact_band": {
        "band": "least to greatest",
        "asked": "asked for",
        "here": "you are here",
        "largest": "largest step",
    },
    "impact_force": {"best": "best touch", "worst": "worst touch", "exact": "without a step"},
}
_LOOKS = {
    "best": {"line_color": GREEN, "line_width": 2.4},
    "worst": {"line_color": VERMILLION, "line_width": 1.6},
    "exact": {"line_color": VIOLET, "line_width": 1.6, "line_dash": "dashed"},
}
_INSTANTS, _FORCES = "Restitution over the instant of touch", "Contact force over time"
_OVER_STEPS = "Restitution over the steps in a contact"
AXES = ("instant", "steps", "restitution", "time", "force")
_SPAN = ("steps", "least", "mean", "greatest")
_TOP, _HIGHEST = 1.05, 2.0  # of the restitution that is drawn: at first, and at most
_HALF = math.sqrt(STEPS[1] / STEPS[0])  # from one of the steps to halfway to the next, times


class ImpactView:
    """Two figures with one axis of restitutions, one of forces; a tap in the second gives its steps in a contact."""

    def __init__(self, on_steps: Callable[[float], None]) -> None:
        self._on_steps = on_steps
        self._drawn: object = None  # question
        self._forces_drawn: object = None  # question and units
        self.instant = empty_source("impact_over_instant", "instant", "restitution")
        self.band = empty_source("impact_over_steps", *_SPAN, "left", "right")
        self.here = empty_source("impact_here", *_SPAN)
        self.levels = empty_source("impact_levels", "asked", "exact")
        self.largest = empty_source("impact_largest", "steps")
        self.forces = {name: empty_source(f"impact_force_{name}", "time", "force") for name in _LOOKS}
        self.ranges = {
            "instant": OwnedRange(0.0, 1.0),
            "steps": OwnedRange(float(STEPS[0]), float(STEPS[-1])),
            "restitution": OwnedRange(0.0, _TOP),
            "time": OwnedRange(0.0, 1.0),
            "force": OwnedRange(0.0, 1.0),
        }
        self.figures = [self._over_instants(), self._over_steps(), self._over_time()]

    def _level(self, plot: figure, name: str) -> LegendItem:
        look = {"line_color": INK if name == "asked" else VIOLET, "line_dash": "dashed", "line_width": 1.6}
        drawn = add_glyph(plot, HSpan(y=name, **look), self.levels)
        return LegendItem(label=LEGENDS["impact_instant"][name], renderers=[drawn])

    def _over_instants(self) -> figure:
        axes = axes_of(self.ranges, "instant", "restitution")
        words = "instant of touch after the last step, t/Δτ", "restitution e"
        plot = make_figure(_INSTANTS, *words, name="impact_instant", **axes)
        line = add_glyph(plot, Line(x="instant", y="restitution", line_color=VERMILLION, line_width=2), self.instant)
        items = [LegendItem(label=LEGENDS["impact_instant"]["step"], renderers=[line])]
        legend_above(plot, [*items, *(self._level(plot, name) for name in ("asked", "exact"))])
        plot.add_tools(hover_tool([line], {"instant": "@instant", "restitution": "@restitution"}))
        return plot

    def _over_steps(self) -> figure:
        axes = axes_of(self.ranges, "steps", "restitution", "x")
        words = "steps in a contact, t_c/Δτ", "restitution e, whenever the bodies touch"
        plot = make_figure(_OVER_STEPS, *words, name="impact_band", **axes)
        area = {"left": "left", "right": "right", "bottom": "least", "top": "greatest"}
        band = add_glyph(plot, Quad(**area, fill_color=VERMILLION, fill_alpha=0.3, line_color=None), self.band)
        mean = add_glyph(plot, Line(x="steps", y="mean", line_color=VERMILLION, line_width=1.5), self.band)
        here = {"line_color": VERMILLION, "line_width": 3}
        marks = [
            add_glyph(plot, Segment(x0="steps", x1="steps", y0="least", y1="greatest", **here), self.here),
            add_glyph(plot, Scatter(x="steps", y="mean", marker="diamond", size=13, fill_color=VERMILLION), self.here),
        ]
        line = {"line_color": GREEN, "line_dash": "dotdash", "line_width": 2}
        largest = add_glyph(plot, VSpan(x="steps", **line), self.largest)
        drawn = {"band": [band, mean], "here": marks, "largest": [largest]}
        names = LEGENDS["impact_band"]
        items = {name: LegendItem(label=names[name], renderers=renderers) for name, renderers in drawn.items()}
        items["asked"] = self._level(plot, "asked")
        legend_above(plot, [items[name] for name in names])
        tips = {"steps in a contact": "@steps", "least": "@least", "mean": "@mean", "greatest": "@greatest"}
        plot.add_tools(hover_tool([band], tips))
        plot.on_event(Tap, self.on_tap)
        return plot

    def _over_time(self) -> figure:
        plot = make_figure(_FORCES, name="impact_force", **axes_of(self.ranges, "time", "force"))
        drawn = {
            name: [add_glyph(plot, Line(x="time", y="force", **look), self.forces[name])]
            for name, look in _LOOKS.items()
        }
        for name in ("best", "worst"):  # what a method with a step knows
            colour = _LOOKS[name]["line_color"]
            dots = Scatter(x="time", y="force", size=5, line_color=colour, fill_color=colour)
            drawn[name].append(add_glyph(plot, dots, self.forces[name]))
        names = LEGENDS["impact_force"]
        self._courses = {name: LegendItem(label=names[name], renderers=drawn[name]) for name in names}
        legend_above(plot, [*self._courses.values()])
        plot.legend.ncols = 1  # its labels change: how many fit beside each other would be that of older ones
        plot.add_tools(
            hover_tool([each[0] for each in drawn.values()], {"time since touch": "@time", "force": "@force"})
        )
        return plot

    def on_tap(self, event: Tap) -> None:
        """Ask for the steps in a contact where a tap is."""
        if event.x is not None and 0 < event.x < math.inf:
            self._on_steps(event.x)

    def update(self, setting: Setting, result: PartialImpact | None) -> None:
        """Draw what is known."""
        if result is None:
            return
        self._draw_forces(setting, result)
        one, e = result.impact, result.found.restitution
        fresh, self._drawn = self._drawn != result.question, result.question
        band = result.over_steps()
        known = {
            "steps": band["steps_per_contact"],
            **{n: band[f"restitution_{n}"] for n in ("least", "mean", "greatest")},
        }
        known |= {"left": known["steps"] / _HALF, "right": known["steps"] * _HALF}
        here = dict(zip(_SPAN, ([one.steps_per_contact], *([value] for value in e)), strict=True))
        steps = [result.largest.steps_per_contact] if result.largest else []
        columns = {
            self.instant: result.instants(),
            self.band: known,
            self.here: here,
            self.levels: {"asked": [one.restitution], "exact": [one.without_step.restitution]},
            self.largest: {"steps": steps},
        }
        for source, values in columns.items():
            write(source, as_float32({name: np.asarray(column, float) for name, column in values.items()}))
        steps_here = written(one.steps_per_contact, 3)
        say(self.figures[1], _OVER_STEPS, f"you are at {steps_here}")
        seen = f"{written(e.least, 3)} to {written(e.greatest, 3)}" if math.isfinite(e.mean) else "none"
        say(self.figures[0], _INSTANTS, seen)
        top = np.nanmax([_TOP, 1.05 * e.greatest, *(1.05 * known["greatest"])])
        self.ranges["restitution"].put(0.0, float(min(top, _HIGHEST)), fresh=fresh)

    def _draw_forces(self, setting: Setting, result: PartialImpact) -> None:
        """The forces over time in the units of the setting, and of which touches they are."""
        plot, scaled = self.figures[2], setting.scale is not None
        time, factors = "time since touch t / s" if scaled else "time since touch τ", {}
        plot.xaxis[0].axis_label, factors["time"] = time, setting.scale.factor("time") if scaled else 1.0
        plot.yaxis[0].axis_label, factors["force"] = quantity_axis(setting, "contact force λ", "force")
        courses = {name: {n: factors[n] * getattr(each, n) for n in factors} for name, each in result.forces.items()}
        for name, source in self.forces.items():
            write(source, as_float32(courses.get(name, {"time": np.empty(0), "force": np.empty(0)})))
            words = LEGENDS["impact_force"][name]
            if name in result.forces:
                one = result.forces[name]
                at = "" if math.isnan(one.instant) else f" t/Δτ {one.instant:.2f},"
                words = f"{words}:{at} e {one.restitution:.2f}"
            self._courses[name].label = value(words)
        most = largest(each["force"] for each in courses.values())
        say(plot, _FORCES, "" if most is None else stated("up to {}", amount(most, "force", setting)), setting)
        drawn, self._forces_drawn = self._forces_drawn, (result.question, setting.scale)
        for axis in factors:
            self.ranges[axis].follow([each[axis] for each in courses.values()], fresh=drawn != self._forces_drawn)
