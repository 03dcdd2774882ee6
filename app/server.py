"""The server: who gets a page, who gets a session, what is said on the way, and how it ends.

A request for the page costs about a millisecond: the page is the same for everyone but for a signed token, so it
is made once. Only when the browser then opens its websocket with that token is a session built, from the address that
Bokeh's script sends along; so a flood of page requests builds nothing.
"""

from __future__ import annotations

import asyncio
import hmac
import ipaddress
import logging
import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

import panel as pn
from bokeh.server import tornado as bokeh_tornado
from bokeh.server.server import Server
from bokeh.util.token import (
    check_token_signature,
    generate_jwt_token,
    generate_session_id,
    get_session_id,
    get_token_payload,
)
from panel.io.application import build_applications
from panel.io.resources import Resources
from panel.io.server import DocHandler, WSHandler, server_html_page_for_session
from panel.io.state import set_curdoc
from tornado.httputil import HTTPServerRequest
from tornado.web import ErrorHandler, RequestHandler

from app import compute, gate, logs, metrics, settings
from app.diagrams import kept
from app.files import ASSETS, asset, style
from app.housekeeping import bound_cache
from app.limits import Bucket
from app.main import TITLE, create_app
from app.security import SecurityHeaders
from app.settings import Settings
from app.workers import end, jobs, workers

# The page sends a few hundred bytes at a time; anything large is not from it.
_MESSAGE_LIMIT = 1 << 18
_TOKEN_SECONDS = 300
_LOST_SECONDS = 15  # a browser that lost its connection finds its session again for so long
# Messages of one connection: a drag sends fifteen a second, each frame drawn for the first time some forty sizes.
_RATE, _BURST, _PULL = 60, 600, 30
_STOP_SECONDS, _LAST_SECONDS = 20, 5  # for what is asked for; for what is withdrawn
_FULL = "This server holds as many sessions as it can. Please try again in a minute."
_BROKEN = "This page could not be built. The fault is the server's, and it has been noted. Please load the page again."
_STOPPING = "This server is being restarted. Please try again in a moment."


class House:
    """What all requests of one server share: the page as it is sent, and whether there is room."""

    _MARK = "THE-TOKEN-OF-THIS-SESSION"
    _OWN = "the page itself"

    def __init__(self, most: int) -> None:
        self._most = most
        self._page = ""
        self.stopping = False

    async def open(self, server: bokeh_tornado.BokehTornado) -> None:
        """Make the page from a session that no browser comes to, and that therefore ends soon."""
        self._context = server.applications["/"]
        session = await self._context.create_session_if_needed(self._OWN, HTTPServerRequest("GET", "/"))
        doc = session.document
        with set_curdoc(doc):
            resources = Resources.from_bokeh(server.resources())
            self._page = server_html_page_for_session(
                session, resources, doc.title, self._MARK, doc.template, doc.template_variables
            )
        metrics.SESSIONS.read = lambda: self.sessions

    @property
    def sessions(self) -> int:
        """Sessions held, those included whose browser has just gone."""
        return sum(session.id != self._OWN for session in self._context.sessions)

    def refusal(self) -> str:
        """Why nobody may come in now, or nothing."""
        if self.stopping:
            return _STOPPING
        return _FULL if self.sessions >= self._most else ""

    def knows(self, session_id: str) -> bool:
        """Whether this session is held."""
        return any(session.id == session_id for session in self._context.sessions)

    def page(self, token: str) -> str:
        """The page for one session."""
        return self._page.replace(self._MARK, token)

    async def end_sessions(self) -> None:
        """Tell every session that it has ended: whatever is still computed for it is withdrawn."""
        for session in list(self._context.sessions):
            await self._context.application.on_session_destroyed(session.document.session_context)


class Page(DocHandler):
    """The page."""

    async def get(self, *args, **kwargs) -> None:
        """Answer at once, with a session to be built or with the reason why not."""
        house, app = self.application.settings["house"], self.application
        self.set_header("Cache-Control", "no-store")  # the token is for one browser
        self.set_header("Content-Type", "text/html; charset=utf-8")
        reason = house.refusal()
        if reason:
            metrics.REFUSED.add("session")
            logs.event("refused", logging.WARNING, what="page", reason=reason)
            self.set_status(503)
            self.set_header("Retry-After", "60")
            self.write(asset("refused.html").replace("REASON", reason))
            return
        session_id = generate_session_id(secret_key=app.secret_key, signed=True)
        self.write(
            house.page(
                generate_jwt_token(session_id, secret_key=app.secret_key, signed=True, expiration=_TOKEN_SECONDS)
            )
        )

    async def head(self, *args, **kwargs) -> None:
        """The same without the body."""
        await self.get(*args, **kwargs)


class Socket(WSHandler):
    """One browser's connection; what it says passes `app.gate`."""

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
        self._bucket = Bucket(_RATE, _BURST)
        self._session_name = logs.name_of(session_id)
        # A message is many small frames: else the last wait until the receiver's delayed acknowledgement, 40 ms.
        self.set_nodelay(True)
        with self._named():
            reason = house.refusal()
            if reason and not house.knows(session_id):
                metrics.REFUSED.add("session")
                logs.event("refused", logging.WARNING, what="session", reason=reason)
                self.close(1013, reason[:100])
                return
            new = not house.knows(session_id)
            await super()._async_open(token)
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
        await super().on_message(fragment)

    async def _receive(self, fragment: str):
        try:
            return await self.receiver.consume(fragment)
        except Exception:  # whatever keeps it from being read, it is not the page's; Bokeh would log all of it
            self._refuse("a message that cannot be read")
            return None

    async def _handle(self, message):
        """One message, with what may not pass taken out of it."""
        with self._named():
            if not self._bucket.take(_PULL if message.msgtype == "PULL-DOC-REQ" else 1):
                self._refuse("too many messages")
                return None
            if message.msgtype == "PATCH-DOC":
                return await self._patch(message)
            if message.msgtype != "PULL-DOC-REQ":
                self._refuse("a message that is not the page's")
                return None
            return await super()._handle(message)

    async def _patch(self, message):
        document = self.connection.session.document
        passed, dropped = gate.sift(message.content, document)
        if dropped and gate.worth_a_word(message.content):
            metrics.REFUSED.add("message")
            logs.event("refused", logging.WARNING, what="message", dropped=dropped, passed=len(passed))
        if not passed:
            return self.connection.ok(message)
        message.content = {"events": passed}
        return await super()._handle(message)

    def on_close(self) -> None:
        """The browser has gone."""
        if hasattr(self, "_session_name"):
            with self._named():
                logs.event("connection closed", logging.DEBUG, code=self.close_code)
        super().on_close()

    def _refuse(self, what: str) -> None:
        metrics.REFUSED.add("message")
        logs.event("refused", logging.WARNING, what="connection", reason=what)
        self.close(1008, what)

    @contextmanager
    def _named(self) -> Iterator[None]:
        token = logs.session.set(self._session_name)
        try:
            yield
        finally:
            logs.session.reset(token)


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


class Alive(RequestHandler):
    """Whether the server answers; Panel's own can be asked to build a whole session for it."""

    def get(self) -> None:
        """One word; 503 while it stops, so that a proxy sends nobody here any more."""
        if self.application.settings["house"].stopping:
            self.set_status(503)
        self.write("alive\n")


class Metrics(RequestHandler):
    """Numbers for whoever runs the server: from this machine, or with the token."""

    def get(self) -> None:
        """Everything that `app.metrics` counts."""
        if not (self._knows_token() or self._is_near()):
            self.send_error(404)
            return
        self.set_header("Content-Type", "text/plain; version=0.0.4; charset=utf-8")
        self.write(metrics.exposition())

    def _knows_token(self) -> bool:
        token = settings.in_force().metrics_token
        given = self.request.headers.get("Authorization", "")
        return bool(token) and hmac.compare_digest(given.encode(), f"Bearer {token}".encode())

    def _is_near(self) -> bool:
        """A proxy is near, whoever asked it is not."""
        passed_on = any(name in self.request.headers for name in ("X-Forwarded-For", "X-Real-Ip", "Forwarded", "Via"))
        try:
            return not passed_on and ipaddress.ip_address(self.request.remote_ip).is_loopback
        except ValueError:  # a Unix socket has no address
            return False


def _answered(handler: RequestHandler) -> None:
    """Tornado calls this at the end of each request."""
    status = handler.get_status()
    metrics.REQUESTS.add(str(status))
    level = logging.ERROR if status >= 500 and status != 503 else logging.DEBUG
    seconds = handler.request.request_time()
    logs.event("answered", level, status=status, path=handler.request.path, seconds=seconds)


def page_or_words() -> pn.viewable.Viewable:
    """What a session shows; if it cannot be built, that in our words: the traceback is for the log."""
    try:
        return create_app()
    except Exception as error:  # whatever it is
        logs.event("session not built", logging.ERROR, error=error)
        words = pn.pane.HTML(f'<p role="alert">{_BROKEN}</p>')
        return pn.Column(words, css_classes=["page"], stylesheets=[style("page")])


def make_server(chosen: Settings) -> Server:
    """The server, listening but not yet answering.

    Raises
    ------
    OSError
        If the port cannot be had.
    """
    # Bokeh takes its routes from this list, as Panel does. Left out are the scripts for embedding the page elsewhere,
    # each of which would build a session, and what tells of the application.
    bokeh_tornado.per_app_patterns[:] = [(r"/ws", Socket), (r"/?", Page)]
    house = House(chosen.sessions)
    own = [f"{chosen.address}:{chosen.port}", f"localhost:{chosen.port}"] if chosen.port else None
    server = pn.io.server.get_server(
        build_applications({"/": page_or_words}, title=TITLE, location=False),
        address=chosen.address,
        port=chosen.port,
        start=False,
        verbose=True,
        websocket_origin=list(chosen.origins) or own,
        websocket_max_message_size=_MESSAGE_LIMIT,
        static_dirs={"speed": str(ASSETS / "speed")},
        # Panel would import any module that an address below /components names.
        extra_patterns=[
            (r"/components/.*", ErrorHandler, {"status_code": 404}),
            (r"/liveness", Alive),
            (r"/metrics", Metrics),
        ],
        use_index=False,
        sign_sessions=True,
        secret_key=chosen.secret_key.encode(),
        session_token_expiration=_TOKEN_SECONDS,
        include_cookies=[],
        unused_session_lifetime_milliseconds=1000 * _LOST_SECONDS,
        check_unused_sessions_milliseconds=5000,
        transforms=[SecurityHeaders],
        log_function=_answered,
        house=house,
    )
    server.io_loop.run_sync(partial(house.open, server._tornado))
    return server


async def _stop(server: Server) -> None:
    """Let nobody in, end what is asked for, withdraw the rest, and stop; at a second signal at once."""
    house = server._tornado.settings["house"]
    if not house.stopping:
        house.stopping = True
        logs.event("stopping", sessions=house.sessions, jobs=jobs())
        limit = time.monotonic() + _STOP_SECONDS
        while jobs() and time.monotonic() < limit:
            await asyncio.sleep(0.02)
        await asyncio.sleep(0.3)  # what was just solved goes out, once the browser has painted what went before
    try:
        await house.end_sessions()
    finally:  # whatever there may be to say about it, it stops
        logs.event("stopped", jobs=jobs())
        server.io_loop.stop()


def serve(chosen: Settings | None = None, *, show: bool = False) -> None:
    """Serve the explorer until a signal ends it: SIGTERM and SIGINT let what is under way end, a second one does not.

    Parameters
    ----------
    chosen
        How; by default as the environment says.
    show
        Open a browser.

    Raises
    ------
    ValueError
        If the environment is wrong.
    OSError
        If the port cannot be had.
    """
    chosen = chosen or settings.from_environment()
    settings.put_in_force(chosen)
    logs.configure(chosen.log_format, chosen.log_level)
    for name in settings.unknown():
        logs.event("no such setting", logging.WARNING, name=name)
    compute.warm()
    kept("table")
    server = make_server(chosen)
    workers().submit(bound_cache, chosen.cache_mb)
    loop = server.io_loop.asyncio_loop
    ends = set()  # a task that nobody holds may vanish

    def stop() -> None:
        ends.add(loop.create_task(_stop(server)))

    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, stop)
    server.start()
    if show:
        server.io_loop.add_callback(server.show, "/")
    try:
        server.io_loop.start()
    finally:
        server.stop(wait=False)
    left = end(_LAST_SECONDS)
    if left:  # what knows no withdrawal: the interpreter would wait for it as long as it takes
        logs.event("left unfinished", logging.WARNING, jobs=left)
        logging.shutdown()
        os._exit(0)
