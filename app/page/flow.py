"""One update in flight, and the latest wins: the next goes out when the browser has painted the last.

Over a slow line everything else builds up a queue, and the page lags behind the hand that moves the slider.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import panel as pn
from bokeh.document import Document

# A browser that says nothing for so long (seconds) is pushed to all the same.
_PATIENCE = 1.0


class Update(NamedTuple):
    """What is to be written: the browser's move that it answers, and how to write it."""

    move: int
    write: Callable[[], None]


class Flow:
    """The way of all updates of one session to its browser."""

    def __init__(self, doc: Document, answer: Callable[[int, int], None]) -> None:
        """``answer(move, frame)`` tells the browser which move an update answers, and its number."""
        self._doc = doc
        self._answer = answer
        self._ready: Update | None = None
        self._unpainted = 0
        self._pushed_at = 0.0
        self.frames = 0

    def push(self, move: int, write: Callable[[], None]) -> None:
        """Write now if the browser is free, else as soon as it is, unless something newer comes."""
        self._ready = Update(move, write)
        self._push_when_painted()

    def painted(self, frame: object) -> None:
        """The browser has painted update number ``frame``."""
        if frame == self._unpainted:
            self._unpainted = 0
            self._push_when_painted()

    def _push_when_painted(self) -> None:
        if self._unpainted and time.monotonic() - self._pushed_at < _PATIENCE:
            return
        if self._ready is None:
            return
        update, self._ready = self._ready, None
        self.frames += 1
        self._unpainted, self._pushed_at = self.frames, time.monotonic()
        with pn.io.hold(self._doc):
            update.write()
            self._answer(update.move, self.frames)
        self._doc.add_timeout_callback(self._push_when_painted, int(1000 * _PATIENCE) + 50)
