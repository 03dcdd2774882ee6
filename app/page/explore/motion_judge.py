"""Judges the kinds of both motions of the setting that is shown, a moment after the last move."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

from vibroscope.app.explorer.compute import JobQueue
from vibroscope.app.explorer.motion_kind import Kinds, judge_motions, kind_threads, known_kinds
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.tab import TabHost
from vibroscope.app.runtime import metrics
from vibroscope.app.runtime.workers import background_worker

_REST = 400  # ms without a new result: curves and explanation come first, those of other sessions for some seconds
_PATIENCE = 3.0  # s


class MotionJudge:
    """Judges what is shown; ``show`` gets kinds that come later than the figures."""

    def __init__(self, host: TabHost, show: Callable[[Kinds], None]) -> None:
        self.host = host
        self._show = show
        self._setting: Setting | None = None  # the one that is shown
        self._queue = JobQueue(
            self._deliver,
            solve=self._judge,
            grace=0.0,
            pool=kind_threads(),
            what="judged",
            measure=metrics.JUDGED,
        )

    def follow(self, setting: Setting) -> Kinds | None:
        """The kinds of both motions of the setting that is shown now, if known; else ``show`` gets them later."""
        self._setting = setting
        kinds = known_kinds(setting)
        if kinds is None:
            self._request_later(setting, time.monotonic() + _PATIENCE)
        return kinds

    def cancel(self) -> None:
        """Nothing is shown, or another setting will be: stop."""
        self._setting = None
        self._queue.drop_waiting()

    def close(self) -> None:
        """The session has ended."""
        self._queue.close()

    def _request_later(self, setting: Setting, latest: float) -> None:
        self.host.doc.add_timeout_callback(partial(self._request, setting, latest), _REST)

    def _request(self, setting: Setting, latest: float) -> None:
        if setting is not self._setting:
            return
        if background_worker().jobs and time.monotonic() < latest:
            self._request_later(setting, latest)
        else:
            self._queue.submit(0, setting)

    def _judge(self, setting: Setting, cancelled: Callable[[], bool]) -> tuple[Setting, Kinds]:
        """Judge both motions; runs in a worker thread."""
        return setting, judge_motions(setting, lambda: cancelled() or setting is not self._setting)

    def _deliver(self, _: int, result: tuple[Setting, Kinds] | Exception) -> None:
        """Hand the kinds to the session's loop; runs in a worker thread. An error is only logged."""
        if not isinstance(result, Exception):
            self.host.call_later(partial(self._deliver_shown, *result))

    def _deliver_shown(self, setting: Setting, kinds: Kinds) -> None:
        if setting is self._setting:
            self._show(kinds)
