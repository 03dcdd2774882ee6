"""One impact: what the contact that is set gives by itself with its step, over its steps, and what to take over."""

import math
from dataclasses import replace

import numpy as np
import panel as pn
from bokeh.core.properties import value
from bokeh.models import HSpan, Line, Quad, Scatter, Segment, VSpan
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.impact_words import (
    advice,
    answer,
    over_speeds_of_motion,
    span_and_mean,
    steps_in_contact,
)
from vibroscope.app.explorer.link import ViewChoice
from vibroscope.app.explorer.method_words import name_of_integrator, words_of_scheme
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import impact_command, impact_python
from vibroscope.app.page.shared.curves import Axis, Curve, Curves, Plot, curve
from vibroscope.app.page.shared.figure import GREEN, INK, VERMILLION, VIOLET, legend_above, quantity_axis
from vibroscope.app.page.shared.seen import amount, largest
from vibroscope.app.page.study.listed import ListPanel, cell, row
from vibroscope.app.page.study.tab import StudyView, refusal
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies.one_impact import STEPS, ImpactQuestion, PartialImpact, Run, grow_impact
from vibroscope.engine import counted, percent, written
from vibroscope.engine.facts import Amount, Statement, stated
from vibroscope.engine.one_impact.choose import CLOSE_TO_ASKED
from vibroscope.engine.units import time_text

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
    """Two figures with one axis of restitutions, one of forces."""

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

    def __init__(self) -> None:
        super().__init__()
        self._forces_drawn: object = None  # question and units
        self.figures["impact_instant"].yaxis.axis_label = "restitution e"
        # Its labels change: how many fit beside each other would be that of older ones.
        self.figures["impact_force"].legend.ncols = 1

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


_POSITIVE = (1e-12, 1e12)
_OFFERS = {"contact": "Set this K", "steps": "Take this step over", "K": "Take this K over", "D": "Take this D over"}
_SHORT = {"K": "stiffness", "D": "damping", "steps": "steps"}
_SAFE = 1.0 - 1e-3  # times the steps in a contact that a K gives: it is rounded
_STIFFER = 1.0 + 5e-4  # times a K that gives the permitted penetration, likewise
_STATUSES = {"start": "start of the step", "end": "end, iterated", "located": "step cut at contact", "": "impact law"}


class OneImpact(StudyView):
    """The restitution over the instant of touch and over the steps, what to take over, and other integrators."""

    key = "impact"
    title = "One impact"
    starts = at_once = True
    grow = staticmethod(grow_impact)
    drawn, arrangement, tapped = ImpactView, ("halves", "impact"), ("impact_band",)
    needs = {  # noqa: RUF012 - read only
        **{"": "found", "impact_band": "band", "impact_force": "forces", "impact_schemes": "schemes"}
    }
    choices = (
        ViewChoice("mass", "m*", None, {}, _POSITIVE, "reduced mass", "mass", "m₁"),
        ViewChoice("speed", "v", None, {}, _POSITIVE, "closing speed", "velocity", "Aω₁"),
        ViewChoice("depth", "δ", None, {}, _POSITIVE, "permitted penetration", "displacement", "A"),
    )
    hint = (
        "Two bodies meet once, and no other force acts. K, D, the step, integrator, contact status and law are those "
        "that are set; e under System is what was asked for. Empty fields take the bodies' mass and the speed of the "
        "reference. With a permitted penetration the table offers the K for it. A click in the right figure sets the "
        "step, a row of the table the integrator and status. Choose units under System to type kg and m/s."
    )
    pictures = (
        Figure("impact_instant", "Restitution over the instant", "Restitution over the instant of touch in a step."),
        Figure("impact_band", "Restitution over the steps", "Least to greatest restitution over steps in a contact."),
        Figure("impact_force", "Contact force over time", "Force of the best and the worst touch, and without a step."),
        Figure("impact_schemes", "Integrators", "The same contact with each integrator and status.", drawn=False),
    )

    def build(self) -> pn.Column:
        """See `StudyView`; two tables in the fourth quarter."""
        page = super().build()
        self.offers = ListPanel(label="What to take over, and other integrators", visible=False)
        self.offers.css_classes = ["cell", "rows"]
        self.offers.listen(open=(str, self._take))
        page.append(self.offers)
        return page

    def obstacle(self, setting: Setting) -> str:
        """Why there is no such contact."""
        return refusal(lambda: self.question(setting).at(self.panel.chosen["speed"] or 1.0))

    def question(self, setting: Setting) -> ImpactQuestion:
        """The contact alone; where no speed is typed also what the reference depends on."""
        system, method, chosen = setting.system, setting.constant_step, self.panel.chosen
        if setting.located == "yes":
            method = replace(method, status="located")
        run = Run(system, setting.eta, setting.reference, setting.initial)
        step = 2.0 * math.pi / (setting.eta * setting.steps)
        mass = chosen["mass"] or system.mass_share
        return ImpactQuestion(method, step, mass, system.restitution, chosen["speed"] or run, chosen["depth"])

    def while_empty(self, setting: Setting) -> dict[str, str]:
        """The mass of the bodies, and the speed of the reference once it is known."""
        of_system, fields = {"mass": setting.system.mass_share}, self.fields(setting)
        if self.result is not None and self.result.impacts:
            of_system["speed"] = self.result.impact.speed
        return {name: written(fields[name].factor * value) for name, value in of_system.items()}

    def draw(self, setting: Setting, result: PartialImpact | None) -> None:
        """Figures and tables."""
        known = result is not None
        self.view.update(setting, result)
        near, points = (_offer_table(result, setting), _scheme_table(result)) if known else ({}, {})
        self.offers.param.update(near=near, points=points, visible=known)

    def _take(self, named: str) -> None:
        """Set what a row of the tables offers."""
        if self.result is None:
            return
        if texts := offers_of(self.result, self._result_setting).get(named):
            texts = self._move.setting.with_contact(texts)
            if named == "contact":  # whose step is sought here
                self.host.set(texts)
            else:
                self.host.visit("explore", texts)
        elif texts := schemes_of(self.result).get(named):
            self.host.set(texts)

    def take_over(self, name: str, x: float, y: float) -> None:
        """Set the step of which ``x`` are in a contact."""
        if self.result is not None and self._result_setting is not None:
            steps = self._result_setting.steps * x / self.result.impact.steps_per_contact
            self.host.set(self._move.setting.with_contact({"steps": str(max(1, round(steps)))}))

    def describe(self, setting: Setting, result: PartialImpact) -> list[list[str | Statement]]:
        """The answer, the contact, and what it gives without the step and with it."""
        one, found, alone = result.impact, result.found, result.impact.without_step
        said = answer(one, one.restitution, found)
        if abs(alone.restitution - one.restitution) > CLOSE_TO_ASKED:
            do = "take another D over" if result.softer is None else "set the K of the table"
            said += f" No step makes up for K and D, which give {alone.restitution:.2f} without one: {do}."
        elif result.searched:
            said += f" {advice(result.largest, CLOSE_TO_ASKED, result.largest and _step_text(result, setting))}"
        of = f", the median of {counted(result.impacts, 'impact')} of the reference" if result.impacts else ""
        measures = "Restitution {}; penetration {}, force {}"
        lost = " to ".join(dict.fromkeys(map(percent, (found.energy_lost.least, found.energy_lost.greatest))))
        return [
            ["Answer", said],
            [
                "Contact",
                stated(
                    "Reduced mass {}, closing speed {}{}; {} steps in a contact. {}.",
                    Amount(one.mass, "mass"),
                    Amount(one.speed, "velocity"),
                    of,
                    written(one.steps_per_contact, 3),
                    words_of_scheme(one.method),
                ),
            ],
            [
                "Without a step",
                stated(
                    f"{measures}.",
                    written(alone.restitution, 3),
                    Amount(alone.penetration, "displacement"),
                    Amount(alone.force, "force"),
                ),
            ],
            [
                "With this step",
                stated(
                    f"{measures}; {{}}. Of the energy {{}} is lost.",
                    span_and_mean(found.restitution),
                    Amount(found.penetration, "displacement"),
                    Amount(found.force, "force"),
                    steps_in_contact(found),
                    lost,
                ),
            ],
            *([["All closing speeds", over_speeds_of_motion(result.motion)]] if result.motion else []),
        ]

    def table(self, name: str) -> list[Series]:
        """The restitution over instants, steps, or integrators and contact statuses; the forces over time."""
        result = self.result
        if name == "impact_force":
            return [Series(TOUCHES[each], columns) for each, columns in result.over_time().items()]
        if name == "impact_instant":
            return [Series("with this step", result.instants())]
        if name == "impact_band":
            return [Series("over steps", result.over_steps())]
        return [Series("integrators", result.of_schemes())]

    def python(self, setting: Setting) -> str:
        """A script that solves this contact."""
        return "" if self.result is None else impact_python(self.result.impact)

    def command(self, setting: Setting) -> str:
        """``vibroscope impact``."""
        return "" if self.result is None else impact_command(self.result.impact)


def _steps_of(time_step: float, setting: Setting) -> int:
    """The fewest steps per period that are not longer."""
    return math.ceil(2.0 * math.pi / (setting.eta * time_step) * (1.0 - 1e-9))


def _step_text(result: PartialImpact, setting: Setting) -> str:
    """The largest step as the step is set, with units also as a time."""
    text = f"T/{_steps_of(result.largest.step, setting)}"
    return f"{text} = {time_text(setting.scale.factor('time') * result.largest.step)}" if setting.scale else text


def offers_of(result: PartialImpact, setting: Setting) -> dict[str, dict[str, str]]:
    """Texts that set another step, K or D for what was asked for, by their names in `_OFFERS`.

    "contact" gives the permitted penetration. The step is the largest that is close. K is the one with which the
    present step is this largest, with the D of the same damping ratio; such a K there is where the spring of the law is
    linear. D gives the restitution without a step.
    """
    found, largest, one = {}, result.largest, result.impact
    method = one.method
    if result.softer is not None:
        rounded = result.softer.with_contact(stiffness=float(_digits(_STIFFER * result.softer.method.stiffness)))
        texts = {"K": _digits(rounded.method.stiffness)}
        if method.damping is not None:
            texts["D"] = _digits(rounded.with_restitution(one.restitution).method.damping)
        if not all(math.isclose(float(text), getattr(setting, each)) for each, text in texts.items()):  # not set yet
            found["contact"] = texts
    if largest is not None:
        found["steps"] = {"steps": str(_steps_of(largest.step, setting))}
        if method.spring_exponent == 1.0 and method.stiffening is None and method.damping is not None:
            softer = _SAFE * one.steps_per_contact / largest.steps_per_contact
            found["K"] = {"K": _digits(method.stiffness * softer**2), "D": _digits(method.damping * softer)}
    off = abs(one.without_step.restitution - one.restitution)
    if method.damping is not None and off > 1e-3 and not math.isnan(result.damping):
        found["D"] = {"D": _digits(result.damping)}
    return {
        name: texts
        for name, texts in found.items()
        if all(FIELDS[each].bounds[0] <= float(text) <= FIELDS[each].bounds[1] for each, text in texts.items())
    }


def schemes_of(result: PartialImpact) -> dict[str, dict[str, str]]:
    """Texts that set each integrator and contact status of the table, by both."""
    found = {}
    for name, status in (one.scheme for one, _ in result.schemes if one.scheme[1]):
        located = {"status": "start", "located": "yes"} if status == "located" else {"status": status, "located": "no"}
        found[f"{name} {status}"] = {"integrator": name, **located}
    return found


def _digits(value: float) -> str:
    return print_number(float(f"{value:.4g}"))


def _offer_table(result: PartialImpact, setting: Setting) -> dict:
    """What can be taken over: a button, the numbers, what for."""
    e = written(result.impact.restitution, 3)
    why = {
        "contact": f"restitution {e} and the permitted penetration, without a step",
        "steps": "the largest that stays close",
        "K": "the largest with the present step",
        "D": f"restitution {e} without a step",
    }
    symbol = "Δτ" if setting.scale is None else "Δt"
    rows = []
    for name, texts in offers_of(result, setting).items():
        fields = {each: shown_field(each, setting) for each in texts}
        words = [f"{_SHORT[each]} {field.words(float(texts[each]))}" for each, field in fields.items()]
        if name == "steps":
            words = [f"time step {symbol} = {_step_text(result, setting)}"]
        title = "Set it here" if name == "contact" else "Set it, and see it in Explore"
        rows.append(row("offer", cell(_OFFERS[name], name, title), ", ".join(words), why[name]))
    return {"title": "To get what was asked for", "heads": ["take over", "numbers", "then"], "rows": rows}


def _scheme_table(result: PartialImpact) -> dict:
    """The same contact with each integrator and contact status."""
    rows = []
    for one, found in result.schemes:
        name, status = one.scheme
        shares = {
            "no solution": found.without_solution,
            "two solutions": found.two_solutions,
            "blown up": found.blown_up,
        }
        faults = ", ".join(f"{words} {percent(share)}" for words, share in shares.items() if share > 0)
        e = span_and_mean(found.restitution).partition(",")[0]
        words = name_of_integrator(name) if status else f"Moreau and Jean, θ = {one.theta:g}"
        opens = (f"{name} {status}", "Set this integrator and contact status") if status else ()
        mark = "◆" if one.scheme == result.impact.scheme else ""
        rows.append(row(_STATUSES[status], cell(words, *opens), _STATUSES[status], e, faults, mark=mark))
    heads = ["integrator", "contact status", "restitution", "touches with"]
    return {"title": "The same numbers with each integrator and contact status", "heads": heads, "rows": rows}
