"""What a user takes away, written one file after the other."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial

from vibroscope.app.explorer.words import cause
from vibroscope.app.page.tabs import Desk
from vibroscope.app.runtime import logs
from vibroscope.app.runtime.workers import pool
from vibroscope.app.studies.live import lower_priority

File = dict[str, str]


class Handout:
    """Of one session; ``give(what, file)`` hands a file to the browser, on the session's own loop."""

    def __init__(self, desk: Desk, give: Callable[[str, File], None]) -> None:
        self._desk = desk
        self._give = give
        self._writing = False

    def write(self, what: str, made: Callable[[], File] | None) -> None:
        """Have ``made`` called by another thread, or say why not; None: there is no such file."""
        if made is None:
            self._desk.tell("There is nothing of that kind to take away here by now: wait for the figures.")
        elif self._writing:
            self._desk.tell("One file after the other: the last one is still being written.")
        else:
            self._writing = True
            pool("files", 1, lower_priority).submit(made).add_done_callback(
                lambda done: self._desk.later(partial(self._written, what, done))
            )

    def _written(self, what: str, done: Future) -> None:
        self._writing = False
        if done.cancelled():
            return
        if done.exception() is None:
            self._give(what, done.result())
        else:
            logs.event("not written", logging.ERROR, error=done.exception(), what=what)
            self._desk.tell(f"This file could not be written ({cause(done.exception())}): try again.")
