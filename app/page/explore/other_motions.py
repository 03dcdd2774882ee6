"""Motions other than those that are run: which coexist at the setting, and one that was opened from a branch.

The motions that coexist are searched for on demand, listed, and run with one click. Of a motion of the bifurcation
diagram is said what to know of it, while it is set.
"""

from collections.abc import Callable, Mapping

import param
from vibroscope.app.explorer.closed_orbit import ClosedOrbit, linked_orbit
from vibroscope.app.explorer.present import Columns
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.asker import StudyAsker
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.shared.seen import orbit_words
from vibroscope.app.page.tab import TabHost
from vibroscope.app.studies.coexisting import CoexistingQuestion, coexisting_content, search_coexisting


class CoexistingPanel(Component):
    """Sends ``{"find": true}``, ``{"close": true}``, ``{"follow": true}``, ``{"peaks": true}``; draws ``content``.

    A click on a motion sets its start.
    """

    content = param.Dict(
        default={"phase": "idle"},
        doc="phase: idle, running, done, stopped or failed; share; error; and `coexisting_content`",
    )

    script = "explore/coexisting"
    sheets = ("shared/scroll_cue",)


class CoexistingMotions:
    """Runs one search at a time; cancels it, and its list, when another system, η or solver is shown."""

    def __init__(self, host: TabHost) -> None:
        self.host = host
        self.view = CoexistingPanel()
        shows = {"close": (bool, lambda _: self.cancel()), "peaks": (bool, lambda _: host.visit("peaks", {}))}
        self.view.listen(find=(bool, self._find), stop=(bool, self._stop), follow=(bool, self._follow_motion), **shows)
        self._setting: Setting | None = None
        self._study = StudyAsker(host, search_coexisting, self._show)

    def follow(self, setting: Setting) -> None:
        """Follow the setting: its start and its units change the list, anything else that changes motions closes it."""
        before, self._setting = self._setting, setting
        if self._study.question is None or setting == before:
            return
        if CoexistingQuestion.of(setting) != self._study.question:
            self.cancel()
        elif self._study.result is not None:
            self._show()

    def hide(self) -> None:
        """Another tab was opened: a list stays, a search ends."""
        if self._study.job is not None:
            self.cancel()

    def cancel(self) -> None:
        """Stop the search and remove its list."""
        self.close()
        self._show()

    def close(self) -> None:
        """The session has ended: stop the search."""
        self._study.forget()
        self._study.result = None

    def _find(self, _: bool) -> None:
        if self._setting is not None:
            self.close()
            self._study.follow(CoexistingQuestion.of(self._setting))
            self._show()

    def _stop(self, _: bool) -> None:
        if self._study.job is not None:
            self._study.stop(True)
            self._show()

    def _follow_motion(self, _: bool) -> None:
        if (setting := self._setting) is not None:
            self.host.visit("bifurcation", {}, lambda tab: tab.follow(setting))

    def _phase(self) -> str:
        study = self._study
        if study.question is None:
            return "idle"
        return "failed" if study.failed else "stopped" if study.stopped else "done" if study.share == 1 else "running"

    def _show(self) -> None:
        study, phase = self._study, self._phase()
        listed = coexisting_content(study.result, self._setting) if study.result is not None else {}
        why = f"The search failed ({study.failed}). Move a slider, or try again."
        failed = {"error": why} if phase == "failed" else {}
        self.view.content = {"phase": phase, "share": round(study.share, 2), **listed, **failed}


class OpenedMotion(Component):
    """A line above the figures."""

    words = param.String(default="", doc="What to know of the motion")

    script = "explore/opened"

    def __init__(self, **params) -> None:
        super().__init__(visible=False, **params)
        self._texts: Mapping[str, str] = {}
        self._setting: Setting | None = None  # of the motion, once it is set
        self._orbit: ClosedOrbit | None = None
        self._linked: Mapping[str, float] = {}  # what a link says of it, until the first setting is shown
        self.on_close: Callable[[], None] = lambda: None  # called when the user closes the line
        self.listen(close=(bool, self._close))

    def announce(self, texts: Mapping[str, str], words: str, orbit: ClosedOrbit) -> None:
        """Show these words as soon as, and as long as, the setting is that of ``texts``."""
        self._texts, self._setting, self._orbit, self.words = texts, None, orbit, words
        self._linked = {}

    def restore(self, choice: Mapping[str, float]) -> None:
        """Show the motion that a link names beside the setting that is followed next."""
        self._linked = choice

    def choice(self) -> dict[str, float]:
        """The numbers of the motion for a link; none if it is not shown."""
        return self._orbit.linked(self._setting) if self.visible else {}

    def columns(self, setting: Setting) -> Columns:
        """The motion in the phase plots; empty if it is not that of the setting."""
        return self._orbit.columns(setting) if self.visible else {}

    def follow(self, setting: Setting) -> None:
        """Follow the setting: another motion has nothing to do with the words."""
        if self._linked:
            self._take_linked(setting)
        if self._setting is None and self._texts:
            given = setting.texts()
            if all(given[name] == text for name, text in self._texts.items() if name != "zero_start"):
                self._setting = setting
        known = self._setting is not None and setting.drawn_like(self._setting) == self._setting
        if known != self.visible:
            self.visible = known

    def _take_linked(self, setting: Setting) -> None:
        orbit, self._linked = linked_orbit(self._linked, setting), {}
        if orbit is not None:
            self._setting, self._orbit = setting, orbit
            self.words = orbit_words(orbit, orbit.largest_multiplier())

    def _close(self, _: bool) -> None:
        self.close()
        self.on_close()

    def close(self) -> None:
        """Show nothing more."""
        self._texts, self._setting, self._linked, self.visible = {}, None, {}, False
