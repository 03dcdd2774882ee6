"""Two spectra over orders of the excitation frequency: of a motion, and of the contact force, of both solutions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from bokeh.models import LegendItem, Line
from bokeh.plotting import figure
from vibroscope.app.explorer.present import as_float32
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import (
    SOLUTIONS,
    add_glyph,
    axes_of,
    empty_source,
    hover_tool,
    legend,
    make_figure,
    quantity_axis,
    write,
)
from vibroscope.app.page.shared.ranges import OwnedRange, UnitAxis
from vibroscope.app.page.shared.seen import say
from vibroscope.app.studies.peaks import SOLVERS, PartialPeaks
from vibroscope.engine import written
from vibroscope.engine.facts import Amount, Statement, joined, stated

HIGHEST = 20.0  # order of `engine.spectrum`
SHOWN = 1e-5  # of the largest amplitude: what is smaller would only stretch the axis
_EMPTY = (1e-3, 10.0)  # ends of an axis without data
_TITLES = {"motion": "Spectrum of the motion", "force": "Spectrum of the contact force"}
# What can be drawn: its words in a label, and its quantity.
DRAWN = {
    "displacement1": ("displacement ξ₁ with the base", "displacement"),
    "displacement2": ("displacement ξ₂ with the base", "displacement"),
    "acceleration1": ("absolute acceleration of body 1", "acceleration"),
    "acceleration2": ("absolute acceleration of body 2", "acceleration"),
    "contact_force": ("contact force λ", "force"),
}


class SpectrumView:
    """The figures "motion" and "force", which share the axis of orders."""

    def __init__(self) -> None:
        self.sources = {
            (kind, solver): empty_source(f"spectrum_{kind}_{solver}", "order", "amplitude")
            for kind in ("motion", "force")
            for solver in SOLVERS
        }
        self.ranges = {"order": OwnedRange(0, HIGHEST), "motion": OwnedRange(*_EMPTY), "force": OwnedRange(*_EMPTY)}
        self.figures = {kind: self._build(kind) for kind in ("motion", "force")}
        self._axes = {kind: UnitAxis(self.ranges[kind], "y", plot) for kind, plot in self.figures.items()}
        self._drawn: object = None  # question and quantity

    def _build(self, kind: str) -> figure:
        axes = axes_of(self.ranges, "order", kind, "y")
        words = "order: frequency relative to the excitation"
        plot = make_figure(_TITLES[kind], words, name=f"spectrum_{kind}", **axes)
        lines = {
            solver: add_glyph(plot, Line(x="order", y="amplitude", **look), self.sources[kind, solver])
            for solver, look in SOLUTIONS.items()
        }
        plot.add_layout(legend([LegendItem(label=solver, renderers=[line]) for solver, line in lines.items()]))
        tips = {"order": "@order", "amplitude, without dimension": "@amplitude"}
        plot.add_tools(hover_tool([*lines.values()], tips, mode="vline", line_policy="nearest"))
        return plot

    def update(self, setting: Setting, quantity: str, result: PartialPeaks | None) -> None:
        """Draw the spectra of ``quantity``, a key of `DRAWN`, and of the contact force, as far as they are known."""
        fresh = result is not None and self._drawn != (result.question, quantity)
        self._drawn = None if result is None else (result.question, quantity)
        for kind, name in (("motion", quantity), ("force", "contact_force")):
            words, unit = DRAWN[name]
            if setting.bodies == "wall":
                words = words.replace("ξ₁", "ξ").replace(" of body 1", "")
            label, factor = quantity_axis(setting, words, unit)
            self._axes[kind].show(label, factor)
            columns = {} if result is None else {s: read.amplitudes for s, read in result.found.items()}
            known = {solver: each for solver, each in columns.items() if each}
            self._draw(kind, known, name, fresh=fresh)
            say(self.figures[kind], _TITLES[kind], _seen(known, name, unit), setting)

    def _draw(self, kind: str, columns: Mapping[str, Mapping[str, np.ndarray]], name: str, *, fresh: bool) -> None:
        top = max((each[name].max() for each in columns.values()), default=0.0)
        nothing = {"order": np.empty(0), "amplitude": np.empty(0)}
        for solver in SOLVERS:
            shown = nothing
            if solver in columns and top > 0:
                shown = {
                    "order": columns[solver]["order"],
                    "amplitude": np.maximum(columns[solver][name], SHOWN * top),
                }
            write(self.sources[kind, solver], as_float32(shown))
        self.ranges[kind].put(*((SHOWN * top, 8 * top) if top > 0 else _EMPTY), fresh=fresh)


def _seen(columns: Mapping[str, Mapping[str, np.ndarray]], name: str, quantity: str) -> Statement:
    """The largest amplitude of each solution beside its mean, which is that of order 0, and its order."""
    tops = {solver: int(np.argmax(each[name] * (each["order"] > 0))) for solver, each in columns.items()}
    return joined(
        "; ",
        (
            stated(
                f"{solver} largest at order {written(float(columns[solver]['order'][at]), 3)}, {{}}",
                Amount(float(columns[solver][name][at]), quantity, 3),
            )
            for solver, at in tops.items()
            if columns[solver][name][at] > 0
        ),
    )
