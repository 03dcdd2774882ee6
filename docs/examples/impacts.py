"""A view of a tab with one figure: the closing speed of each impact of the reference over its instant in the period."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from bokeh.models import Scatter
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.page.shared.curves import Axis, Curves, Plot, curve
from vibroscope.app.page.shared.figure import BLUE
from vibroscope.app.page.study.tab import StudyView, free_obstacle
from vibroscope.engine import Reference, System, counted, simulate

# -- the study: app/studies/impacts.py ---------------------------------------------------------------------------------


class ImpactQuestion(NamedTuple):
    """What the result depends on: two settings with the same question share it."""

    system: System
    eta: float
    reference: Reference


class PartialImpacts(NamedTuple):
    """Instants (shares of T) and closing speeds, (n,) each."""

    question: ImpactQuestion
    phase: np.ndarray
    speed: np.ndarray
    share: float  # 1 once all is computed

    def data(self) -> dict[str, object]:
        """What is known, for a file."""
        return {"phase": self.phase, "closing_speed": self.speed}


def grow_impacts(
    question: ImpactQuestion, last: PartialImpacts | None, cancelled: Callable[[], bool]
) -> Iterator[PartialImpacts]:
    """Partial results in a worker thread, each a whole picture: here the first periods, then more."""
    if last is not None and last.share == 1:
        return
    for periods in (300, 3000):
        run = simulate(*question, periods=periods, keep=periods // 3, cancelled=cancelled)
        phase = run.impacts.time / run.period % 1
        yield PartialImpacts(question, phase, run.impacts.closing_speed, share=periods / 3000)


# -- the figure: app/page/study/impacts.py -----------------------------------------------------------------------------


class ImpactView(Curves):
    """The figure, its data and its axes. It is made once; `update` writes columns in place."""

    axes = {  # noqa: RUF012 - read only
        "phase": Axis(0, 1, "instant τ/T"),
        "speed": Axis(0, 5, "closing speed −g′", "velocity"),
    }
    dots = curve(Scatter, "impacts", x="phase", y="speed", marker="circle", size=5, line_color=BLUE, fill_color=BLUE)
    plots = {"impacts": Plot("Impacts", "phase", "speed", {"": ("", [dots])})}  # noqa: RUF012 - read only

    def update(self, setting: Setting, result: PartialImpacts | None) -> None:
        """Draw a result, with an axis in the units of the setting; None: nothing is known yet."""
        self.label(setting)
        if result is not None:
            self.write("impacts", {"phase": result.phase, "speed": result.speed})
            self.follow("speed", fresh=self.changes_to(result.question))


# -- the view, in the same file ----------------------------------------------------------------------------------------


class Impacts(StudyView):
    """Starts the study where its question has changed, cancels it, shows its progress: all that `StudyTab` does."""

    key = "impacts"
    title = "Impacts"
    grow = staticmethod(grow_impacts)
    drawn = ImpactView
    hint = "One dot for each impact of the reference."
    pictures = (Figure("impacts", "Impacts", "Closing speed of each impact over its instant in the period."),)

    def obstacle(self, setting: Setting) -> str:
        """Where nothing drives the bodies nothing moves."""
        return free_obstacle(setting, "this figure")

    def question(self, setting: Setting) -> ImpactQuestion:
        """What the figure depends on, and no more: K, D and the step are not in it."""
        return ImpactQuestion(setting.system, setting.eta, setting.reference)

    def describe(self, setting: Setting, result: PartialImpacts) -> list[list[str]]:
        """Head and text of the panel; sentences are those of the model, `StudyTab` puts units into them."""
        return [["Impacts", f"{counted(len(result.speed), 'impact')} in the periods that are shown."]]

    def table(self, name: str) -> list[Series]:
        """The data of the figure, for its CSV file, and how the script beside that draws them."""
        return [Series("impacts", {"phase": self.result.phase, "closing_speed": self.result.speed})]
