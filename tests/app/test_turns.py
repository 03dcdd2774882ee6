"""Openings take turns by address, and their budget has a price for every frame, byte and file."""

import asyncio
import json
import struct
import time
from contextlib import suppress
from types import SimpleNamespace

import pytest
from tornado.iostream import StreamClosedError
from tornado.websocket import WebSocketClosedError
from vibroscope.app.page import take_away
from vibroscope.app.runtime import limits
from vibroscope.app.runtime.limits import Turns

from tests.browserless import Client, mapped, token_of
from tests.served import served
from tests.share import share
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


# --- what a client sends ----------------------------------------------------------------------------------------------

MASKED, PING, CONTINUATION, TEXT, FINAL = 0x80, 0x9, 0x0, 0x1, 0x80


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with served(tmp_path_factory.mktemp("turns") / "log.txt", VIBROSCOPE_LOG_FORMAT="json") as server:
        yield server
    lines = [json.loads(line) for line in server.log.read_text().splitlines() if line.startswith("{")]
    assert not [line for line in lines if "traceback" in line or line["level"] == "error"]


def frame(kind, text=b""):
    assert len(text) < 126
    return struct.pack("BB", kind, MASKED | len(text)) + bytes(4) + text


@pytest.mark.parametrize(
    "frames",
    [[frame(FINAL | PING)], [frame(TEXT, b"x"), *[frame(CONTINUATION)] * 50]],
    ids=["pings", "fragments without content"],
)
def test_frames_without_content_are_not_free(server, frames):
    async def steps():
        client = await Client(server.url).open()
        stream = client.socket.protocol.stream
        begin, *more = frames
        try:
            await stream.write(begin)
            for _ in range(200):
                await stream.write(b"".join(more or [begin]) * 100)
            while await client.receive() is not None:
                pass
        finally:
            client.socket.close()

    refused = server.metric('vibroscope_refused_total{what="message"}')
    with suppress(StreamClosedError, WebSocketClosedError):  # the client still writes
        asyncio.run(asyncio.wait_for(steps(), PATIENCE))
    assert server.metric('vibroscope_refused_total{what="message"}') == refused + 1


def upload(text):
    parts = [text[begin : begin + 4000] for begin in range(0, len(text), 4000)]
    return mapped({"load": mapped({str(number): part for number, part in enumerate(parts)})})


@pytest.mark.parametrize("compression", [None, {}])
def test_large_files_are_read_at_a_limited_rate(server, compression):
    text, files = "# " + "x" * 60_000, 30

    async def steps():
        async with Client(server.url, compression=compression) as client:
            await client.ready()
            begun = time.monotonic()
            for _ in range(files):
                await client.send("PATCH-DOC", {"events": [client.message(upload(text), "Header")]})
            await client.set(99, eta="1.3")  # and the session goes on
            return time.monotonic() - begun

    seconds = asyncio.run(asyncio.wait_for(steps(), PATIENCE))
    assert seconds > (files * len(text) - 1_000_000) / 400_000 - 0.5


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
    files.load({"0": "x"}, read.append)
    files.load({"0": "x"}, read.append)
    assert heard == ["The last file is still being read: try again in a moment."]
    assert read == []
    waiting.pop()()
    assert len(read) == 1
    files.load({"0": "x"}, read.append)
    assert len(waiting) == 1


def test_a_browser_that_closes_right_after_the_upgrade_causes_no_traceback(server):
    async def steps():
        for number in range(share(18)):
            token = await token_of(server.url)
            reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
            head = f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nOrigin: {server.url}\r\n"
            head += "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            head += f"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: bokeh, {token}\r\n\r\n"
            writer.write(head.encode())
            await writer.drain()
            if number % 2:
                assert (await reader.readline()).startswith(b"HTTP/1.1 101")
            writer.transport.abort()
        async with Client(server.url) as client:  # by now the server has dealt with the others
            await client.ready()

    asyncio.run(asyncio.wait_for(steps(), PATIENCE))  # the fixture reads the log
