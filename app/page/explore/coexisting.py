"""The motions that coexist at the setting: searched for on demand, listed, and run with one click."""

import param
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.asker import StudyAsker
from vibroscope.app.page.shared.component import Component
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
