"""The base of the tabs with a study: a question that follows the setting, a picture that refines, one study at a time.

A study starts when its tab is open and its question has changed. The next question cancels it, and so do another tab
and the end of the session. A move that changes no question only moves the marks.
"""

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping
from typing import ClassVar

import panel as pn
from bokeh.events import RangesUpdate, Tap
from vibroscope.app.explorer.field_units import ShownField, beside_field, shown_content
from vibroscope.app.explorer.link import View
from vibroscope.app.explorer.method_words import words_of_method
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure
from vibroscope.app.export.tables import columns_in_units
from vibroscope.app.page.asker import StudyAsker
from vibroscope.app.page.files import style
from vibroscope.app.page.shared.curves import Curves
from vibroscope.app.page.shared.declared import Key
from vibroscope.app.page.shared.muting import Muting
from vibroscope.app.page.study.listed import ListedSearches, ListPanel
from vibroscope.app.page.study.panel import StudyPanel
from vibroscope.app.page.tab import COMPUTING, Move, TabHost, TabView
from vibroscope.app.studies.study_job import RESULTS, Grow, PartialResult
from vibroscope.engine import written
from vibroscope.engine.facts import Statement, message_of, sentence


class StudyView(TabView):
    """Base of the studies: what they declare is built here, once.

    Attributes
    ----------
    study : StudyAsker
    view : Curves
        Its figures, once it is built.
    list : ListPanel or None
        Below them.
    searches : ListedSearches or None
        Beside the study: drawn over its figures, and listed below them.
    """

    grow: ClassVar[Grow]  # partial results of a question
    drawn: ClassVar[type[Curves]]  # its figures
    place: ClassVar[str] = ""  # of all of them, a class of `studies.css`
    arrangement: ClassVar[tuple[str, ...]] = ()  # of the page, likewise
    tapped: ClassVar[tuple[str, ...]] = ()  # names of the figures a click in which takes over its place
    zoomed: ClassVar[str] = ""  # name of the figure whose zoom, which others follow, is computed anew
    listed: ClassVar[str] = ""  # name of the list below the figures, for screen readers; empty if there is none
    searched: ClassVar[type[ListedSearches] | None] = None
    head: ClassVar[str] = ""  # of the panel, if that is not the title
    hint: ClassVar[str] = ""  # below all of the panel
    extras: ClassVar[Mapping[str, object]] = {}  # of the panel: ``file``, ``cursor``, ``aligned`` of `StudyPanel.spec`
    pictures: ClassVar[tuple[Figure, ...]]  # that can be taken away
    needs: ClassVar[Mapping[str, str]] = {}  # what of the result they show, by their names; "": those that are left out
    keyed: ClassVar[tuple[str, ...]] = ()  # names of those whose colours the key explains
    quantities: ClassVar[Mapping[str, str] | None] = None  # of columns; None: those of studies and fields
    at_once: ClassVar[bool] = False  # whether a first answer comes as fast as marks: then these wait for it
    searches: ListedSearches | None = None

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        cls.axes, cls.legends = cls.drawn.spans(), cls.drawn.legends()

    def __init__(self, host: TabHost) -> None:
        super().__init__(host)
        self._result_setting: Setting | None = None  # the last one that the result answers
        self.study = StudyAsker(host, type(self).grow, self._changed)
        self._move: Move | None = None
        self._visible = False

    @property
    def result(self) -> PartialResult | None:
        """What is shown: of the present question, or of the last one until there is something of the present one."""
        return self.study.result

    # -- what a study defines ---------------------------------------------------

    @abstractmethod
    def question(self, setting: Setting) -> object:
        """The question of the study."""

    def draw(self, setting: Setting, result: PartialResult | None) -> None:
        """Write the marks of the setting and, if there is one, the picture."""
        self.view.update(setting, result)

    @abstractmethod
    def describe(self, setting: Setting, result: PartialResult) -> list[list[str | Statement]]:
        """Head and text of what the picture says about a setting that it answers; printed in the units shown."""

    def obstacle(self, setting: Setting) -> str:
        """Why the study has nothing to show of a setting, and what to do, in a sentence; empty if it has."""
        return ""

    def search_questions(self, setting: Setting) -> tuple[object, list[str]]:
        """What the ``searches`` look for, if there are any, and sentences about what that is, or why there is none."""
        return None, []

    def away(self, setting: Setting) -> dict[str, list[str]]:
        """Values of choices, and numbers, that the panel hides for the system: at a wall those of body 2."""
        return {each.name: [*each.of_body_2] for each in self.choices if each.of_body_2 and setting.bodies == "wall"}

    def fields(self, setting: Setting) -> dict[str, ShownField]:
        """How the numbers that have a unit are shown."""
        return {
            each.name: beside_field(setting, each.label, each.hint, each.quantity, each.natural)
            for each in self.choices
            if each.quantity
        }

    def while_empty(self, setting: Setting) -> dict[str, str]:
        """The numbers that hold where a field is empty, in words."""
        return {}

    def take_over(self, name: str, x: float, y: float) -> None:
        """Set what a click in one of the ``tapped`` figures means."""

    def build(self) -> pn.Column:
        """Figures and panel in the grid of `studies.css`; a list below them has room there while it is visible."""
        self.view = self.drawn()
        self.ranges, figures = self.view.ranges, self.view.figures
        self.muting = Muting(self.legends, self.view.items)
        self.list = ListPanel(label=self.listed, visible=False) if self.listed else None
        if self.searched is not None:
            self.searches = self.searched(self.host, self.view, self._push)
            self.list = self.searches.view
        for name in self.tapped:
            figures[name].on_event(Tap, self.on_tap)
        if self.zoomed:
            figures[self.zoomed].on_event(RangesUpdate, lambda event: self.refresh())
        spec = {"title": self.head or self.title, "figures": [*figures], "hint": self.hint, **self.extras}
        self.panel = StudyPanel(self.choices, spec, dict(self.chosen), self._choose, self._stop)
        self.panel.css_classes = ["cell", "panel"]
        cells = [pn.pane.Bokeh(plot, sizing_mode="stretch_both") for plot in figures.values()]
        for cell in cells:
            classes = ["cell", "figure", *self.place.split(), *cell.object.css_classes]
            cell.css_classes = cell.object.css_classes = classes
        if self.list is not None:
            self.list.css_classes = ["cell", "wide"]
        self._page = pn.Column(
            *cells,
            self.panel,
            *([] if self.list is None else [self.list]),
            css_classes=["studies", *self.arrangement],
            stylesheets=[style("study/studies")],
            sizing_mode="stretch_both",
        )
        return self._page

    # -- the open tab --------------------------------------------------------

    def show_if_ready(self, move: Move) -> bool:
        """Never: the page comes first."""
        return False

    def show(self, move: Move) -> None:
        """Move the marks, and start a study where the question has changed."""
        self._visible = True
        self._move = move
        with pn.io.hold(self.host.doc):  # both ends of a range at once
            self.view.fit_axes(move.setting)
            if move.fresh:
                self.unzoom()
        self.refresh()

    def restore(self, view: View) -> None:
        """Take a view from a link, the choices included."""
        super().restore(view)
        self.panel.chosen = self.panel.chosen | dict(view.choice)

    def choice(self) -> dict[str, str | int]:
        """The choices that differ from those at first."""
        now = self.panel.chosen
        return {name: now[name] for name, first in self.chosen.items() if now[name] != first}

    def summary(self, setting: Setting) -> str:
        """The statements of the panel once the picture is complete; until then, that it is computed."""
        if obstacle := self.obstacle(setting):
            return obstacle
        question = self.question(setting)
        result = self.result if self._answers(question) else RESULTS.get(question)
        if result is None or result.share < 1:
            return COMPUTING
        return _as_text(shown_content(self.describe(setting, result), setting.scale))

    def hide(self) -> None:
        """Cancel what is under way; it goes on from there when the tab is opened again."""
        self._visible = False
        self._cancel()

    def _cancel(self) -> None:
        self.study.forget()
        if self.searches is not None:
            self.searches.cancel()

    def refresh(self) -> None:
        """Start the study that the setting, the choices and the zoom call for, and draw; nothing while hidden."""
        if self._visible:
            if self._obstacle:
                self._cancel()
            else:
                self._ask()
                if self.at_once and self.result is not None and not self._answers(self.study.question):
                    return
            self._push()

    @property
    def _searches(self) -> bool:
        """Whether the user has chosen to search."""
        return self.panel.chosen[self.searches.switch] != "off"

    @property
    def _obstacle(self) -> str:
        return self.obstacle(self._move.setting) if self._move else ""

    def _ask(self) -> None:
        """Start what is called for, if that is not what is under way or done."""
        question = self.question(self._move.setting)
        self.study.follow(question)
        if self.searches is not None:
            self.searches.ask(self.search_questions(self._move.setting)[0])
        if self._answers(question):
            self._result_setting = self._move.setting

    def _answers(self, question: object) -> bool:
        return self.result is not None and self.result.question == question

    def _push(self) -> None:
        """Send what has changed, when the browser is free."""
        self.host.push(self._move.number, self._write)

    def _changed(self) -> None:
        if self.study.failed:
            self.host.report_error(self._failure, self._move.number)
        else:
            self._result_setting = self._move.setting
        self._push()

    @property
    def _failure(self) -> str:
        cause = self.study.failed
        return cause and f"This could not be computed ({cause}). Change what you moved last; the last picture stays."

    def _write(self) -> None:
        if self._visible:
            self._show()
            if self.list is not None:
                classes = [each for each in self._page.css_classes if each != "listed"]
                self._page.css_classes = [*classes, *(["listed"] if self.list.visible else [])]

    def _show(self) -> None:
        obstacle = self._obstacle
        if self.searches is not None and (obstacle or not self._searches):
            self.searches.clear()
        self.panel.away = self.away(self._move.setting)
        self.panel.show_fields(self.fields(self._move.setting), self.while_empty(self._move.setting))
        for plot in self.view.figures.values():
            plot.visible = not obstacle
        self.panel.statements = self._statements()
        if obstacle:
            self.panel.status, self.panel.key = {}, []
            self.host.summarise(obstacle)
            return
        self.draw(self._move.setting, self.result)
        share, stopped = self.study.share, self.study.stopped
        text = self._failure or ("complete" if share >= 1 else f"{100 * share:.0f} % computed")
        self.panel.status = {
            "share": round(share, 3),
            "running": self.study.job is not None,
            "text": f"{text}, stopped" if stopped else text,
        }
        if share >= 1:  # a screen reader speaks once, when all is known
            self.host.summarise(_as_text(self.panel.statements))

    # -- what can be taken away ----------------------------------------------

    def figures(self) -> list[Figure]:
        """Those in which there is anything; of what the searches have found there are tables alone."""
        return [each for each in self.pictures if self.result is not None and not self._obstacle and self._has(each)]

    def _has(self, each: Figure) -> bool:
        if self.searches is not None and not each.drawn:
            return bool(self.searches.found)
        needed = self.needs.get(each.name, self.needs.get(""))
        return needed is None or bool(getattr(self.result, needed))

    def key_of(self, name: str) -> Key:
        """The key of the panel."""
        return Key(self.panel.key_title, self.panel.key) if name in self.keyed else Key()

    def data(self) -> dict[str, object]:
        """The results so far, in the units that are shown."""
        return self._shown_in_units(self.result.data())

    def _shown_in_units(self, data: Mapping[str, object]) -> dict[str, object]:
        return dict(columns_in_units(data, self._result_setting.scale, self.quantities))

    def words(self) -> dict[str, str]:
        """The text of the panel."""
        return dict(self._statements())

    def shown_setting(self) -> Setting | None:
        """The setting of the picture: not the present one while that is being computed, or after it failed."""
        return self._result_setting

    def script_question(self, setting: Setting) -> object:
        """The question that a script answers: that of the picture, or of ``setting`` while there is none."""
        return self.question(setting) if self.result is None else self.result.question

    def _statements(self) -> list[list[str]]:
        if obstacle := self._obstacle:
            return [["Nothing to show", obstacle]]
        if self.result is None:
            return []
        return shown_content(self.describe(self._result_setting, self.result), self._move.setting.scale)

    # -- from the user ------------------------------------------------------

    def on_tap(self, event: Tap) -> None:
        """Take over the place of a click in a figure."""
        if event.x is not None and event.y is not None and math.isfinite(event.x) and math.isfinite(event.y):
            self.take_over(event.model.name if event.model else "", event.x, event.y)

    def _choose(self, chosen: dict) -> None:
        self.panel.chosen = chosen
        self.refresh()

    def _stop(self, on: bool) -> None:
        if self._visible:
            self.study.stop(on)
            self._push()


def method_lines(question, of_each: str) -> list[list[str]]:
    """Head and text: the method of a study over steps, and its stiffness where that follows them."""
    words, scale = words_of_method(question.method), question.stiffness_of_step
    lines = [["Penalty solution", f"{words}."]] if words else []
    if scale is None:
        return lines
    text = f"K = {written(scale)} m/Δτ² follows the step: each n has a K of its own, and {of_each}."
    return [*lines, ["Stiffness", text]]


def free_obstacle(setting: Setting, shown: str, why: str = "begins at rest, where nothing moves") -> str:
    """Why a study has nothing to show where nothing drives the bodies; empty where they are driven."""
    if setting.is_driven:
        return ""
    return (
        f"Nothing drives the bodies, and {shown} {why}: let the base or a force move "
        "them under System; Explore shows their free vibration from an own start."
    )


def engine_obstacle(setting: Setting, question) -> str:
    """Why the engine has no study of the integrator, status or law that is set; empty where it has one."""
    return refusal(question.study) if setting.penalty.has_choices else ""


def refusal(ask: Callable[[], object]) -> str:
    """Why something cannot be asked, in a sentence; empty if it can."""
    try:
        ask()
    except ValueError as error:
        return sentence(message_of(error))
    return ""


def _as_text(statements: list[list[str]]) -> str:
    return " ".join(f"{head}: {text}" for head, text in statements)
