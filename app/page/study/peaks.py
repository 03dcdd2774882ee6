"""Peaks and spectra: the largest values of both solutions and how far they differ, and their spectra."""

from collections.abc import Iterable, Mapping

import numpy as np
from bokeh.models import Line
from vibroscope.app.explorer.field_units import unit_of
from vibroscope.app.explorer.link import ViewChoice
from vibroscope.app.explorer.state import SOLVERS, Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import peaks_command, peaks_python
from vibroscope.app.page.shared.curves import Axis, Curves, Plot, curve
from vibroscope.app.page.shared.figure import SOLUTIONS, divisor
from vibroscope.app.page.study.listed import row
from vibroscope.app.page.study.tab import StudyView, free_obstacle
from vibroscope.app.studies.load import PartialRuns
from vibroscope.app.studies.peaks import (
    MOTIONS,
    PartialPeaks,
    PeaksQuestion,
    difference_text,
    grow_peaks,
    has_impacts,
    impacts_note,
    kept_text,
)
from vibroscope.engine import PEAKS, written
from vibroscope.engine.facts import Amount, Statement, joined, sentence, stated

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


_NAMES = {
    "displacement1": "displacement, body 1",
    "displacement2": "displacement, body 2",
    "velocity1": "velocity, body 1",
    "velocity2": "velocity, body 2",
    "acceleration1": "acceleration, body 1",
    "acceleration2": "acceleration, body 2",
    "penetration": "penetration",
    "contact_force": "contact force",
    "impulse": "impulse of a contact",
    "closing_speed": "closing speed",
    "contact_time": "time in a contact",
}
_NONE = "–"
_SPECTRA = {f"{kind}{body}": f"{kind} of body {body}" for kind in ("displacement", "acceleration") for body in (1, 2)}


class Peaks(StudyView):
    """The table, and the spectra of a motion and of the contact force."""

    key = "peaks"
    title = "Peaks and spectra"
    starts = True
    grow = staticmethod(grow_peaks)
    drawn, place, listed = SpectrumView, "tall", "Largest values of both solutions"
    quantities = PEAKS
    python, command = staticmethod(peaks_python), staticmethod(peaks_command)
    choices = (
        ViewChoice("quantity", "Spectrum of", "displacement1", _SPECTRA, of_body_2=("displacement2", "acceleration2")),
    )
    hint = (
        "Peaks: displacements and velocities relative to the base, accelerations absolute. Spectra: with the base "
        "motion; a motion that repeats every n periods has lines at multiples of 1/n."
    )
    pictures = (
        Figure("peaks", "Peaks", "Largest values of both solutions.", drawn=False),
        Figure("spectrum_motion", "Spectrum of the motion", "Amplitudes of a body over orders of the excitation."),
        Figure("spectrum_force", "Spectrum of the force", "Amplitudes of the contact force over orders."),
    )

    def obstacle(self, setting: Setting) -> str:
        """Where nothing drives bodies at rest, nothing moves."""
        return free_obstacle(setting, "this table") if setting.from_rest else ""

    def question(self, setting: Setting) -> PeaksQuestion:
        """All that is set but how it is drawn."""
        return PeaksQuestion(setting.system, setting.eta, setting.reference, setting.penalty, setting.initial)

    @property
    def _quantity(self) -> str:
        """What the first spectrum is of; at a wall, of the body that moves."""
        chosen = self.panel.chosen["quantity"]
        return chosen.replace("2", "1") if self._move.setting.bodies == "wall" else chosen

    def draw(self, setting: Setting, result: PartialPeaks | None) -> None:
        """Spectra and table."""
        self.view.update(setting, self._quantity, result)
        known = result is not None
        table = peak_table(result, setting) if known else {}
        self.list.param.update(near=table, status={"text": _over(setting)}, visible=known)

    def describe(self, setting: Setting, result: PartialPeaks) -> list[list[str | Statement]]:
        """Transmissibility, and why a solution has no numbers."""
        lines = [
            [f"{solver.capitalize()} solution", sentence(read.ended)]
            for solver, read in result.found.items()
            if read.ended
        ]
        bodies = (1,) if setting.bodies == "wall" else (1, 2)
        known = {
            solver: " and ".join(f"{read.transmissibility[body - 1]:.3g} (body {body})" for body in bodies)
            for solver, read in result.found.items()
            if np.isfinite(read.transmissibility).all()
        }
        if known:
            text = "; ".join(f"{solver} {numbers}" for solver, numbers in known.items())
            lines.append(["Transmissibility at the excitation frequency", f"{text}."])
        whole = "penalty" in result.found and all(not read.ended for read in result.found.values())
        if text := impacts_note(result.found["reference"].peaks) if whole else "":
            lines.append(["No number", text])
        return lines or [["Both solutions", stated("The table shows the largest values.")]]

    def table(self, name: str) -> list[Series]:
        """The peaks, or a spectrum, of each solution in the units that are shown."""
        found = self.result.found.items()
        if name == "peaks":
            return [
                Series(solver, {head: np.array([peak]) for head, peak in self._shown_in_units(read.peaks).items()})
                for solver, read in found
            ]
        names = self._moving(("order", *MOTIONS) if name == "spectrum_motion" else ("order", "contact_force"))
        series = (
            Series(solver, {each: read.amplitudes[each] for each in names}) for solver, read in found if read.amplitudes
        )
        return [each._replace(columns=self._shown_in_units(each.columns)) for each in series]

    def data(self) -> dict[str, object]:
        """All numbers of both solutions, in the units that are shown."""
        return {
            solver: {
                "peaks": self._shown_in_units(read.peaks),
                "spectrum": self._shown_in_units(read.amplitudes),
                "transmissibility": read.transmissibility,
            }
            for solver, read in self.result.found.items()
        }

    def _shown_in_units(self, data: Mapping[str, object]) -> dict[str, object]:
        """See `StudyView`; without body 2 at a wall."""
        return super()._shown_in_units({name: data[name] for name in self._moving(data)})

    def _moving(self, names: Iterable[str]) -> list[str]:
        """Without those of body 2 at a wall."""
        return [name for name in names if self._result_setting.bodies != "wall" or not name.endswith("2")]


def _over(setting: Setting) -> str:
    return f"Largest values over {kept_text(setting.system, setting.eta, setting.initial)}"


def peak_table(result: PartialPeaks | PartialRuns, setting: Setting) -> dict:
    """The rows of the table: each peak of both solutions, and how far the penalty solution is off."""
    struck, rows = has_impacts({name: result.values(name)[0] for name in PEAKS}), []
    for name, quantity in PEAKS.items():
        if setting.bodies == "wall" and name.endswith("2"):
            continue
        unit = unit_of(quantity, setting)
        factor = 1.0 if setting.scale is None else setting.scale.factor(quantity)
        values = result.values(name)
        texts = [written(factor * value) if np.isfinite(value) else _NONE for value in values]
        off = difference_text(name, values, struck).replace("-", "−") or _NONE
        title = _NAMES[name] if setting.bodies != "wall" else _NAMES[name].removesuffix(", body 1")
        rows.append(row("peak", f"{title} / {divisor(unit)}" if unit else title, *texts, off))
    return {"title": "", "heads": ["largest", *SOLVERS, "difference"], "rows": rows}
