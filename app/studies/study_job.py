"""Studies that grow while a user watches, in threads of their own behind everything else. No panel import.

A study is a generator of partial results, each a whole picture and finer than the one before. The last one of each
study is remembered by its question, so that a study that was cancelled goes on from there. While a study is under way,
whoever asks the same question waits for the same results; when its job ends early, one that waits goes on from there.
"""

import contextlib
import threading
from collections.abc import Callable, Iterator
from typing import Protocol

from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.job import Job
from vibroscope.app.runtime.workers import LONG, Workers, lower_priority, own_time, pool
from vibroscope.engine.arguments import Poll

THREADS = 4  # studies that run at the same time, of all sessions
SECONDS = 180.0  # of one study's own time, unless its user says "go on"

RESULTS = Cache(24)  # the last partial result of each study by its question

_computing: "dict[tuple[int, object], StudyJob]" = {}  # what is under way, by its memory of results and its question
_lock = threading.Lock()  # of that, and of who waits for it


class PartialResult(Protocol):
    """The results of a study so far, as a page shows them."""

    question: object
    share: float  # of all cells that are done

    def data(self) -> dict[str, object]:
        """The results so far, for a file: numbers, words, arrays, and dictionaries of those."""


# From a question, an earlier result to go on from, which is a part, and whether it was cancelled.
Grow = Callable[[object, PartialResult | None, Poll], Iterator[PartialResult]]


def study_threads() -> Workers:
    """The threads of all studies; the threads that they start have their low priority too."""
    return pool("study", THREADS, lower_priority, margin=LONG)


class StudyJob(Job):
    """One user's study under way: ``deliver(job, partial result or exception)`` is called in a worker thread.

    What a cancelled study has found stays in ``results``. A study that another job of the process computes is not
    computed again: this job waits for the other's results, and computes on where the other ends without the last one.
    The other goes on while anybody waits, even when it is cancelled.

    ``threads`` are by default those of all studies.

    Attributes
    ----------
    deliver : callable
    waiting : list of StudyJob
        For the results of this one.
    out_of_time : bool
        Whether it stopped after `SECONDS`.
    """

    def __init__(
        self,
        question: object,
        grow: Grow,
        deliver: "Callable[[StudyJob, PartialResult | Exception], None]",
        results: Cache = RESULTS,
        threads: Workers | None = None,
    ) -> None:
        super().__init__(question, "study")
        self._grow = grow
        self.deliver = deliver
        self._results = results
        self._own_threads = threads
        self.out_of_time = False
        self.waiting: list[StudyJob] = []
        self.begin()

    def begin(self) -> None:
        """Compute the study, or wait for the results of the job that computes it."""
        with _lock:
            computing = _computing.setdefault(self._key, self)
            if computing is not self:
                computing.waiting.append(self)
                return
        self._begin(self._own_threads or study_threads())

    @property
    def _is_over(self) -> bool:
        return self.cancelled and all(job.cancelled for job in self.waiting)

    @property
    def _key(self) -> tuple[int, object]:
        return id(self._results), self.question

    def _report(self, result: PartialResult | Exception, *, last: bool) -> None:
        """Deliver a result to all who wait; after the last one nobody does."""
        with _lock:
            waiting = [job for job in self.waiting if not job.cancelled]
            self.waiting = [] if last else list(waiting)
        for job in (self, *waiting):
            if not job.cancelled:
                job.deliver(job, result)

    def _end(self) -> None:
        super()._end()
        with _lock:
            _computing.pop(self._key, None)
            waiting, self.waiting = self.waiting, []
        for job in waiting:
            if not job.cancelled:
                job.begin()

    def _answer(self) -> Iterator[None]:
        used, begin = 0.0, own_time()
        known = self._results.get(self.question)
        whole = known is not None and known.share == 1
        growing = (each for each in (known,)) if whole else self._grow(self.question, known, self._poll)
        with contextlib.closing(growing):
            for partial in growing:
                used += own_time() - begin
                self._results.put(self.question, partial)
                if self._is_over:
                    return
                self.out_of_time = partial.share < 1 and used > SECONDS
                self._report(partial, last=partial.share == 1)
                if self.out_of_time:
                    return
                yield
                begin = own_time()

    def _fail(self, error: Exception) -> None:
        self._report(error, last=True)
