"""The motion of a code over the reference: phase plot and displacement of the observed body."""

from __future__ import annotations

import numpy as np
from bokeh.models import Line, Scatter
from vibroscope.app.explorer.compute import RunPair
from vibroscope.app.explorer.present import WINDOW, present
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.curves import Axis, Curve, Curves, Plot, curve
from vibroscope.app.page.shared.figure import BLUE, SOLUTIONS, SUBSCRIPTS, VERMILLION, label_of, time_label
from vibroscope.app.page.shared.seen import amplitude, apart, of_both, say

_DOTS = {
    "reference": {"marker": "circle", "line_color": BLUE, "fill_color": BLUE},
    "penalty": {"marker": "diamond", "line_color": VERMILLION, "fill_color": None},
}


def _phase(solver: str) -> list[Curve]:
    line = curve(Line, f"code_phase_{solver}", x="x", y="v", **SOLUTIONS[solver])
    return [line, curve(Scatter, f"code_section_{solver}", x="x", y="v", size=8, **_DOTS[solver])]


class YourCodeView(Curves):
    """Two figures; at a wall they show body 1, else body 2."""

    axes = {  # noqa: RUF012 - read only
        "x": Axis(-8, 8),
        "v": Axis(-8, 8, headroom=0.16),
        "time": Axis(0, WINDOW),
        "displacement": Axis(-8, 8, headroom=0.16),
    }
    plots = {  # noqa: RUF012 - read only
        "code_phase": Plot("Phase plot", "x", "v", {solver: (solver, _phase(solver)) for solver in SOLUTIONS}),
        "code_displacement": Plot(
            "Displacement",
            "time",
            "displacement",
            {
                solver: (solver, [curve(Line, f"code_trace_{solver}", x="t", y="x", **look)])
                for solver, look in SOLUTIONS.items()
            },
        ),
    }

    def update(self, setting: Setting, runs: RunPair | None, title: str) -> None:
        """Draw runs in the units of the setting; None: nothing is known yet."""
        body = setting.system.observed_body
        sub = SUBSCRIPTS[body]
        phase, displacement = self.figures.values()
        position = label_of(setting, f"displacement ξ{sub}", "displacement")
        phase.xaxis[0].axis_label = displacement.yaxis[0].axis_label = position
        phase.yaxis[0].axis_label = label_of(setting, f"velocity ξ{sub}′", "velocity")
        displacement.xaxis[0].axis_label = time_label(setting)
        name = f"{title}, body {body}"
        if runs is None:
            say(phase, name)
            return
        columns, fresh = present(RunPair(setting, runs.reference, runs.penalty)), self.changes_to(runs.setting)
        for solver in SOLUTIONS:
            for kind in ("phase", "section"):
                of = columns[f"{kind}_{solver}"]
                self.write(f"code_{kind}_{solver}", {"x": of[f"x{body}"], "v": of[f"v{body}"]})
            of = columns["displacements"]
            self.write(f"code_trace_{solver}", {"t": of["t"], "x": of[f"{solver}{body}"]})
        swings, traces = (
            [self.sources[f"code_{kind}_{s}"].data["x"] for s in SOLUTIONS] for kind in ("phase", "trace")
        )
        say(phase, name, of_both("amplitude", [*map(amplitude, swings)], "displacement", setting), setting)
        self.say("code_displacement", apart([np.subtract(*traces)], setting), setting)
        self.ranges["time"].put(0, WINDOW * setting.period, fresh=fresh)
        self.follow("x", "v", "displacement", fresh=fresh)
