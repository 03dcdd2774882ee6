"""The K–D plane: where the penalty model moves as it should, and what of the rest is an artefact of the time step."""

from __future__ import annotations

import math

import numpy as np
import panel as pn
from vibroscope.app.explorer.link import LOGARITHMIC
from vibroscope.app.explorer.state import Setting, print_number
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import sweep_command, sweep_python
from vibroscope.app.page.plane.figure import PlaneView
from vibroscope.app.page.study.tab import StudyTab
from vibroscope.app.studies import cell_classes as classes
from vibroscope.app.studies.plane import COUNT, SAMPLE, SIDES, TRANSIENT, Plane, PlaneStage, refine_plane

_SIDE_NAMES = {"penalty": "Newmark", "exact": "Exact penalty"}
_SUDDEN = 30  # steps: the paper takes a contact of fewer for one sudden impact


class PlaneTab(StudyTab):
    """Figures 11 and 12 of the paper, at any η."""

    key = "plane"
    title = "K–D plane"
    refine = staticmethod(refine_plane)
    chosen = {"quantity": "period", "limit": _SUDDEN}  # noqa: RUF012 - read only
    axes = {"K": LOGARITHMIC, "D": LOGARITHMIC}  # noqa: RUF012 - read only
    pictures = (
        Figure("plane_penalty", "Plane with a time step", "Newmark over K and D: the colours of the page's key."),
        Figure("plane_exact", "Plane without one", "The exact penalty model over K and D, which has no time step."),
    )

    def build(self) -> pn.viewable.Viewable:
        """Two planes and the panel."""
        self.view = PlaneView(self._set, self._zoomed)
        return self.lay_out(*(self.stretch(plot, "tall") for plot in self.view.figures.values()))

    @classmethod
    def spec(cls) -> dict:
        """What can be chosen."""
        return {
            "title": "K–D plane",
            "switches": [
                {
                    "name": "quantity",
                    "label": "Colour",
                    "choices": {name: quantity.label for name, quantity in classes.QUANTITIES.items()},
                }
            ],
            "limits": [{"name": "limit", "label": "Sudden below", "low": 2, "high": 200}],
            "hint": "A click sets K and D; so do their sliders, which the arrow keys move. “Sudden below” counts steps "
            "in contact and is drawn as stripes over the longest contact.",
        }

    def question(self, setting: Setting) -> Plane:
        """All but K and D themselves."""
        errors = self.panel.chosen["quantity"] == "error"
        located = setting.located == "yes"
        return Plane(setting.system, setting.eta, setting.steps, located, errors, **self.view.spans)

    def draw(self, setting: Setting, stage: PlaneStage | None) -> None:
        """Both planes and the key."""
        quantity = self.panel.chosen["quantity"]
        if stage is not None and quantity == "error" and not stage.question.errors:
            quantity = "period"  # what there is, until the errors come
        limit = self.panel.chosen["limit"] if quantity == "contact" else None
        self.view.update(setting, stage, quantity, limit)
        self.panel.key = classes.legend(quantity, limit)

    def tell(self, setting: Setting, stage: PlaneStage) -> list[list[str]]:
        """The cell that is set, and both planes together."""
        return told(setting, stage)

    def table(self, name: str) -> list[Series]:
        """A row for each cell that is known."""
        side, known = name.removeprefix("plane_"), self._stage.known
        K, D = np.meshgrid(self._stage.question.axis("K"), self._stage.question.axis("D"))
        tables = {"K": K, "D": D, **self._stage.tables[side], "contact_steps": self._stage.contact_steps(side)}
        return [Series(_SIDE_NAMES[side], {column: table[known] for column, table in tables.items()})]

    def python(self, setting: Setting) -> str:
        """`sweep_plane` over the rectangle in view, with and without a time step."""
        asked = self.asked(setting)
        axes = ", ".join(f"np.geomspace({a!r}, {b!r}, {COUNT})" for a, b in map(asked.ends, ("K", "D")))
        how = f"transient={TRANSIENT}, sample={SAMPLE}, parts={asked.errors}"
        steps = {"penalty": f"steps={asked.steps}, located={asked.located}", "exact": "steps=None"}
        calls = {
            side: f"sweep_plane(\n    system, {asked.eta!r}, {axes},\n    {own}, {how},\n)"
            for side, own in steps.items()
        }
        return sweep_python(calls, asked.system)

    def command(self, setting: Setting) -> str:
        """``vibroscope sweep plane`` over the rectangle in view, with and without a time step."""
        asked = self.asked(setting)
        axes = "".join(f" --{name} {':'.join(map(repr, asked.ends(name)))}:{COUNT}" for name in ("K", "D"))
        how = f"{'' if asked.errors else ' --no-error'} --transient {TRANSIENT} --sample {SAMPLE}"
        newmark = f" --steps {asked.steps}{' --located' if asked.located else ''}"
        given = f" --eta {print_number(asked.eta)}{axes}"
        return sweep_command("plane", asked.system, *(given + own + how for own in (newmark, " --solver exact")))

    def _set(self, K: float, D: float) -> None:
        self.host.set({"K": print_number(K), "D": print_number(D)})

    def _zoomed(self) -> None:
        if self._visible:
            self.ask()
            self.push()


def told(setting: Setting, stage: PlaneStage) -> list[list[str]]:
    """Head and text of what the planes say: the cell that holds the setting, and both planes together."""
    lines = []
    place = stage.cell(setting.K, setting.D)
    if place is not None:
        K, D = (print_number(float(f"{x:.3g}")) for x in stage.centre(place))
        lines += [[f"{_SIDE_NAMES[side]}, cell at K ≈ {K}, D ≈ {D}", _cell(stage, side, place)] for side in SIDES]
    return [*lines, ["The whole plane" + ("" if stage.share >= 1 else " so far"), _whole(stage)]]


def _cell(stage: PlaneStage, side: str, place: tuple[int, int]) -> str:
    if stage.diverged(side)[place]:
        return "blown up."
    period, impacts, steps = (
        table[place]
        for table in (
            stage.shown(side, "period"),
            stage.shown(side, "impacts_per_period"),
            stage.contact_steps(side),
        )
    )
    if not math.isfinite(period):
        return "not computed yet."
    kind = f"period {period:.0f}" if period else "does not repeat itself"
    text = f"{kind}, impacts per period {impacts:.3g}, longest contact {steps:.3g} steps"
    if stage.question.errors:
        error = stage.shown(side, "error")[place]
        text += f", error {100 * error:.2g} %" if math.isfinite(error) else ", no error: the motions keep no step"
    return f"{text}."


def _whole(stage: PlaneStage) -> str:
    known = stage.known
    one, apart = ({side: stage.shown(side, name)[known] for side in SIDES} for name in ("period", "near_period"))
    shares = {side: 100 * (one[side] == 1).mean() for side in SIDES}
    scatter = 100 * ((one["exact"] > 0) & (one["penalty"] == 0)).mean()
    blown = 100 * stage.diverged("penalty")[known].mean()
    forgiven = 100 * (apart["penalty"] == 1).mean()
    text = (
        f"Period one in {shares['exact']:.0f} % of the cells without a time step, in {shares['penalty']:.0f} % with it "
        f"({forgiven:.0f} % where scatter is forgiven). In {scatter:.0f} % the motion repeats itself without a time "
        "step and not with it: there the step is to blame."
    )
    return f"{text} {blown:.0f} % blew up." if blown else text
