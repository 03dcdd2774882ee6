"""Cancellable work at low priority, for all that a page asks and no slider waits for. No panel import."""

import logging
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator

from vibroscope.app.runtime import logs, metrics
from vibroscope.app.runtime.compilation import Compiled, compilation
from vibroscope.app.runtime.workers import Workers, give_way, own_time, stand_aside
from vibroscope.engine import Cancelled
from vibroscope.engine.arguments import Poll


class Job(ABC):
    """One question that a worker thread answers, until it is cancelled. A subclass reports its results itself.

    Parameters
    ----------
    question : object
    what : str
        What the log says of it.
    """

    def __init__(self, question: object, what: str) -> None:
        self.question, self._what = question, what
        self._cancelled = threading.Event()
        self._session = logs.session.get()

    def cancel(self) -> None:
        """Stop the work, within some hundredths of a second of its own time, and report nothing more."""
        self._cancelled.set()

    @property
    def cancelled(self) -> bool:
        """Whether `cancel` was called."""
        return self._cancelled.is_set()

    def _poll(self) -> bool:
        """Give way to other sessions, and return whether to stop: what a long computation calls all the time."""
        stand_aside()
        give_way()
        return self._is_over

    @property
    def _is_over(self) -> bool:
        """Whether nobody waits for the answer."""
        return self.cancelled

    @abstractmethod
    def _answer(self) -> Iterator[None]:
        """Find the answer and report it, slice by slice: after each, other sessions have their turn.

        Within a slice they have it whenever `_poll` is called.

        May raise `engine.Cancelled`.
        """

    @abstractmethod
    def _fail(self, error: Exception) -> None:
        """Report that the work failed."""

    def _end(self) -> None:
        """End the work, with an answer or without."""
        self._slices.close()

    def _begin(self, threads: Workers, needs: Compiled = Compiled.ALL) -> None:
        self._slices = self._answer()
        self._threads = threads
        compilation.when_done(lambda: threads.submit(self._work, session=self._session), needs)

    def _work(self) -> None:
        if self._is_over or not self._work_on():
            self._end()
            return
        self._threads.submit(self._work, session=self._session)

    def _work_on(self) -> bool:
        """Compute one slice; returns whether there are more."""
        with logs.in_session(self._session):
            try:
                next(self._slices)
            except (StopIteration, Cancelled):
                return False
            except Exception as error:  # the page shows it; the worker thread must survive
                logs.event("failed", logging.ERROR, error=error, job=self._what)
                if not self.cancelled:
                    self._fail(error)
                return False
        return True


class Answer(Job):
    """A question that one call answers: ``deliver(job, answer or exception)`` is called in a worker thread.

    Parameters
    ----------
    question : object
    solve : callable
        ``solve(question, cancelled, report)`` returns the answer; ``report(part)`` delivers a part of it before.
    deliver : callable
    threads : Workers
    what : str
        Its name in the log.
    measure : metrics.Durations, optional
        Of the seconds of its own that an answer took.
    needs : Compiled
        What must be compiled before.
    """

    def __init__(
        self,
        question: object,
        solve: Callable[[object, Poll, Callable[[object], None]], object],
        deliver: "Callable[[Answer, object], None]",
        threads: Workers,
        what: str,
        *,
        measure: metrics.Durations | None = None,
        needs: Compiled = Compiled.ALL,
    ) -> None:
        super().__init__(question, what)
        self._solve, self._deliver, self._measure = solve, deliver, measure
        self._begin(threads, needs)

    def _answer(self) -> Iterator[None]:
        begin = own_time()
        answer = self._solve(self.question, self._poll, self._report)
        seconds = own_time() - begin
        if self._measure is not None:
            self._measure.add(seconds)
        logs.event("done", seconds=seconds, job=self._what)
        self._report(answer)
        yield from ()  # all in one slice

    def _report(self, found: object) -> None:
        if not self.cancelled:
            self._deliver(self, found)

    def _fail(self, error: Exception) -> None:
        self._deliver(self, error)
