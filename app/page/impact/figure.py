"""The restitution over the instant of touch, and over the steps in a contact with what is set."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from bokeh.events import Tap
from bokeh.models import HSpan, LegendItem, Line, Quad, Scatter, Segment, VSpan
from bokeh.plotting import figure
from vibroscope.app.explorer.present import as_float32
from vibroscope.app.page.shared.figure import (
    GREEN,
    INK,
    VERMILLION,
    VIOLET,
    add_glyph,
    empty_source,
    hover_tool,
    legend_above,
    make_figure,
    write,
)
from vibroscope.app.page.shared.ranges import OwnedRange
from vibroscope.app.studies.one_impact import STEPS, PartialImpact
from vibroscope.engine import written

LEGENDS = {  # entries of each figure by their names in a link, as they are written
    "impact_instant": {"step": "with this step", "asked": "asked for", "exact": "without a step"},
    "impact_band": {
        "band": "least to greatest",
        "asked": "asked for",
        "here": "you are here",
        "largest": "largest step",
    },
}
_SPAN = ("steps", "least", "mean", "greatest")
_TOP, _HIGHEST = 1.05, 2.0  # of the restitution that is drawn: at first, and at most
_HALF = math.sqrt(STEPS[1] / STEPS[0])  # from one of the steps to halfway to the next, times


class ImpactView:
    """Two figures with one axis of restitutions; a tap in the second gives its steps in a contact to ``on_steps``."""

    def __init__(self, on_steps: Callable[[float], None]) -> None:
        self._on_steps = on_steps
        self._drawn: object = None  # question
        self.instant = empty_source("impact_over_instant", "instant", "restitution")
        self.band = empty_source("impact_over_steps", *_SPAN, "left", "right")
        self.here = empty_source("impact_here", *_SPAN)
        self.levels = empty_source("impact_levels", "asked", "exact")
        self.largest = empty_source("impact_largest", "steps")
        self.ranges = {
            "instant": OwnedRange(0.0, 1.0),
            "steps": OwnedRange(float(STEPS[0]), float(STEPS[-1])),
            "restitution": OwnedRange(0.0, _TOP),
        }
        self.figures = [self._over_instants(), self._over_steps()]

    def _level(self, plot: figure, name: str) -> LegendItem:
        look = {"line_color": INK if name == "asked" else VIOLET, "line_dash": "dashed", "line_width": 1.6}
        drawn = add_glyph(plot, HSpan(y=name, **look), self.levels)
        return LegendItem(label=LEGENDS["impact_instant"][name], renderers=[drawn])

    def _over_instants(self) -> figure:
        axes = {"x_range": self.ranges["instant"].range, "y_range": self.ranges["restitution"].range}
        words = "instant of touch after the last step, t/Δτ", "restitution e"
        plot = make_figure("Restitution over the instant of touch", *words, name="impact_instant", **axes)
        line = add_glyph(plot, Line(x="instant", y="restitution", line_color=VERMILLION, line_width=2), self.instant)
        items = [LegendItem(label=LEGENDS["impact_instant"]["step"], renderers=[line])]
        legend_above(plot, [*items, *(self._level(plot, name) for name in ("asked", "exact"))])
        plot.add_tools(hover_tool([line], {"instant": "@instant", "restitution": "@restitution"}))
        return plot

    def _over_steps(self) -> figure:
        axes = {"x_range": self.ranges["steps"].range, "y_range": self.ranges["restitution"].range}
        words = "steps in a contact, t_c/Δτ", "restitution e, whenever the bodies touch"
        plot = make_figure("", *words, name="impact_band", x_axis_type="log", **axes)
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

    def on_tap(self, event: Tap) -> None:
        """Ask for the steps in a contact where a tap is."""
        if event.x is not None and 0 < event.x < math.inf:
            self._on_steps(event.x)

    def update(self, result: PartialImpact | None) -> None:
        """Draw what is known."""
        if result is None:
            return
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
        self.figures[1].title.text = f"Restitution over the steps in a contact: you are at {steps_here}"
        top = np.nanmax([_TOP, 1.05 * e.greatest, *(1.05 * known["greatest"])])
        self.ranges["restitution"].put(0.0, float(min(top, _HIGHEST)), fresh=fresh)
