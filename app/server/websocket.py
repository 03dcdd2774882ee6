"""The websocket of one browser: its token and origin, the rate and content of its messages, and answers to failures."""

import logging
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from weakref import WeakKeyDictionary

from bokeh.document import Document
from bokeh.protocol.message import Message
from bokeh.protocol.receiver import Receiver
from bokeh.server.connection import ServerConnection
from bokeh.server.session import ServerSession
from bokeh.server.views.ws import WSHandler
from bokeh.util.token import get_session_id
from tornado.ioloop import IOLoop, PeriodicCallback
from tornado.websocket import WebSocketClosedError, WebSocketHandler
from vibroscope.app.compat import stop_compressing, stream_of
from vibroscope.app.runtime import logs, metrics
from vibroscope.app.runtime.limits import TokenBucket
from vibroscope.app.runtime.workers import ahead_of_jobs
from vibroscope.app.server.admission import is_valid_token
from vibroscope.app.server.building import pull
from vibroscope.app.server.protocol import PageProtocol
from vibroscope.app.server.security import is_allowed_origin, log_refused
from vibroscope.app.server.validation import cost_of, is_worth_logging, valid_events

# Budget of one session over all its connections, per second and at once: one for each frame that is read (a message has
# three; pings and empty ones count, too), and `validation.cost_of` its messages. Connecting again and sending the
# document cost as much as many moves. A drag costs 18 for each painted frame, and a screen shows 60 frames per second.
_RATE, _BURST, _RECONNECT, _PULL = 1200, 1700, 170, 750
_BYTES, _BYTES_AT_ONCE = 400_000, 1_000_000  # a second of one connection: larger files are read more slowly
_HEADER_BYTES = 2  # that begin each frame, read for themselves
_LEAVE_SECONDS = 0.5  # for a connection that was ended to close
PING_SECONDS = 30.0  # of a browser that waits for its session; Bokeh pings those that have one
_MOST_CONNECTIONS = 3  # per session: a browser may reconnect before the server knows that it had gone
_FAILED = "This could not be done. The fault is the server's, and it has been noted."
_budgets: WeakKeyDictionary[ServerSession, TokenBucket] = WeakKeyDictionary()
_handlers: dict[str, Callable[[Message, ServerConnection], Awaitable[Message]]] = {
    "PULL-DOC-REQ": pull,
    "PATCH-DOC": ServerSession.patch,
}


@contextmanager
def pinging(ping: Callable[[], None]) -> Iterator[None]:
    """Ping a browser meanwhile: a proxy ends a connection that says nothing for two minutes."""
    pings = PeriodicCallback(ping, 1000 * PING_SECONDS)
    pings.start()
    try:
        yield
    finally:
        pings.stop()


class SessionSocket(WSHandler):
    """Connects one browser to its session; `app.server.validation` filters what it sends."""

    async def prepare(self) -> None:
        """Refuse a foreign origin and a token that is forged or too old before there is a connection."""
        await super().prepare()
        offered = self.request.headers.get("Sec-WebSocket-Protocol", "").split(",")
        self._token_text = offered[1].strip() if len(offered) == 2 else ""
        self._stream = stream_of(self)
        self._closed = self._ended = False
        self._frame_bytes = 0  # of the frame that is being read, as they come
        if not is_allowed_origin(self.request, self.application.settings["origins"]):
            self.send_error(403)
        elif not is_valid_token(self._token_text, self.application.secret_key):
            log_refused("token", self.request)
            self.send_error(403)

    def check_origin(self, origin: str) -> bool:
        """Return true: `prepare` has checked the origin, since Tornado does not ask here where it equals the host."""
        return True

    async def open(self) -> None:
        """Connect to the session of the token, which is built if there is none yet; or close with the reason."""
        admission, begun = self.application.settings["admission"], time.monotonic()
        session_id = get_session_id(self._token_text)
        self._session_name = logs.session_name(session_id)
        if self._stream.closed():  # the browser has gone already
            return
        # A message is several small frames; otherwise the last one waits 40 ms for the receiver's delayed
        # acknowledgement.
        self.set_nodelay(True)
        self._stream.write_without_waiting(partial(self._end, "it does not read"))
        with logs.in_session(self._session_name):
            known = admission.session(session_id)
            if known is None and (reason := admission.refusal()):
                self._refuse(reason)
                return
            self._budget = (known and _budgets.get(known)) or TokenBucket(_RATE, _BURST)
            if known and (known.connection_count >= _MOST_CONNECTIONS or not self._budget.take(_RECONNECT)):
                self._end("too many connections")
                return
            admission.prewarmed.release(session_id)
            session = await self._session(session_id)
            if session is None:
                return
            self._budget = _budgets.setdefault(session, self._budget)
            self._bytes = TokenBucket(_BYTES, _BYTES_AT_ONCE)
            self._stream.price_reads(self._price_read)
            await self._connect(session, PageProtocol(admission.prewarmed.take_json))
            if known is None:
                seconds = time.monotonic() - begun
                metrics.OPENED.add("opened")
                metrics.BUILT.add(seconds)
                logs.event("session opened", seconds=seconds, sessions=admission.sessions)
                _log_end_of_session(session.document, self._session_name)

    async def _session(self, session_id: str) -> ServerSession | None:
        """The session, built in its turn; None if there is none and nobody waits for it any more, or no room."""
        admission = self.application.settings["admission"]
        context = self.application_context
        if admission.session(session_id) is None:
            owner = self.request.remote_ip or ""
            with pinging(self.ping):
                async with admission.openings.turn(owner):
                    if self._stream.closed() or self._closed:
                        return None
                    if admission.session(session_id) is None and (reason := admission.refusal()):
                        self._refuse(reason)
                        return None
                    await context.create_session_if_needed(session_id, self.request)
        session = await context.create_session_if_needed(session_id, self.request)
        return None if self._closed else session

    def _refuse(self, reason: str) -> None:
        metrics.REFUSED.add("session")
        logs.event("refused", logging.WARNING, what="session", reason=reason)
        self.close(1013, reason[:100])

    async def _connect(self, session: ServerSession, protocol: PageProtocol) -> None:
        self.receiver = Receiver(protocol)
        self.connection = self.application.new_connection(protocol, self, self.application_context, session)
        await self.send_message(protocol.create("ACK"))

    def _price_read(self, number: int) -> float:
        """Take the price of a frame; return how long to wait before so many bytes are read."""
        if not self._ended and not self._budget.take(number == _HEADER_BYTES):
            self._end_flood()
        self._frame_bytes += number
        return self._bytes.owe(number)

    async def on_message(self, fragment: str | bytes) -> None:
        """Collect the frames of a message and answer it; all frames of the page are text."""
        if self._closed or self._ended or self.connection is None:
            return
        self._bytes.owe(max(0, len(fragment) - self._frame_bytes))  # of a compressed frame, the size that it takes here
        self._frame_bytes = 0
        self.application.settings["admission"].prewarmed.note_activity()
        if isinstance(fragment, bytes):
            self._end("a frame that is not the page's")
            return
        try:
            message = await self.receiver.consume(fragment)
        except Exception:  # of any kind: the page sends nothing that cannot be read
            self._end("a message that cannot be read")
            return
        if message:
            with logs.in_session(self._session_name):
                answer = await self._answer(message)
                if answer:
                    await self.send_message(answer)
                    if answer.msgtype == "PULL-DOC-REPLY":
                        stop_compressing(self)

    async def _answer(self, message: Message) -> Message | None:
        pull = message.msgtype == "PULL-DOC-REQ"
        if not self._budget.take(_PULL if pull else cost_of(message.content)):
            self._end_flood()
            return None
        if message.msgtype not in _handlers:
            self._end("a message that is not the page's")
            return None
        if not pull and not self._filter(message):
            return self.connection.ok(message)
        if pull:  # takes as long as building a part of the page
            async with self.application.settings["admission"].openings.turn(self.request.remote_ip or ""):
                return await answer(message, self.connection, _handlers[message.msgtype])
        with ahead_of_jobs():
            return await answer(message, self.connection, _handlers[message.msgtype])

    def _filter(self, message: Message) -> bool:
        """Remove the events that are not allowed; return whether any are left."""
        valid, dropped = valid_events(message.content, self.connection.session.document)
        if dropped and is_worth_logging(message.content):
            metrics.REFUSED.add("message")
            logs.event("refused", logging.WARNING, what="message", dropped=dropped, passed=len(valid))
        message.content = {"events": valid}
        return bool(valid)

    async def write_message(self, message: bytes | str, binary: bool = False, locked: bool = True) -> None:
        """Write a frame at once: `Stream` waits for nobody.

        Bokeh waits a turn of the loop for each frame of a message. Figures that were ready in one of these turns found
        the message unfinished, and Panel looked again 10 ms later.
        """
        WebSocketHandler.write_message(self, message, binary)

    def ping(self, data: str | bytes = b"") -> None:
        """Ping the browser, unless the connection is about to end.

        Bokeh takes the error of such a ping for the end and detaches the session, which `on_close` then lacks.
        """
        with suppress(WebSocketClosedError):
            super().ping(data)

    def on_close(self) -> None:
        """Disconnect from the session."""
        self._closed = True
        if hasattr(self, "_session_name"):
            with logs.in_session(self._session_name):
                logs.event("connection closed", logging.DEBUG, code=self.close_code)
        super().on_close()

    def _end_flood(self) -> None:
        """End the connection, and let its address wait before it opens the next session."""
        self._end("too many messages")
        self.application.settings["admission"].openings.penalise(self.request.remote_ip or "")

    def _end(self, reason: str) -> None:
        self._ended = True
        IOLoop.current().call_later(_LEAVE_SECONDS, self._stream.close)  # else it may send on for some seconds
        metrics.REFUSED.add("message")
        logs.event("refused", logging.WARNING, what="connection", reason=reason)
        self.close(1008, reason)


async def answer(
    message: Message, connection: ServerConnection, handle: Callable[[Message, ServerConnection], Awaitable[Message]]
) -> Message:
    """Return the answer of ``handle``; if it fails, an answer without the error, which goes to the log."""
    try:
        return await handle(message, connection)
    except Exception as error:
        logs.event("message failed", logging.ERROR, error=error)
    return connection.error(message, _FAILED)


def _log_end_of_session(doc: Document, name: str) -> None:
    begun = time.monotonic()

    def log(context: object) -> None:
        metrics.OPENED.add("closed")
        logs.event("session closed", session=name, seconds=time.monotonic() - begun)

    doc.on_session_destroyed(log)
