"""Phase plots of both pendulums: velocity over displacement, the Poincaré section marked."""

from __future__ import annotations

from bokeh.models import LegendItem, Line, Scatter
from vibroscope.app.explorer.present import Columns
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import (
    BLUE,
    PENALTY,
    PINNED,
    REFERENCE,
    VERMILLION,
    Ghost,
    draw,
    legend,
    make_figure,
    sources,
    tips,
)
from vibroscope.app.page.shared.ranges import OwnedRange

_SUBSCRIPT = {1: "₁", 2: "₂"}
_WIDTHS = {"reference": REFERENCE["line_width"], "penalty": PENALTY["line_width"]}
_SLIM, _SLIM_FROM = 1.0, 700


class PhaseView:
    """Two figures over the same four sources."""

    def __init__(self) -> None:
        self.sources = sources(
            {
                "phase_reference": ("x1", "v1", "x2", "v2"),
                "phase_penalty": ("x1", "v1", "x2", "v2"),
                "section_reference": ("eta", "x1", "v1", "x2", "v2"),
                "section_penalty": ("eta", "x1", "v1", "x2", "v2"),
            }
        )
        self.sections = {name: self.sources[name] for name in ("section_reference", "section_penalty")}
        self.ghost = Ghost("phase_reference", "phase_penalty")
        self.ranges = {name: OwnedRange(-8, 8) for name in ("x1", "x2")}
        self.ranges |= {name: OwnedRange(-8, 8, headroom=0.16) for name in ("v1", "v2")}
        self._lines: list = []
        self.figures = [self._figure(1), self._figure(2)]

    def _figure(self, number: int):
        plot = make_figure(
            f"Phase plot, pendulum {number}",
            "",
            "",
            name=f"phase{number}",
            x_range=self.ranges[f"x{number}"].range,
            y_range=self.ranges[f"v{number}"].range,
            min_border_left=48,
        )
        x, y = f"x{number}", f"v{number}"
        ghosts = [
            draw(plot, Line(x=x, y=y, **look), self.ghost.of(self.sources[f"phase_{solver}"]))
            for solver, look in PINNED.items()
        ]
        reference = draw(plot, Line(x=x, y=y, **REFERENCE), self.sources["phase_reference"])
        penalty = draw(plot, Line(x=x, y=y, **PENALTY), self.sources["phase_penalty"])
        self._lines += [(reference, "reference"), (penalty, "penalty")]
        dot = Scatter(x=x, y=y, marker="circle", size=7, fill_color=BLUE, line_color="white", line_width=0.8)
        ring = Scatter(x=x, y=y, marker="diamond", size=9, fill_color=None, line_color=VERMILLION, line_width=1.3)
        dots = draw(plot, dot, self.sources["section_reference"])
        rings = draw(plot, ring, self.sources["section_penalty"])
        plot.add_layout(
            legend(
                [
                    LegendItem(label="reference", renderers=[reference, dots]),
                    LegendItem(label="penalty", renderers=[penalty, rings]),
                    self.ghost.item(ghosts),
                ],
                3,
            )
        )
        plot.add_tools(
            tips([dots, rings], {"at τ ≡ 0 (mod T)": f"displacement @{x}, velocity @{y}"}),
        )
        return plot

    def _label(self, setting: Setting) -> None:
        physical = setting.scale is not None
        for figure, sub in zip(self.figures, _SUBSCRIPT.values(), strict=True):
            figure.xaxis[0].axis_label = f"displacement {f'x{sub} / mm' if physical else f'ξ{sub} / base amplitude'}"
            figure.yaxis[0].axis_label = f"velocity {f'x{sub}′ / (mm/s)' if physical else f'ξ{sub}′'}"

    def update(self, columns: dict[str, Columns], setting: Setting, *, fresh: bool) -> None:
        """Of columns that the sources hold by now: ranges follow by their rule, labels say the units."""
        self._label(setting)
        for line, solver in self._lines:
            # A band of many loops must stay a band of lines, not become a smear.
            loops = len(columns[f"phase_{solver}"]["x1"]) / _SLIM_FROM
            line.glyph.line_width = _WIDTHS[solver] if loops <= 1 else _SLIM
        for name, owned in self.ranges.items():
            owned.follow([columns[s][name] for s in self.sources], fresh=fresh)
