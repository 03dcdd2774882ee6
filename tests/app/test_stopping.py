"""A server that is asked to stop."""

import asyncio
import signal
import time

from tests.browserless import Client, mapped, move
from tests.served import served
from tests.waiting import PATIENCE


def test_a_stop_signal_lets_a_move_finish_and_cancels_a_study(tmp_path):
    async def steps(server):
        async with Client(server.url) as watcher, Client(server.url, "eta=1.2345") as client:
            await watcher.ready()
            await watcher.patch(watcher.message(mapped({"view": "plane"}), "Header"))
            await client.ready()
            shown = await client.shown(lambda shown: shown.get("update"))
            await client.patch(client.message(mapped({"painted": shown["update"]})))
            await client.patch(client.message(move({"eta": "1.31"}, 7)))
            server.process.send_signal(signal.SIGTERM)
            return await client.shown(lambda shown: shown.get("move") == 7)

    with served(tmp_path / "log.txt") as server:
        assert asyncio.run(asyncio.wait_for(steps(server), PATIENCE))["texts"]["eta"] == "1.31"
        begun = time.monotonic()
        assert server.stop() == 0
        assert time.monotonic() - begun < 30  # the study alone would take minutes
    log = server.log.read_text()
    assert "Traceback" not in log
    assert "left unfinished" not in log
