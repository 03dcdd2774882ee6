"""What is written to a connection within one turn of the loop leaves it in one piece.

A message of Bokeh's is three frames and more, each a call of the system's, and each call gives the interpreter's lock
away: with solvers at work it comes back after milliseconds.
"""

from __future__ import annotations

import asyncio
from asyncio import Future

from tornado.iostream import IOStream, StreamClosedError

_CONTROL = 0x08  # close, ping, pong: in the opcode, RFC 6455, 5.2


class Gathered:
    """Takes the place of a stream's ``write``, for frames of a websocket."""

    def __init__(self, stream: IOStream) -> None:
        self._write = stream.write
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
            self._write(frames).add_done_callback(lambda written: _pass_on(written, sent))
        except StreamClosedError as error:
            _fail(sent, error)


def _pass_on(written: Future, sent: Future) -> None:
    error = None if written.cancelled() else written.exception()
    if sent.done():
        return
    if error is None:
        sent.set_result(None)
    else:
        _fail(sent, error)


def _fail(sent: Future, error: BaseException) -> None:
    if not sent.done():
        sent.set_exception(error)
        sent.exception()  # whoever does not wait for it need not hear of it
