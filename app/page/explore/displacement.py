"""Displacements over two periods, and a strip that shows contact as the paper's sensor does."""

from __future__ import annotations

import numpy as np
from bokeh.core.properties import value
from bokeh.models import ColumnDataSource, FactorRange, HBar, LegendItem, Line, Range1d
from vibroscope.app.explorer.present import WINDOW, Columns, factor_of
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import (
    BLUE,
    PARTS,
    PENALTY,
    PINNED,
    REFERENCE,
    RIGHT,
    VERMILLION,
    Ghost,
    draw,
    empty,
    legend,
    make_figure,
    sources,
    time_label,
    tips,
    write,
)
from vibroscope.app.page.shared.ranges import OwnedRange

_NAMES = {
    "total": "difference",
    "time_step": "time step",
    "regularisation": "K and D",
    "joint_damping": "joint damping",
}
_LABELS = {
    "relative": ("ξ / base amplitude", "x / mm"),
    "absolute": ("(ξ + cos ητ) / base amplitude", "(x + A cos Ωt) / mm"),
    "difference": ("Δξ{number} / base amplitude", "Δx{number} / mm"),
}


class DisplacementView:
    """The displacement figure and the contact strip below it, on one time axis."""

    def __init__(self, time: Range1d) -> None:
        self.sources = sources(
            {
                "displacements": (
                    "t",
                    *(f"{s}{k}" for s in ("reference", "penalty") for k in ("1", "2", "_v1", "_v2")),
                ),
                "strip_reference": ("left", "right"),
                "strip_penalty": ("left", "right"),
            }
        )
        self.ghost = Ghost("displacements")
        self.difference = empty("difference", "t", *PARTS)
        self._items: dict[str, list[LegendItem]] = {}  # what is seen with displacements, and with their difference
        self._grounds: list = []  # below the intervals of contact
        self.range = OwnedRange(-10, 10, headroom=0.16)
        self.figure = self._displacement(time)
        self.strip = self._strip(time)

    def _displacement(self, time: Range1d):
        plot = make_figure(
            "Displacements",
            "",
            "",
            name="displacement",
            x_range=time,
            y_range=self.range.range,
            min_border_right=RIGHT,
        )
        ghost = self.ghost.of(self.sources["displacements"])
        ghosts = [
            draw(plot, Line(x="t", y=f"{solver}{number}", **look), ghost)
            for solver, look in PINNED.items()
            for number in (1, 2)
        ]
        items = []
        for solver, look in (("reference", REFERENCE), ("penalty", PENALTY)):
            for number, dash in ((1, "solid"), (2, "dashed")):
                glyph = Line(x="t", y=f"{solver}{number}", **(look | {"line_dash": dash}))
                line = draw(plot, glyph, self.sources["displacements"])
                items.append(LegendItem(label=f"ξ{'₁₂'[number - 1]} {solver}", renderers=[line]))
        parts = [
            LegendItem(
                label=_NAMES[name],
                visible=False,
                renderers=[draw(plot, Line(x="t", y=name, **look), self.difference, visible=False)],
            )
            for name, look in PARTS.items()
        ]
        self._items = {"displacements": items, "difference": parts}
        self._ghosts = ghosts
        plot.add_layout(legend([*items, *parts, self.ghost.item(ghosts)], 9))
        # One line carries the hover for all four: they share their times.
        plot.add_tools(
            tips(
                [items[0].renderers[0]],
                {
                    "time": "@t",
                    "reference": "① @reference1, ② @reference2",
                    "penalty": "① @penalty1, ② @penalty2",
                },
                mode="vline",
                line_policy="nearest",
            ),
        )
        return plot

    def _strip(self, time: Range1d):
        plot = make_figure(
            "",
            "",
            "",
            name="strip",
            x_range=time,
            y_range=FactorRange("penalty", "reference"),
            min_border_right=RIGHT,
            min_border_bottom=4,
            tools="",
            active_drag=None,
            toolbar_location=None,
            height=70,
        )
        for solver, colour, hatch in (("reference", BLUE, None), ("penalty", VERMILLION, "right_diagonal_line")):
            # An impact has no length: its outline keeps it visible.
            ground = ColumnDataSource({"right": np.array([WINDOW], float)})
            self._grounds.append(ground)
            where = {"y": value(solver), "right": "right", "height": 0.6}
            draw(plot, HBar(left=0, fill_color="#F1F3F5", line_color=None, **where), ground)
            bar = HBar(
                left="left",
                fill_color=colour,
                line_color=colour,
                line_width=1.6,
                fill_alpha=0.85 if hatch is None else 0.35,
                hatch_pattern=hatch,
                hatch_color=colour,
                hatch_scale=6,
                hatch_weight=1.2,
                **where,
            )
            draw(plot, bar, self.sources[f"strip_{solver}"])
        plot.xaxis.visible = False
        plot.ygrid.grid_line_color = None
        return plot

    def update(self, columns: dict[str, Columns], setting: Setting, *, fresh: bool) -> None:
        """Of columns that the sources hold by now: the range follows, the label says what is shown."""
        for ground in self._grounds:
            write(ground, {"right": np.array([WINDOW * setting.period], float)})
        self.figure.xaxis[0].axis_label = time_label(setting)
        if setting.frame == "difference":
            return
        turned = self._turn(setting)
        shown = [columns["displacements"][f"{solver}{n}"] for solver in ("reference", "penalty") for n in (1, 2)]
        self.range.follow(shown, fresh=fresh or turned)

    def explain(self, series: dict[str, np.ndarray], setting: Setting) -> None:
        """Write the difference in parts, each (2, n), if it is shown; without a ``series`` nothing is drawn."""
        if setting.frame != "difference":
            return
        turned = self._turn(setting)
        row = 0 if setting.coordinate == "xi1" else 1
        count = len(series["total"][row]) if series else 0
        factor = np.float32(factor_of("displacement", setting))
        columns = {"t": np.linspace(0, WINDOW * setting.period, count, dtype=np.float32)}
        columns |= {
            name: factor * series[name][row] if name in series else np.full(count, np.nan, "f4") for name in PARTS
        }
        write(self.difference, columns)
        self.range.follow([columns[name] for name in PARTS], fresh=turned)

    def _turn(self, setting: Setting) -> bool:
        """Show the displacements or their difference; whether that is something else than before."""
        label = _LABELS[setting.frame][setting.scale is not None].format(
            number="₁" if setting.coordinate == "xi1" else "₂"
        )
        turned = self.figure.yaxis[0].axis_label != label
        self.figure.yaxis[0].axis_label = label
        for kind, items in self._items.items():
            seen = (kind == "difference") == (setting.frame == "difference")
            for item in items:
                item.visible = seen
                for line in item.renderers:
                    line.visible = seen
        for line in self._ghosts:
            line.visible = setting.frame != "difference"
        self.figure.title.text = "Penalty − reference, in parts" if setting.frame == "difference" else "Displacements"
        return turned
