"""The session that is kept ready: lent once, for a plain page alone, counted as nobody's, ended if it is not opened."""

import asyncio
import itertools
import json
import time

import pytest
from bokeh.document import Document
from bokeh.models import Range1d
from vibroscope.app.server import prewarmed as module
from vibroscope.app.server.prewarmed import Spare

from tests.browserless import Client
from tests.served import served

WHAT = ("kept ready", "opened")


class Held:
    """What the spare needs of Bokeh's context: sessions that are built, and whether they may end."""

    def __init__(self):
        self.blocked = {}
        self.documents = {}

    async def create_session_if_needed(self, session_id, request):
        assert not request.query
        self.blocked[session_id] = 0
        self.documents[session_id] = Document()
        self.documents[session_id].add_root(Range1d(start=0, end=1))
        return self.get_session(session_id)

    def get_session(self, session_id):
        held = self

        class Session:
            document = held.documents[session_id]

            def block_expiration(self):
                held.blocked[session_id] += 1

            def unblock_expiration(self):
                held.blocked[session_id] -= 1

        return Session()


@pytest.fixture
def held():
    return Held()


@pytest.fixture
def spare(held, monkeypatch):
    monkeypatch.setattr(module, "jobs", lambda: 0)
    names = itertools.count(1)
    return Spare(held, lambda: f"s{next(names)}")


def look(spare, wanted=True):
    asyncio.run(spare.look(wanted))


def test_it_is_lent_once_and_the_next_is_built_when_it_is_opened(spare, held):
    assert spare.lend() == ""
    look(spare)
    assert held.blocked == {"s1": 1}
    assert spare.holds("s1")
    assert spare.lend() == "s1"
    assert spare.lend() == ""
    look(spare)
    assert list(held.blocked) == ["s1"]
    assert spare.holds("s1")
    spare.opened("s1")
    assert held.blocked["s1"] == 0
    assert not spare.holds("s1")
    look(spare)
    assert spare.lend() == "s2"


def test_what_its_browser_is_told_first_was_made_before_and_is_told_once(spare, held):
    look(spare)
    doc = held.documents["s1"]
    made = doc.to_json
    told = made()
    assert told.content == Document.to_json(doc).content
    assert doc.to_json() is not told
    assert doc.to_json != made


def test_what_was_made_before_a_change_is_not_told(spare, held):
    look(spare)
    doc = held.documents["s1"]
    doc.add_next_tick_callback(lambda: None)  # nothing that a browser sees
    assert "to_json" in vars(doc)
    doc.roots[0].end = 2
    assert doc.to_json().content["roots"][0]["attributes"]["end"] == 2


def test_none_is_built_while_anybody_moves_or_waits_or_none_is_wanted(spare, held, monkeypatch):
    spare.heard()
    look(spare)
    monkeypatch.setattr(module, "_QUIET", 0.0)
    monkeypatch.setattr(module, "jobs", lambda: 1)
    look(spare)
    monkeypatch.setattr(module, "jobs", lambda: 0)
    look(spare, wanted=False)
    assert held.blocked == {}
    look(spare)
    assert held.blocked == {"s1": 1}


def test_one_that_is_not_opened_may_end(spare, held, monkeypatch):
    look(spare)
    spare.lend()
    monkeypatch.setattr(module, "_LENT", -1.0)
    look(spare)
    assert held.blocked == {"s1": 0, "s2": 1}


def test_whoever_opens_another_session_takes_nothing(spare, held):
    look(spare)
    spare.lend()
    spare.opened("another")
    assert spare.holds("s1")
    assert held.blocked == {"s1": 1}
    assert not spare.holds("")


def test_a_page_that_was_kept_ready_is_a_page_as_any_other(tmp_path):
    with served(tmp_path / "log.txt", VIBROSCOPE_LOG_FORMAT="json", VIBROSCOPE_LOG_LEVEL="debug") as server:
        time.sleep(8)  # quiet

        async def steps():
            assert server.metric("vibroscope_sessions ") == 0
            async with Client(server.url) as one, Client(server.url) as two, Client(server.url, "eta=1.5") as three:
                assert server.metric("vibroscope_sessions ") == 3
                for client in (one, two, three):
                    await client.ready()
                assert (await one.set(1, eta="1.3"))["texts"]["eta"] == "1.3"
                assert (await two.set(1, K="9000"))["texts"]["eta"] == "1.08"
                assert (await three.set(1, K="9000"))["texts"]["eta"] == "1.5"

        asyncio.run(asyncio.wait_for(steps(), 60))
    lines = [json.loads(line) for line in (tmp_path / "log.txt").read_text().splitlines() if line.startswith("{")]
    kept, opened = ([line["session"] for line in lines if line["event"] == f"session {what}"] for what in WHAT)
    assert len(opened) == 3
    assert kept[0] == opened[0]
    assert not {*opened[1:]} & {*kept}
