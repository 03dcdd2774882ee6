"""The tab Paper: claims are checked once they are seen, and only while the tab is open."""

import json
from dataclasses import replace

import pytest
from bokeh.document import Document
from vibroscope.app.page.paper import tab as tab_module
from vibroscope.app.page.paper.tab import Paper
from vibroscope.app.page.session import Session
from vibroscope.app.page.tab import Move
from vibroscope.app.paper import CLAIMS
from vibroscope.app.paper import checks as module
from vibroscope.app.paper.claims import is_cancelled
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.json_text import json_text
from vibroscope.engine import Cancelled

SEEN, CANCEL = {"seen": True}, {"cancel": True}


class Timeless(Document):
    """Calls at once what should be called later."""

    def add_timeout_callback(self, callback, timeout_milliseconds):
        callback()


class Host:
    """The page: what the tab calls on it is noted, or waits until the test runs it."""

    view_titles = Session.view_titles

    def __init__(self):
        self.doc = Timeless()
        self.waiting, self.offers, self.summary, self.error = [], [], "", ""
        self.tab = Paper(self)
        self.tab.build()

    def update_offers(self):
        self.offers.append(self.tab.awaited())

    def call_later(self, callback):
        self.waiting.append(callback)

    def push(self, move, write):
        write()

    def add_models(self, add, then):
        add()
        then()

    def summarise(self, text):
        self.summary = text

    def report_error(self, text, move=None):
        self.error = text

    def deliver(self):
        """Run the first callback that waits for the session's loop."""
        self.waiting.pop(0)()


class Checks:
    """Stands for the worker thread: runs its jobs when the test says so."""

    def __init__(self):
        self.jobs = []

    def submit(self, work, session):
        self.jobs.append(work)

    def work(self):
        while self.jobs:
            self.jobs.pop(0)()

    @property
    def claims(self):
        return {work.__self__.question for work in self.jobs}


@pytest.fixture
def checks(monkeypatch):
    checks, known = Checks(), Cache(len(CLAIMS))
    monkeypatch.setattr(module, "pool", lambda *_, **__: checks)
    for user in (module, tab_module):
        monkeypatch.setattr(user, "CHECKED", known)
    return checks


@pytest.fixture
def host(checks):
    return Host()


def test_a_claim_is_checked_when_it_is_seen_and_once(checks, host):
    tab = host.tab
    assert checks.jobs == []
    for message in (SEEN, SEEN, {"seen": "no"}, "seen"):
        tab.cards["4C"].receive(message)
    assert len(checks.jobs) == 1
    checks.work()
    assert tab.cards["4C"].found == {}
    host.deliver()
    assert tab.cards["4C"].found["verdict"] == "agrees"
    assert [key for key, slot in tab.slots.items() if len(slot) == 2] == ["4C"]
    title = tab.slots["4C"][1].object.title
    assert (title.text, title.visible) == (f"Figure 4 [C]: {tab.data()['claims'][0]['found']}", False)
    assert [row["figure"] for row in json.loads(json_text(tab.data()))["claims"]] == ["Figure 4 [C]"]
    assert host.offers == [""]


def test_a_finding_is_kept_for_other_sessions(checks, host):
    host.tab.cards["4C"].receive(SEEN)
    checks.work()
    other = Host()
    other.tab.cards["4C"].receive(SEEN)
    assert checks.jobs == []
    assert other.tab.cards["4C"].found["verdict"] == "agrees"


def test_a_hidden_tab_checks_nothing_and_goes_on_when_it_is_shown(checks, host, monkeypatch):
    checked, check = [], CLAIMS["4C"].check
    noted = replace(CLAIMS["4C"], check=lambda scene: checked.append(scene.eta) or check(scene))
    monkeypatch.setitem(CLAIMS, "4C", noted)
    tab = host.tab
    tab.cards["4C"].receive(SEEN)
    tab.hide()
    checks.work()
    assert checked == host.waiting == []
    tab.show(Move(1, None))
    checks.work()
    assert checked == [2.76]
    host.deliver()
    assert tab.cards["4C"].found["verdict"] == "agrees"


def test_a_finding_that_comes_while_the_tab_is_hidden_is_drawn_when_it_is_shown(checks, host):
    tab = host.tab
    tab.cards["4C"].receive(SEEN)
    checks.work()
    tab.hide()
    host.deliver()
    assert (len(tab.slots["4C"]), checks.jobs) == (1, [])
    tab.show(Move(1, None))
    assert len(tab.slots["4C"]) == 2
    assert tab.cards["4C"].found["verdict"] == "agrees"


def test_the_summary_comes_once_all_claims_in_view_are_checked(checks, host):
    tab = host.tab
    assert tab.summary(None) == f"0 of {len(CLAIMS)} claims checked."
    tab.show(Move(1, None))
    tab.cards["4C"].receive(SEEN)
    tab.cards["14D"].receive(SEEN)
    checks.work()
    host.deliver()
    assert host.summary == ""
    host.deliver()
    assert host.summary == tab.summary(None)
    assert host.summary == f"2 of {len(CLAIMS)} claims checked: 1 agree, 1 differ, 0 shown by example."


def test_a_check_that_fails_says_so_on_its_card_and_is_tried_again(checks, host, monkeypatch):
    claim, tab = CLAIMS["4C"], host.tab
    monkeypatch.setitem(CLAIMS, "4C", replace(claim, check=lambda scene: 1 / 0))
    tab.cards["4C"].receive(SEEN)
    checks.work()
    host.deliver()
    error = tab.cards["4C"].found["error"]
    assert error == "This could not be checked (division by zero). Open another tab and come back to try again."
    monkeypatch.setitem(CLAIMS, "4C", claim)
    tab.hide()
    tab.show(Move(1, None))
    checks.work()
    host.deliver()
    assert tab.cards["4C"].found["verdict"] == "agrees"


def test_all_figures_are_offered_and_checked_when_they_are_taken(checks, host):
    tab, taken = host.tab, []
    assert [figure.name for figure in tab.figures()] == ["claims", *(f"paper{key}" for key in CLAIMS)]
    tab.prepare("png:paper4C", lambda: taken.append("4C"))
    assert checks.claims == {"4C"}
    assert tab.awaited() == "Checking 1 claim for this file …"
    checks.work()
    assert taken == []
    host.deliver()
    assert (taken, tab.awaited()) == (["4C"], "")
    tab.prepare("toml", lambda: taken.append("toml"))
    tab.prepare("csv:paper4C", lambda: taken.append("again"))
    assert (taken, checks.jobs) == (["4C", "toml", "again"], [])
    tab.prepare("report", lambda: taken.append("report"))
    assert checks.claims == CLAIMS.keys() - {"4C"}
    assert tab.awaited() == f"Checking {len(CLAIMS) - 1} claims for this file …"


@pytest.mark.parametrize("why", ["was cancelled", "failed"])
def test_a_file_whose_claim_is_not_checked_does_not_come_and_says_so(checks, host, monkeypatch, why):
    tab, taken, claim = host.tab, [], CLAIMS["4C"]
    monkeypatch.setitem(CLAIMS, "4C", replace(claim, check=lambda scene: 1 / 0))
    tab.prepare("svg:paper4C", lambda: taken.append("4C"))
    if why == "failed":
        checks.work()
        host.deliver()
    else:
        tab.cards["4C"].receive(CANCEL)
    assert host.error == f"The file was not made: the check of Figure 4 [C] {why}."
    assert (taken, tab.awaited()) == ([], "")


def test_a_check_that_was_cancelled_ends_and_begins_anew_when_asked(checks, host, monkeypatch):
    claim, tab, card = CLAIMS["4C"], host.tab, host.tab.cards["4C"]

    def check(scene):
        card.receive(CANCEL)  # the user does, while it runs
        if is_cancelled.get()():
            raise Cancelled
        return claim.check(scene)

    monkeypatch.setitem(CLAIMS, "4C", replace(claim, check=check))
    card.receive(SEEN)
    checks.work()
    assert card.found == {"cancelled": True}
    assert host.waiting == []
    monkeypatch.setitem(CLAIMS, "4C", claim)
    tab.hide()
    tab.show(Move(1, None))
    assert checks.jobs == []  # it stays cancelled
    card.receive(SEEN)
    assert card.found == {}
    checks.work()
    host.deliver()
    assert card.found["verdict"] == "agrees"
    card.receive(CANCEL)
    assert card.found["verdict"] == "agrees"


def test_a_check_that_another_session_waits_for_goes_on(checks, host, monkeypatch):
    claim, other = CLAIMS["4C"], Host()

    def check(scene):
        host.tab.cards["4C"].receive(CANCEL)
        assert not is_cancelled.get()()
        return claim.check(scene)

    monkeypatch.setitem(CLAIMS, "4C", replace(claim, check=check))
    for each in (host, other):
        each.tab.cards["4C"].receive(SEEN)
    checks.work()
    assert host.waiting == []
    other.deliver()
    assert other.tab.cards["4C"].found["verdict"] == "agrees"


def entries(tab, key):
    """The entries of the legend of a claim's figure."""
    return tab.slots[key][1].object.legend[0].items


def check(host, checks, key):
    host.tab.cards[key].receive(SEEN)
    checks.work()
    host.deliver()


def test_entries_that_are_muted_go_into_the_link_and_come_back_when_the_claim_is_checked(checks, host):
    heard = []
    host.tab.watch_view(lambda: heard.append(host.tab.view_texts()["mute"]))
    check(host, checks, "4C")
    for renderer in entries(host.tab, "4C")[1].renderers:  # what the browser does at a click
        renderer.visible = False
    assert heard == ["paper4C:entry2"]
    other = Host()
    other.tab.restore(Paper.read_view("", "", heard[0]))
    assert other.tab.view_texts()["mute"] == heard[0]  # also before the claim is checked
    other.tab.cards["4C"].receive(SEEN)
    assert [item.renderers[0].visible for item in entries(other.tab, "4C")[:2]] == [True, False]
