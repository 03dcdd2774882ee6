"""The tabs of the page, one a file; `app.page.tab` says what a tab is. A new one is a line in `TABS`."""

from vibroscope.app.page.bifurcation.tab import Bifurcation
from vibroscope.app.page.explore.tab import Explore
from vibroscope.app.page.help.tab import Help
from vibroscope.app.page.paper.tab import Paper
from vibroscope.app.page.plane.tab import PlaneTab
from vibroscope.app.page.speed.tab import Speed
from vibroscope.app.page.tab import Desk, Move, Tab
from vibroscope.app.page.time_step.tab import TimeStepTab

TABS: dict[str, type[Tab]] = {tab.key: tab for tab in (Explore, Bifurcation, PlaneTab, TimeStepTab, Speed, Paper, Help)}

__all__ = ["TABS", "Desk", "Move", "Tab"]
