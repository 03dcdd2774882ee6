"""The log names the client that a proxy names; without that setting nobody can name another client."""

import asyncio
import json

import pytest

from tests.browserless import get
from tests.served import served
from tests.waiting import PATIENCE

CLIENT = "203.0.113.7"


@pytest.mark.parametrize(("proxied", "named"), [("no", "127.0.0.1"), ("yes", CLIENT)])
def test_the_log_names_the_client_that_was_refused(proxied, named, tmp_path):
    async def ask():
        headers = {"X-Forwarded-For": CLIENT, "Sec-WebSocket-Protocol": "bokeh, forged"}
        assert (await get(f"{server.url}/ws", headers=headers)).code == 403
        for near in (CLIENT, "127.0.0.1"):  # whoever comes through a proxy is not of this machine
            assert (await get(f"{server.url}/metrics", headers={"X-Forwarded-For": near})).code == 404

    with served(tmp_path / "log.txt", VIBROSCOPE_LOG_FORMAT="json", VIBROSCOPE_PROXIED=proxied) as server:
        asyncio.run(asyncio.wait_for(ask(), PATIENCE))
    lines = [json.loads(line) for line in (tmp_path / "log.txt").read_text().splitlines()]
    assert [line["address"] for line in lines if line["event"] == "refused"] == [named]
