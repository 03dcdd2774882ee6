"""The tabs of the page, one a file; `app.tabs.base` says what a tab is. A new one is a line in `TABS`."""

from app.tabs.base import Desk, Move, Tab
from app.tabs.bifurcation import Bifurcation
from app.tabs.explore import Explore
from app.tabs.help import Help
from app.tabs.paper import Paper
from app.tabs.plane import PlaneTab
from app.tabs.speed import Speed
from app.tabs.timestep import TimeStepTab

TABS: dict[str, type[Tab]] = {tab.key: tab for tab in (Explore, Bifurcation, PlaneTab, TimeStepTab, Speed, Paper, Help)}

__all__ = ["TABS", "Desk", "Move", "Tab"]
