"""The tabs of one session: each built when it is first opened, one of them seen."""

from __future__ import annotations

from collections.abc import Callable

import panel as pn
from vibroscope.app.page.files import style
from vibroscope.app.page.tabs import TABS, Desk, Tab


class Stage:
    """Where the open tab lies; ``on_look`` is called whenever a user zooms one of them or mutes something of it."""

    def __init__(self, desk: Desk, on_look: Callable[[], None]) -> None:
        self.view = pn.Column(css_classes=["stage"], stylesheets=[style("shared/page")], sizing_mode="stretch_width")
        self._desk = desk
        self._on_look = on_look
        self._tabs: dict[str, Tab] = {}
        self._places: dict[str, pn.Column] = {}
        self._open = ""

    @property
    def tab(self) -> Tab:
        """The open one."""
        return self._tabs[self._open]

    def open(self, key: str) -> None:
        """Bring a tab to the front, built now if it was never open before."""
        if key == self._open:
            return
        if self._open:
            self.tab.hide()
            self._places[self._open].visible = False
        if key not in self._tabs:
            self._build(key)
        self._open = key
        self._places[key].visible = True

    def close(self) -> None:
        """The session has ended."""
        for tab in self._tabs.values():
            tab.close()

    def _build(self, key: str) -> None:
        self._tabs[key] = tab = TABS[key](self._desk)
        self._places[key] = pn.Column(
            tab.build(), css_classes=["place"], stylesheets=[style("shared/page")], sizing_mode="stretch_width"
        )
        self.view.append(self._places[key])
        for owned in tab.ranges.values():
            owned.on_move = self._on_look
        tab.muting.on_mute = self._on_look
