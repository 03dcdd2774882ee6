"""Checks that sessions wait for: each is made once a process, one after the other, and not at all if nobody waits."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

from vibroscope.app.paper import CLAIMS, Finding
from vibroscope.app.paper.claims import is_cancelled
from vibroscope.app.runtime import logs
from vibroscope.app.runtime.compilation import compilation
from vibroscope.app.runtime.workers import lower_priority, pool
from vibroscope.engine import Cancelled

Deliver = Callable[[str, Finding | Exception], None]


def _submit(job: Callable, *arguments) -> None:
    """Run a job in a thread of lower priority than those of the sliders."""
    compilation.when_done(lambda: pool("paper", 1, lower_priority).submit(job, *arguments))


class CheckQueue:
    """Findings by claim, and who waits for those that are not known; a finding is kept, since no setting changes it.

    Parameters
    ----------
    submit : callable
        Runs a function with its arguments in a worker thread.
    """

    def __init__(self, submit: Callable[..., None] = _submit) -> None:
        self._submit = submit
        self._lock = threading.Lock()
        self._findings: dict[str, Finding] = {}
        self._waiting: dict[str, list[Deliver]] = {}
        self._cancelled: set[str] = set()

    def request(self, key: str, deliver: Deliver) -> None:
        """Check a claim; ``deliver(key, finding or exception)`` is called in a worker thread, or now if it is known."""
        with self._lock:
            finding = self._findings.get(key)
            if finding is None:
                self._cancelled.discard(key)
                waiting = self._waiting.setdefault(key, [])
                waiting.append(deliver)
                if len(waiting) == 1:
                    self._submit(self._check, key)
                return
        deliver(key, finding)

    def cancel_all(self, deliver: Deliver) -> None:
        """Drop all requests with this ``deliver``; a check that nobody waits for does not begin."""
        with self._lock:
            for waiting in self._waiting.values():
                waiting[:] = [other for other in waiting if other != deliver]

    def cancel(self, key: str, deliver: Deliver) -> None:
        """Drop one request; a check that runs ends as soon as it can, unless others wait for it."""
        with self._lock:
            waiting = self._waiting.get(key, [])
            waiting[:] = [other for other in waiting if other != deliver]
            if not waiting:
                self._cancelled.add(key)

    def _check(self, key: str) -> None:
        with self._lock:
            if not self._waiting.get(key):
                return
        token = is_cancelled.set(lambda: key in self._cancelled)
        try:
            result: Finding | Exception = CLAIMS[key].find()
        except Cancelled:  # whoever has requested it again since has submitted it again
            return
        except Exception as error:  # shown on the card
            result = error
            logs.event("not checked", logging.ERROR, error=error, claim=key)  # no session's: many may wait for it
        finally:
            is_cancelled.reset(token)
        with self._lock:
            if isinstance(result, Finding):
                self._findings[key] = result
            waiting = self._waiting.pop(key, [])
        for deliver in waiting:
            deliver(key, result)


CHECKS = CheckQueue()
