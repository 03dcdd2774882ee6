"""Silent connections end, even when there are more than descriptors; a browser that never reads delays nobody."""

import asyncio
import errno
import os
import resource
import socket
import time
import urllib.request
from contextlib import ExitStack, contextmanager

import pytest
from tornado.iostream import StreamClosedError
from vibroscope.app.server.connections import MOST_UNREAD_BYTES, Listener, Stream

from tests.browserless import Client
from tests.served import served
from tests.waiting import PATIENCE

LIMIT, SILENT = 400, 420
FASTER = 4  # than 30 s: connections are opened in a second or two
QUICK = f"""
from tornado.httpserver import HTTPServer
initialize = HTTPServer.initialize
def sooner(server, *args, idle_connection_timeout, **kwargs):
    initialize(server, *args, idle_connection_timeout=idle_connection_timeout / {FASTER}, **kwargs)
HTTPServer.initialize = sooner
"""


@contextmanager
def descriptors(number):
    """A process that starts in this block has no more."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (number, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def alive(server):
    return urllib.request.urlopen(f"{server.url}/liveness", timeout=PATIENCE).read() == b"alive\n"


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
    async def steps(sockets):
        async with Client(server.url) as client:  # a websocket may be silent for ever
            await client.ready()
            silent = []
            while len(silent) < SILENT:
                silent += [sockets.enter_context(half_sent(server)) for _ in range(20)]
                assert alive(server)  # all are accepted: the system queues no more than 128
            begun = time.monotonic()
            assert len(server.log.read_text().splitlines()) < 40
            assert server.metric('vibroscope_refused_total{what="connection"}') >= SILENT - LIMIT + 128
            for connection in silent:
                connection.settimeout(max(0.1, begun + 20 - time.monotonic()))
                assert ended(connection)
            assert (await client.set(1, eta="1.7"))["texts"]["eta"] == "1.7"

    with ExitStack() as stack:
        with descriptors(LIMIT):
            (tmp_path / "sitecustomize.py").write_text(QUICK)
            options = {"VIBROSCOPE_LOG_FORMAT": "json", "PYTHONPATH": str(tmp_path)}
            server = stack.enter_context(served(tmp_path / "log.txt", **options))
        asyncio.run(asyncio.wait_for(steps(stack), PATIENCE))
    assert "Traceback" not in server.log.read_text()


@contextmanager
def listening(**options):
    """A listener and the address that it listens on."""
    server = Listener(lambda request: None, **options)
    sock = socket.create_server(("127.0.0.1", 0))
    address = sock.getsockname()
    server.add_sockets([sock])
    try:
        yield server, address
    finally:
        server.stop()


def test_the_listener_pauses_while_the_system_has_no_descriptors(monkeypatch, caplog):
    async def steps():
        tried, again = [], asyncio.Event()

        def full(_):
            tried.append(time.monotonic())
            if len(tried) == 2:
                again.set()
            raise OSError(errno.EMFILE, "Too many open files")

        monkeypatch.setattr(socket.socket, "accept", full)
        with listening() as (server, address), socket.create_connection(address):
            await again.wait()
            assert tried[1] - tried[0] > 0.9
            monkeypatch.undo()
            while not server.silent_connections:  # admitted after all
                await asyncio.sleep(0.02)
        await server.close_all_connections()

    asyncio.run(asyncio.wait_for(steps(), PATIENCE))
    assert len(caplog.records) <= 3


def test_a_new_connection_replaces_the_one_that_has_been_silent_longest():
    async def steps(last):
        with (
            listening(most_descriptors=last + 7) as (server, address),
            ExitStack() as stack,
        ):  # its own, and two of each
            clients = []
            for count in (1, 2, 2):
                clients.append(stack.enter_context(socket.create_connection(address)))
                clients[-1].setblocking(False)
                while server.silent_connections < count:
                    await asyncio.sleep(0.01)
            assert await asyncio.get_running_loop().sock_recv(clients[0], 1) == b""
            for client in clients[1:]:
                with pytest.raises(BlockingIOError):
                    client.recv(1)
        await server.close_all_connections()

    with ExitStack() as stack:  # the next numbers follow each other
        filled = [stack.enter_context(open(os.devnull)).fileno() for _ in range(64)]
        asyncio.run(asyncio.wait_for(steps(max(filled) + 3), PATIENCE))  # after those of the loop


def test_a_connection_is_refused_when_only_websockets_could_make_room():
    async def steps():
        with listening(most_descriptors=0) as (_, address), socket.create_connection(address) as refused:
            refused.setblocking(False)
            assert await asyncio.get_running_loop().sock_recv(refused, 1) == b""

    asyncio.run(asyncio.wait_for(steps(), PATIENCE))


@contextmanager
def stream_and_reader():
    ours, theirs = socket.socketpair()
    with theirs:
        stream = Stream(ours)
        yield stream, theirs
        stream.close()


def test_writing_does_not_wait_for_a_browser_that_never_reads_and_gives_up_on_it_once():
    async def steps():
        given_up = []

        def give_up():
            given_up.append(True)
            stream.write(b"farewell")

        with stream_and_reader() as (stream, _):
            stream.write_without_waiting(give_up)
            for _ in range(MOST_UNREAD_BYTES // 1_000_000):
                await asyncio.wait_for(stream.write(bytes(1_000_000)), PATIENCE)
            assert not given_up  # the system has taken a part of it
            for _ in range(5):
                await asyncio.wait_for(stream.write(bytes(1_000_000)), PATIENCE)
        assert given_up == [True]

    asyncio.run(steps())


def test_what_is_written_without_waiting_arrives():
    async def steps():
        with stream_and_reader() as (stream, reader):
            stream.write_without_waiting(lambda: None)
            await asyncio.gather(stream.write(b"one "), stream.write(b"two"))
            assert reader.recv(100) == b"one two"

    asyncio.run(steps())


def test_writing_to_a_closed_stream_is_an_error():
    async def steps():
        with stream_and_reader() as (stream, _):
            stream.write_without_waiting(lambda: None)
            stream.close()
            with pytest.raises(StreamClosedError):
                await stream.write(b"x")

    asyncio.run(steps())
