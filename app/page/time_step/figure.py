"""The time step: phase plots with it fixed and located, and how blur and error fade with more steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from bokeh.events import Tap
from bokeh.models import LegendItem, Span
from bokeh.plotting import figure
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.method_words import STEP_NAMES, brief_name
from vibroscope.app.explorer.present import as_float32
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import (
    VERMILLION,
    axes_of,
    cursor_line,
    empty_source,
    legend,
    make_figure,
    quantity_axis,
    write,
)
from vibroscope.app.page.shared.ranges import OwnedRange, UnitAxis
from vibroscope.app.page.shared.seen import say
from vibroscope.app.studies.time_step import STEPS, PartialStep
from vibroscope.engine import percent
from vibroscope.engine.facts import Amount, Statement, joined, stated
from vibroscope.engine.sweeps import SCHEMES

GREEN = "#009E73"  # the located step is neither of the two solutions that have a colour in Explore
_COLOURS = {"fixed": VERMILLION, "located": GREEN}
_MARKERS = {"fixed": "diamond", "located": "circle"}
# Figures and axes are named in links. Of each: variable, title, label.
_SIZES = {
    "spread": ("scatter", "Blur about the cycle (drawn down to 10⁻¹⁰ A)", "standard deviation of ξ₂"),
    "error_time_step": (
        "error_time_step",
        "Error by the time step alone",
        "rms difference from exact penalty, relative",
    ),
}
# Smaller values are rounding; drawn, they would only stretch the axis.
_FLOOR = 1e-10
_NO_SIZES = (_FLOOR, 1.0)  # ends of an axis without data
_SHOWN = ("xi2", "v2")  # axes and columns of the phase plots; at a wall they hold ξ₁ and ξ₁′
_UNIT_AXES = (  # what stands before the unit, quantity
    ("xi2", "displacement ξ₂", "displacement"),
    ("v2", "velocity ξ₂′", "velocity"),
    ("spread", _SIZES["spread"][2], "displacement"),
)
_SPAN = STEPS[0] / 1.4, STEPS[-1] * 1.4


class TimeStepView:
    """Two phase plots and two logarithmic plots over n."""

    def __init__(self, on_steps: Callable[[int], None]) -> None:
        self._on_steps = on_steps
        self._result: PartialStep | None = None
        self.orbits = {scheme: empty_source(f"step_orbit_{scheme}", *_SHOWN) for scheme in SCHEMES}
        self.sections = {scheme: empty_source(f"step_section_{scheme}", *_SHOWN) for scheme in SCHEMES}
        self.sizes = {
            (name, scheme): empty_source(f"step_{name}_{scheme}", "n", "size") for name in _SIZES for scheme in SCHEMES
        }
        self.ranges = {"xi2": OwnedRange(-8, 8), "v2": OwnedRange(-8, 8), "n": OwnedRange(*_SPAN)}
        self.ranges |= {name: OwnedRange(*_NO_SIZES) for name in _SIZES}
        self._cursors: list[Span] = []
        self.phases = {scheme: self._phase(scheme) for scheme in SCHEMES}
        self.curves = {name: self._curve(name) for name in _SIZES}
        phases = self.phases.values()
        self._axes = {name: UnitAxis(self.ranges[name], side, *phases) for name, side in (("xi2", "x"), ("v2", "y"))}
        self._axes["spread"] = UnitAxis(self.ranges["spread"], "y", self.curves["spread"])

    @property
    def figures(self) -> list[figure]:
        """Phase plots above, curves below."""
        return [*self.phases.values(), *self.curves.values()]

    def _phase(self, scheme: str) -> figure:
        axes = axes_of(self.ranges, *_SHOWN)
        words = "Being computed …", "displacement ξ₂", "velocity ξ₂′"
        plot = make_figure(*words, name=f"step_phase_{scheme}", **axes)
        plot.line("xi2", "v2", source=self.orbits[scheme], line_color=_COLOURS[scheme], line_width=1.3)
        look = {"marker": _MARKERS[scheme], "size": 8, "line_color": _COLOURS[scheme], "line_width": 1.3}
        fill = None if scheme == "fixed" else _COLOURS[scheme]
        plot.scatter("xi2", "v2", source=self.sections[scheme], fill_color=fill, **look)
        return plot

    def _curve(self, name: str) -> figure:
        _, title, label = _SIZES[name]
        axes = axes_of(self.ranges, "n", name, "xy")
        plot = make_figure(title, "steps per period n = T/Δτ", label, name=f"step_{name}", **axes)
        items = []
        for scheme in SCHEMES:
            source, colour = self.sizes[name, scheme], _COLOURS[scheme]
            dash = "solid" if scheme == "fixed" else "dashed"
            drawn = [
                plot.line("n", "size", source=source, line_color=colour, line_width=1.5, line_dash=dash),
                plot.scatter("n", "size", source=source, marker=_MARKERS[scheme], size=10, color=colour),
            ]
            items.append(LegendItem(label=STEP_NAMES[scheme], renderers=drawn))
        plot.add_layout(legend(items))
        cursor = cursor_line(name=f"step_cursor_{name}")
        plot.add_layout(cursor)
        self._cursors.append(cursor)
        plot.on_event(Tap, self.on_tap)
        return plot

    def update(self, setting: Setting, result: PartialStep | None) -> None:
        """Move the cursors; draw what is known, the phase plots with the n that is nearest to the one set."""
        for cursor in self._cursors:
            cursor.location = setting.steps
        for name, words, quantity in _UNIT_AXES:
            words = words.replace("ξ₂", "ξ₁") if setting.bodies == "wall" else words
            self._axes[name].show(*quantity_axis(setting, words, quantity))
        if result is None:
            return
        fresh = self._result is None or self._result.question != result.question
        self._result = result
        index = result.nearest(setting.steps)
        for scheme in SCHEMES:
            self._draw(result, index, scheme, setting)
        for name in _SIZES:
            sizes = np.concatenate([self.sizes[name, scheme].data["size"] for scheme in SCHEMES])
            ends = tuple(10.0**end for end in _decades(sizes)) if len(sizes) else _NO_SIZES
            self.ranges[name].put(*ends, fresh=fresh and len(sizes) > 0)
            variable, title, _ = _SIZES[name]
            why = result.why_none(variable)
            seen = f"no number, since {why}" if why else _seen(result, index, variable)
            say(self.curves[name], title, seen, setting)
        drawn = [*self.orbits.values(), *self.sections.values()]
        for name in _SHOWN:
            columns = [source.data[name] for source in drawn]
            self.ranges[name].follow(columns, fresh=fresh)

    def _draw(self, result: PartialStep, index: int, scheme: str, setting: Setting) -> None:
        question, method = result.question, result.question.method
        stiffness = result.stiffness if np.ndim(result.stiffness) == 0 else float(f"{result.stiffness[index]:.6g}")
        numbers = {"eta": question.eta, "K": stiffness, "D": method.damping}
        fields = [(shown_field(name, setting), value) for name, value in numbers.items() if value is not None]
        at = ", ".join(field.words(value) if not field.unit else field.measure(value) for field, value in fields)
        name = f", {brief_name(method)}" if method.has_choices else ""
        title = f"T/{result.steps[index]:.0f}, {STEP_NAMES[scheme]}{name}, {at}"
        say(self.phases[scheme], title, result.words(index, scheme), setting)
        for source, shown in ((self.orbits, result.orbit), (self.sections, result.section)):
            write(source[scheme], as_float32(dict(zip(_SHOWN, shown(index, scheme).values(), strict=True))))
        for name in _SIZES:
            sizes = result.of_scheme(_SIZES[name][0], scheme)
            fine = np.isfinite(sizes)
            shown = {"n": result.steps[fine], "size": np.maximum(sizes[fine], _FLOOR)}
            write(self.sizes[name, scheme], as_float32(shown))

    def on_tap(self, event: Tap) -> None:
        """Set n to that of the study which is nearest to a tap."""
        if event.x is not None and 0 < event.x < np.inf and self._result is not None:
            self._on_steps(int(self._result.steps[self._result.nearest(event.x)]))


def _seen(result: PartialStep, index: int, variable: str) -> Statement:
    """The size of a curve at the n that is shown, of each scheme that has one there."""
    sizes = {scheme: float(result.of_scheme(variable, scheme)[index]) for scheme in result.schemes}
    numbers = (
        stated("{} {}", STEP_NAMES[scheme], Amount(size, "displacement", 2) if variable == "scatter" else percent(size))
        for scheme, size in sizes.items()
        if np.isfinite(size)
    )
    known = joined(", ", numbers)
    return stated("{} at T/{}", known, f"{result.steps[index]:.0f}") if known else known


def _decades(sizes: np.ndarray) -> tuple[int, int]:
    """Whole decades that hold all sizes, and one above for the legend."""
    low, high = np.log10([sizes.min(), sizes.max()])
    return int(np.ceil(low)) - 1, int(np.ceil(high)) + 1
