"""The pinned result behind the live one: computed once, and drawn again when it is drawn in another way."""

from __future__ import annotations

from collections.abc import Callable

import panel as pn
from vibroscope.app.explorer.compute import JobQueue, RunPair, cached_runs
from vibroscope.app.explorer.errors import error_text
from vibroscope.app.explorer.present import Columns, present
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.tab import TabHost
from vibroscope.app.page.updates import prepare_in_worker

_DRAWING_FIELDS = ("frame", "units", "omega1", "m1", "amplitude")  # how a result is drawn; it does not depend on them


class PinnedResult:
    """Draws the host's pinned setting; ``draw`` gets its columns, or None if nothing is pinned.

    ``make_queue`` makes the queue of its computations, and ``cached`` gives the runs that need none.
    """

    def __init__(
        self,
        host: TabHost,
        draw: Callable[[dict[str, Columns] | None], None],
        make_queue: Callable[..., JobQueue] = JobQueue,
        cached: Callable[[Setting], RunPair | None] = cached_runs,
    ) -> None:
        self.host = host
        self._draw = draw
        self._cached = cached
        self._queue = make_queue(prepare_in_worker(host.call_later, _prepare, self._show, self._fail))
        self._wanted: Setting | None = None

    def follow(self, setting: Setting) -> None:
        """Draw the pinned setting like ``setting`` unless that is done or under way: now if it is cached, or later."""
        pinned = self.host.pinned
        wanted = pinned and pinned._replace(**{name: getattr(setting, name) for name in _DRAWING_FIELDS})
        if wanted == self._wanted:
            return
        self._wanted = wanted
        runs = self._cached(wanted) if wanted else None
        if wanted and runs is None:
            self._queue.submit(0, wanted)
            return
        self._queue.withdraw()
        self._draw(present(runs) if runs else None)

    def close(self) -> None:
        """The session has ended."""
        self._queue.close()

    def _show(self, _: int, result: tuple[Setting, dict[str, Columns]]) -> None:
        """Also while another tab is open, since nothing would request the result again."""
        setting, columns = result
        if setting == self._wanted:
            with pn.io.hold(self.host.doc):
                self._draw(columns)

    def _fail(self, _: int, error: Exception) -> None:
        if self._wanted is not None:
            self._draw(None)
            self.host.report_error(
                f"The pinned setting could not be computed ({error_text(error)}). Unpin it, or pin another setting."
            )


def _prepare(runs: RunPair) -> tuple[Setting, dict[str, Columns]]:
    return runs.setting, present(runs)
