"""Work that stands back behind the sliders and can be withdrawn: what studies and searches share. No panel import."""

from __future__ import annotations

import logging
import os
import sys
import threading
from abc import ABC, abstractmethod

from vibroscope.app.runtime import logs
from vibroscope.app.runtime.workers import Workers
from vibroscope.engine import Cancelled

_NICE = 10  # how far its threads stand back (Linux: each thread has a priority of its own)


def stand_back() -> None:
    """Give this thread, and those that it starts, a lower priority than the sliders' (on Linux)."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)


class Job(ABC):
    """One question under way in a worker thread, where all that it tells is told, until it is cancelled."""

    def __init__(self, question: object) -> None:
        self.question = question
        self._cancelled = threading.Event()
        self._session = logs.session.get()

    def cancel(self) -> None:
        """Nothing more is wanted, nothing is told any more; it stops within some hundredths of a second."""
        self._cancelled.set()

    @property
    def cancelled(self) -> bool:
        """Whether it was withdrawn."""
        return self._cancelled.is_set()

    @abstractmethod
    def _answer(self) -> None:
        """Find the answer and tell it; may raise `engine.Cancelled`."""

    @abstractmethod
    def _fail(self, error: Exception) -> None:
        """Tell that it failed."""

    def _begin(self, threads: Workers) -> None:
        threads.submit(self._work)

    def _work(self) -> None:
        if self.cancelled:
            return
        with logs.named(self._session):
            try:
                self._answer()
            except Cancelled:
                return
            except Exception as error:  # told on the page; a worker must not die of it
                logs.event("not answered", logging.ERROR, error=error, job=type(self).__name__.lower())
                if not self.cancelled:
                    self._fail(error)
