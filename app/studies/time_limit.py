"""A limit of the seconds that a search computes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from vibroscope.app.runtime.workers import own_time


class TimeLimit:
    """Ends a search after so many seconds of its own; what others had while it was `paused` does not count."""

    def __init__(self, seconds: float, cancelled: Callable[[], bool]) -> None:
        self._left, self._cancelled = seconds, cancelled
        self._begin = own_time()

    def ends(self) -> bool:
        """Whether the search was cancelled, or its time is over."""
        return self._cancelled() or own_time() - self._begin > self._left

    @contextmanager
    def paused(self) -> Iterator[None]:
        """While a partial result is taken: other studies have their turn then."""
        self._left -= own_time() - self._begin
        yield
        self._begin = own_time()
