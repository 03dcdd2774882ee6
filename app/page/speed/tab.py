"""Speed against error: what a period costs at the present setting and how wrong it is, measured while one watches."""

from __future__ import annotations

import math

import numpy as np
import panel as pn
from vibroscope.app.explorer.link import LOGARITHMIC
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import speed_python
from vibroscope.app.page.files import style
from vibroscope.app.page.speed.figure import SpeedView
from vibroscope.app.page.study.tab import StudyTab
from vibroscope.app.studies.speed import CHECKED, KINDS, PERIODS, Key, Question, SpeedStage, refine_speed

# Served from assets/speed; `benchmarks/work_precision.py --write` renews it.
FIGURE = "speed/work-precision.svg"
_SHIPPED = f"""
<article class="text shipped">
<details>
<summary>Six problems and other solvers, as measured and shipped</summary>
<p>Error after ten periods against 60-digit solutions, over the time that one period takes. The solvers in closed form
are single points: they have no time step. Newmark's error falls about as the step, and irregularly, since each contact
change is missed by a part of a step; that of the located step, which lands on the contact changes, falls as its
square.</p>
<img class="figure" src="{FIGURE}" alt="Error after ten periods against time per period for six problems: the closed
form solvers lie furthest to the lower left, plain Newmark furthest to the upper right.">
</details>
<p><a class="figure-link" href="{FIGURE}" target="_blank" rel="noopener">Open the figure by itself</a></p>
</article>
"""


class Speed(StudyTab):
    """Work and precision at the present η, K, D and n; what was shipped is behind a disclosure."""

    key = "speed"
    title = "Speed against error"
    refine = staticmethod(refine_speed)
    chosen = {}  # noqa: RUF012 - nothing to choose
    pictures = (Figure("speed", "Speed against error", "Error after ten periods over processor time per period."),)
    axes = {"cost": LOGARITHMIC, "error": LOGARITHMIC}  # noqa: RUF012 - read only
    legends = {"speed": KINDS}  # noqa: RUF012 - read only

    def build(self) -> pn.viewable.Viewable:
        """The figure, the panel, the shipped figure below."""
        self.view = SpeedView()
        page = self.lay_out(self.stretch(self.view.figure, "wide"), classes=("speed",))
        shipped = pn.pane.HTML(
            _SHIPPED, stylesheets=[style("shared/text")], sizing_mode="stretch_width", sanitize_html=False
        )
        shipped.css_classes = ["cell", "wide"]
        page.append(shipped)
        return page

    @classmethod
    def spec(cls) -> dict:
        """Nothing to choose: the sliders do."""
        return {
            "title": "Speed against error",
            "switches": [],
            "limits": [],
            "hint": f"Error: the largest of the four state components after {CHECKED} periods from rest, against the "
            f"exact penalty model. Cost: processor time of this machine over {PERIODS} periods, all solvers in turn. "
            "Vertical lines: closed form, without a time step and without this error.",
        }

    def question(self, setting: Setting) -> Question:
        """All that costs or errors depend on; fixed or located, both are measured."""
        return Question(setting.system, setting.eta, setting.K, setting.D, setting.steps, setting.reference)

    def table(self, name: str) -> list[Series]:
        """A row for each solver and n."""
        found = self._stage.data()
        columns = {"steps": found["solver_steps"]} | {
            n: found[n] for n in ("us_per_period", "solves_per_period", "error")
        }
        kinds = np.array(found["solver"])
        return [
            Series(kind, {name: np.asarray(column)[kinds == kind] for name, column in columns.items()})
            for kind in dict.fromkeys(found["solver"])
        ]

    def tell(self, setting: Setting, stage: SpeedStage) -> list[list[str]]:
        """The figure in words."""
        return told(setting, stage)

    def python(self, setting: Setting) -> str:
        """The same measurement: of this machine, and so with other numbers each time."""
        return speed_python(self.asked(setting))

    def draw(self, setting: Setting, stage: SpeedStage | None) -> None:
        """The figure."""
        self.view.update(setting, stage)


def told(setting: Setting, stage: SpeedStage) -> list[list[str]]:
    """Head and text: the setting, what an FE code pays for it, what the located step would, the closed forms."""
    n = stage.question.steps
    kind = "located" if setting.located == "yes" else "fixed"
    return [
        [f"Set: T/{n}, {kind} step", _said(stage, Key(kind, n))],
        ["What an FE code pays", _walked(stage, n)],
        ["What the located step would", _located(stage, n)],
        ["Closed form", _closed(stage)],
    ]


def _said(stage: SpeedStage, key: Key) -> str:
    if not math.isfinite(stage.errors[key]):
        return f"No error: this run or the exact penalty model's gave up within {CHECKED} periods. Take a smaller step."
    return f"error {stage.errors[key]:.2g} after {CHECKED} periods, for {stage.cost(key):.3g} µs per period."


def _walked(stage: SpeedStage, n: int) -> str:
    plain, leaps = Key("plain", n), Key("fixed", n)
    return (
        f"{n} steps per period, one by one: {stage.cost(plain):.3g} µs in a plain loop over two pendulums, "
        f"{1000 * stage.cost(plain) / n:.3g} ns a step. The leaps of this page over the same steps are "
        f"{stage.times(plain, leaps):.3g} times as fast, but an FE code does not leap. A code with more unknowns pays "
        "more for each step: count steps."
    )


def _located(stage: SpeedStage, n: int) -> str:
    """The located step with the fewest solves that is as exact as the fixed step at n, or all there is to say."""
    fixed = stage.errors[Key("fixed", n)]
    if not math.isfinite(fixed):
        return f"T/{n}: {_said(stage, Key('located', n))}"
    enough = [key for key in stage.curve("located") if stage.errors[key] <= fixed]
    if not enough:
        return f"None of those tried is as exact as the fixed step of T/{n}. T/{n}: {_said(stage, Key('located', n))}"
    best = min(enough, key=stage.solves.get)
    return (
        f"T/{best.steps}: {_said(stage, best)} That is no worse than the fixed step of T/{n}. Steps are cut at the "
        f"contact changes, so it takes {stage.solves[best]:.0f} solves per period beside {n}, "
        f"{_share(stage.solves[best] / n)}."
    )


def _share(ratio: float) -> str:
    return f"{1 / ratio:.2g} times fewer" if ratio < 1 else f"{ratio:.2g} times as many"


def _closed(stage: SpeedStage) -> str:
    return (
        f"the reference takes {stage.closed_form('reference'):.3g} µs per period, the exact penalty model "
        f"{stage.closed_form('exact'):.3g} µs; both without a time step."
    )
