"""Studies that grow while one watches: threads of their own behind everything else, and what was found is kept.

A study is a generator of stages, each a whole picture, finer than the one before. No panel import.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Protocol

from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.job import Job, lower_priority
from vibroscope.app.runtime.workers import Workers, pool

_THREADS = 4  # studies that run at the same time, of all sessions
_LONGEST = 180.0  # seconds of one study, unless its user says "go on"
_KEPT = 24

KEPT = Cache(_KEPT)  # the last stage of each study by its question; one that was cancelled goes on from there


class Stage(Protocol):
    """A study as far as it has come."""

    share: float  # of all cells that are done

    def data(self) -> dict[str, object]:
        """What is known, for a file: numbers, words, arrays, and dictionaries of those."""


Refine = Callable[[object, Stage | None, Callable[[], bool]], Iterator[Stage]]


def studies() -> Workers:
    """The threads of all studies; what they start inherits their priority."""
    return pool("study", _THREADS, lower_priority)


class Live(Job):
    """One study under way: ``deliver(live, stage or exception)`` is called in a worker thread as stages come.

    What a cancelled one has found is kept.
    """

    def __init__(
        self, question: object, refine: Refine, deliver: Callable[[Live, Stage | Exception], None], kept=KEPT
    ) -> None:
        super().__init__(question)
        self._refine = refine
        self._deliver = deliver
        self._kept = kept
        self.exhausted = False  # it has had its time
        self._begin(studies())

    def _answer(self) -> None:
        end = time.monotonic() + _LONGEST
        for stage in self._refine(self.question, self._kept.get(self.question), self._cancelled.is_set):
            self._kept.put(self.question, stage)
            if self.cancelled:
                return
            self.exhausted = stage.share < 1 and time.monotonic() > end
            self._deliver(self, stage)
            if self.exhausted:
                return

    def _fail(self, error: Exception) -> None:
        self._deliver(self, error)
