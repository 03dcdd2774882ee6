"""The part of Explore that explains the difference: when the hand rests, and once for all who ask the same."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

from vibroscope.app.explorer import words
from vibroscope.app.explorer.compute import Latest, frame_of
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.tab import Desk
from vibroscope.app.runtime import metrics
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.workers import background_worker, jobs

_RESTS = 150  # ms without another frame before the difference is explained: while a slider moves, the curves come first
_PATIENCE, _LOOKS = 0.5, 0.01  # s that an explanation stands back while curves are waited for; s between two looks
_KEPT = Cache(200)


class Explaining:
    """Explains what is shown, while ``seen()``; ``tell`` gets an explanation that was waited for."""

    def __init__(self, desk: Desk, seen: Callable[[], bool], tell: Callable[[words.Meaning], None]) -> None:
        self.desk = desk
        self._seen = seen
        self._tell = tell
        self._shown: Setting | None = None
        self._frame = 0  # its number, counted from the first that was shown
        self._latest = Latest(
            self._explained,
            solve=_explain,
            grace=0.0,
            pool=background_worker(),
            what="explained",
            measure=metrics.EXPLAINED,
        )

    def follow(self, setting: Setting) -> words.Meaning | None:
        """What explains the setting that is shown now, if it is known; else it comes when the hand rests."""
        self._shown = setting
        self._frame += 1
        meaning = _KEPT.get(_question(setting))
        if meaning is None:
            self.desk.doc.add_timeout_callback(partial(self._ask, self._frame), _RESTS)
        return meaning

    def withdraw(self) -> None:
        """Something else will be shown: what waits is wanted no more."""
        self._latest.withdraw()

    def close(self) -> None:
        """The session has ended."""
        self._latest.close()

    def _ask(self, frame: int) -> None:
        """The hand rests: explain what is shown, if it still is."""
        if self._seen() and frame == self._frame:
            self._latest.submit(0, self._shown)

    def _explained(self, _: int, result: words.Meaning | Exception) -> None:
        """In a worker thread."""
        if isinstance(result, Exception):
            words_for = f"The difference could not be explained ({result}). The figures are right; move on."
            self.desk.later(partial(self.desk.tell, words_for))
        else:
            self.desk.later(self._arrived)

    def _arrived(self) -> None:
        """An explanation has come: tell it if it is of what is shown by now."""
        meaning = _KEPT.get(_question(self._shown))
        if meaning is not None and self._seen():
            self._tell(meaning)


def _question(setting: Setting) -> object:
    """What an explanation depends on: not on how it is drawn."""
    return setting.system, setting.eta, setting.penalty, setting.reference


def _explain(setting: Setting, cancelled: Callable[[], bool] | None = None) -> words.Meaning:
    meaning = _KEPT.get(_question(setting))
    if meaning is None:
        asked = _standing_back(cancelled)
        asked()
        meaning = words.explain(frame_of(setting, asked), asked)
        _KEPT.put(_question(setting), meaning)
    return meaning


def _standing_back(cancelled: Callable[[], bool] | None) -> Callable[[], bool]:
    """Curves come first: whenever it is asked, it waits until nobody waits for any, but not for ever in all."""
    end = time.monotonic() + _PATIENCE

    def asked() -> bool:
        while jobs() and time.monotonic() < end:
            time.sleep(_LOOKS)
        return cancelled is not None and cancelled()

    return asked
