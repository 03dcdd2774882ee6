"""Sends the columns that a move changes in one message.

Bokeh would send two frames for each column and an event for each source; a move changes about forty columns.
"""

from collections.abc import Mapping

import numpy as np
from bokeh.models import ColumnDataSource
from vibroscope.app.compat import update_silently
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.shared.figure import changed_columns, write


class ColumnSender(Component):
    """Keeps the sources here and in the browser equal; Bokeh sends the columns until the browser listens."""

    script, sheets = "explore/column_sender", None

    def __init__(self, **params) -> None:
        super().__init__(visible=False, **params)
        self._listening = False
        self._sources: dict[str, ColumnDataSource] = {}
        self._waiting: list[tuple[str, str, np.ndarray]] = []
        self.on_msg(lambda event: self.start_listening())

    def put(self, source: ColumnDataSource, columns: Mapping[str, np.ndarray]) -> None:
        """Put float32 ``columns`` into ``source``; the next `send` sends those that differ."""
        self._sources[source.id] = source
        if not self._listening:
            write(source, columns)
            return
        new = changed_columns(source, columns)
        update_silently(source, new)
        self._waiting += [(source.id, name, column) for name, column in new.items()]

    def send(self) -> None:
        """Send all waiting columns in one message."""
        if self._waiting:
            self.send_message(pack_columns(self._waiting))
            self._waiting.clear()

    def send_message(self, message: dict) -> None:
        """Send a message to the component in the browser."""
        self._send_msg(message)

    def start_listening(self) -> None:
        """The browser listens, for the first time, or again after it was away; then it gets all columns."""
        if self._listening:
            self._waiting = [(s.id, name, column) for s in self._sources.values() for name, column in s.data.items()]
            self.send()
        self._listening = True


def pack_columns(columns: list[tuple[str, str, np.ndarray]]) -> dict:
    """The message of some columns, each with the id of its source and its name: a list of these, and all numbers."""
    names = [[source, name, len(column)] for source, name, column in columns]
    return {"names": names, "values": b"".join(column.tobytes() for *_, column in columns)}
