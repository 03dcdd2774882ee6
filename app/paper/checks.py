"""Checks that sessions wait for: each is made once a process, one after the other, and not at all if nobody waits."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from vibroscope.app.paper import CLAIMS, Finding
from vibroscope.app.runtime import logs
from vibroscope.app.runtime.job import lower_priority
from vibroscope.app.runtime.workers import Workers, pool

Deliver = Callable[[str, Finding | Exception], None]


def _thread() -> Workers:
    """One thread behind the sliders'."""
    return pool("paper", 1, lower_priority)


class Checks:
    """What was found, by claim, and who waits for the rest. A finding depends on nothing that is set, so it is kept."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._found: dict[str, Finding] = {}
        self._waiting: dict[str, list[Deliver]] = {}

    def ask(self, key: str, deliver: Deliver) -> None:
        """Check a claim; ``deliver(key, finding or exception)`` is called in a worker thread, or now if it is known."""
        with self._lock:
            found = self._found.get(key)
            if found is None:
                waiting = self._waiting.setdefault(key, [])
                waiting.append(deliver)
                if len(waiting) == 1:
                    _thread().submit(self._work, key)
                return
        deliver(key, found)

    def withdraw(self, deliver: Deliver) -> None:
        """Nothing more is wanted by this one; a check that has begun ends, those in the queue do not begin."""
        with self._lock:
            for waiting in self._waiting.values():
                waiting[:] = [other for other in waiting if other != deliver]

    def _work(self, key: str) -> None:
        with self._lock:
            if not self._waiting.get(key):
                return
        try:
            result: Finding | Exception = CLAIMS[key].find()
        except Exception as error:  # told on the card
            result = error
            logs.event("not checked", logging.ERROR, error=error, claim=key)  # of no session: many may wait for it
        with self._lock:
            if isinstance(result, Finding):
                self._found[key] = result
            waiting = self._waiting.pop(key, [])
        for deliver in waiting:
            deliver(key, result)


CHECKS = Checks()
