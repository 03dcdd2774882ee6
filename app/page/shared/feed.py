"""The columns that a move changes, sent to the browser in one piece.

Bokeh sends two frames for each column and an event for each source, of which a move changes some forty.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from bokeh.models import ColumnDataSource
from vibroscope.app.compat import update_silently
from vibroscope.app.page.files import script
from vibroscope.app.page.shared.component import Component
from vibroscope.app.page.shared.figure import changed, write


class Feed(Component):
    """Keeps the sources here and those in the browser alike; until the browser listens, by Bokeh's own way."""

    _esm = script("shared/dom", "shared/feed")

    def __init__(self, **params) -> None:
        super().__init__(visible=False, **params)
        self._listens = False
        self._sources: dict[str, ColumnDataSource] = {}
        self._waiting: list[tuple[str, str, np.ndarray]] = []
        self.on_msg(self._heard)

    def put(self, source: ColumnDataSource, columns: Mapping[str, np.ndarray]) -> None:
        """Put float32 ``columns`` into ``source``; what changed goes out with the next `send`."""
        self._sources[source.id] = source
        if not self._listens:
            write(source, columns)
            return
        new = changed(source, columns)
        update_silently(source, new)
        self._waiting += [(source.id, name, column) for name, column in new.items()]

    def send(self) -> None:
        """One message, whatever the number of columns."""
        if self._waiting:
            names = [[source, name, len(column)] for source, name, column in self._waiting]
            self._send_msg({"names": names, "values": b"".join(column.tobytes() for *_, column in self._waiting)})
            self._waiting.clear()

    def _heard(self, _) -> None:
        """The browser listens: for the first time, or anew, having been away while something was sent."""
        if self._listens:
            self._waiting = [(s.id, name, column) for s in self._sources.values() for name, column in s.data.items()]
            self.send()
        self._listens = True
