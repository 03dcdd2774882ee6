"""Connections: how long one may be silent, and how many there may be.

Tornado lets a connection that says nothing be for an hour. So enough of them take every descriptor there is; nobody
comes in any more, and each turn of the loop fails to accept and logs that it failed. Here a silent one ends soon, and
some descriptors are never given to connections: once only those are left, whoever comes in takes the place of the one
that has been silent the longest. Websockets are not silent, whatever they say: Bokeh asks whether they still live.
"""

from __future__ import annotations

import errno
import logging
import resource
import socket
from functools import partial

from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPConnection, HTTPMessageDelegate
from tornado.ioloop import IOLoop
from tornado.iostream import IOStream
from vibroscope.app.runtime import logs, metrics
from vibroscope.app.runtime.limits import Bucket

_SILENT_SECONDS = 30  # between connecting or an answer and the next request, and for its body: the page sends none
_LONGEST_BODY = 1 << 16
OPTIONS = {
    "idle_connection_timeout": _SILENT_SECONDS,
    "body_timeout": _SILENT_SECONDS,
    "max_body_size": _LONGEST_BODY,
}
_KEPT_FREE = 128  # for files: as many connections as Tornado accepts in one turn may each ask for one
_REST_SECONDS = 1
_NO_ROOM = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)


class Listener(HTTPServer):
    """Tornado's server, whose connections leave some descriptors free."""

    def initialize(self, *args, **kwargs) -> None:
        """See `tornado.util.Configurable`."""
        super().initialize(*args, **kwargs)
        limit, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
        self._most = limit - min(_KEPT_FREE, limit // 2)
        self._silent: dict[IOStream, None] = {}  # those that are no websockets, the longest silent first
        self._words = Bucket(rate=1, burst=1)

    def add_sockets(self, sockets) -> None:
        """Accept on these, and rest where the system refuses."""
        super().add_sockets([_Resting(sock, self._rest) for sock in sockets])

    def _rest(self, sock: socket.socket) -> None:
        self._handlers[sock.fileno()]()  # Tornado's, to accept no more; it may be called again
        self._tell("none accepted for a moment")
        IOLoop.current().call_later(_REST_SECONDS, self._accept_again, sock)

    def _accept_again(self, sock: socket.socket) -> None:
        if not self._stopped:
            super().add_sockets([sock])

    def _handle_connection(self, connection: socket.socket, address: object) -> None:
        # The system gives the lowest number that is free, so that here all below are taken, whoever has them.
        if connection.fileno() >= self._most:
            metrics.REFUSED.add("connection")
            higher, room = connection, self._end_longest_silent()
            self._tell("the longest silent one ended" if room else "none let in")
            with higher:
                if not room:
                    return
                connection = higher.dup()  # has the number that just became free
        super()._handle_connection(connection, address)

    def _end_longest_silent(self) -> bool:
        while self._silent:
            stream = next(iter(self._silent))
            del self._silent[stream]
            if not stream.closed():
                stream.close()
                return True
        return False

    def _tell(self, what: str) -> None:
        if self._words.take():
            logs.event("connections at their limit", logging.WARNING, most=self._most, what=what)

    def start_request(self, server_conn: object, request_conn: HTTPConnection) -> HTTPMessageDelegate:
        """Tornado waits for the next request of a connection."""
        self._silent.pop(server_conn.stream, None)
        self._silent[server_conn.stream] = None
        return super().start_request(server_conn, request_conn)

    def on_close(self, server_conn: object) -> None:
        """It ended, or became a websocket."""
        self._silent.pop(server_conn.stream, None)
        super().on_close(server_conn)


class _Resting(socket.socket):
    """A listening socket that says so where the system has no descriptor left, instead of failing in every turn."""

    def __init__(self, sock: socket.socket, rest) -> None:
        super().__init__(fileno=sock.detach())
        self.setblocking(False)
        self._rest = partial(rest, self)

    def accept(self) -> tuple[socket.socket, object]:
        """See `socket.socket.accept`; Tornado takes a `BlockingIOError` for the end of this turn."""
        try:
            return super().accept()
        except OSError as error:
            if error.errno not in _NO_ROOM:
                raise
            self._rest()
            raise BlockingIOError from error
