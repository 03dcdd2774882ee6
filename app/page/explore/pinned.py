"""The pinned results beside the live one: each is computed once, and drawn again when it is drawn in another way."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import panel as pn
from vibroscope.app.explorer.compute import JobQueue, RunPair, cached_runs
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.present import Columns
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.explore.explainer import explanation_queue, known_explanation
from vibroscope.app.page.explore.result import Result, prepare
from vibroscope.app.page.tab import TabHost
from vibroscope.app.page.updates import prepare_in_worker


class PinnedResults:
    """Finds the results of the host's pinned settings, one after the other, then their explanations.

    ``draw`` is called when one has come, or a pin has come or gone. ``make_queue`` and ``make_explainer`` make the
    queues of the computations, and ``cached`` gives the runs that need none.
    """

    def __init__(
        self,
        host: TabHost,
        draw: Callable[[], None],
        make_queue: Callable[..., JobQueue] = JobQueue,
        make_explainer: Callable[..., JobQueue] = explanation_queue,
        cached: Callable[[Setting], RunPair | None] = cached_runs,
    ) -> None:
        self.host = host
        self._draw = draw
        self._cached = cached
        self._queue = make_queue(prepare_in_worker(host.call_later, prepare, self._show, self._fail))
        self._explainer = make_explainer(lambda _, found: host.call_later(lambda: self._explained(found)))
        self._wanted: tuple[Setting, ...] = ()
        self._results: dict[Setting, Result | None] = {}  # None: it could not be computed
        self._ready: dict[Setting, Result] = {}  # prepared ahead
        self._computing: Setting | None = None
        self._explaining: Setting | None = None
        self._unexplained: set[Setting] = set()  # their explanation has failed

    @property
    def results(self) -> list[tuple[Setting, Result | None]]:
        """The pinned settings, drawn like the present one, with the results that are there."""
        return [(setting, self._results.get(setting)) for setting in self._wanted]

    def columns(self, live: Setting) -> list[dict[str, Columns]]:
        """The columns to be drawn of each pin; a reference that is the live one is left out."""
        return [_without_reference(result, live) if result else {} for _, result in self.results]

    def prepare_like(self, setting: Setting) -> None:
        """Prepare the pinned settings that are cached to be drawn like ``setting``; in a worker, ahead of `follow`."""
        pins = (pinned.drawn_like(setting) for pinned in self.host.pinned)
        known = self._results
        runs = {pinned: self._cached(pinned) for pinned in pins if pinned not in known}
        self._ready = {pinned: prepare(found) for pinned, found in runs.items() if found is not None}

    def follow(self, setting: Setting) -> None:
        """Draw the pinned settings like ``setting``: those that are cached now, the others when they come."""
        wanted = tuple(pinned.drawn_like(setting) for pinned in self.host.pinned)
        if not (wanted or self._wanted):
            return
        self._wanted, ready = wanted, self._ready
        self._results = {pinned: result for pinned, result in self._results.items() if pinned in wanted}
        for pinned in wanted:
            if pinned in self._results:
                continue
            if pinned in ready:
                self._results[pinned] = ready[pinned]
            elif (runs := self._cached(pinned)) is not None:
                self._results[pinned] = prepare(runs)
        self._draw()
        self._continue()

    def close(self) -> None:
        """The session has ended."""
        self._queue.close()
        self._explainer.close()

    def _continue(self) -> None:
        """Request what comes next, unless something is under way that is still wanted."""
        if self._computing not in self._wanted:
            self._computing = next((pinned for pinned in self._wanted if pinned not in self._results), None)
            if self._computing is not None:
                self._queue.submit(0, self._computing)
        if self._explaining not in self._wanted:
            ready = [pinned for pinned in self._wanted if self._results.get(pinned) and pinned not in self._unexplained]
            self._explaining = next((pinned for pinned in ready if known_explanation(pinned) is None), None)
            if self._explaining is not None:
                self._explainer.submit(0, self._explaining)

    def _show(self, _: int, result: Result) -> None:
        """Also while another tab is open, since nothing would request the result again."""
        self._computed(result.setting, result)

    def _fail(self, _: int, error: Exception) -> None:
        failed = self._computing
        if failed in self._wanted:
            self.host.report_error(
                f"A pinned setting could not be computed ({error_text(error)}). Unpin it, or pin another setting."
            )
            self._computed(failed, None)

    def _computed(self, setting: Setting, result: Result | None) -> None:
        self._computing = None
        if setting in self._wanted:
            self._results[setting] = result
            with pn.io.hold(self.host.doc):
                self._draw()
        self._continue()

    def _explained(self, found: object) -> None:
        if isinstance(found, Exception) and self._explaining is not None:
            self._unexplained.add(self._explaining)
        self._explaining = None
        with pn.io.hold(self.host.doc):
            self._draw()
        self._continue()


def _reference_run(setting: Setting) -> tuple:
    return setting.system, setting.eta, setting.reference, setting.initial


def _without_reference(result: Result, live: Setting) -> dict[str, Columns]:
    setting = result.setting
    if _reference_run(setting) != _reference_run(live):
        return result.columns
    return {
        source: {
            name: np.full_like(column, np.nan) if "reference" in source or name.startswith("reference") else column
            for name, column in columns.items()
        }
        for source, columns in result.columns.items()
    }
