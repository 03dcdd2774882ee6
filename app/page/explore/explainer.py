"""What is found of the setting that is shown, a moment after the last move: its explanation, the kinds of motion."""

import math
import time
from collections.abc import Callable
from functools import partial

from vibroscope.app.explorer.compute import compute_runs, needed
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.explanation import AloneFacts, Explanation, explain
from vibroscope.app.explorer.motion_kind import Kinds, judge_motions, keep_kind, kind_threads, known_kinds
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.asker import Asker
from vibroscope.app.page.tab import TabHost, on_loop
from vibroscope.app.runtime import metrics
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.job import Answer
from vibroscope.app.runtime.workers import background_worker
from vibroscope.engine import Compiled
from vibroscope.engine.arguments import Poll

_APART = 0.2  # s between curves of a search that are shown while it runs
_REST = 150  # ms without a new result before the difference is explained: while a slider moves, the curves come first
EXPLANATIONS = Cache(200)


class Explainer(Asker):
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
        super().__init__(host, _REST)
        self._is_visible = is_visible
        self._show, self._show_alone = show, show_alone

    def follow(self, setting: Setting) -> Explanation | None:
        """The explanation of the setting that is shown now, if it is cached; else ``show`` gets it later."""
        explanation = known_explanation(setting)
        if explanation is None:
            self.ask(partial(self._begin_if_visible, setting))
        else:
            self.drop()
        return explanation

    def _begin_if_visible(self, setting: Setting) -> Answer | None:
        return begin_explanation(setting, on_loop(self._host, self._take)) if self._is_visible() else None

    def _take(self, _: Answer, found: AloneFacts | Explanation | Exception) -> None:
        if isinstance(found, Exception):
            text = f"The difference could not be explained ({error_text(found)}). The figures are right; move on."
            self._host.report_error(text)
        elif self._is_visible():
            (self._show_alone if isinstance(found, dict) else self._show)(found)


def begin_explanation(setting: Setting, deliver: Callable[[Answer, object], None]) -> Answer:
    """Explain a setting in a low-priority thread; ``deliver`` gets curves, `AloneFacts`, and then the `Explanation`."""
    needs = needed(setting, Compiled.VERDICTS)
    return Answer(
        setting, _explain, deliver, background_worker(), "explanation", measure=metrics.EXPLAINED, needs=needs
    )


def known_explanation(setting: Setting) -> Explanation | None:
    """The explanation of a setting if it is cached."""
    return EXPLANATIONS.get(_key(setting))


def _key(setting: Setting) -> object:
    """Everything that an explanation depends on."""
    return setting.system, setting.eta, setting.penalty, setting.reference, setting.initial


def _explain(setting: Setting, cancelled: Poll, report: Callable[[AloneFacts], None]) -> Explanation:
    how = cancelled, partial(keep_kind, setting), _now_and_then(report)
    return EXPLANATIONS.get_or(_key(setting), lambda: explain(compute_runs(setting, cancelled), *how))


def _now_and_then(act: Callable[[AloneFacts], None]) -> Callable[[AloneFacts], None]:
    """``act`` for those calls that come some time after the last one: the session's loop has figures to draw."""
    last = -math.inf

    def call(facts: AloneFacts) -> None:
        nonlocal last
        if time.monotonic() >= last + _APART:
            last = time.monotonic()
            act(facts)

    return call


_REST_OF_KINDS = 400  # ms: curves and explanation come first, those of other sessions for some seconds
_PATIENCE = 3.0  # s


class MotionJudge(Asker):
    """Judges what is shown; ``show`` gets kinds that come later than the figures."""

    def __init__(self, host: TabHost, show: Callable[[Kinds], None]) -> None:
        super().__init__(host, _REST_OF_KINDS)
        self._show = show

    def follow(self, setting: Setting) -> Kinds | None:
        """The kinds of both motions of the setting that is shown now, if known; else ``show`` gets them later."""
        self.drop()
        kinds = known_kinds(setting)
        if kinds is None:
            self.ask(partial(self._begin_when_idle, setting, time.monotonic() + _PATIENCE))
        return kinds

    def _begin_when_idle(self, setting: Setting, latest: float) -> Answer | None:
        if background_worker().jobs and time.monotonic() < latest:
            self.ask(partial(self._begin_when_idle, setting, latest))
            return None
        needs = needed(setting, Compiled.VERDICTS)
        take = on_loop(self._host, self._take)
        return Answer(setting, _judge, take, kind_threads(), "kinds", measure=metrics.JUDGED, needs=needs)

    def _take(self, _: Answer, kinds: Kinds | Exception) -> None:
        """Show the kinds; an error is only logged."""
        if not isinstance(kinds, Exception):
            self._show(kinds)


def _judge(setting: Setting, cancelled: Poll, _: Callable) -> Kinds:
    return judge_motions(setting, cancelled)
