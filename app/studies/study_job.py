"""Studies that grow while a user watches, in threads of their own behind everything else. No panel import.

A study is a generator of partial results, each a whole picture and finer than the one before. The last one of each
study is remembered by its question, so that a study that was cancelled goes on from there.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Protocol

from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.job import Job
from vibroscope.app.runtime.workers import LONG, Workers, lower_priority, own_time, pool

THREADS = 4  # studies that run at the same time, of all sessions
SECONDS = 180.0  # of one study's own time, unless its user says "go on"

RESULTS = Cache(24)  # the last partial result of each study by its question


class PartialResult(Protocol):
    """What a page shows of a study so far."""

    question: object
    share: float  # of all cells that are done

    def data(self) -> dict[str, object]:
        """What is known, for a file: numbers, words, arrays, and dictionaries of those."""


# From a question, an earlier partial result to go on from, and whether it was cancelled.
Grow = Callable[[object, PartialResult | None, Callable[[], bool]], Iterator[PartialResult]]


def study_threads() -> Workers:
    """The threads of all studies; the threads that they start have their low priority too."""
    return pool("study", THREADS, lower_priority, margin=LONG)


class StudyJob(Job):
    """One study under way: ``deliver(job, partial result or exception)`` is called in a worker thread.

    What a cancelled study has found stays in ``results``.
    """

    def __init__(
        self,
        question: object,
        grow: Grow,
        deliver: Callable[[StudyJob, PartialResult | Exception], None],
        results: Cache = RESULTS,
    ) -> None:
        super().__init__(question)
        self._grow = grow
        self._deliver = deliver
        self._results = results
        self.out_of_time = False
        self._begin(study_threads())

    def _answer(self) -> Iterator[None]:
        used, begin = 0.0, own_time()
        growing = self._grow(self.question, self._results.get(self.question), self._poll)
        with contextlib.closing(growing):
            for partial in growing:
                used += own_time() - begin
                self._results.put(self.question, partial)
                if self.cancelled:
                    return
                self.out_of_time = partial.share < 1 and used > SECONDS
                self._deliver(self, partial)
                if self.out_of_time:
                    return
                yield
                begin = own_time()

    def _fail(self, error: Exception) -> None:
        self._deliver(self, error)
