"""The load over time, displacements and contact force of both solutions, and the shock response over frequency."""

from __future__ import annotations

import numpy as np
from bokeh.core.properties import value
from bokeh.models import Line
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.curves import Axis, Curves, Plot, curve
from vibroscope.app.page.shared.figure import INK, SOLUTIONS, SUBSCRIPTS, VIOLET, symbols
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.shared.seen import amount, largest, of_both
from vibroscope.app.studies.load import RATIOS, PartialRuns
from vibroscope.app.studies.peaks import SOLVERS
from vibroscope.engine.facts import Statement, stated
from vibroscope.engine.load import ON, quantity_of

_ONE = {"line_color": INK, "line_width": 2}  # what is of neither solution, or of both
_MOTIONS = {f"{solver}{body}": (solver, body) for solver in SOLVERS for body in (1, 2)}
_DASHED = {"line_dash": "dashed"}
_FORCES = {solver: (solver, look) for solver, look in SOLUTIONS.items()}
_RESPONSES = {"with": ("with the stop", _ONE), "without": ("without it", _ONE | _DASHED | {"line_color": VIOLET})}


def _plot(name: str, title: str, x: str, y: str, entries: dict[str, tuple[str, dict]]) -> Plot:
    drawn = {
        entry: (words, [curve(Line, f"{name}_{entry}", x="x", y="y", hovered=True, **look)])
        for entry, (words, look) in entries.items()
    }
    return Plot(title, x, y, drawn, {"at": "@x", "value, without dimension": "@y"})


def _named(solver: str, body: int) -> tuple[str, dict]:
    return f"ξ{SUBSCRIPTS[body]} {solver}", SOLUTIONS[solver] | (_DASHED if body == 2 else {})


class LoadView(Curves):
    """Four figures, three of them with one axis of time."""

    axes = {  # noqa: RUF012 - read only
        "time": Axis(0.0, 1.0, "time τ", "time"),
        "load": Axis(0.0, 1.0, ON["base"], quantity_of("base")),
        "motion": Axis(0.0, 1.0, "displacements ξ₁, ξ₂", "displacement"),
        "force": Axis(0.0, 1.0, "contact force λ", "force"),
        "ratio": Axis(
            float(RATIOS[0]), float(RATIOS[-1]), "natural frequency of body 1", "frequency", logarithmic=True
        ),
        "response": Axis(0.0, 1.0, "largest acceleration", "acceleration"),
    }
    plots = {  # noqa: RUF012 - read only
        "load_course": _plot("load_course", "Load", "time", "load", {"load": ("", _ONE)}),
        "load_motion": _plot(
            "load_motion", "Displacements", "time", "motion", {entry: _named(*of) for entry, of in _MOTIONS.items()}
        ),
        "load_force": _plot(
            "load_force", "Contact force", "time", "force", {n: (n, look) for n, look in SOLUTIONS.items()}
        ),
        "load_shock": _plot("load_shock", "Shock response", "ratio", "response", _RESPONSES),
    }

    def update(self, setting: Setting, result: PartialRuns | None) -> None:
        """Draw what is known."""
        self._label(setting, "base" if result is None else result.question.source.on)
        if result is None:
            return
        curves = {} if result.load is None else _curves(setting, result)
        for source in self.sources:
            self.write(source, dict(zip("xy", curves.get(source, ((), ())), strict=True)))
        if result.load is None:
            return
        fresh = self.changes_to(result.question)
        self.follow("load", "motion", "force", "response", fresh=fresh)
        self.ranges["time"].put(0.0, float(curves["load_course_load"][0][-1]), fresh=fresh)
        for name, seen in self._seen(setting, result.load.on, curves).items():
            self.say(name, seen, setting)

    def _label(self, setting: Setting, on: str) -> None:
        wall = setting.bodies == "wall"
        others = {"motion": ("displacement ξ", "displacement")} if wall else {}
        self.label(setting, load=(ON[on], quantity_of(on)), **others)
        for entry, (_, body) in _MOTIONS.items():
            item, words = self.items["load_motion", entry], self.plots["load_motion"].entries[entry][0]
            item.label = value(symbols(setting, words.replace("₁", "") if wall else words))
            show_entry(item, not (wall and body == 2))
        if setting.scale is None:
            self.units["time"].show("time τ", 1.0)
            self.units["ratio"].show("natural frequency of body 1 / ω₁", 1.0)

    def _seen(self, setting: Setting, on: str, curves: dict) -> dict[str, str | Statement]:
        """What is seen in each figure."""
        of_load, scale = quantity_of(on), setting.scale

        def most(source: str, quantity: str) -> float | None:
            """The largest size of a curve; columns have no dimension, and the axes have the units."""
            return largest([(scale.factor(quantity) if scale else 1.0) * np.asarray(curves.get(source, ((), ()))[1])])

        seen = {"load_course": "", "load_shock": ""}
        if (peak := most("load_course_load", of_load)) is not None:
            seen["load_course"] = stated("at most {}", amount(peak, of_load, setting))
        both = [[most(f"load_motion_{solver}{body}", "displacement") for body in (1, 2)] for solver in SOLVERS]
        tops = [max((each for each in of_one if each is not None), default=None) for of_one in both]
        seen["load_motion"] = of_both("at most", tops, "displacement", setting)
        forces = [most(f"load_force_{solver}", "force") for solver in SOLVERS]
        seen["load_force"] = of_both("at most", forces, "force", setting)
        first, second = (most(f"load_shock_{entry}", "acceleration") for entry in ("with", "without"))
        if first is not None:
            numbers = amount(first, "acceleration", setting, bare=True), amount(second, "acceleration", setting)
            seen["load_shock"] = stated("{}, without the stop {}", *numbers)
        return seen


def _curves(setting: Setting, result: PartialRuns) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """What is known of each curve, by its source."""
    known, response = result.curves, result.response
    names = {("load", "load"): "load_course_load"} | {
        (solver, "contact_force"): f"load_force_{solver}" for solver in SOLVERS
    }
    names |= {
        (solver, f"displacement{body}"): f"load_motion_{entry}"
        for entry, (solver, body) in _MOTIONS.items()
        if body == 1 or setting.bodies != "wall"
    }
    curves = {source: known[name] for name, source in names.items() if name in known}
    if response:
        curves["load_shock_with"] = response["ratio"], response["acceleration"]
        curves["load_shock_without"] = response["ratio"], response["acceleration_without"]
    return curves
