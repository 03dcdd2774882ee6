"""The prewarmed session: handed out once, for a plain page request, counted as nobody's, ended if it is not opened.

That of a server works like any other page: `test_stopping`.
"""

import asyncio
import itertools

import pytest
from bokeh.document import Document
from bokeh.models import Range1d
from vibroscope.app.server import building as module
from vibroscope.app.server.building import PrewarmedSession


class Registry:
    """The part of Bokeh's application context that prewarming needs: sessions are built, and may expire or not."""

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
        registry = self

        class Session:
            document = registry.documents[session_id]

            async def with_document_locked(self, act):
                return await act()

            def block_expiration(self):
                registry.blocked[session_id] += 1

            def unblock_expiration(self):
                registry.blocked[session_id] -= 1

        return Session()


@pytest.fixture
def registry():
    return Registry()


@pytest.fixture
def prewarmed(registry, monkeypatch):
    monkeypatch.setattr(module, "jobs", lambda: 0)
    return make(registry)


def make(registry, **options):
    names = itertools.count(1)
    return PrewarmedSession(registry, lambda: f"s{next(names)}", **options)


def update(prewarmed, wanted=True):
    asyncio.run(prewarmed.update(wanted))


def test_it_is_handed_out_once_and_the_next_is_built_when_it_is_opened(prewarmed, registry):
    assert prewarmed.hand_out() == ""
    update(prewarmed)
    assert registry.blocked == {"s1": 1}
    assert prewarmed.owns("s1")
    assert prewarmed.hand_out() == "s1"
    assert prewarmed.hand_out() == ""
    update(prewarmed)
    assert list(registry.blocked) == ["s1"]
    assert prewarmed.owns("s1")
    prewarmed.release("s1")
    assert registry.blocked["s1"] == 0
    assert not prewarmed.owns("s1")
    update(prewarmed)
    assert prewarmed.hand_out() == "s2"


def test_its_document_is_stored_and_sent_once(prewarmed, registry):
    update(prewarmed)
    doc = registry.documents["s1"]
    assert prewarmed.take_json(doc).content == doc.to_json().content
    assert prewarmed.take_json(doc) is None


def test_a_stored_document_is_dropped_when_the_browser_would_see_a_change(prewarmed, registry):
    update(prewarmed)
    doc = registry.documents["s1"]
    doc.add_next_tick_callback(lambda: None)  # a browser does not see this
    doc.roots[0].end = 2
    assert prewarmed.take_json(doc) is None
    prewarmed.hand_out()
    prewarmed.release("s1")
    update(prewarmed)
    unchanged = registry.documents["s2"]
    unchanged.add_next_tick_callback(lambda: None)
    assert prewarmed.take_json(unchanged).content == unchanged.to_json().content


def test_none_is_built_while_a_browser_is_active_or_jobs_run_or_none_is_wanted(registry, monkeypatch):
    monkeypatch.setattr(module, "jobs", lambda: 0)
    active = make(registry)
    active.note_activity()
    update(active)
    prewarmed = make(registry, quiet_seconds=0)
    monkeypatch.setattr(module, "jobs", lambda: 1)
    update(prewarmed)
    monkeypatch.setattr(module, "jobs", lambda: 0)
    update(prewarmed, wanted=False)
    assert registry.blocked == {}
    update(prewarmed)
    assert registry.blocked == {"s1": 1}


def test_one_that_is_not_opened_in_time_may_expire(registry, monkeypatch):
    monkeypatch.setattr(module, "jobs", lambda: 0)
    prewarmed = make(registry, claim_seconds=-1.0)
    update(prewarmed)
    prewarmed.hand_out()
    update(prewarmed)
    assert registry.blocked == {"s1": 0, "s2": 1}


def test_opening_another_session_does_not_release_it(prewarmed, registry):
    update(prewarmed)
    prewarmed.hand_out()
    prewarmed.release("another")
    assert prewarmed.owns("s1")
    assert registry.blocked == {"s1": 1}
    assert not prewarmed.owns("")


@pytest.mark.parametrize("part", ["create_session_if_needed", "get_session"])
def test_a_failure_is_logged_and_tried_again_ever_later(part, prewarmed, registry, monkeypatch, caplog):
    pauses, left, good = [], [3], getattr(registry, part)

    def fails(*arguments):
        left[0] -= 1
        if left[0] >= 0:
            raise OSError("no room")
        return good(*arguments)

    async def sleep(seconds):
        pauses.append(seconds)
        if len(pauses) == 6:
            raise asyncio.CancelledError

    monkeypatch.setattr(registry, part, fails)
    monkeypatch.setattr(module.asyncio, "sleep", sleep)
    with pytest.raises(asyncio.CancelledError):
        asyncio.run(prewarmed.run(lambda: True))
    assert [record.message for record in caplog.records] == ["session not kept ready"] * 3
    assert "no room" in str(caplog.records[0].exc_info[1])
    assert pauses == [0.5, 1.0, 2.0, 4.0, 0.5, 0.5]
    assert prewarmed.hand_out() == "s4"
    assert sum(map(prewarmed.owns, registry.blocked)) == 1


def test_a_session_whose_document_cannot_be_stored_may_end(prewarmed, registry, monkeypatch):
    async def fails(session, work):
        raise OSError("no room")

    monkeypatch.setattr(module, "in_thread", fails)
    with pytest.raises(OSError, match="no room"):
        update(prewarmed)
    assert registry.blocked == {"s1": 0}
    assert not prewarmed.owns("s1")


def test_one_that_has_ended_before_it_is_opened_stops_nothing(registry, monkeypatch):
    monkeypatch.setattr(module, "jobs", lambda: 0)
    prewarmed = make(registry, claim_seconds=-1.0)
    update(prewarmed)
    del registry.documents[prewarmed.hand_out()]
    with pytest.raises(KeyError):
        update(prewarmed)
    update(prewarmed)
    assert prewarmed.hand_out() == "s2"
