"""Speed against error: what a period costs at the present setting and its error, measured while a user watches."""

from __future__ import annotations

import math

import numpy as np
import panel as pn
from vibroscope.app.explorer.method_words import words_of_method
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import speed_python
from vibroscope.app.page.files import style
from vibroscope.app.page.speed.figure import SpeedView, error_column
from vibroscope.app.page.study.tab import StudyView, free_obstacle
from vibroscope.app.studies.speed import CHECKED, PERIODS, PartialSpeed, SolverKey, SpeedQuestion, grow_speed
from vibroscope.engine import Units, written

# Served from assets/speed; `benchmarks/work_precision.py --write` renews it.
FIGURE = "speed/work-precision.svg"
_SHIPPED = f"""
<article class="text shipped">
<details>
<summary>Six problems and other solvers, as measured and shipped</summary>
<p>Error after ten periods against 60-digit solutions, over the time that one period takes. The solvers in closed form
are single points: they have no time step. Newmark's error falls about as the step, and irregularly, since each contact
change is missed by a part of a step; that of steps that are cut where contact changes falls as its
square.</p>
<img class="figure" src="{FIGURE}" alt="Error after ten periods against time per period for six problems: the closed
form solvers lie furthest to the lower left, plain Newmark furthest to the upper right.">
</details>
<p><a class="figure-link" href="{FIGURE}" target="_blank" rel="noopener">Open the figure by itself</a></p>
</article>
"""


class Speed(StudyView):
    """Work and precision at the present η, K, D and n; what was shipped is behind a disclosure."""

    key = "speed"
    title = "Speed against error"
    grow = staticmethod(grow_speed)
    chosen = {}  # noqa: RUF012 - nothing to choose
    pictures = (Figure("speed", "Speed against error", "Error after ten periods over processor time per period."),)
    axes, legends = SpeedView.spans(), SpeedView.legends()

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
            "hint": f"Error: the largest of the four state components after {CHECKED} periods, against the "
            f"exact penalty model, divided by what the axis names. Cost: processor time of this machine over "
            f"{PERIODS} periods, all solvers in turn. "
            "Vertical lines: the reference and the exact penalty model, without a time step and without this error. "
            "Integrator, contact status and law are those that are set under Solver.",
        }

    def obstacle(self, setting: Setting) -> str:
        """Why there is no study: nothing drives the bodies."""
        return free_obstacle(setting, "this measurement") if setting.from_rest else ""

    def question(self, setting: Setting) -> SpeedQuestion:
        """All that costs or errors depend on; fixed or located, both are measured."""
        asked = setting.system, setting.eta, setting.constant_step, setting.reference, setting.own_start
        return SpeedQuestion(*asked, setting.step_scale if setting.follows_step else None)

    def table(self, name: str) -> list[Series]:
        """A row for each solver and n."""
        found = self.result.data()
        columns = {"steps": found["solver_steps"]} | {n: found[n] for n in ("us_per_period", "solves_per_period")}
        columns[self._error_column()] = found["error"]
        kinds = np.array(found["solver"])
        return [
            Series(kind, {name: np.asarray(column)[kinds == kind] for name, column in columns.items()})
            for kind in dict.fromkeys(found["solver"])
        ]

    def data(self) -> dict[str, object]:
        """The results so far, in the units that are shown; the errors under the name that they have in the table."""
        return {self._error_column() if n == "error" else n: each for n, each in super().data().items()}

    def _error_column(self) -> str:
        return error_column(self.shown_setting() or Setting())

    def describe(self, setting: Setting, result: PartialSpeed) -> list[list[str]]:
        """The measurement and the figure in words."""
        words = words_of_method(result.question.method)
        lines = [["Penalty solution", f"{words}."]] if words else []
        if (scale := result.question.stiffness_of_step) is not None:
            text = f"K = {written(scale)} m/Δτ² follows the step: each n has a K of its own, and an exact model."
            lines.append(["Stiffness", text])
        return [*lines, *statements(setting, result)]

    def python(self, setting: Setting) -> str:
        """A script of the same measurement; it runs on another machine or at another time, so its numbers differ."""
        return speed_python(self.script_question(setting))

    def draw(self, setting: Setting, result: PartialSpeed | None) -> None:
        """The figure."""
        self.view.update(setting, result)


def statements(setting: Setting, result: PartialSpeed) -> list[list[str]]:
    """Head and text: the setting, what an FE code pays for it, what the located step would, no time step."""
    n, scale = result.question.method.steps, setting.scale
    kind = "located" if setting.located == "yes" else "fixed"
    step = "step cut where contact changes" if kind == "located" else "constant step"
    lines = [
        [f"Present setting: T/{n}, {step}", _cost(result, SolverKey(kind, n), scale)],
        ["What an FE code pays", _plain_cost(result, n)],
    ]
    if "located" in result.question.kinds:
        lines.append(["With the step cut where contact changes", _located(result, n, scale)])
    return [*lines, ["Without a time step", _stepless(result)]]


def _cost(result: PartialSpeed, key: SolverKey, scale: Units | None) -> str:
    if not math.isfinite(result.errors[key]):
        other = ", or another choice for steps without a solution" if result.question.method.status == "end" else ""
        return (
            f"No error: this run or the exact penalty model's gave up within {CHECKED} periods. "
            f"Take a smaller step{other}."
        )
    return (
        f"error {_error(result.errors[key], scale)} after {CHECKED} periods, for {result.cost(key):.3g} µs per period."
    )


def _error(error: float, scale: Units | None) -> str:
    """An error of any of the four state components, with its unit."""
    if scale is None:
        return f"{written(error, 2)} A (Aω₁ of a velocity)"
    return f"at most {scale.text('displacement', error, 2)} and {scale.text('velocity', error, 2)}"


def _plain_cost(result: PartialSpeed, n: int) -> str:
    plain, skipping = SolverKey("plain", n), SolverKey("fixed", n)
    if "plain" not in result.question.kinds:
        return (
            f"{n} steps per period, one by one: {result.cost(skipping):.3g} µs for two bodies, "
            f"{1000 * result.cost(skipping) / n:.3g} ns a step, in which this law is solved for. A code with more "
            "unknowns pays more for each step: count steps."
        )
    return (
        f"{n} steps per period, one by one: {result.cost(plain):.3g} µs in a plain loop over two bodies, "
        f"{1000 * result.cost(plain) / n:.3g} ns a step. This page skips steps and finds the same solution "
        f"{result.times(plain, skipping):.3g} times as fast, but an FE code cannot skip. A code with more unknowns "
        "pays more for each step: count steps."
    )


def _located(result: PartialSpeed, n: int, scale: Units | None) -> str:
    """The located step with the fewest solves that is as exact as the fixed step at n, or all there is to say."""
    fixed = result.errors[SolverKey("fixed", n)]
    if not math.isfinite(fixed):
        return f"T/{n}: {_cost(result, SolverKey('located', n), scale)}"
    enough = [key for key in result.curve("located") if result.errors[key] <= fixed]
    if not enough:
        this = _cost(result, SolverKey("located", n), scale)
        return f"None of those tried is as exact as the fixed step of T/{n}. T/{n}: {this}"
    best, solves = min(enough, key=result.solves.get), result.solves[SolverKey("fixed", n)]
    return (
        f"T/{best.steps}: {_cost(result, best, scale)} That is no worse than the fixed step of T/{n}. Steps are cut "
        f"at the contact changes, so it takes {result.solves[best]:.0f} solves per period beside {solves:.0f}, "
        f"{_share(result.solves[best] / solves)}."
    )


def _share(ratio: float) -> str:
    return f"{1 / ratio:.2g} times fewer" if ratio < 1 else f"{ratio:.2g} times as many"


def _stepless(result: PartialSpeed) -> str:
    return (
        f"the reference takes {result.stepless('reference'):.3g} µs per period, the exact penalty model "
        f"{result.stepless('exact'):.3g} µs."
    )
