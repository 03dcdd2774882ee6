"""The motions of both solvers: phase plots, displacements over a strip of their contacts, and the contact force.

The force has an axis of impulses at the right, since the force of an impact is infinite.
"""

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, FactorRange, HBar, LegendItem, Line, Scatter, Segment
from bokeh.plotting import figure
from vibroscope.app.explorer.compute import SHOWN_PERIODS, shown_periods
from vibroscope.app.explorer.contact_count import contact_count, contact_share
from vibroscope.app.explorer.field_units import unit_of
from vibroscope.app.explorer.present import Columns, unit_factor
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.curves import AddedCurves, Axis, Curve, Curves, Plot, curve, inside
from vibroscope.app.page.shared.figure import (
    BARE,
    BLUE,
    INK,
    PARTS,
    PIN_NAMES,
    PINS,
    RIGHT,
    SOLUTIONS,
    SUBSCRIPTS,
    VERMILLION,
    add_glyph,
    divisor,
    hover_tool,
    label_of,
    make_figure,
    name_of_part,
    show_rows,
    symbols,
    time_label,
    write,
)
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.shared.ranges import extent, fitted_range
from vibroscope.app.page.shared.seen import amount, amplitude, apart, largest, of_both, say
from vibroscope.engine.facts import Statement, joined, stated

_CURVES = {f"{solver}{number}": (solver, number) for solver in SOLUTIONS for number in SUBSCRIPTS}
_DASHES = {1: "solid", 2: "dashed"}  # of the bodies
_THIN, _THIN_FROM = 1.0, 700  # px; points from which lines are thin, so that many loops do not merge into an area
_LABELS = {
    "relative": "displacements ξ₁, ξ₂",
    "absolute": "displacements with the base",
    "difference": "difference of ξ{number}",
}
_AT_WALL = "displacement ξ₁"  # relative to the base, which the wall stands on
_STRIP = "Contact strip"
_BARS = {"reference": (BLUE, None, 0.85), "penalty": (VERMILLION, "right_diagonal_line", 0.35)}  # of the strip
_NO_IMPULSE = 10.0  # end of the axis of impulses where there is none
_OVER_IMPULSES = 0.2  # free space above the impulses, relative to the largest
_WORDS = {"force": ("contact force", " λ"), "impulse": ("impulse", " ∫λ dτ")}  # and symbols, without units
_POINTS = {  # once a period
    "reference": {"marker": "circle", "size": 7, "fill_color": BLUE, "line_color": "white", "line_width": 0.8},
    "penalty": {"marker": "diamond", "size": 9, "fill_color": None, "line_color": VERMILLION, "line_width": 1.3},
}
_STEMS = {
    "reference": {"line_color": BLUE, "line_width": 2, "line_dash": "solid"},
    "penalty": {"line_color": VERMILLION, "line_width": 1, "line_dash": "dotted"},
}
_HEADS = {
    "reference": {"marker": "circle", "size": 7, "fill_color": BLUE, "line_color": BLUE, "line_width": 1.4},
    "penalty": {"marker": "diamond", "size": 11, "fill_color": None, "line_color": VERMILLION, "line_width": 1.4},
}


def _entry(solver: str, number: int) -> str:
    return f"ξ{SUBSCRIPTS[number]} {solver}"


def _phase(number: int) -> Plot:
    place = {"x": f"x{number}", "y": f"v{number}"}
    entries = {
        solver: (
            solver,
            [
                curve(Line, f"phase_{solver}", **place, **look),
                curve(Scatter, f"section_{solver}", **place, **_POINTS[solver], layer=1, hovered=True),
            ],
        )
        for solver, look in SOLUTIONS.items()
    }
    tips = {"displacement": f"@x{number}", "velocity": f"@v{number}"}
    room = {"min_border_left": 48}
    return Plot(f"Phase plot, body {number}", **place, entries=entries, tips=tips, legend=inside(3), room=room)


def _displacements() -> Plot:
    entries = {
        name: (
            _entry(solver, number),
            [curve(Line, "displacements", x="t", y=name, **SOLUTIONS[solver] | {"line_dash": _DASHES[number]})],
        )
        for name, (solver, number) in _CURVES.items()
    }
    entries |= {
        name: (name_of_part(name), [curve(Line, "difference", x="t", y=name, **look)]) for name, look in PARTS.items()
    }
    return Plot("Displacements", "time", "displacement", entries, legend=inside(8), room={"min_border_right": RIGHT})


def _stems(solver: str, layer: int) -> list[Curve]:
    source, more = f"impulse_{solver}", {"on_right": True, "layer": layer}
    return [
        curve(Segment, source, x0="t", y0=0, x1="t", y1="impulse", **_STEMS[solver], **more),
        curve(Scatter, source, x="t", y="impulse", **_HEADS[solver], **more),
    ]


def _force(solver: str, layer: int) -> list[Curve]:
    return [curve(Line, f"force_{solver}", x="t", y="force", **SOLUTIONS[solver], layer=layer)]


def _pin(number: int) -> AddedCurves:
    """The curves of a pinned result, below the live ones."""
    colour, dash = PINS[number]
    looks = {
        "reference": {"line_color": colour, "line_width": 3, "line_alpha": 0.35},
        "penalty": {"line_color": colour, "line_width": 1.6, "line_dash": dash},
    }

    def like(live: str, solver: str, x: str, y: str) -> Curve:
        return curve(Line, f"pinned{number + 1}_{live}", x=x, y=y, level="underlay", **looks[solver])

    lines = {f"phase{n}": [like(f"phase_{s}", s, f"x{n}", f"v{n}") for s in SOLUTIONS] for n in SUBSCRIPTS}
    lines["displacement"] = [like("displacements", solver, "t", name) for name, (solver, _) in _CURVES.items()]
    lines["force"] = [like(f"force_{solver}", solver, "t", "force") for solver in SOLUTIONS]
    return AddedCurves(PIN_NAMES[number], f"pin {number + 1}", lines)


def _closed() -> AddedCurves:
    """One cycle of a motion of a branch."""
    look = {"line_color": INK, "line_width": 1.8, "line_dash": "dotted"}
    lines = {f"phase{n}": [curve(Line, "phase_closed", x=f"x{n}", y=f"v{n}", **look)] for n in SUBSCRIPTS}
    return AddedCurves("branch", "branch", lines)


def _measured() -> AddedCurves:
    """The points of a measurement; over time those of body 2 are hollow."""
    look = {"size": 3, "line_color": INK, "line_width": 0.8}
    points = {
        f"phase{n}": [curve(Scatter, "measured_phase", x=f"x{n}", y=f"v{n}", fill_color=INK, **look)]
        for n in SUBSCRIPTS
    }
    fills = {"x1": INK, "x2": None}
    points["displacement"] = [
        curve(Scatter, "measured_time", x="t", y=name, fill_color=fill, **look) for name, fill in fills.items()
    ]
    return AddedCurves("measured", "measured", points)


class MotionView(Curves):
    """The five figures, and what is drawn beside both solutions in them: pins, a motion of a branch, a measurement."""

    axes = {  # noqa: RUF012 - read only
        "time": Axis(0, SHOWN_PERIODS),
        **{name: Axis(-8, 8) for name in ("x1", "x2")},
        **{name: Axis(-8, 8, headroom=0.16) for name in ("v1", "v2")},
        "displacement": Axis(-10, 10, headroom=0.16),
        "force": Axis(-1, 20, headroom=0.22),
        "impulse": Axis(-0.5, _NO_IMPULSE),
    }
    plots = {  # noqa: RUF012 - read only
        "phase1": _phase(1),
        "phase2": _phase(2),
        "displacement": _displacements(),
        "force": Plot(
            "Contact force",
            "time",
            "force",
            {
                "reference": ("reference", _force("reference", 1)),
                "reference_impulses": ("its impulses", _stems("reference", 3)),
                "penalty": ("penalty", _force("penalty", 0)),
                "penalty_impulses": ("its impulses", _stems("penalty", 2)),
            },
            legend=inside(5),
            right="impulse",
            room={"min_border_right": RIGHT},
        ),
    }
    beside = {  # noqa: RUF012 - read only
        **dict.fromkeys(("section_reference", "section_penalty"), ("eta",)),
        "displacements": tuple(f"{solver}_v{number}" for solver, number in _CURVES.values()),
        **dict.fromkeys(("strip_reference", "strip_penalty"), ("left", "right")),
    }

    def __init__(self) -> None:
        super().__init__()
        self.on_legend: Callable[[str, str, LegendItem], None] = lambda *_: None  # called with each new legend entry
        self.pins, self.closed, self.measured = [_pin(number) for number in range(len(PINS))], _closed(), _measured()
        self.added = [*self.pins, self.closed, self.measured]
        self._backgrounds: list[ColumnDataSource] = []  # of the strip
        for name in ("phase1", "phase2"):
            self.figures[name].xaxis.ticker.desired_num_ticks = 4  # narrow beside numbers such as −0.002
        for name in PARTS:
            self.items["displacement", name].visible = False
        self._hover_displacements()
        self._hover_forces()
        self.figures["strip"] = self._strip()

    def _hover_displacements(self) -> None:
        """Add a hover tool that follows a line without ink: were its renderers changed, Bokeh would walk all models."""
        unseen = Line(x="t", y=next(iter(_CURVES)), line_alpha=0)
        self._hovered = add_glyph(self.figures["displacement"], unseen, self.sources["displacements"])
        self._hover = hover_tool([self._hovered], {"time": "@t"}, mode="vline", line_policy="nearest")
        self._hover.formatters = {f"@{name}": "printf" for name in ("t", *_CURVES)}
        for name in _CURVES:  # a click in the legend
            line = self.items["displacement", name].renderers[0]
            line.on_change("visible", lambda attr, old, new: self._follow_visible())
        self.figures["displacement"].add_tools(self._hover)

    def _hover_forces(self) -> None:
        drawn = {"force": [], "impulse": []}
        for solver in reversed(SOLUTIONS):
            drawn["force"].append(self.items["force", solver].renderers[0])
            drawn["impulse"].append(self.items["force", f"{solver}_impulses"].renderers[1])
        self._hovers = {name: hover_tool(each, {"time": "@t", name: f"@{name}"}) for name, each in drawn.items()}
        self.figures["force"].add_tools(*self._hovers.values())

    def _follow_visible(self) -> None:
        """Let the hover tool follow the first line that is visible; it shows all four, which share their times."""
        lines = {name: self.items["displacement", name].renderers[0] for name in _CURVES}
        first = next((name for name, line in lines.items() if line.visible), "")
        self._hovered.visible = bool(first)
        if first and self._hovered.glyph.y != first:
            self._hovered.glyph.y = first

    def _strip(self) -> figure:
        axes = {"x_range": self.ranges["time"].range, "y_range": FactorRange("penalty", "reference")}
        room = {"min_border_right": RIGHT, "min_border_bottom": 4, "height": 70}
        plot = make_figure(_STRIP, name="strip", **axes, **room, **BARE)  # with a title for screen readers
        for solver, (colour, hatch, alpha) in _BARS.items():
            background = ColumnDataSource({"right": np.array([SHOWN_PERIODS], float)})
            self._backgrounds.append(background)
            where = {"y": value(solver), "right": "right", "height": 0.6}
            add_glyph(plot, HBar(left=0, fill_color="#F1F3F5", line_color=None, **where), background)
            # The outline keeps an impact visible, which has length zero.
            look = {"fill_color": colour, "fill_alpha": alpha, "line_color": colour, "line_width": 1.6}
            look |= {"hatch_pattern": hatch, "hatch_color": colour, "hatch_scale": 6, "hatch_weight": 1.2}
            add_glyph(plot, HBar(left="left", **where, **look), self.sources[f"strip_{solver}"])
        plot.title.visible = plot.xaxis.visible = False
        plot.ygrid.grid_line_color = None
        return plot

    def update(self, setting: Setting, *, fresh: bool) -> None:
        """Fit ranges, line widths and labels to the columns that the sources hold already."""
        self._update_phases(setting, fresh)
        self.update_displacements(setting, fresh)
        self._update_forces(setting, fresh)

    # -- phase plots -------------------------------------------------------------------

    def _update_phases(self, setting: Setting, fresh: bool) -> None:
        for number, sub in SUBSCRIPTS.items():
            name, columns = f"phase{number}", (f"x{number}", f"v{number}")
            plot = self.figures[name]
            labels = {
                label_of(setting, f"displacement ξ{sub}", "displacement"): f"@{columns[0]}",
                label_of(setting, f"velocity ξ{sub}′", "velocity"): f"@{columns[1]}",
            }
            plot.xaxis[0].axis_label, plot.yaxis[0].axis_label = labels
            show_rows(plot.hover[0], labels)
            seen = [amplitude(self.sources[f"phase_{solver}"].data[columns[0]]) for solver in SOLUTIONS]
            self.say(name, of_both("amplitude", seen, "displacement", setting), setting)
            for solver, look in SOLUTIONS.items():
                points = len(self.sources[f"phase_{solver}"].data["x1"])
                line = self.items[name, solver].renderers[0].glyph
                line.line_width = look["line_width"] if points <= _THIN_FROM else _THIN
            for side, column in zip("xy", columns, strict=True):
                self.follow(column, fresh=fresh, beside=self._beside(name, side))

    # -- beside both solutions ---------------------------------------------------------

    def draw_beside(
        self, pinned: Sequence[Mapping[str, Columns]], closed: Columns, measured: Mapping[str, Columns]
    ) -> list[AddedCurves]:
        """Draw pinned results, a motion of a branch and a measurement; returns the curves that are missing for that."""
        for number, pin in enumerate(self.pins):
            live = {name: name.partition("_")[2] for name in pin.sources} if number < len(pinned) else {}
            pin.show({name: pinned[number].get(source, {}) for name, source in live.items()})
        self.closed.show({"phase_closed": closed} if closed else {})
        self.measured.show({name: columns for name, columns in measured.items() if len(columns["x1"])})
        return [each for each in self.added if each.missing]

    def add(self, missing: Sequence[AddedCurves]) -> None:
        """Add these curves to the figures, unless they are there."""
        for curves in missing:
            is_new = not curves.items
            curves.add(self.figures)
            for name, item in curves.items.items() if is_new else ():
                self.on_legend(name, curves.entry, item)

    def _beside(self, name: str, side: str) -> list[np.ndarray]:
        return [column for curves in self.added for column in curves.along(name, side)]

    # -- displacements, or their difference ----------------------------------------------

    def update_displacements(self, setting: Setting, fresh: bool) -> None:
        """As `update`, for the displacements and the strip alone."""
        for background in self._backgrounds:
            write(background, {"right": np.array([shown_periods(setting) * setting.period], float)})
        self.figures["displacement"].xaxis[0].axis_label = time_label(setting)
        self._name_curves(setting)
        say(self.figures["strip"], _STRIP, self._seen_in_strip(setting))
        if setting.frame == "difference":
            return
        switched = self._switch(setting)
        drawn = self.sources["displacements"].data
        between = [drawn[f"reference{n}"] - drawn[f"penalty{n}"] for n in SUBSCRIPTS]
        self.say("displacement", apart(between, setting), setting)
        shown = [*(drawn[name] for name in _CURVES), *self._beside("displacement", "y")]
        self.ranges["displacement"].follow(shown, fresh=fresh or switched)

    def _name_curves(self, setting: Setting) -> None:
        """Legend and hover with the symbols and units that are shown."""
        unit = divisor(unit_of("displacement", setting))
        rows = {"time τ/T" if setting.scale is None else "time t / s": "@t"}
        for name, of in _CURVES.items():
            item, words = self.items["displacement", name], symbols(setting, _entry(*of))
            if item.label != value(words):
                item.label = value(words)
            rows[f"{words} / {unit}"] = f"@{name}"
        show_rows(self._hover, rows)

    def explain(self, series: dict[str, np.ndarray], setting: Setting) -> None:
        """Draw the parts of the difference, each (2, n), if they are to be shown; without ``series``, draw nothing."""
        if setting.frame != "difference":
            return
        switched = self._switch(setting)
        row = 0 if setting.coordinate == "xi1" else 1
        count = len(series["total"][row]) if series else 0
        factor = np.float32(unit_factor("displacement", setting))
        columns = {"t": np.linspace(0, shown_periods(setting) * setting.period, count, dtype=np.float32)}
        columns |= {
            name: factor * series[name][row] if name in series else np.full(count, np.nan, "f4") for name in PARTS
        }
        self.write("difference", columns)
        most = largest([columns["total"]])
        seen = "" if most is None else stated("up to {}", amount(most, "displacement", setting))
        say(self.figures["displacement"], "Difference", seen, setting)
        self.ranges["displacement"].follow([columns[name] for name in PARTS], fresh=switched)

    def _switch(self, setting: Setting) -> bool:
        """Show the displacements or their difference; returns whether that has changed the quantity of the axis."""
        words = _LABELS[setting.frame].format(number=SUBSCRIPTS[int(setting.coordinate[-1])])
        words = _AT_WALL if setting.bodies == "wall" and setting.frame == "relative" else words
        axis, label = self.figures["displacement"].yaxis[0], label_of(setting, words, "displacement")
        switched, differs = axis.axis_label != label, setting.frame == "difference"
        axis.axis_label = label
        for name, (_, number) in _CURVES.items():
            absent = number == 2 and setting.bodies == "wall"
            show_entry(self.items["displacement", name], not (differs or absent))
        for name in PARTS:
            show_entry(self.items["displacement", name], differs)
        self._follow_visible()
        for curves in self.added:
            curves.draw("displacement", not differs)
        return switched

    def _seen_in_strip(self, setting: Setting) -> str:
        """How often each solution is in contact, and for how long."""

        def words(solver: str) -> str:
            spans = self.sources[f"strip_{solver}"].data
            length = shown_periods(setting) * setting.period
            number = contact_count(**spans, length=length, rigid=solver == "reference")
            return f"{solver} {number}, {contact_share(**spans, length=length)} of the time"

        return "; ".join(map(words, SOLUTIONS))

    # -- the contact force ---------------------------------------------------------------

    def _update_forces(self, setting: Setting, fresh: bool) -> None:
        """Zero force is always in view."""
        plot = self.figures["force"]
        plot.xaxis[0].axis_label = time_label(setting)
        labels = {
            name: label_of(setting, words + (symbol if setting.scale is None else ""), name)
            for name, (words, symbol) in _WORDS.items()
        }
        if setting.stops == "two":
            labels["force"] += ", below 0: second stop"
        plot.yaxis[0].axis_label, plot.right[0].axis_label = labels.values()
        # A located step resolves contacts that are shorter than the samples: their mean is drawn.
        mean = ", its mean where a contact is too short to sample" if setting.located == "yes" else ""
        time = "time τ/T" if setting.scale is None else "time t / s"
        for name, tool in self._hovers.items():
            show_rows(tool, {time: "@t", labels[name] + (mean if name == "force" else ""): f"@{name}"})
        forces, impulses = (
            [self.sources[f"{name}_{solver}"].data[name] for solver in SOLUTIONS] for name in ("force", "impulse")
        )
        self.say("force", _seen(forces, impulses, setting), setting)
        # in view at least, where there is no contact, too; the forces of some systems are far below it
        one = min(largest(forces) or math.inf, unit_factor("force", setting))
        always = -one if setting.stops == "two" else 0.0, one
        self.follow("force", fresh=fresh, beside=self._beside("force", "y"), always=always)
        self._follow_impulses(impulses, fresh)

    def _follow_impulses(self, impulses: list, fresh: bool) -> None:
        """Fit the range of the impulses so that both axes have their zero at the same height."""
        low, high = self.ranges["force"].home
        ends = extent(impulses)
        most = max(ends[1], ends[0] * high / low) if ends else 0.0  # those at a second stop are negative
        top = fitted_range((0.0, most), _OVER_IMPULSES)[1] if ends else _NO_IMPULSE
        self.ranges["impulse"].put(top * low / high, top, fresh=fresh)


def _seen(forces: list, impulses: list, setting: Setting) -> str | Statement:
    """The largest force of each solution that has one, and the largest impulses."""
    most = [largest([force]) or None for force in forces]
    struck = [largest([impulse]) or None for impulse in impulses]
    parts = [of_both("up to", most, "force", setting), of_both("impulse up to", struck, "impulse", setting)]
    return joined("; ", filter(None, parts)) or "no contact"
