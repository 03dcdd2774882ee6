"""The restitution over the instant of touch and over the steps in a contact, and the force over time."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from bokeh.core.properties import value
from bokeh.events import Tap
from bokeh.models import HSpan, Line, Quad, Scatter, Segment, VSpan
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.curves import Axis, Curve, Curves, Plot, curve
from vibroscope.app.page.shared.figure import GREEN, INK, VERMILLION, VIOLET, legend_above, quantity_axis
from vibroscope.app.page.shared.seen import amount, largest
from vibroscope.app.studies.one_impact import STEPS, PartialImpact
from vibroscope.engine import written
from vibroscope.engine.facts import stated

_SPAN = ("least", "mean", "greatest")
_TOP, _HIGHEST = 1.05, 2.0  # of the restitution that is drawn: at first, and at most
_HALF = math.sqrt(STEPS[1] / STEPS[0])  # from one of the steps to halfway to the next, times
_OF_STEP = {"line_color": VERMILLION}
TOUCHES = {"best": "best touch", "worst": "worst touch", "exact": "without a step"}


def _level(name: str, colour: str) -> list[Curve]:
    return [curve(HSpan, "impact_levels", y=name, layer=1, line_color=colour, line_dash="dashed", line_width=1.6)]


def _course(name: str, colour: str, **look: object) -> tuple[str, list[Curve]]:
    source, place = f"impact_force_{name}", {"x": "time", "y": "force", "line_color": colour}
    drawn = [curve(Line, source, hovered=True, **place, **look)]
    if name != "exact":  # what a method with a step knows
        drawn.append(curve(Scatter, source, layer=1, **place, size=5, fill_color=colour))
    return TOUCHES[name], drawn


_OVER_INSTANT = curve(Line, "impact_over_instant", hovered=True, x="instant", y="restitution", line_width=2, **_OF_STEP)
_BAND = [
    curve(
        Quad,
        "impact_over_steps",
        hovered=True,
        **{"left": "left", "right": "right", "bottom": "least", "top": "greatest"},
        **{"fill_color": VERMILLION, "fill_alpha": 0.3, "line_color": None},
    ),
    curve(Line, "impact_over_steps", x="steps", y="mean", line_width=1.5, **_OF_STEP),
]
_HERE = [
    curve(Segment, "impact_here", x0="steps", x1="steps", y0="least", y1="greatest", line_width=3, **_OF_STEP),
    curve(Scatter, "impact_here", x="steps", y="mean", marker="diamond", size=13, fill_color=VERMILLION),
]
_LARGEST = curve(VSpan, "impact_largest", x="steps", line_color=GREEN, line_dash="dotdash", line_width=2)


class ImpactView(Curves):
    """Two figures with one axis of restitutions, one of forces; a tap in the second gives its steps in a contact."""

    axes = {  # noqa: RUF012 - read only
        "instant": Axis(0.0, 1.0, "instant of touch after the last step, t/Δτ"),
        "steps": Axis(float(STEPS[0]), float(STEPS[-1]), "steps in a contact, t_c/Δτ", logarithmic=True),
        "restitution": Axis(0.0, _TOP, "restitution e, whenever the bodies touch"),
        "time": Axis(0.0, 1.0),
        "force": Axis(0.0, 1.0),
    }
    plots = {  # noqa: RUF012 - read only
        "impact_instant": Plot(
            "Restitution over the instant of touch",
            "instant",
            "restitution",
            {
                "step": ("with this step", [_OVER_INSTANT]),
                "asked": ("asked for", _level("asked", INK)),
                "exact": ("without a step", _level("exact", VIOLET)),
            },
            {"instant": "@instant", "restitution": "@restitution"},
            legend=legend_above,
        ),
        "impact_band": Plot(
            "Restitution over the steps in a contact",
            "steps",
            "restitution",
            {
                "band": ("least to greatest", _BAND),
                "asked": ("asked for", _level("asked", INK)),
                "here": ("you are here", _HERE),
                "largest": ("largest step", [_LARGEST]),
            },
            {"steps in a contact": "@steps", "least": "@least", "mean": "@mean", "greatest": "@greatest"},
            legend=legend_above,
        ),
        "impact_force": Plot(
            "Contact force over time",
            "time",
            "force",
            {
                "best": _course("best", GREEN, line_width=2.4),
                "worst": _course("worst", VERMILLION, line_width=1.6),
                "exact": _course("exact", VIOLET, line_width=1.6, line_dash="dashed"),
            },
            {"time since touch": "@time", "force": "@force"},
            legend=legend_above,
        ),
    }

    def __init__(self, on_steps: Callable[[float], None]) -> None:
        super().__init__()
        self._on_steps = on_steps
        self._forces_drawn: object = None  # question and units
        self.figures["impact_instant"].yaxis.axis_label = "restitution e"
        self.figures["impact_band"].on_event(Tap, self.on_tap)
        # Its labels change: how many fit beside each other would be that of older ones.
        self.figures["impact_force"].legend.ncols = 1

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
        fresh, band = self.changes_to(result.question), result.over_steps()
        steps, spans = band["steps_per_contact"], {name: band[f"restitution_{name}"] for name in _SPAN}
        self.write("impact_over_instant", result.instants())
        self.write("impact_over_steps", {"steps": steps, **spans, "left": steps / _HALF, "right": steps * _HALF})
        here = {"steps": [one.steps_per_contact]} | {name: [end] for name, end in zip(_SPAN, e, strict=True)}
        self.write("impact_here", here)
        self.write("impact_levels", {"asked": [one.restitution], "exact": [one.without_step.restitution]})
        self.write("impact_largest", {"steps": [result.largest.steps_per_contact] if result.largest else []})
        self.say("impact_band", f"you are at {written(one.steps_per_contact, 3)}")
        seen = f"{written(e.least, 3)} to {written(e.greatest, 3)}" if math.isfinite(e.mean) else "none"
        self.say("impact_instant", seen)
        top = np.nanmax([_TOP, 1.05 * e.greatest, *(1.05 * spans["greatest"])])
        self.ranges["restitution"].put(0.0, float(min(top, _HIGHEST)), fresh=fresh)

    def _draw_forces(self, setting: Setting, result: PartialImpact) -> None:
        """The forces over time in the units of the setting, and of which touches they are."""
        plot, scaled = self.figures["impact_force"], setting.scale is not None
        time, factors = "time since touch t / s" if scaled else "time since touch τ", {}
        plot.xaxis[0].axis_label, factors["time"] = time, setting.scale.factor("time") if scaled else 1.0
        plot.yaxis[0].axis_label, factors["force"] = quantity_axis(setting, "contact force λ", "force")
        courses = {name: {n: factors[n] * getattr(each, n) for n in factors} for name, each in result.forces.items()}
        for name, words in TOUCHES.items():
            self.write(f"impact_force_{name}", courses.get(name, {}))
            if name in result.forces:
                one = result.forces[name]
                at = "" if math.isnan(one.instant) else f" t/Δτ {one.instant:.2f},"
                words = f"{words}:{at} e {one.restitution:.2f}"
            self.items["impact_force", name].label = value(words)
        most = largest(each["force"] for each in courses.values())
        self.say("impact_force", "" if most is None else stated("up to {}", amount(most, "force", setting)), setting)
        drawn, self._forces_drawn = self._forces_drawn, (result.question, setting.scale)
        self.follow("time", "force", fresh=drawn != self._forces_drawn)
