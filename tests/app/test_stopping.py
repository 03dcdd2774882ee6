"""A server from the session that it keeps ready to the signal that stops it."""

import asyncio
import json
import signal
import time

import pytest

from tests.browserless import Client, mapped, move
from tests.served import served
from tests.waiting import PATIENCE


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    log = tmp_path_factory.mktemp("server") / "log.txt"
    with served(log, VIBROSCOPE_LOG_FORMAT="json", VIBROSCOPE_LOG_LEVEL="debug") as server:
        yield server


def logged(server):
    return [json.loads(line) for line in server.log.read_text().splitlines() if line.startswith("{")]


def test_a_prewarmed_page_works_like_any_other(server):
    server.wait_for(lambda: "session kept ready" in server.log.read_text())

    async def steps():
        assert server.metric("vibroscope_sessions ") == 0
        async with Client(server.url) as one, Client(server.url) as two, Client(server.url, "eta=1.5") as three:
            assert server.metric("vibroscope_sessions ") == 3
            for client in (one, two, three):
                await client.ready()
            assert (await one.set(1, eta="1.3"))["texts"]["eta"] == "1.3"
            assert (await two.set(1, K="9000"))["texts"]["eta"] == "1.08"
            assert (await three.set(1, K="9000"))["texts"]["eta"] == "1.5"

    asyncio.run(asyncio.wait_for(steps(), PATIENCE))
    built, opened = (
        [line["session"] for line in logged(server) if line["event"] == f"session {event}"]
        for event in ("kept ready", "opened")
    )
    assert len(opened) == 3
    assert built[0] == opened[0]
    assert not {*opened[1:]} & {*built}


def test_a_stop_signal_lets_a_move_finish_and_cancels_a_study(server):
    """It comes last."""

    async def steps():
        async with Client(server.url) as watcher, Client(server.url, "eta=1.2345") as client:
            await watcher.ready()
            await watcher.patch(watcher.message(mapped({"view": "plane"}), "Header"))
            await client.ready()
            shown = await client.shown(lambda shown: shown.get("update"))
            await client.patch(client.message(mapped({"painted": shown["update"]})))
            await client.patch(client.message(move({"eta": "1.31"}, 7)))
            server.process.send_signal(signal.SIGTERM)
            return await client.shown(lambda shown: shown.get("move") == 7)

    assert asyncio.run(asyncio.wait_for(steps(), PATIENCE))["texts"]["eta"] == "1.31"
    begun = time.monotonic()
    assert server.stop() == 0
    assert time.monotonic() - begun < 30  # the study alone would take minutes
    log = server.log.read_text()
    assert "Traceback" not in log
    assert "left unfinished" not in log
    assert not [line for line in logged(server) if "traceback" in line]
