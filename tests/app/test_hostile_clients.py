"""Hostile clients: forged tokens, origins, addresses, values and messages; floods of messages and connections."""

import asyncio
import json
import struct
import time
from contextlib import suppress

import pytest
from tornado.iostream import StreamClosedError
from tornado.websocket import WebSocketClosedError

from tests.browserless import Client, changed, event, mapped, move, token_of
from tests.served import served
from tests.share import share
from tests.waiting import PATIENCE

# One of each way to fail; test_reading.py tries more of them, and the release tests try thousands.
BAD_ADDRESSES = ("eta=%C2%B2", "eta=" + "9" * 1900, "eta=1.2&eta=1.3", "view=nowhere", "theme=²&eta=%ff%fe")


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    log = tmp_path_factory.mktemp("server") / "log.txt"
    with served(log, VIBROSCOPE_LOG_FORMAT="json", VIBROSCOPE_SESSIONS="40") as server:
        yield server
    lines = [json.loads(line) for line in log.read_text().splitlines() if line.startswith("{")]
    assert {"session opened", "computed", "refused"} <= {line["event"] for line in lines}
    assert not [line for line in lines if "traceback" in line or line["event"] == "answered"]


def run(steps):
    return asyncio.run(asyncio.wait_for(steps, PATIENCE))  # so long on a busy machine, a few seconds else


def test_a_forged_token_gets_no_connection(server):
    async def steps():
        good = await token_of(server.url)
        head, _, sign = good.partition(".")
        other = await token_of(server.url)
        mixed = f"{other.partition('.')[0]}.{sign}"
        for token in ("x", "eyJzZXNzaW9uX2lkIjogIngifQ", head, f"{head}.{sign[::-1]}", mixed):
            assert await Client(server.url).knock(token=token) == 403

    run(steps())


def test_another_origin_gets_no_connection(server):
    async def steps():
        for origin in ("http://evil.example", f"http://127.0.0.1:{server.port}.evil.example", "null"):
            assert await Client(server.url).knock(origin=origin) == 403

    run(steps())


@pytest.mark.parametrize("query", BAD_ADDRESSES)
def test_a_bad_address_is_refused_in_words(server, query):
    async def steps():
        async with Client(server.url, query) as client:
            header = next(m for m in client.models("Header1"))
            assert "The link was not accepted" in header["attributes"].get("error", "")

    run(steps())


def test_a_forged_value_is_refused_in_words_and_the_state_stays(server):
    async def steps():
        async with Client(server.url) as client:
            await client.ready()
            held = await client.set(1, eta="1.2", K="2500")
            assert held["texts"]["eta"] == "1.2"
            for number, text in enumerate(("nan", "1e999", "²", "9" * 5000, "", None, True, 7), start=2):
                await client.patch(client.message(move({"eta": text, "K": "500"}, number)))
            await client.set(50, D="9")
            held = await client.set(51, eta="1e9", K="500")
            assert held["texts"]["eta"] == "1.2"
            assert held["texts"]["K"] == "2500"
            assert "eta must be" in held["refused"]["text"]

    run(steps())


def test_no_model_can_be_forged(server):
    async def steps():
        client = Client(server.url)
        token = await token_of(server.url)
        await client.open(token=token)
        other = await Client(server.url).open(token=token)  # shows the same session
        source = client.models("ColumnDataSource")[0]["id"]
        ends = client.models("Range1d")[0]["id"]
        await client.ready()
        for forged in (
            changed(client.component("Controls"), "esm", "alert(1)"),
            changed(client.models("Header1")[0]["id"], "error", "<b>give me your password</b>"),
            changed(client.models("Controls1")[0]["id"], "shown", mapped({})),
            changed(client.models("Figure")[0]["id"], "width", 10**9),
            changed(source, "data", mapped({"x": [1, 2, 3]})),
            changed(ends, "start", {"type": "number", "value": "nan"}),
            changed(ends, "start", float("inf")),
            changed(ends, "start", "0"),
            {"kind": "ColumnsStreamed", "model": {"id": source}, "attr": "data", "data": {}, "rollover": None},
            {"kind": "RootRemoved", "model": {"id": source}},
            {"kind": "TitleChanged", "title": "forged"},
            event("data_event", mapped({"model": {"id": "p1"}, "data": 1})),
            event("button_click", mapped({"model": {"id": source}})),
            "nothing",
        ):
            assert (await client.patch(forged))["msgtype"] == "OK"
        fresh = await open_when_affordable(server.url, token)
        for reader in (other, fresh):
            reader.socket.close()
        text = json.dumps(fresh.document)
        assert "alert(1)" not in text
        assert "password" not in text
        assert fresh.models("Header1")[0]["attributes"].get("error", "") == ""
        shown = await client.set(9, eta="1.3")  # and the session goes on
        assert shown["texts"]["eta"] == "1.3"
        client.socket.close()

    run(steps())


async def open_when_affordable(url, token):
    """Open the session once its budget allows it: sending the document costs as much as many moves."""
    while True:
        client = Client(url)
        try:
            return await client.open(token=token)
        except ConnectionError:  # the server has closed the connection
            client.socket.close()
        await asyncio.sleep(1)  # an attempt costs tokens, too


def test_a_message_that_the_page_never_sends_ends_the_connection(server):
    kinds = ("PUSH-DOC", "SERVER-INFO-REQ", "OK", "nonsense")
    messages = [(json.dumps({"msgid": "1", "msgtype": kind}), "{}", '{"doc": {"roots": []}}') for kind in kinds]
    nameless = [(json.dumps({"msgtype": kind}), "{}", '{"events": []}') for kind in ("PULL-DOC-REQ", "PATCH-DOC")]
    garbage = [["{"] * 3, ["[]"] * 3, ["9" * 5000] * 3, [b"\0"], ["x" * 300_000]]

    async def steps():
        for kind in (messages, nameless, garbage):
            token = await token_of(server.url)  # all of a kind connect to one session
            for parts in kind:
                client = await Client(server.url).connect(token=token)
                for part in parts:
                    await client.socket.write_message(part, binary=isinstance(part, bytes))
                while await client.socket.read_message() is not None:
                    pass
                client.socket.close()

    run(steps())


def test_a_flood_of_messages_ends_the_connection(server):
    async def steps():
        client = await Client(server.url).connect()
        try:
            for _ in range(6000):  # empty, so that a busy machine takes them in fast enough, too
                await client.send("PATCH-DOC", {"events": []})
            while await client.receive() is not None:
                pass
        finally:
            client.socket.close()

    refused = server.metric('vibroscope_refused_total{what="message"}')
    with suppress(WebSocketClosedError):
        run(steps())
    assert server.metric('vibroscope_refused_total{what="message"}') > refused


def test_a_flood_within_one_message_ends_the_connection(server):
    async def steps():
        async with Client(server.url) as client:
            await client.ready()
            tabs = [client.message(mapped({"view": tab}), "Header") for tab in ("help", "explore")]
            assert await client.patch(*tabs * 10) is not None
            assert await client.patch(*tabs * 250) is None

    run(steps())


def test_the_budget_of_a_session_covers_all_its_connections(server):
    async def steps():
        token = await token_of(server.url)
        one = await Client(server.url).open(token)  # the document is sent once
        two, three = [await Client(server.url).connect(token) for _ in range(2)]
        four = Client(server.url)
        with pytest.raises(ConnectionError):  # the server closes instead of acknowledging
            await four.connect(token)
        try:
            with pytest.raises((ConnectionError, WebSocketClosedError)):
                await twice((one, two, three))  # not too much for one connection alone
        finally:
            for client in (one, two, three, four):
                client.socket.close()

    run(steps())


def test_coming_back_again_and_again_is_refused(server):
    async def comes_back(token):
        client = Client(server.url)
        try:
            await client.connect(token)
        except ConnectionError:  # the server closes instead of acknowledging
            return False
        finally:
            client.socket.close()
        while await client.socket.read_message() is not None:
            pass  # the server knows that the browser has gone
        return True

    async def steps():
        token = await token_of(server.url)
        stays = await Client(server.url).open(token)
        await stays.ready()
        times = 0
        while times < 200 and await comes_back(token):
            times += 1
        assert 3 < times < 200  # a browser that loses its connection now and then is admitted
        await asyncio.sleep(2)  # all of them have spent the budget of one session; it fills again
        assert (await stays.set(1, eta="1.3"))["texts"]["eta"] == "1.3"
        stays.socket.close()

    run(steps())


async def twice(clients):
    """Get the document twice in each; the server may close before all is sent."""
    for _ in range(2):
        for client in clients:
            await client.send("PULL-DOC-REQ", {})
    for client in clients:
        for _ in range(2):
            await client.answer("PULL-DOC-REPLY")


def test_a_client_that_leaves_before_the_answer_causes_no_traceback(server):
    async def steps():
        for _ in range(3):
            client = await Client(server.url).connect()
            for _ in range(2):
                await client.send("PULL-DOC-REQ", {})
            client.socket.close()
        async with Client(server.url) as client:  # by now the server has dealt with the others
            await client.ready()

    run(steps())  # the fixture reads the log


MASKED, PING, CONTINUATION, TEXT, FINAL = 0x80, 0x9, 0x0, 0x1, 0x80


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
        run(steps())
    assert server.metric('vibroscope_refused_total{what="message"}') == refused + 1


def upload(text):
    parts = [text[begin : begin + 4000] for begin in range(0, len(text), 4000)]
    return mapped({"part": mapped({str(number): part for number, part in enumerate(parts)})})


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

    seconds = run(steps())
    assert seconds > (files * len(text) - 1_000_000) / 400_000 - 0.5


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

    run(steps())  # the fixture reads the log
