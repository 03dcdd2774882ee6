"""Openings take turns by address, and files are read one at a time.

What a client's frames, bytes and files cost it: `test_hostile_clients`.
"""

import asyncio
from types import SimpleNamespace

import pytest
from vibroscope.app.page import take_away
from vibroscope.app.runtime import limits
from vibroscope.app.runtime.limits import Turns

from tests.waiting import PATIENCE


@pytest.fixture
def spend(monkeypatch):
    """Pieces take no time but what they spend, and a rest is over once the loop has gone round."""
    now, rests = 0.0, []

    def spend(seconds):
        nonlocal now
        now += seconds

    class Loop:
        def __init__(self):
            self.loop = asyncio.get_running_loop()
            self.create_future = self.loop.create_future

        def call_later(self, seconds, act):
            rests.append(round(seconds, 3))
            self.loop.call_soon(act)

    monkeypatch.setattr(limits.time, "monotonic", lambda: now)
    monkeypatch.setattr(limits, "get_running_loop", Loop)
    spend.rests = rests
    return spend


def run_all(turns, spend, owners, seconds=1.0):
    """The owners in the order in which they had their turn; all ask at once."""
    had = []

    async def piece(owner):
        async with turns.turn(owner):
            spend(seconds)
            had.append(owner)

    async def all_of_them():
        await asyncio.gather(*map(piece, owners))

    loop = asyncio.new_event_loop()
    try:
        loop.run_until_complete(all_of_them())
    finally:
        loop.close()
    return "".join(had)


def test_who_has_had_least_comes_next(spend):
    assert run_all(Turns(), spend, "aaaaab", seconds=0.1) == "abaaaa"
    assert run_all(Turns(), spend, "aaabbb", seconds=0.1) == "ababab"


def test_the_first_piece_is_followed_by_no_rest_and_many_by_one_as_long_as_the_piece(spend):
    run_all(Turns(), spend, "a" * 12)
    assert spend.rests[0] == 0
    assert spend.rests == sorted(spend.rests)
    assert spend.rests[-1] == 1


def test_who_asked_for_too_much_waits_and_nobody_else(spend, monkeypatch):
    waited = []

    async def sleep(seconds):
        waited.append(round(seconds, 3))
        spend(seconds)

    monkeypatch.setattr(limits, "sleep", sleep)
    turns = Turns()
    turns.penalise("a")
    assert run_all(turns, spend, "b") == "b"
    assert waited == []
    assert run_all(turns, spend, "aa") == "aa"
    assert waited == [Turns.PENALTY - 1]


def test_who_gave_up_waiting_has_no_turn_and_holds_up_nobody():
    async def steps():
        turns, had = Turns(), []

        async def piece(owner):
            async with turns.turn(owner):
                had.append(owner)
                await asyncio.sleep(0)

        first, gone, last = (asyncio.ensure_future(piece(owner)) for owner in "abc")
        await asyncio.sleep(0)
        gone.cancel()
        await asyncio.gather(first, last)
        await asyncio.sleep(0.01)
        await asyncio.wait_for(piece("d"), PATIENCE)
        assert had == ["a", "c", "d"]

    asyncio.run(steps())


def test_a_file_is_read_in_a_thread_one_at_a_time(monkeypatch):
    waiting, heard = [], []

    class Host:
        report_error = heard.append

        def call_later(self, act):
            act()

    class Future:
        def cancelled(self):
            return False

        def add_done_callback(self, act):
            waiting.append(lambda: act(self))

    thread = SimpleNamespace(submit=lambda *job, **about: Future())
    monkeypatch.setattr(take_away, "pool", lambda *_: thread)
    files, read = take_away.TakeAway(Host(), None), []
    files.load(b"x", read.append)
    files.load(b"x", read.append)
    assert heard == ["The last file is not done yet: try again in a moment."]
    assert read == []
    waiting.pop()()
    assert len(read) == 1
    files.load(b"x", read.append)
    assert len(waiting) == 1
