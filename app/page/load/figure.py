"""The load over time, displacements and contact force of both solutions, and the shock response over frequency."""

from __future__ import annotations

import numpy as np
from bokeh.core.properties import value
from bokeh.models import LegendItem, Line
from bokeh.plotting import figure
from vibroscope.app.explorer.present import as_float32
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import (
    INK,
    SOLUTIONS,
    SUBSCRIPTS,
    VIOLET,
    add_glyph,
    axes_of,
    empty_source,
    hover_tool,
    legend,
    make_figure,
    quantity_axis,
    symbols,
    write,
)
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.shared.ranges import OwnedRange, UnitAxis, extent
from vibroscope.app.page.shared.seen import amount, largest, of_both, say
from vibroscope.app.studies.load import RATIOS, PartialRuns
from vibroscope.app.studies.peaks import SOLVERS
from vibroscope.engine.facts import Statement, stated
from vibroscope.engine.load import ON, quantity_of

_TITLES = {
    "load_course": "Load",
    "load_motion": "Displacements",
    "load_force": "Contact force",
    "load_shock": "Shock response",
}
# Curves of each figure by their names in a link, as the legend has them.
LEGENDS = {
    "load_course": {"load": "load"},
    "load_motion": {f"{solver}{body}": f"ξ{SUBSCRIPTS[body]} {solver}" for solver in SOLVERS for body in (1, 2)},
    "load_force": dict(zip(SOLVERS, SOLVERS, strict=True)),
    "load_shock": {"with": "with the stop", "without": "without it"},
}
AXES = ("time", "load", "motion", "force", "ratio", "response")
_VALUES = {"load_course": "load", "load_motion": "motion", "load_force": "force"}  # axis of each figure over time


class LoadView:
    """Four figures, three of them with one axis of time."""

    def __init__(self) -> None:
        self.sources = {
            (name, entry): empty_source(f"{name}_{entry}", "x", "y")
            for name, entries in LEGENDS.items()
            for entry in entries
        }
        self.ranges = {name: OwnedRange(0.0, 1.0) for name in AXES}
        self.ranges["ratio"] = OwnedRange(float(RATIOS[0]), float(RATIOS[-1]))
        self._items: dict[tuple[str, str], LegendItem] = {}
        self.figures = {name: self._build(name) for name in _TITLES}
        over_time = [self.figures[name] for name in _VALUES]
        self._axes = {"time": UnitAxis(self.ranges["time"], "x", *over_time)}
        self._axes |= {axis: UnitAxis(self.ranges[axis], "y", self.figures[name]) for name, axis in _VALUES.items()}
        self._axes["ratio"] = UnitAxis(self.ranges["ratio"], "x", self.figures["load_shock"])
        self._axes["response"] = UnitAxis(self.ranges["response"], "y", self.figures["load_shock"])
        self._drawn: object = None  # question

    def _build(self, name: str) -> figure:
        x, y = ("time", _VALUES[name]) if name in _VALUES else ("ratio", "response")
        axes = axes_of(self.ranges, x, y, "x" if x == "ratio" else "")
        plot = make_figure(_TITLES[name], name=name, **axes)
        lines = []
        for entry, words in LEGENDS[name].items():
            look = SOLUTIONS.get(
                entry.rstrip("12"), {"line_color": VIOLET if entry == "without" else INK, "line_width": 2}
            )
            if entry.endswith("2") or entry == "without":
                look = look | {"line_dash": "dashed"}
            lines.append(add_glyph(plot, Line(x="x", y="y", **look), self.sources[name, entry]))
            self._items[name, entry] = LegendItem(label=words, renderers=lines[-1:])
        if len(lines) > 1:
            plot.add_layout(legend([self._items[name, entry] for entry in LEGENDS[name]]))
        plot.add_tools(hover_tool(lines, {"at": "@x", "value, without dimension": "@y"}))
        return plot

    def update(self, setting: Setting, result: PartialRuns | None) -> None:
        """Draw what is known."""
        self._label(setting, "base" if result is None else result.question.source.on)
        if result is None:
            return
        if result.load is None:
            for source in self.sources.values():
                write(source, as_float32({"x": np.empty(0), "y": np.empty(0)}))
            return
        fresh, self._drawn = self._drawn != result.question, result.question
        bodies = (1,) if setting.bodies == "wall" else (1, 2)
        known, response, nothing = result.curves, result.response, (np.empty(0), np.empty(0))
        curves = {("load_course", "load"): known["load", "load"]}
        for solver in SOLVERS:
            curves["load_force", solver] = known.get((solver, "contact_force"), nothing)
            for body in bodies:
                curves["load_motion", f"{solver}{body}"] = known.get((solver, f"displacement{body}"), nothing)
        if response:
            curves["load_shock", "with"] = response["ratio"], response["acceleration"]
            curves["load_shock", "without"] = response["ratio"], response["acceleration_without"]
        drawn = {key: curves.get(key, nothing) for key in self.sources}
        for key, (x, y) in drawn.items():
            write(self.sources[key], as_float32({"x": x, "y": y}))
        for name, axis in (*_VALUES.items(), ("load_shock", "response")):
            of_figure = [each for key, each in drawn.items() if key[0] == name]
            self.ranges[axis].follow([y for _, y in of_figure], fresh=fresh)
        self.ranges["time"].put(0.0, float(known["load", "load"][0][-1]), fresh=fresh)
        for name, seen in self._seen(setting, result.load.on, drawn).items():
            say(self.figures[name], _TITLES[name], seen, setting)

    def _label(self, setting: Setting, on: str) -> None:
        labels = {
            "time": ("time τ", "time"),
            "load": (ON[on], quantity_of(on)),
            "motion": ("displacement ξ" if setting.bodies == "wall" else "displacements ξ₁, ξ₂", "displacement"),
            "force": ("contact force λ", "force"),
            "ratio": ("natural frequency of body 1", "frequency"),
            "response": ("largest acceleration", "acceleration"),
        }
        for axis, (text, quantity) in labels.items():
            self._axes[axis].show(*quantity_axis(setting, text, quantity))
        for entry, words in LEGENDS["load_motion"].items():
            item, wall = self._items["load_motion", entry], setting.bodies == "wall"
            item.label = value(symbols(setting, words.replace("₁", "") if wall else words))
            show_entry(item, not (wall and entry.endswith("2")))
        if setting.scale is None:
            self._axes["time"].show("time τ", 1.0)
            self._axes["ratio"].show("natural frequency of body 1 / ω₁", 1.0)

    def _seen(self, setting: Setting, on: str, drawn: dict) -> dict[str, str | Statement]:
        """What is seen in each figure."""
        of_load = quantity_of(on)
        quantities = {"load_course": of_load, "load_motion": "displacement", "load_force": "force"}
        quantities |= {"load_shock": "acceleration"}
        scale = setting.scale  # columns have no dimension, and the axes have the units
        factors = {name: scale.factor(each) if scale else 1.0 for name, each in quantities.items()}
        peaks = {key: largest([factors[key[0]] * y]) for key, (_, y) in drawn.items()}
        seen = {"load_course": "", "load_shock": ""}
        if (peak := peaks["load_course", "load"]) is not None:
            seen["load_course"] = stated("at most {}", amount(peak, of_load, setting))
        both = [[peaks["load_motion", f"{solver}{body}"] for body in (1, 2)] for solver in SOLVERS]
        tops = [max((each for each in of_one if each is not None), default=None) for of_one in both]
        seen["load_motion"] = of_both("at most", tops, "displacement", setting)
        forces = [peaks["load_force", solver] for solver in SOLVERS]
        seen["load_force"] = of_both("at most", forces, "force", setting)
        if extent([drawn["load_shock", "with"][1]]) is not None:
            first, second = (peaks["load_shock", entry] for entry in ("with", "without"))
            numbers = amount(first, "acceleration", setting, bare=True), amount(second, "acceleration", setting)
            seen["load_shock"] = stated("{}, without the stop {}", *numbers)
        return seen
