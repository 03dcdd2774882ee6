"""What the tabs of studies share: a question that follows the setting, a picture that grows, one at a time.

A study starts when its tab is open and its question has changed; the next question cancels it, and so do another tab
and the end of the session. A move that changes no question only moves the marks.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import partial
from typing import ClassVar

import panel as pn
from bokeh.plotting import figure
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.link import View
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure
from vibroscope.app.page.files import style
from vibroscope.app.page.shared.muting import Muting
from vibroscope.app.page.study.panel import StudyPanel
from vibroscope.app.page.tab import COMPUTING, Move, Tab, TabHost
from vibroscope.app.studies.live import KEPT, Live, Refine, Stage


class StudyTab(Tab):
    """Base of the studies."""

    refine: ClassVar[Refine]  # stages of the answer to a question
    chosen: ClassVar[dict]  # what is chosen at first
    pictures: ClassVar[tuple[Figure, ...]]  # that can be taken away

    def __init__(self, host: TabHost) -> None:
        super().__init__(host)
        self._live: Live | None = None
        self._move: Move | None = None
        self._visible = False
        self._stage: Stage | None = None
        self._of: Setting | None = None  # the last that the stage is the answer to
        self._stopped = False  # by the user
        self._failed = ""

    # -- what a study says ---------------------------------------------------

    @classmethod
    @abstractmethod
    def spec(cls) -> dict:
        """Switches, limits, title and hint of the panel."""

    @abstractmethod
    def question(self, setting: Setting) -> object:
        """What is to be computed."""

    @abstractmethod
    def draw(self, setting: Setting, stage: Stage | None) -> None:
        """Write the marks of the setting and, if there is one, the picture."""

    @abstractmethod
    def tell(self, setting: Setting, stage: Stage) -> list[list[str]]:
        """Head and text of what the picture says of a setting that it is the answer to."""

    def stretch(self, plot: figure, *classes: str) -> pn.pane.Bokeh:
        """A figure that fills its cell."""
        pane = pn.pane.Bokeh(plot, sizing_mode="stretch_both")
        pane.css_classes = plot.css_classes = ["cell", "figure", *classes]
        return pane

    def lay_out(self, *cells, classes: tuple[str, ...] = ()) -> pn.Column:
        """Figures and the panel in the grid of `studies.css`."""
        spec = {"figures": [cell.object.name for cell in cells], **self.spec()}
        self.panel = StudyPanel(spec, dict(self.chosen), self._choose, self._stop)
        self.panel.css_classes = ["cell", "panel"]
        self.ranges = self.view.ranges
        self.muting = Muting(self.legends, [cell.object for cell in cells])
        return pn.Column(
            *cells,
            self.panel,
            css_classes=["studies", *classes],
            stylesheets=[style("study/studies")],
            sizing_mode="stretch_both",
        )

    # -- the open tab --------------------------------------------------------

    def show_if_ready(self, move: Move) -> bool:
        """Never: the page comes first."""
        return False

    def show(self, move: Move) -> None:
        """Move the marks, and ask anew where the question has changed."""
        self._visible = True
        self._move = move
        if move.fresh:
            with pn.io.hold(self.host.doc):  # both ends of a range at once
                self.unzoom()
        self.ask()
        self.push()

    def restore(self, view: View) -> None:
        """See it so, the choices included."""
        super().restore(view)
        self.panel.chosen = self.panel.chosen | dict(view.choice)

    def choice(self) -> dict[str, str | int]:
        """What is not chosen as at first."""
        return {name: value for name, value in self.panel.chosen.items() if value != self.chosen[name]}

    def summary(self, setting: Setting) -> str:
        """What the panel says of the whole picture; of a part of it nothing yet."""
        question = self.question(setting)
        stage = self._stage if self._stage is not None and self._stage.question == question else KEPT.get(question)
        return _in_one(self.tell(setting, stage)) if stage is not None and stage.share >= 1 else COMPUTING

    def hide(self) -> None:
        """What is under way is cancelled; it goes on from there when the tab is opened again."""
        self._visible = False
        if self._live is not None:
            self._live.cancel()
            self._live = None

    def ask(self) -> None:
        """Start what the setting and the choices call for, if that is not what is under way or done."""
        question = self.question(self._move.setting)
        if self._live is None or question != self._live.question:
            if self._live is not None:
                self._live.cancel()
            self._stopped, self._failed = False, ""
            self._stage = KEPT.get(question) or self._stage
            self._live = Live(question, type(self).refine, self._delivered)
        if self._stage is not None and self._stage.question == question:
            self._of = self._move.setting

    def push(self) -> None:
        """Send what has changed, when the browser is free."""
        self.host.push(self._move.number, self._write)

    def _delivered(self, live: Live, stage: Stage | Exception) -> None:
        """In a worker thread."""
        self.host.call_later(partial(self._arrived, live, stage))

    def _arrived(self, live: Live, stage: Stage | Exception) -> None:
        if live is not self._live or live.cancelled:
            return
        if isinstance(stage, Exception):
            self._failed = (
                f"This could not be computed ({error_text(stage)}). Change what you moved last; the last picture stays."
            )
            self.host.report_error(self._failed, self._move.number)
        else:
            self._stage, self._of = stage, self._move.setting
            self._stopped = live.exhausted
        self.push()

    def _write(self) -> None:
        if not self._visible:
            return
        current = self._stage is not None and self._stage.question == self.question(self._move.setting)
        self.draw(self._move.setting, self._stage)
        self.panel.told = self._told()
        share = self._stage.share if current else 0.0
        running = share < 1 and not self._stopped and not self._failed
        text = self._failed or ("complete" if share >= 1 else f"{100 * share:.0f} % computed")
        self.panel.status = {
            "share": round(share, 3),
            "running": running,
            "text": f"{text}, stopped" if self._stopped else text,
        }
        if share >= 1:  # a screen reader is told once, when all is known
            self.host.summarise(_in_one(self.panel.told))

    # -- what can be taken away ----------------------------------------------

    def figures(self) -> list[Figure]:
        """All, once there is anything in them."""
        return list(self.pictures) if self._stage is not None else []

    def data(self) -> dict[str, object]:
        """What is known."""
        return self._stage.data()

    def words(self) -> dict[str, str]:
        """What stands in the panel."""
        return dict(self._told())

    def shown_setting(self) -> Setting | None:
        """The one that the picture is of: while the next is computed, or after it failed, not the one that holds."""
        return self._of

    def asked(self, setting: Setting) -> object:
        """What a script has to compute: the question of the picture, or of ``setting`` while there is none."""
        return self.question(setting) if self._stage is None else self._stage.question

    def _told(self) -> list[list[str]]:
        return [] if self._stage is None else self.tell(self._of, self._stage)

    # -- from the panel ------------------------------------------------------

    def _choose(self, chosen: dict) -> None:
        self.panel.chosen = chosen
        if self._visible:
            self.ask()
            self.push()

    def _stop(self, on: bool) -> None:
        if self._live is None or not self._visible:
            return
        self._live.cancel()
        if not on:
            self._live = None
            self.ask()
        self._stopped = on
        self.push()


def _in_one(told: list[list[str]]) -> str:
    return " ".join(f"{head}: {said}" for head, said in told)
