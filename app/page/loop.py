"""The loop of one session's document: what threads have found is written there, and only while a page is there."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from bokeh.document import Document
from vibroscope.app.runtime import logs


class Loop:
    """Callbacks wait until the page is open: Panel drops what changes before the browser says that it has it."""

    def __init__(self, doc: Document) -> None:
        self._doc = doc
        self._name = logs.session.get()
        self._waiting: list[Callable[[], None]] = []
        self._loaded = False
        self._closed = False

    def start(self) -> None:
        """The page is open: do what had to wait."""
        self._loaded = True
        for callback in self._waiting:
            callback()
        self._waiting.clear()

    def close(self) -> None:
        """The browser is gone: nothing more is wanted."""
        self._closed = True

    def later(self, callback: Callable[[], None]) -> None:
        """From a worker thread: call ``callback`` on the loop, if the session is still there."""
        if self._doc.session_context is not None and not self._closed:
            self._doc.add_next_tick_callback(partial(self._once_loaded, callback))

    def _once_loaded(self, callback: Callable[[], None]) -> None:
        if self._loaded:
            with logs.in_session(self._name):
                callback()
        else:
            self._waiting.append(callback)
