"""Suggest K, D, Δτ: the input of a tolerance, a search in the background, and its result."""

import math

import param
from vibroscope.app.codes.catalogue import Code, codes
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.explanation import Explanation
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.suggestion import (
    SoFar,
    begin_search,
    default_limits,
    make_question,
    offered_tolerance,
    partial_content,
    suggestion_content,
)
from vibroscope.app.page.asker import Asker
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.tab import TabHost, on_loop
from vibroscope.app.runtime.job import Answer
from vibroscope.engine import Recommendation


class SuggestPanel(Component):
    """Sends ``{"suggest": what `make_question` reads}`` and ``{"cancel": true}``; draws ``content``."""

    limits = param.Dict(default={}, doc="Limits and tolerances of a search, as texts, until others are typed")

    content = param.Dict(
        default={"phase": "idle"},
        doc="phase: idle, running, done or failed; share; error; and `app.explorer.suggestion.suggestion_content`, "
        "while running `partial_content`; moved: whether K, D or Δτ were moved since, so that nothing was set",
    )

    code = param.String(default="", doc="name of the code that the tab Your code has chosen; empty: none")

    offer = param.String(default="5", doc="the tolerance in the field until one is typed")

    script = "explore/suggest"
    sheets = ("shared/scroll_cue",)


class Suggester:
    """Runs one search at a time; cancels it, and its result, when its question no longer holds."""

    def __init__(self, host: TabHost) -> None:
        self.host = host
        self.view = SuggestPanel(limits=default_limits(Setting()))
        self.view.listen(suggest=(object, self.suggest), cancel=(object, lambda _: self.cancel()))
        self._setting: Setting | None = None
        self._asker = Asker(host)
        self._asked: Setting | None = None  # the setting at which the search began
        self._found: Recommendation | None = None  # by the search, once it is done
        self._searched_code: Code | None = None  # over which the search was asked
        self._moved = False  # whether K, D or Δτ were moved before it was

    def follow(self, setting: Setting) -> None:
        """Follow the setting: a search for another system, η or reference is cancelled, and units are those shown."""
        before, self._setting = self._setting, setting
        code = self._code
        self.view.code = code.name if code else ""
        limits = default_limits(setting)
        if limits != self.view.limits:
            self.view.limits = limits
        if self._found is not None and (setting.scale, setting.initial) != (before.scale, before.initial):
            self._show_found(self._found)
        if self._asker.job is not None:
            question = self._asker.job.question
            if question != question.follow(setting):
                self.cancel()

    @property
    def _code(self) -> Code | None:
        return codes().get(self.host.code)

    def offer(self, explanation: Explanation) -> None:
        """Offer a tolerance that can be met where this difference is."""
        self.view.offer = offered_tolerance(explanation)

    def cancel(self) -> None:
        """Stop the search and remove its result."""
        self.close()
        self._show(phase="idle")

    def close(self) -> None:
        """The session has ended: stop the search."""
        self._asker.drop()
        self._found = None

    @property
    def front(self) -> dict[str, list[float]]:
        """Columns of the front that was found; empty if none is drawn, or while it grows."""
        points = self.view.content.get("front", []) if self._found is not None else []
        if len(points) < 2:
            return {}
        steps, errors, texts, *_ = zip(*points, strict=True)
        fields = {name: shown_field(name, self._setting) for name in ("K", "D")}
        numbers = {
            field.column: [field.factor * float(point[name]) for point in texts] for name, field in fields.items()
        }
        return {"steps": [*steps], "error": [*errors], **numbers}

    @property
    def tolerance(self) -> float:
        """The tolerance that the front was searched for; nan while there is none."""
        return self.view.content.get("tolerance", math.nan)

    @property
    def sentences(self) -> list[str]:
        """The result of the search in words; empty while there is none."""
        content = self.view.content
        return [f"{content['head']}.", *content["lines"]] if self._found is not None else []

    def suggest(self, typed: object) -> None:
        """Search for a setting, with the tolerance and the limits that were typed."""
        if self._setting is None:
            return
        self.cancel()
        try:
            wanted = isinstance(typed, dict) and typed.get("code") == "yes" and self._code
            self._searched_code = wanted or None
            question = make_question(self._setting, typed, wanted.schemes() if wanted else ())
        except Refused as error:
            self._show(phase="failed", error=str(error))
            return
        self._show(phase="running", share=0.0)
        self._asked = self._setting
        self._asker.ask(lambda: begin_search(question, on_loop(self.host, self._take)))

    def _take(self, _: Answer, found: tuple[float, SoFar] | Recommendation | Exception) -> None:
        """Show the progress of the search, its result, or that it failed."""
        if isinstance(found, tuple):
            share, so_far = found
            self._show(phase="running", share=round(share, 2), **partial_content(so_far, self._setting))
            return
        if isinstance(found, Exception):
            self._show(phase="failed", error=f"The search failed ({found}). Ask for another tolerance, or move η.")
            return
        self._found = found
        # The user may have changed the setting meanwhile (a scene of the same η, a point of the front): keep that.
        self._moved = _searched(self._setting) != _searched(self._asked)
        content = self._show_found(found)
        if content["met"] and content["use"] and not self._moved:
            self.host.set(content["use"])

    def _show_found(self, found: Recommendation) -> dict:
        """Show the result of the search in the units of the setting, and return what is shown."""
        content = suggestion_content(found, self._setting) | {"moved": self._moved}
        if self._searched_code and found.best:
            setting, code = self._setting, self._searched_code
            words = code.words_for(setting.system, setting.eta, found.method, setting.scale)
            content["lines"] = [*content["lines"], f"What to set in {code.name}: {'; '.join(words)}"]
        self._show(phase="done", **content)
        return content

    def _show(self, **content) -> None:
        self.view.content = content
        self.host.update_offers()  # with the front, a figure to take away comes or goes


def _searched(setting: Setting) -> tuple[float, float, int]:
    """The numbers that a search sets."""
    return setting.K, setting.D, setting.steps
