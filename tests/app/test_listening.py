"""Addresses that the server listens on, IPv6 among them, origins that it accepts, and the client that its log names."""

import asyncio
import re
import signal
import socket

import pytest
from vibroscope.app.runtime.settings import Settings
from vibroscope.app.server.security import allowed_hosts, allowed_origins

from tests.browserless import Client, get
from tests.served import served
from tests.waiting import PATIENCE


def has_ipv6():
    try:
        with socket.socket(socket.AF_INET6) as probe:
            probe.bind(("::1", 0))
    except OSError:
        return False
    return True


@pytest.mark.skipif(not has_ipv6(), reason="this machine has no IPv6")
def test_a_session_over_ipv6_by_a_proxy_that_names_its_client_until_an_interrupt(tmp_path):
    """An end by SIGTERM: `test_stopping`. Without the setting of a proxy, nobody can name another: `test_hosts`."""
    proxied = "203.0.113.7"

    async def steps():
        other = Client(server.url)
        assert await other.knock(origin=server.url.replace("[::1]", "[::2]")) == 403
        headers = {"X-Forwarded-For": proxied, "Sec-WebSocket-Protocol": "bokeh, forged"}
        assert (await get(f"{server.url}/ws", headers=headers)).code == 403
        for near in (proxied, "::1"):  # whoever comes through a proxy is not of this machine
            assert (await get(f"{server.url}/metrics", headers={"X-Forwarded-For": near})).code == 404
        async with Client(server.url) as client:  # its origin is the server's own address
            assert await client.ready()

    with served(tmp_path / "log.txt", VIBROSCOPE_ADDRESS="::1", VIBROSCOPE_PROXIED="yes") as server:
        asyncio.run(asyncio.wait_for(steps(), PATIENCE))
        assert server.stop(signal.SIGINT) == 0
    log = server.log.read_text()
    assert f"Launching server at http://[::1]:{server.port}\n" in log
    assert re.findall(r" refused .*address=(\S+)", log) == ["::1", proxied]
    assert "Traceback" not in log


@pytest.mark.parametrize(
    ("chosen", "origins"),
    [
        (Settings(), {"127.0.0.1:8000", "localhost:8000"}),
        (Settings(address="::1"), {"[::1]:8000", "localhost:8000"}),
        (
            Settings(origins=("a.example", "b.example:81", "[::1]", "[::2]:80", "[::3]:8080")),
            {"a.example", "b.example:81", "[::1]", "[::2]", "[::3]:8080"},
        ),
    ],
)
def test_origins_are_compared_without_the_default_port(chosen, origins):
    assert allowed_origins(chosen, 8000) == origins
    assert allowed_hosts(chosen, 8000) == origins | {"127.0.0.1:8000", "localhost:8000", "[::1]:8000"}
