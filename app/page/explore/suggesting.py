"""The part of Explore that suggests K, D and Δτ: one search at a time, withdrawn when its question no longer holds."""

from __future__ import annotations

from functools import partial

from vibroscope.app.explorer.state import Refused, Setting
from vibroscope.app.explorer.suggestion import Search, question_of, told_of
from vibroscope.app.page.explore.suggest import Suggest
from vibroscope.app.page.tab import Desk
from vibroscope.engine import Recommendation

_IDLE = {"phase": "idle"}


class Suggesting:
    """Wires `app.page.explore.suggest` to `app.explorer.suggestion`."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self.view = Suggest(self._ask, self.withdraw)
        self._setting: Setting | None = None
        self._search: Search | None = None

    def follow(self, setting: Setting) -> None:
        """Take what is set now: what was asked for another system, η or reference is withdrawn, with its answer."""
        self._setting = setting
        if self._search is not None:
            asked = self._search.question
            if asked != question_of(setting, f"{100 * asked.tolerance:.12g}"):
                self.withdraw()

    def withdraw(self) -> None:
        """Stop what runs and take back what was told."""
        if self._search is not None:
            self._search.cancel()
            self._search = None
        self._say(_IDLE)

    @property
    def front(self) -> dict[str, list[float]]:
        """Columns of what was found, where it is drawn; empty where it is not."""
        points = self.view.told.get("front", [])
        if len(points) < 2:
            return {}
        steps, errors, texts = zip(*points, strict=True)
        return {"steps": [*steps], "error": [*errors]} | {n: [float(each[n]) for each in texts] for n in ("K", "D")}

    def close(self) -> None:
        """The session has ended."""
        if self._search is not None:
            self._search.cancel()

    def _ask(self, percent: object) -> None:
        if self._setting is None:
            return
        self.withdraw()
        try:
            question = question_of(self._setting, percent)
        except Refused as error:
            self._say({"phase": "failed", "error": str(error)})
            return
        self._say({"phase": "running", "share": 0.0})
        self._search = Search(question, self._progressed, self._found)

    def _progressed(self, search: Search, share: float) -> None:
        """In a worker thread."""
        self.desk.later(partial(self._tell, search, {"phase": "running", "share": round(share, 2)}))

    def _found(self, search: Search, found: Recommendation | Exception) -> None:
        """In a worker thread."""
        self.desk.later(partial(self._arrived, search, found))

    def _tell(self, search: Search, told: dict) -> None:
        if search is self._search:
            self._say(told)

    def _say(self, told: dict) -> None:
        """The front that it may draw can be taken away."""
        self.view.told = told
        self.desk.offer()

    def _arrived(self, search: Search, found: Recommendation | Exception) -> None:
        if isinstance(found, Exception):
            error = f"The search failed ({found}). Ask for another tolerance, or move η."
            self._tell(search, {"phase": "failed", "error": error})
            return
        told = told_of(found)
        self._tell(search, {"phase": "done", **told})
        if search is self._search and told["met"] and told["use"]:
            self.desk.set(told["use"])
