"""The time step: phase plots with it fixed and located, and how blur and error fade with more steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from bokeh.events import Tap
from bokeh.models import Line, Scatter
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.method_words import STEP_NAMES, brief_name
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.curves import Axis, Curves, Plot, curve
from vibroscope.app.page.shared.figure import VERMILLION, cursor_line
from vibroscope.app.page.shared.seen import say
from vibroscope.app.studies.time_step import STEPS, PartialStep
from vibroscope.engine import percent
from vibroscope.engine.facts import Amount, Statement, joined, stated
from vibroscope.engine.sweeps import SCHEMES

GREEN = "#009E73"  # the located step is neither of the two solutions that have a colour in Explore
_LOOKS = {  # of each scheme: colour, marker, dash, colour of its points once a period
    "fixed": (VERMILLION, "diamond", "solid", None),
    "located": (GREEN, "circle", "dashed", GREEN),
}
_SIZES = {"spread": "scatter", "error_time_step": "error_time_step"}  # axes of the sizes over n, and their variables
# Smaller values are rounding; drawn, they would only stretch the axis.
_FLOOR = 1e-10


def _decades(least: float, greatest: float) -> tuple[float, float]:
    """Whole decades that hold all sizes, and one above for the legend."""
    low, high = np.round(np.log10([least, greatest]), 6)  # of columns in single precision
    return 10.0 ** (np.ceil(low) - 1), 10.0 ** (np.ceil(high) + 1)


def _phase(scheme: str) -> Plot:
    colour, marker, _, fill = _LOOKS[scheme]
    look, shown = {"line_color": colour, "line_width": 1.3}, {"x": "xi2", "y": "v2"}  # at a wall these hold ξ₁ and ξ₁′
    dots = curve(Scatter, f"step_section_{scheme}", **shown, **look, marker=marker, size=8, fill_color=fill)
    return Plot(
        "Being computed …", **shown, entries={"": ("", [curve(Line, f"step_orbit_{scheme}", **shown, **look), dots])}
    )


def _over_steps(name: str, title: str) -> Plot:
    entries = {}
    for scheme, (colour, marker, dash, _) in _LOOKS.items():
        source, shown = f"step_{name}_{scheme}", {"x": "n", "y": "size", "line_color": colour}
        line = curve(Line, source, **shown, line_width=1.5, line_dash=dash)
        entries[scheme] = (
            STEP_NAMES[scheme],
            [line, curve(Scatter, source, **shown, fill_color=colour, marker=marker, size=10)],
        )
    return Plot(title, "n", name, entries)


class TimeStepView(Curves):
    """Two phase plots and, below them, two logarithmic plots over n."""

    axes = {  # noqa: RUF012 - read only
        "xi2": Axis(-8, 8, "displacement ξ₂", "displacement"),
        "v2": Axis(-8, 8, "velocity ξ₂′", "velocity"),
        "n": Axis(STEPS[0] / 1.4, STEPS[-1] * 1.4, "steps per period n = T/Δτ", logarithmic=True),
        "spread": Axis(_FLOOR, 1.0, "standard deviation of ξ₂", "displacement", logarithmic=True, fit=_decades),
        "error_time_step": Axis(
            _FLOOR, 1.0, "rms difference from exact penalty, relative", logarithmic=True, fit=_decades
        ),
    }
    plots = {f"step_phase_{scheme}": _phase(scheme) for scheme in SCHEMES} | {
        "step_spread": _over_steps("spread", "Blur about the cycle (drawn down to 10⁻¹⁰ A)"),
        "step_error_time_step": _over_steps("error_time_step", "Error by the time step alone"),
    }

    def __init__(self, on_steps: Callable[[int], None]) -> None:
        super().__init__()
        self._on_steps = on_steps
        self._result: PartialStep | None = None
        self._cursors = {f"step_{name}": cursor_line(name=f"step_cursor_{name}") for name in _SIZES}
        for name, cursor in self._cursors.items():
            self.figures[name].add_layout(cursor)
            self.figures[name].on_event(Tap, self.on_tap)

    def update(self, setting: Setting, result: PartialStep | None) -> None:
        """Move the cursors; draw what is known, the phase plots with the n that is nearest to the one set."""
        for cursor in self._cursors.values():
            cursor.location = setting.steps
        self.label(setting, lambda words: words.replace("ξ₂", "ξ₁") if setting.bodies == "wall" else words)
        if result is None:
            return
        fresh, self._result = self.changes_to(result.question), result
        index = result.nearest(setting.steps)
        for scheme in SCHEMES:
            self._draw(result, index, scheme, setting)
        self.follow(*_SIZES, "xi2", "v2", fresh=fresh)
        for name, variable in _SIZES.items():
            why = result.why_none(variable)
            seen = f"no number, since {why}" if why else _seen(result, index, variable)
            self.say(f"step_{name}", seen, setting)

    def _draw(self, result: PartialStep, index: int, scheme: str, setting: Setting) -> None:
        question, method = result.question, result.question.method
        stiffness = result.stiffness if np.ndim(result.stiffness) == 0 else float(f"{result.stiffness[index]:.6g}")
        numbers = {"eta": question.eta, "K": stiffness, "D": method.damping}
        fields = [(shown_field(name, setting), value) for name, value in numbers.items() if value is not None]
        at = ", ".join(field.words(value) if not field.unit else field.measure(value) for field, value in fields)
        name = f", {brief_name(method)}" if method.has_choices else ""
        title = f"T/{result.steps[index]:.0f}, {STEP_NAMES[scheme]}{name}, {at}"
        say(self.figures[f"step_phase_{scheme}"], title, result.words(index, scheme), setting)
        for source, shown in (("orbit", result.orbit), ("section", result.section)):
            self.write(f"step_{source}_{scheme}", dict(zip(("xi2", "v2"), shown(index, scheme).values(), strict=True)))
        for name, variable in _SIZES.items():
            sizes = result.of_scheme(variable, scheme)
            fine = np.isfinite(sizes)
            self.write(f"step_{name}_{scheme}", {"n": result.steps[fine], "size": np.maximum(sizes[fine], _FLOOR)})

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
