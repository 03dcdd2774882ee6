"""Cancellable work at low priority: what studies and searches have in common. No panel import."""

from __future__ import annotations

import logging
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterator

from vibroscope.app.runtime import logs
from vibroscope.app.runtime.compilation import compilation
from vibroscope.app.runtime.workers import Workers, give_way, stand_aside
from vibroscope.engine import Cancelled


class Job(ABC):
    """One question that a worker thread answers, until it is cancelled. A subclass reports its results itself."""

    def __init__(self, question: object) -> None:
        self.question = question
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

    def _begin(self, threads: Workers) -> None:
        self._slices = self._answer()
        self._threads = threads
        compilation.when_done(lambda: threads.submit(self._work, session=self._session))

    def _work(self) -> None:
        if self.cancelled or not self._work_on():
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
                logs.event("not answered", logging.ERROR, error=error, job=type(self).__name__.lower())
                if not self.cancelled:
                    self._fail(error)
                return False
        return True
