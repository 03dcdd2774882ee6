"""Explains the difference between both solutions: a moment after the last move, and once for all sessions."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial

from vibroscope.app.explorer.compute import JobQueue, compute_runs
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.explanation import AloneFacts, Explanation, explain
from vibroscope.app.explorer.motion_kind import keep_kind
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.tab import TabHost
from vibroscope.app.runtime import metrics
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.workers import background_worker

_APART = 0.2  # s between curves of a search that are shown while it runs
_REST = 150  # ms without a new result before the difference is explained: while a slider moves, the curves come first
EXPLANATIONS = Cache(200)


class Explainer:
    """Explains what is shown, as long as ``is_visible()``.

    ``show`` gets an explanation that comes later, ``show_alone`` before it `Explanation.alone` as far as it is known.
    """

    def __init__(
        self,
        host: TabHost,
        is_visible: Callable[[], bool],
        show: Callable[[Explanation], None],
        show_alone: Callable[[AloneFacts], None] = lambda facts: None,
    ) -> None:
        self.host = host
        self._is_visible = is_visible
        self._show, self._show_alone = show, show_alone
        self._setting: Setting | None = None
        self._result = 0  # number of the result that is shown
        self._queue = explanation_queue(self._deliver, self._deliver_alone)

    def follow(self, setting: Setting) -> Explanation | None:
        """The explanation of the setting that is shown now, if it is cached; else ``show`` gets it later."""
        self._setting = setting
        self._result += 1
        explanation = EXPLANATIONS.get(_key(setting))
        if explanation is None:
            self.host.doc.add_timeout_callback(partial(self._request, self._result), _REST)
        return explanation

    def cancel(self) -> None:
        """Another setting will be shown: stop, or its explanation would wait for one that nobody needs any more."""
        self._queue.cancel()

    def close(self) -> None:
        """The session has ended."""
        self._queue.close()

    def _request(self, result: int) -> None:
        if self._is_visible() and result == self._result:
            self._queue.submit(0, self._setting)

    def _deliver(self, _: int, result: tuple[Setting, Explanation] | Exception) -> None:
        """Hand a result, or the error in its place, to the session's loop; runs in a worker thread."""
        if isinstance(result, Exception):
            text = f"The difference could not be explained ({error_text(result)}). The figures are right; move on."
            self.host.call_later(partial(self.host.report_error, text))
        else:
            self.host.call_later(partial(self._show_shown, self._show, *result))

    def _deliver_alone(self, setting: Setting, facts: AloneFacts) -> None:
        """Hand curves to the session's loop; runs in a worker thread."""
        self.host.call_later(partial(self._show_shown, self._show_alone, setting, facts))

    def _show_shown(self, show: Callable[[object], None], setting: Setting, found: object) -> None:
        """Show what was found if it is of the setting that is shown by now."""
        if self._is_visible() and _key(setting) == _key(self._setting):
            show(found)


def explanation_queue(
    deliver: Callable[[int, Explanation | Exception], None],
    deliver_alone: Callable[[Setting, AloneFacts], None] = lambda setting, facts: None,
) -> JobQueue:
    """A queue that explains settings in a low-priority thread; ``deliver_alone`` gets the curves that come first."""
    return JobQueue(
        deliver,
        solve=partial(_explain, deliver_alone=deliver_alone),
        grace=0.0,
        pool=background_worker(),
        what="explained",
        measure=metrics.EXPLAINED,
    )


def known_explanation(setting: Setting) -> Explanation | None:
    """The explanation of a setting if it is cached."""
    return EXPLANATIONS.get(_key(setting))


def _key(setting: Setting) -> object:
    """Everything that an explanation depends on."""
    return setting.system, setting.eta, setting.penalty, setting.reference, setting.initial


def _explain(
    setting: Setting,
    cancelled: Callable[[], bool] | None = None,
    deliver_alone: Callable[[Setting, AloneFacts], None] = lambda setting, facts: None,
) -> tuple[Setting, Explanation]:
    explanation = EXPLANATIONS.get(_key(setting))
    if explanation is None:
        on_alone = _now_and_then(partial(deliver_alone, setting))
        explanation = explain(compute_runs(setting, cancelled), cancelled, partial(keep_kind, setting), on_alone)
        EXPLANATIONS.put(_key(setting), explanation)
    return setting, explanation


def _now_and_then(act: Callable[[AloneFacts], None]) -> Callable[[AloneFacts], None]:
    """``act`` for those calls that come some time after the last one: the session's loop has figures to draw."""
    last = -math.inf

    def call(facts: AloneFacts) -> None:
        nonlocal last
        if time.monotonic() >= last + _APART:
            last = time.monotonic()
            act(facts)

    return call
