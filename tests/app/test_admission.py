"""Limits on sessions and on the cost of a request, and failures whose details stay in the log."""

import asyncio
import json
from unittest.mock import Mock

from bokeh.server.connection import ServerConnection
from vibroscope.app.server import admission, websocket
from vibroscope.app.server.protocol import PageProtocol
from vibroscope.app.server.websocket import SessionSocket, answer

from tests.browserless import Client, get
from tests.served import served
from tests.waiting import PATIENCE


def test_sessions_and_costs_beyond_the_limits_are_refused(tmp_path):
    limits = {"VIBROSCOPE_SESSIONS": "1", "VIBROSCOPE_STEPS": "5000000"}

    async def steps(server):
        async with Client(server.url) as client:
            await client.ready()
            refusal = await get(server.url)
            assert refusal.code == 503
            assert "as many sessions as it can" in refusal.body.decode()
            assert refusal.headers["Retry-After"]
            shown = await client.set(1, steps="32000")
            assert shown["texts"]["steps"] == "2000"
            assert "this server does 5,000,000" in shown["refused"]["text"]

    with served(tmp_path / "log.txt", **limits) as server:
        asyncio.run(asyncio.wait_for(steps(server), PATIENCE))


def test_a_page_that_cannot_be_built_shows_an_apology_without_the_error(monkeypatch, caplog):
    monkeypatch.setattr(admission, "create_app", lambda: 1 / 0)
    apology = admission.page_or_apology()[0].object
    assert "could not be built" in apology
    assert "division" not in apology
    assert "ZeroDivisionError" in caplog.text


def test_the_answer_to_a_message_that_fails_does_not_contain_the_error(caplog):
    async def fail(message, connection):
        raise RuntimeError("/home/someone/secret")

    protocol = PageProtocol()
    connection = ServerConnection(protocol, Mock(), None, Mock())
    failed = asyncio.run(answer(protocol.create("PULL-DOC-REQ"), connection, fail))
    assert failed.msgtype == "ERROR"
    assert json.loads(failed.content_json)["traceback"] is None
    assert "secret" not in failed.content_json
    assert "RuntimeError" not in failed.content_json
    assert "someone/secret" in caplog.text


def test_a_ping_to_a_connection_that_is_about_to_end_leaves_it_its_session():
    socket, session = SessionSocket.__new__(SessionSocket), Mock()
    socket.ws_connection = None  # Tornado drops it when the closing begins
    connection = ServerConnection(PageProtocol(), socket, None, session)
    connection.send_ping()  # Bokeh detaches the session where this fails
    assert connection.session is session


def test_a_browser_that_waits_for_its_session_is_pinged_and_then_no_more(monkeypatch):
    monkeypatch.setattr(websocket, "PING_SECONDS", 0.01)

    class Pings:
        def __init__(self):
            self.count, self.third = 0, asyncio.Event()

        def __call__(self):
            self.count += 1
            if self.count == 3:
                self.third.set()

    async def steps():
        first, second = Pings(), Pings()
        with websocket.pinging(first):
            await asyncio.wait_for(first.third.wait(), PATIENCE)
        sent = first.count
        with websocket.pinging(second):  # as long again
            await asyncio.wait_for(second.third.wait(), PATIENCE)
        assert first.count == sent

    asyncio.run(steps())
