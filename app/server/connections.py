"""HTTP connections: time limits for silent ones, a limit on their number, writing without waiting, bare refusals.

Tornado keeps a silent connection for an hour, so that enough of them take every file descriptor; then nobody can
connect, and each turn of the event loop fails to accept and logs that. Here a silent connection ends soon, and some
descriptors are never given to connections: when only those are left, a new connection replaces the one that has been
silent longest. Websockets do not count as silent: Bokeh checks with pings whether they are alive.
"""

import asyncio
import errno
import logging
import resource
import socket
from asyncio import Future
from collections.abc import Awaitable, Callable, Iterable

from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPConnection, HTTPMessageDelegate
from tornado.ioloop import IOLoop
from tornado.iostream import IOStream, StreamBufferFullError
from vibroscope.app.compat import BARE_REFUSAL
from vibroscope.app.runtime import logs, metrics
from vibroscope.app.runtime.limits import TokenBucket
from vibroscope.app.server.security import HEADERS

_SILENT_SECONDS = 30  # between connecting or an answer and the next request, and for a body, which the page never sends
_MOST_BODY_BYTES = 1 << 16
OPTIONS = {
    "idle_connection_timeout": _SILENT_SECONDS,
    "body_timeout": _SILENT_SECONDS,
    "max_body_size": _MOST_BODY_BYTES,
}
MOST_UNREAD_BYTES = 16_000_000  # that wait for one browser; larger than any export
_RESERVED_DESCRIPTORS = 128  # for files: all connections that Tornado accepts in one turn may each open one
_NO_DESCRIPTORS = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)


class Listener(HTTPServer):
    """Tornado's HTTP server with at most ``most_descriptors`` connections; by default as many as the system allows."""

    def initialize(self, *args, most_descriptors: int | None = None, **kwargs) -> None:
        """See `tornado.util.Configurable`."""
        super().initialize(*args, **kwargs)
        limit, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
        reserved = min(_RESERVED_DESCRIPTORS, limit // 2)
        self._most = limit - reserved if most_descriptors is None else most_descriptors
        self._silent: dict[IOStream, None] = {}  # the connections that are no websockets, longest silent first
        self._stopped_listening = False
        self._log_rate = TokenBucket(rate=1, burst=1)

    def add_sockets(self, sockets: Iterable[socket.socket]) -> None:
        """Accept connections on these sockets, and pause when the system refuses."""
        super().add_sockets([_ListeningSocket(sock, self._admit, self._pause) for sock in sockets])

    def stop(self) -> None:
        """Accept no more connections."""
        self._stopped_listening = True
        super().stop()

    def handle_stream(self, stream: IOStream, address: tuple) -> Awaitable[None] | None:
        """Serve one connection; its stream can write without waiting."""
        return super().handle_stream(Stream(stream.socket, self.max_buffer_size, self.read_chunk_size), address)

    def _pause(self, sock: socket.socket) -> None:
        IOLoop.current().remove_handler(sock)  # else each turn of the loop would try again
        self._log("none accepted for a moment")
        IOLoop.current().call_later(1, self._resume, sock)

    def _resume(self, sock: socket.socket) -> None:
        if not self._stopped_listening:
            super().add_sockets([sock])

    def _admit(self, connection: socket.socket) -> socket.socket | None:
        """Return the connection to serve in place of a new one, or None to refuse it."""
        # The system assigns the lowest free number: at this number all lower descriptors are in use.
        if connection.fileno() < self._most:
            return connection
        with connection:
            while self._close_longest_silent():
                copy = connection.dup()  # takes the number that has just become free, unless another thread was faster
                if copy.fileno() < self._most:
                    self._log("the longest silent one ended")
                    return copy
                copy.close()
        metrics.REFUSED.add("connection")
        self._log("none let in")
        return None

    def _close_longest_silent(self) -> bool:
        while self._silent:
            stream = next(iter(self._silent))
            del self._silent[stream]
            if not stream.closed():
                stream.close()
                metrics.REFUSED.add("connection")
                return True
        return False

    def _log(self, what: str) -> None:
        if self._log_rate.take():
            logs.event("connections at their limit", logging.WARNING, most=self._most, what=what)

    @property
    def silent_connections(self) -> int:
        """Number of connections that wait for a request or send one, websockets excluded."""
        return len(self._silent)

    def start_request(self, server_conn: object, request_conn: HTTPConnection) -> HTTPMessageDelegate:
        """Called when Tornado waits for the next request of a connection."""
        self._silent.pop(server_conn.stream, None)
        self._silent[server_conn.stream] = None
        return super().start_request(server_conn, request_conn)

    def on_close(self, server_conn: object) -> None:
        """Called when a connection ends or becomes a websocket."""
        self._silent.pop(server_conn.stream, None)
        super().on_close(server_conn)


class _ListeningSocket(socket.socket):
    """A listening socket that asks ``admit`` about each connection and calls ``pause`` when descriptors run out."""

    def __init__(
        self,
        sock: socket.socket,
        admit: Callable[[socket.socket], socket.socket | None],
        pause: Callable[[socket.socket], None],
    ) -> None:
        super().__init__(fileno=sock.detach())
        self.setblocking(False)
        self._admit, self._pause = admit, pause

    def accept(self) -> tuple[socket.socket, object]:
        """See `socket.socket.accept`; Tornado takes these two errors for "no more" and "this one has gone"."""
        try:
            connection, address = super().accept()
        except OSError as error:
            if error.errno not in _NO_DESCRIPTORS:
                raise
            self._pause(self)
            raise BlockingIOError from error
        admitted = self._admit(connection)
        if admitted is None:
            raise ConnectionAbortedError
        return admitted, address


_REFUSAL = "\r\n".join(
    ["HTTP/1.1 400 Bad Request", *(f"{name}: {value}" for name, value in HEADERS.items()), "Content-Length: 0", "", ""]
).encode()


class Stream(IOStream):
    """A connection whose writer need not wait until the browser has read what was written.

    Bokeh waits with the session locked, so that a browser that never reads would stop every other connection to its
    session. What Tornado writes to a client that it does not understand has the security headers, too.
    """

    _give_up: Callable[[], None] | None = None
    _price: Callable[[int], float] | None = None

    def price_reads(self, price: Callable[[int], float]) -> None:
        """From now on wait for ``price(number of bytes)`` seconds before each time that so many are read."""
        self._price = price

    def read_bytes(self, num_bytes: int, partial: bool = False) -> Awaitable[bytes]:
        """See `tornado.iostream.IOStream`."""
        seconds = self._price(num_bytes) if self._price is not None else 0.0
        return self._read_later(seconds, num_bytes, partial) if seconds else super().read_bytes(num_bytes, partial)

    async def _read_later(self, seconds: float, num_bytes: int, partial: bool) -> bytes:
        await asyncio.sleep(seconds)
        return await super().read_bytes(num_bytes, partial)

    def write_without_waiting(self, give_up: Callable[[], None]) -> None:
        """From now on report every write as done; call ``give_up`` once if too many bytes remain unread."""
        self.max_write_buffer_size = MOST_UNREAD_BYTES
        self._give_up = give_up

    def write(self, data: bytes | memoryview) -> Future[None]:
        """See `tornado.iostream.IOStream`."""
        if self._give_up is None:
            return super().write(_REFUSAL if data == BARE_REFUSAL else data)
        try:
            super().write(data)
        except StreamBufferFullError:
            self.max_write_buffer_size = None  # the message that closes the connection is written, too
            self._give_up()
        done: Future[None] = Future()
        done.set_result(None)
        return done
