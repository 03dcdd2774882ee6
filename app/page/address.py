"""The address of the open page: it follows what is set, and a moment later how it is seen."""

from __future__ import annotations

from collections.abc import Callable

from vibroscope.app.explorer.state import Setting, print_address
from vibroscope.app.page.opening import FIRST
from vibroscope.app.page.tabs import Desk, Tab

_RESTS = 150  # ms after which a zoom goes into the address


class Address:
    """What restores one session's page; ``changed`` is called when the user has looked elsewhere without a move."""

    def __init__(self, desk: Desk, changed: Callable[[], None]) -> None:
        self.refused = False  # the link that the page was opened with: it stays there until something is changed
        self._desk = desk
        self._changed = changed
        self.theme = ""  # light or dark, where the user or the link has chosen
        self._seen_anew = False  # and nobody has looked yet whether the address changes

    def link(self, tab: Tab, setting: Setting) -> str:
        """What restores a tab as it is seen, with a setting."""
        return self._printed(tab, setting, tab.printed())

    def shown(self, tab: Tab, setting: Setting) -> str:
        """What the browser's address becomes; empty: it stays."""
        view = tab.printed()
        return "" if self.refused and not any(view.values()) else self._printed(tab, setting, view)

    def follow(self) -> None:
        """The user zooms or mutes, or an axis follows its data: look when that rests, a wheel says much at once."""
        if not self._seen_anew:
            self._seen_anew = True
            self._desk.doc.add_timeout_callback(self._look, _RESTS)

    def _look(self) -> None:
        self._seen_anew = False
        self._desk.later(self._changed)

    def _printed(self, tab: Tab, setting: Setting, view: dict[str, str]) -> str:
        return print_address(setting, tab.key if tab.key != FIRST else "", self._desk.pinned, **view, theme=self.theme)
