"""The tabs of the page, and the area of one session that shows one view of them; `app.page.tab` says what a view is."""

from collections.abc import Callable
from typing import NamedTuple

import panel as pn
from vibroscope.app.explorer.link import View
from vibroscope.app.page.bifurcation.tab import Bifurcation
from vibroscope.app.page.explore.tab import Explore
from vibroscope.app.page.files import style
from vibroscope.app.page.help.tab import Help
from vibroscope.app.page.paper.tab import Paper
from vibroscope.app.page.study.basin import Basins
from vibroscope.app.page.study.impact import OneImpact
from vibroscope.app.page.study.load import LoadTab
from vibroscope.app.page.study.peaks import Peaks
from vibroscope.app.page.study.plane import Plane
from vibroscope.app.page.study.speed import Speed
from vibroscope.app.page.study.time_step import TimeStep
from vibroscope.app.page.tab import TabHost, TabView
from vibroscope.app.page.your_code.tab import YourCode


class Tab(NamedTuple):
    """A tab: its title and its views, of which the first is shown first."""

    title: str
    views: tuple[type[TabView], ...]


# A new tab is a line here, a new view an entry of its tab.
TABS = (
    Tab("Explore", (Explore,)),
    Tab("One impact", (OneImpact, LoadTab)),
    Tab("Bifurcation", (Bifurcation, Basins)),
    Tab("K–D plane", (Plane,)),
    Tab("Step and cost", (TimeStep, Speed)),
    Tab("Your code", (YourCode, Peaks)),
    Tab("Help", (Help, Paper)),
)
VIEWS: dict[str, type[TabView]] = {view.key: view for tab in TABS for view in tab.views}
FIRST_VIEW = Explore.key


class TabArea:
    """Builds each view of one session when it is first opened, and shows one of them.

    ``on_view_change`` is called whenever the user changes the view without a move (`TabView.watch_view`).
    """

    def __init__(self, host: TabHost, on_view_change: Callable[[], None]) -> None:
        self.column = pn.Column(
            css_classes=["tab-area"], stylesheets=[style("shared/page")], sizing_mode="stretch_width"
        )
        self._host = host
        self._on_view_change = on_view_change
        self._views: dict[str, TabView] = {}
        self._places: dict[str, pn.Column] = {}
        self._open = ""

    def has(self, key: str) -> bool:
        """Whether a view is built."""
        return key in self._views

    @property
    def view(self) -> TabView:
        """The open view."""
        return self._views[self._open]

    def open(self, key: str, state: View | None = None) -> None:
        """Show a view; it is built now, as ``state`` says, if it has never been open."""
        if key == self._open:
            return
        if key not in self._views:
            self._build(key, state)
        if self._open:
            self.view.hide()
            self._places[self._open].visible = False
        self._open = key
        self._places[key].visible = True

    def reset(self) -> None:
        """The user has asked for the page as it is at first."""
        for view in self._views.values():
            view.reset()

    def close(self) -> None:
        """The session has ended."""
        for view in self._views.values():
            view.close()

    def _build(self, key: str, state: View | None) -> None:
        view = VIEWS[key](self._host)
        place = pn.Column(
            view.build(), css_classes=["place"], stylesheets=[style("shared/page")], sizing_mode="stretch_width"
        )
        self.column.append(place)
        view.watch_view(self._on_view_change)
        if state is not None:
            view.restore(state)
        self._views[key], self._places[key] = view, place
