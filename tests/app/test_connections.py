"""Connections that say nothing: they end, and while there are more of them than descriptors, others are served."""

import asyncio
import errno
import resource
import socket
import time
import urllib.request
from contextlib import ExitStack, contextmanager

from vibroscope.app.server.connections import Listener

from tests.browserless import Client
from tests.served import served

LIMIT, SILENT = 400, 420


@contextmanager
def descriptors(number):
    """What is started in here has no more."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (number, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def alive(server):
    return urllib.request.urlopen(f"{server.url}/liveness", timeout=15).read() == b"alive\n"


def half_sent(server):
    connection = socket.create_connection(("127.0.0.1", server.port))
    connection.sendall(b"GET / HTTP/1.1\r\nHost: x\r\nX-Slow: ")
    return connection


def ended(connection):
    try:
        return connection.recv(1) == b""
    except ConnectionResetError:
        return True


def test_more_silent_connections_than_descriptors(tmp_path):
    async def steps():
        async with Client(server.url) as client:  # a websocket is let be, however long it says nothing
            await client.ready()
            silent = [half_sent(server) for _ in range(SILENT)]
            begun, asked = time.monotonic(), 0
            while time.monotonic() < begun + 5:
                assert alive(server)
                asked += 1
                await asyncio.sleep(0.2)
            assert len(server.log.read_text().splitlines()) < 40
            assert server.metric('vibroscope_refused_total{what="connection"}') >= SILENT - LIMIT + 100 + asked
            for connection in silent:
                connection.settimeout(max(0.1, begun + 33 - time.monotonic()))
                assert ended(connection)
                connection.close()
            assert (await client.set(1, eta="1.7"))["texts"]["eta"] == "1.7"

    with ExitStack() as stack:
        with descriptors(LIMIT):
            server = stack.enter_context(served(tmp_path / "log.txt", VIBROSCOPE_LOG_FORMAT="json"))
        asyncio.run(asyncio.wait_for(steps(), 120))
    assert "Traceback" not in server.log.read_text()


def test_a_full_table_is_no_spin(monkeypatch, caplog):
    tried = []

    def full(_):
        tried.append(1)
        raise OSError(errno.EMFILE, "Too many open files")

    async def steps():
        server = Listener(lambda request: None)
        server.listen(0, "127.0.0.1")
        (listening,) = server._sockets.values()
        with socket.create_connection(listening.getsockname()):
            await asyncio.sleep(1.4)
            assert len(tried) == 2  # at once, and after a second
            monkeypatch.undo()
            await asyncio.sleep(1)
            assert server._silent  # let in after all
        server.stop()
        await server.close_all_connections()

    monkeypatch.setattr(socket.socket, "accept", full)
    asyncio.run(asyncio.wait_for(steps(), 20))
    assert len(caplog.records) <= 3


def test_a_full_table_of_websockets_lets_nobody_in():
    async def steps():
        server = Listener(lambda request: None)
        server.listen(0, "127.0.0.1")
        server._most = 0
        (listening,) = server._sockets.values()
        with socket.create_connection(listening.getsockname()) as refused:
            refused.setblocking(False)
            assert await asyncio.get_running_loop().sock_recv(refused, 1) == b""
        server.stop()

    asyncio.run(asyncio.wait_for(steps(), 20))
