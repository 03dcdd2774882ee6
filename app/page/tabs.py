"""The tabs of the page, and the area of one session that shows one of them; `app.page.tab` defines what a tab is."""

from __future__ import annotations

from collections.abc import Callable

import panel as pn
from vibroscope.app.explorer.link import View
from vibroscope.app.page.basin.tab import BasinTab
from vibroscope.app.page.bifurcation.tab import Bifurcation
from vibroscope.app.page.explore.tab import Explore
from vibroscope.app.page.files import style
from vibroscope.app.page.help.tab import Help
from vibroscope.app.page.paper.tab import Paper
from vibroscope.app.page.plane.tab import PlaneTab
from vibroscope.app.page.speed.tab import Speed
from vibroscope.app.page.tab import Tab, TabHost
from vibroscope.app.page.time_step.tab import TimeStepTab
from vibroscope.app.page.your_code.tab import YourCode

# A new tab is a line here.
_TABS = Explore, Bifurcation, PlaneTab, BasinTab, TimeStepTab, YourCode, Speed, Paper, Help
TABS: dict[str, type[Tab]] = {tab.key: tab for tab in _TABS}
FIRST_TAB = Explore.key


class TabArea:
    """Builds each tab of one session when it is first opened, and shows one of them.

    ``on_view_change`` is called whenever the user changes the view without a move (`Tab.watch_view`).
    """

    def __init__(self, host: TabHost, on_view_change: Callable[[], None]) -> None:
        self.view = pn.Column(css_classes=["tab-area"], stylesheets=[style("shared/page")], sizing_mode="stretch_width")
        self._host = host
        self._on_view_change = on_view_change
        self._tabs: dict[str, Tab] = {}
        self._places: dict[str, pn.Column] = {}
        self._open = ""

    @property
    def tab(self) -> Tab:
        """The open tab."""
        return self._tabs[self._open]

    def open(self, key: str, view: View | None = None) -> None:
        """Show a tab; it is built now, with ``view``, if it has never been open."""
        if key == self._open:
            return
        if self._open:
            self.tab.hide()
            self._places[self._open].visible = False
        if key not in self._tabs:
            self._build(key)
            if view is not None:
                self._tabs[key].restore(view)
        self._open = key
        self._places[key].visible = True

    def reset(self) -> None:
        """The user has asked for the page as it is at first."""
        for tab in self._tabs.values():
            tab.reset()

    def close(self) -> None:
        """The session has ended."""
        for tab in self._tabs.values():
            tab.close()

    def _build(self, key: str) -> None:
        self._tabs[key] = tab = TABS[key](self._host)
        self._places[key] = pn.Column(
            tab.build(), css_classes=["place"], stylesheets=[style("shared/page")], sizing_mode="stretch_width"
        )
        self.view.append(self._places[key])
        tab.watch_view(self._on_view_change)
