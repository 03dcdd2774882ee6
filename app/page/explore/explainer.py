"""Explains the difference between both solutions: a moment after the last move, and once for all sessions."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from vibroscope.app.explorer.compute import JobQueue, compute_runs
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.explanation import Explanation, explain
from vibroscope.app.explorer.motion_kind import keep_kind
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.tab import TabHost
from vibroscope.app.runtime import metrics
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.workers import background_worker

_REST = 150  # ms without a new result before the difference is explained: while a slider moves, the curves come first
EXPLANATIONS = Cache(200)


class Explainer:
    """Explains what is shown, as long as ``is_visible()``; ``show`` gets an explanation that comes later."""

    def __init__(self, host: TabHost, is_visible: Callable[[], bool], show: Callable[[Explanation], None]) -> None:
        self.host = host
        self._is_visible = is_visible
        self._show = show
        self._setting: Setting | None = None
        self._result = 0  # number of the result that is shown
        self._queue = explanation_queue(self._deliver)

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
            self.host.call_later(partial(self._show_shown, *result))

    def _show_shown(self, setting: Setting, explanation: Explanation) -> None:
        """Show the explanation if it is that of the setting that is shown by now."""
        if self._is_visible() and _key(setting) == _key(self._setting):
            self._show(explanation)


def explanation_queue(deliver: Callable[[int, Explanation | Exception], None]) -> JobQueue:
    """A queue that explains settings in a low-priority thread."""
    return JobQueue(
        deliver,
        solve=_explain,
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


def _explain(setting: Setting, cancelled: Callable[[], bool] | None = None) -> tuple[Setting, Explanation]:
    explanation = EXPLANATIONS.get(_key(setting))
    if explanation is None:
        explanation = explain(compute_runs(setting, cancelled), cancelled, partial(keep_kind, setting))
        EXPLANATIONS.put(_key(setting), explanation)
    return setting, explanation
