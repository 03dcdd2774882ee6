"""What is written to a connection within one turn of the loop leaves it in one piece.

A message of Bokeh's is three frames and more, each a call of the system's, and each call gives the interpreter's lock
away: with solvers at work it comes back after milliseconds.

Nobody waits until the browser has taken it: Bokeh would, with the session locked, and one that never reads would stop
whoever else looks at that session. So it may pile up, to a bound.
"""

from __future__ import annotations

import asyncio
from asyncio import Future
from collections.abc import Callable

from tornado.iostream import IOStream, StreamClosedError

_CONTROL = 0x08  # close, ping, pong: in the opcode, RFC 6455, 5.2
# Bytes that wait for a browser, at most: more than any file that can be taken away.
UNREAD = 16_000_000


class Gathered:
    """Takes the place of a stream's ``write``, for frames of a websocket; ``let_go`` ends one that does not read."""

    def __init__(self, stream: IOStream, let_go: Callable[[], None]) -> None:
        self._stream, self._write = stream, stream.write
        self._let_go = let_go
        self._unread = False
        self._frames: list[bytes] = []
        self._sent: Future[None] = Future()

    def __call__(self, frame: bytes) -> Future[None]:
        """Send the frame with the others of this turn; a control frame takes what waits along at once."""
        if not self._frames:
            self._sent = Future()
            asyncio.get_running_loop().call_soon(self._flush)
        self._frames.append(frame)
        sent = self._sent
        if frame[0] & _CONTROL:
            self._flush()
        return sent

    def _flush(self) -> None:
        if not self._frames:
            return
        frames, sent = b"".join(self._frames), self._sent
        self._frames = []
        try:
            self._write(frames)
        except StreamClosedError as error:
            if not sent.done():
                sent.set_exception(error)
                sent.exception()  # whoever does not wait for it need not hear of it
        else:
            if not sent.done():
                sent.set_result(None)
            if not self._unread and len(self._stream._write_buffer or b"") > UNREAD:
                self._unread = True  # before the word of farewell, which is written here too
                self._let_go()
