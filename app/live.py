"""Studies that grow while one watches: threads of their own behind everything else, and what was found is kept.

A study is a generator of stages, each a whole picture, finer than the one before. No panel import.
"""

from __future__ import annotations

import logging
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Protocol

from app.compute import RunCache
from app.workers import Workers, pool
from engine import Cancelled

log = logging.getLogger("vibroscope")

_THREADS = 4  # studies that run at the same time, of all sessions
_NICE = 10  # how far they stand back behind the sliders (Linux: each thread has a priority of its own)
_LONGEST = 180.0  # seconds of one study, unless its user says "go on"
_KEPT = 24

KEPT = RunCache(_KEPT)  # the last stage of each study by its question; one that was cancelled goes on from there


class Stage(Protocol):
    """A study as far as it has come."""

    share: float  # of all cells that are done

    def data(self) -> dict[str, object]:
        """What is known, for a file: numbers, words, arrays, and dictionaries of those."""


Refine = Callable[[object, Stage | None, Callable[[], bool]], Iterator[Stage]]


def studies() -> Workers:
    """The threads of all studies; what they start inherits their priority."""
    return pool("study", _THREADS, stand_back)


def stand_back() -> None:
    """Give this thread, and those that it starts, a lower priority than the sliders' (on Linux)."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)


class Live:
    """One study under way: ``deliver(live, stage or exception)`` is called in a worker thread as stages come."""

    def __init__(
        self, question: object, refine: Refine, deliver: Callable[[Live, Stage | Exception], None], kept=KEPT
    ) -> None:
        self.question = question
        self._refine = refine
        self._deliver = deliver
        self._kept = kept
        self._cancelled = threading.Event()
        self.exhausted = False  # it has had its time
        studies().submit(self._work)

    def cancel(self) -> None:
        """Nothing more is wanted: it stops within some hundredths of a second, and what it has found is kept."""
        self._cancelled.set()

    @property
    def cancelled(self) -> bool:
        """Whether it was withdrawn."""
        return self._cancelled.is_set()

    def _work(self) -> None:
        if self.cancelled:
            return
        end = time.monotonic() + _LONGEST
        try:
            for stage in self._refine(self.question, self._kept.get(self.question), self._cancelled.is_set):
                self._kept.put(self.question, stage)
                if self.cancelled:
                    return
                self.exhausted = stage.share < 1 and time.monotonic() > end
                self._deliver(self, stage)
                if self.exhausted:
                    return
        except Cancelled:
            return
        except Exception as error:  # told on the page; a worker must not die of it
            log.exception("a study failed")
            self._deliver(self, error)
