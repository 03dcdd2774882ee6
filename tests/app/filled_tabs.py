"""Tabs with data, for the tests of what can be taken away."""

import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.link import print_address
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.paper import tab as paper
from vibroscope.app.page.paper.tab import ClaimCard
from vibroscope.app.page.study.tab import StudyView
from vibroscope.app.page.tab import Move
from vibroscope.app.page.tabs import VIEWS
from vibroscope.app.paper import CLAIMS
from vibroscope.app.studies import speed

from tests.app.fakes import Document, QueueingHost, send

SETTING = Setting(eta=2.76, K=12000.0, D=18.0, steps=200, kappa=2.4)
PAPER = ("3", "6A", "9A", "12")  # claims whose pictures are each of another kind
ADDRESS = f"?{print_address(SETTING)}"


@pytest.fixture(scope="module")
def filled():
    """A function from the key of a tab to one with data: of the first partial result, of bifurcation complete."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(speed, "ROUNDS", (1,))
        tabs = {}

        def fill(key):
            if key == "paper":  # its other figures would have to be checked, too
                patch.setattr(paper, "CLAIMS", {name: CLAIMS[name] for name in PAPER})
            if key not in tabs:
                tabs[key] = _fill(VIEWS[key](QueueingHost(doc=Document() if key == "explore" else None)))
            return tabs[key]

        yield fill
        for tab in tabs.values():
            tab.close()


def _fill(tab):
    page = tab.page = tab.build()
    tab.host.doc.add_root(page.get_root(tab.host.doc))
    if tab.key == "explore":
        compute_runs(SETTING)
        assert tab.show_if_ready(Move(1, SETTING))
        return tab
    if tab.key == "bifurcation":
        tab.restore(type(tab).read_view("", "count:30;transient:200", ""))
    tab.show(Move(1, SETTING))
    if tab.key == "paper":
        for card in page.select(ClaimCard):
            send(card, {"seen": True})
        tab.host.catch_up_until(lambda: len(tab.data()["claims"]) == len(PAPER))
    if isinstance(tab, StudyView):
        complete = tab.key == "bifurcation"
        tab.host.catch_up_until(lambda: tab.host.summary if complete else tab.figures())
        tab.hide()
    return tab
