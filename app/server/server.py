"""The server: what it is made of, and how it runs and stops."""

from __future__ import annotations

import asyncio
import gc
import hmac
import ipaddress
import logging
import os
import signal
import time
from functools import partial

import panel as pn
from bokeh.server import tornado as bokeh_tornado
from bokeh.server.server import Server
from bokeh.util.browser import view
from panel.io.application import build_applications
from tornado.httpserver import HTTPServer
from tornado.web import ErrorHandler, RequestHandler
from vibroscope.app.explorer import compute
from vibroscope.app.explorer.diagrams import load_diagram
from vibroscope.app.page.page import TITLE
from vibroscope.app.runtime import logs, metrics, settings
from vibroscope.app.runtime.files import ASSETS
from vibroscope.app.runtime.settings import Settings
from vibroscope.app.runtime.workers import end, jobs, workers
from vibroscope.app.server import connections
from vibroscope.app.server.admission import TOKEN_SECONDS, House, Page, page_or_words
from vibroscope.app.server.housekeeping import bound_cache, drop_oldest
from vibroscope.app.server.security import SecurityHeaders
from vibroscope.app.server.websocket import Socket

# The page sends a few hundred bytes at a time; anything large is not from it.
_MESSAGE_LIMIT = 1 << 18
# Control characters, escaped or not: functions for files fail on some of them, in ways of their own.
_UNREADABLE = r"(?is).*(?:%[01][0-9a-f]|%7f|[\x00-\x1f\x7f]).*"
_LOST_SECONDS = 15  # a browser that lost its connection finds its session again for so long
_STOP_SECONDS, _LAST_SECONDS = 20, 5  # for what is asked for; for what is withdrawn


class Unreadable(RequestHandler):
    """The answer to an address that holds a control character, whatever it begins with."""

    def initialize(self, **_) -> None:
        """Bokeh tells each handler of a page's routes about the page."""

    def prepare(self) -> None:
        """Said before any method is looked for."""
        self.set_status(400)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish("This address cannot be read: it holds a control character.\n")


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
        """Everything that `app.runtime.metrics` counts."""
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
    request = handler.request
    told = {"status": status, "path": request.path, "address": request.remote_ip, "seconds": request.request_time()}
    logs.event("answered", level, **told)


def make_server(chosen: Settings) -> Server:
    """The server, listening but not yet answering.

    Raises
    ------
    OSError
        If the port cannot be had.
    """
    # Bokeh takes its routes from this list, as Panel does. Left out are the scripts for embedding the page elsewhere,
    # each of which would build a session, and what tells of the application. They come before all that serve files.
    bokeh_tornado.per_app_patterns[:] = [(_UNREADABLE, Unreadable), (r"/ws", Socket), (r"/?", Page)]
    HTTPServer.configure(connections.Listener)  # what Bokeh's makes is of this kind from now on
    house = House(chosen.sessions)
    server = pn.io.server.get_server(
        build_applications({"/": page_or_words}, title=TITLE, location=False),
        address=chosen.address,
        port=chosen.port,
        start=False,
        verbose=False,  # Panel's line has IPv6 without brackets
        use_xheaders=chosen.proxied == "yes",
        websocket_max_message_size=_MESSAGE_LIMIT,
        static_dirs={"speed": str(ASSETS / "speed")},
        # Panel would import any module that an address below /components names.
        extra_patterns=[
            (r"/components/.*", ErrorHandler, {"status_code": 404}),
            (r"/liveness", Alive),
            (r"/metrics", Metrics),
        ],
        http_server_kwargs={**connections.OPTIONS},
        use_index=False,
        sign_sessions=True,
        secret_key=chosen.secret_key.encode(),
        session_token_expiration=TOKEN_SECONDS,
        include_cookies=[],
        unused_session_lifetime_milliseconds=1000 * _LOST_SECONDS,
        check_unused_sessions_milliseconds=5000,
        transforms=[SecurityHeaders],
        log_function=_answered,
        house=house,
    )
    server._tornado.websocket_origins.clear()
    server._tornado.websocket_origins.update(_origins(chosen, server.port))
    server.io_loop.run_sync(partial(house.open, server._tornado))
    return server


def _origins(chosen: Settings, port: int) -> set[str]:
    """Hosts that the page may be opened under, as Bokeh compares them; of IPv6 it would take none as an option."""
    hosts = chosen.origins or (f"{chosen.host}:{port}", f"localhost:{port}")
    # A browser leaves out port 80; Bokeh puts it back, but for IPv6.
    named = {host if ":" in host else f"{host}:80" for host in hosts}
    return {host.removesuffix(":80") if host.startswith("[") else host for host in named}


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
    bound_cache(chosen.cache_mb)
    compute.warm()
    load_diagram("table")
    gc.freeze()  # what is imported stays: each full collection would go through it, for 0.1 to 0.3 s
    server = make_server(chosen)
    workers().submit(drop_oldest)
    loop = server.io_loop.asyncio_loop
    ends = set()  # a task that nobody holds may vanish

    def stop() -> None:
        ends.add(loop.create_task(_stop(server)))

    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, stop)
    server.start()
    logs.event("started", address=chosen.address, port=server.port)
    url = f"http://{chosen.host}:{server.port}"
    if chosen.log_format == "text":  # a line for people
        print(f"Launching server at {url}")
    if show:
        server.io_loop.add_callback(view, url, new="tab")
    try:
        server.io_loop.start()
    finally:
        server.stop(wait=False)
    left = end(_LAST_SECONDS)
    if left:  # what knows no withdrawal: the interpreter would wait for it as long as it takes
        logs.event("left unfinished", logging.WARNING, jobs=left)
        logging.shutdown()
        os._exit(0)
