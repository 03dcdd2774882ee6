"""The websocket of one browser: its token, what it may say and how often, and what is told when it is refused."""

from __future__ import annotations

import logging
import time
from functools import partial
from weakref import WeakKeyDictionary

from bokeh.server.session import ServerSession
from bokeh.util.token import check_token_signature, get_session_id, get_token_payload
from panel.io.server import WSHandler
from vibroscope.app.runtime import logs, metrics
from vibroscope.app.runtime.limits import Bucket
from vibroscope.app.server import patch
from vibroscope.app.server import validation as gate
from vibroscope.app.server.batched_writes import Gathered

# Of one session, whatever the number of its connections: `validation.price` of what they say, a second and at once. To
# connect again, and to send the document, cost as much as many moves. A drag takes 12 for each frame that is painted,
# and a screen shows 60 a second.
_RATE, _BURST, _AGAIN, _PULL = 720, 1000, 100, 450
_CONNECTIONS = 3  # of one session: a browser that comes back may be faster than the news that it had gone
_BUCKETS: WeakKeyDictionary[ServerSession, Bucket] = WeakKeyDictionary()
_FAILED = "This could not be done. The fault is the server's, and it has been noted."


class Socket(WSHandler):
    """One browser's connection; what it says passes `app.server.validation`."""

    async def prepare(self) -> None:
        """Refuse a token that is not of this server, or too old, before there is a connection."""
        await super().prepare()
        offered = self.request.headers.get("Sec-WebSocket-Protocol", "").split(",")
        if len(offered) != 2 or not _ours(offered[1].strip(), self.application.secret_key):
            metrics.REFUSED.add("token")
            logs.event("refused", logging.WARNING, what="token", address=self.request.remote_ip)
            self.send_error(403)

    async def _async_open(self, token: str) -> None:
        house, begun = self.application.settings["house"], time.monotonic()
        session_id = get_session_id(token)
        self._session_name = logs.name_of(session_id)
        # A message is many small frames: else the last wait until the receiver's delayed acknowledgement, 40 ms.
        self.set_nodelay(True)
        self.ws_connection.stream.write = Gathered(self.ws_connection.stream, partial(self._refuse, "it does not read"))
        with logs.named(self._session_name):
            known = house.session(session_id)
            reason = "" if known else house.refusal()
            if reason:
                metrics.REFUSED.add("session")
                logs.event("refused", logging.WARNING, what="session", reason=reason)
                self.close(1013, reason[:100])
                return
            if known and known.connection_count >= _CONNECTIONS:
                self._refuse("too many connections")
                return
            new = not known
            self._bucket = (known and _BUCKETS.get(known)) or Bucket(_RATE, _BURST)
            if known and not self._bucket.take(_AGAIN):
                self._refuse("too many connections")
                return
            house.spare.opened(session_id)
            await super()._async_open(token)
            if self._left():
                return
            self._bucket = _BUCKETS.setdefault(self.connection.session, self._bucket)
            patch.speak(self.connection.protocol)
            if new:
                seconds = time.monotonic() - begun
                metrics.OPENED.add("opened")
                metrics.BUILT.add(seconds)
                logs.event("session opened", seconds=seconds, sessions=house.sessions)
                _when_closed(self.connection.session.document, self._session_name)

    async def on_message(self, fragment: str | bytes) -> None:
        """One frame of a message; the page's are text, and come after the session stands."""
        if isinstance(fragment, bytes) or self.receiver is None:
            self._refuse("a frame that is not the page's")
            return
        self.application.settings["house"].spare.heard()
        await super().on_message(fragment)

    async def _receive(self, fragment: str):
        try:
            return await self.receiver.consume(fragment)
        except Exception:  # whatever keeps it from being read, it is not the page's; Bokeh would log all of it
            self._refuse("a message that cannot be read")
            return None

    async def _handle(self, message):
        """One message, with what may not pass taken out of it."""
        if self._left():
            return None
        with logs.named(self._session_name):
            if not self._bucket.take(_PULL if message.msgtype == "PULL-DOC-REQ" else gate.price(message.content)):
                self._refuse("too many messages")
                return None
            if message.msgtype == "PATCH-DOC":
                return await self._patch(message)
            if message.msgtype != "PULL-DOC-REQ":
                self._refuse("a message that is not the page's")
                return None
            return _in_plain_words(await super()._handle(message))

    async def _patch(self, message):
        document = self.connection.session.document
        passed, dropped = gate.sift(message.content, document)
        if dropped and gate.worth_a_word(message.content):
            metrics.REFUSED.add("message")
            logs.event("refused", logging.WARNING, what="message", dropped=dropped, passed=len(passed))
        if not passed:
            return self.connection.ok(message)
        message.content = {"events": passed}
        return _in_plain_words(await super()._handle(message))

    def on_close(self) -> None:
        """The browser has gone."""
        if hasattr(self, "_session_name"):
            with logs.named(self._session_name):
                logs.event("connection closed", logging.DEBUG, code=self.close_code)
        if not self._left():
            super().on_close()

    def _left(self) -> bool:
        """Whether there is no session any more; what was said before it ended may still be read."""
        return self.connection is None or self.connection._session is None

    def _refuse(self, what: str) -> None:
        metrics.REFUSED.add("message")
        logs.event("refused", logging.WARNING, what="connection", reason=what)
        self.close(1008, what)


def _in_plain_words(answer):
    """The answer; Bokeh's to what failed holds the exception and its traceback, which are for the log alone."""
    if answer is not None and answer.msgtype == "ERROR":
        logs.event("message failed", logging.ERROR)
        answer.content = {"text": _FAILED, "traceback": None}
    return answer


def _ours(token: str, key: bytes) -> bool:
    """Whether a token was signed here and still holds."""
    try:
        return (
            check_token_signature(token, secret_key=key, signed=True)
            and get_token_payload(token)["session_expiry"] > time.time()
        )
    except (ValueError, KeyError, TypeError):  # nothing that could be read as one
        return False


def _when_closed(doc, name: str) -> None:
    begun = time.monotonic()

    def closed(context) -> None:
        metrics.OPENED.add("closed")
        logs.event("session closed", session=name, seconds=time.monotonic() - begun)

    doc.on_session_destroyed(closed)
