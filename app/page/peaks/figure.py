"""Two spectra over orders of the excitation frequency: of a motion, and of the contact force, of both solutions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from bokeh.models import Line
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.curves import Axis, Curves, Plot, curve
from vibroscope.app.page.shared.figure import SOLUTIONS
from vibroscope.app.studies.peaks import SOLVERS, PartialPeaks
from vibroscope.engine import written
from vibroscope.engine.facts import Amount, Statement, joined, stated

HIGHEST = 20.0  # order of `engine.spectrum`
SHOWN = 1e-5  # of the largest amplitude: what is smaller would only stretch the axis
# What can be drawn: its words in a label, and its quantity.
DRAWN = {
    "displacement1": ("displacement ξ₁ with the base", "displacement"),
    "displacement2": ("displacement ξ₂ with the base", "displacement"),
    "acceleration1": ("absolute acceleration of body 1", "acceleration"),
    "acceleration2": ("absolute acceleration of body 2", "acceleration"),
    "contact_force": ("contact force λ", "force"),
}


def _spectrum(kind: str, title: str) -> Plot:
    place = {"x": "order", "y": "amplitude", "hovered": True}
    entries = {
        solver: (solver, [curve(Line, f"spectrum_{kind}_{solver}", **place, **look)])
        for solver, look in SOLUTIONS.items()
    }
    tips = {"order": "@order", "amplitude, without dimension": "@amplitude"}
    return Plot(title, "order", kind, entries, tips, {"mode": "vline", "line_policy": "nearest"})


def _amplitudes(name: str) -> Axis:
    return Axis(1e-3, 10.0, *DRAWN[name], logarithmic=True, fit=lambda least, most: (SHOWN * most, 8 * most))


class SpectrumView(Curves):
    """The spectra of a motion and of the contact force, which share the axis of orders."""

    axes = {  # noqa: RUF012 - read only
        "order": Axis(0, HIGHEST, "order: frequency relative to the excitation"),
        "motion": _amplitudes("displacement1"),
        "force": _amplitudes("contact_force"),
    }
    plots = {  # noqa: RUF012 - read only
        "spectrum_motion": _spectrum("motion", "Spectrum of the motion"),
        "spectrum_force": _spectrum("force", "Spectrum of the contact force"),
    }

    def update(self, setting: Setting, quantity: str, result: PartialPeaks | None) -> None:
        """Draw the spectra of ``quantity``, a key of `DRAWN`, and of the contact force, as far as they are known."""
        fresh = self.changes_to(result and (result.question, quantity)) and result is not None
        self.label(setting, _of_one_body if setting.bodies == "wall" else str, motion=DRAWN[quantity])
        read = {} if result is None else {solver: each.amplitudes for solver, each in result.found.items()}
        known = {solver: each for solver, each in read.items() if each}
        for kind, name in (("motion", quantity), ("force", "contact_force")):
            self._draw(kind, known, name)
            self.say(f"spectrum_{kind}", _seen(known, name, DRAWN[name][1]), setting)
        self.follow("motion", "force", fresh=fresh)

    def _draw(self, kind: str, columns: Mapping[str, Mapping[str, np.ndarray]], name: str) -> None:
        top = max((each[name].max() for each in columns.values()), default=0.0)
        for solver in SOLVERS:
            drawn = columns.get(solver) if top > 0 else None
            shown = drawn and {"order": drawn["order"], "amplitude": np.maximum(drawn[name], SHOWN * top)}
            self.write(f"spectrum_{kind}_{solver}", shown or {})


def _of_one_body(words: str) -> str:
    """A label where there is no second body."""
    return words.replace("ξ₁", "ξ").replace(" of body 1", "")


def _seen(columns: Mapping[str, Mapping[str, np.ndarray]], name: str, quantity: str) -> Statement:
    """The largest amplitude of each solution beside its mean, which is that of order 0, and its order."""
    tops = {solver: int(np.argmax(each[name] * (each["order"] > 0))) for solver, each in columns.items()}
    return joined(
        "; ",
        (
            stated(
                f"{solver} largest at order {written(float(columns[solver]['order'][at]), 3)}, {{}}",
                Amount(float(columns[solver][name][at]), quantity, 3),
            )
            for solver, at in tops.items()
            if columns[solver][name][at] > 0
        ),
    )
