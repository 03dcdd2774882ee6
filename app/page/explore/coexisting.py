"""The motions that coexist at the setting: searched for on demand, listed, and run with one click."""

from __future__ import annotations

import param
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.files import esm, style
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.tab import TabHost, on_loop
from vibroscope.app.studies.coexisting import Coexisting, CoexistingQuestion, coexisting_content, search_coexisting
from vibroscope.app.studies.study_job import StudyJob


class CoexistingPanel(Component):
    """Sends ``{"find": true}``, ``{"close": true}``, ``{"follow": true}``, ``{"peaks": true}``; draws ``content``.

    A click on a motion sets its start.
    """

    content = param.Dict(
        default={"phase": "idle"},
        doc="phase: idle, running, done, stopped or failed; share; error; and `coexisting_content`",
    )

    _esm = esm("explore/coexisting")
    _stylesheets = [style("shared/scroll_cue", "explore/coexisting")]  # noqa: RUF012 - Panel reads it from the class


class CoexistingMotions:
    """Runs one search at a time; cancels it, and its list, when another system, η or solver is shown."""

    def __init__(self, host: TabHost) -> None:
        self.host = host
        self.view = CoexistingPanel()
        self.view.on_msg(lambda event: self._receive(event.data))
        self._setting: Setting | None = None
        self._job: StudyJob | None = None
        self._result: Coexisting | None = None
        self._phase = "idle"

    def follow(self, setting: Setting) -> None:
        """Follow the setting: its start and its units change the list, anything else that changes motions closes it."""
        before, self._setting = self._setting, setting
        if self._job is None or setting == before:
            return
        if CoexistingQuestion.of(setting) != self._job.question:
            self.cancel()
        elif self._result is not None:
            self._show()

    def hide(self) -> None:
        """Another tab was opened: a list stays, a search ends."""
        if self._phase == "running":
            self.cancel()

    def cancel(self) -> None:
        """Stop the search and remove its list."""
        self.close()
        self._phase = "idle"
        self._show()

    def close(self) -> None:
        """The session has ended: stop the search."""
        if self._job is not None:
            self._job.cancel()
        self._job = self._result = None

    def _receive(self, message: object) -> None:
        if not isinstance(message, dict) or self._setting is None:
            return
        if "find" in message:
            self.close()
            self._phase = "running"
            self._job = StudyJob(
                CoexistingQuestion.of(self._setting), search_coexisting, on_loop(self.host, self._take)
            )
            self._show()
        elif "stop" in message and self._phase == "running":
            self._job.cancel()
            self._phase = "stopped"
            self._show()
        elif "close" in message:
            self.cancel()
        elif "follow" in message:
            setting = self._setting
            self.host.visit("bifurcation", {}, lambda tab: tab.follow(setting))
        elif "peaks" in message:
            self.host.visit("peaks", {})

    def _take(self, job: StudyJob, result: Coexisting | Exception) -> None:
        if isinstance(result, Exception):
            self._phase = "failed"
            self._show(error=f"The search failed ({error_text(result)}). Move a slider, or try again.")
            return
        self._result = result
        self._phase = "done" if result.share == 1 else "stopped" if job.out_of_time else "running"
        self._show()

    def _show(self, **more) -> None:
        listed = coexisting_content(self._result, self._setting) if self._result is not None else {}
        share = round(self._result.share, 2) if self._result is not None else 0.0
        self.view.content = {"phase": self._phase, "share": share, **listed, **more}
