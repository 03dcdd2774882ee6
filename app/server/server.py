"""The server: its routes and options, how it starts, runs and stops."""

import asyncio
import logging
import os
import signal
import sys
import time
from concurrent.futures import ThreadPoolExecutor

from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from bokeh.settings import settings as bokeh_settings
from bokeh.util.browser import view
from panel.io.application import build_applications
from panel.io.resources import DIST_DIR
from tornado.ioloop import IOLoop
from tornado.netutil import bind_sockets
from tornado.web import ErrorHandler, StaticFileHandler
from vibroscope.app.explorer import compute
from vibroscope.app.explorer.shipped import load_diagram
from vibroscope.app.page.files import folder_of_modules
from vibroscope.app.page.page import TITLE
from vibroscope.app.runtime import logs, settings
from vibroscope.app.runtime.compilation import compilation
from vibroscope.app.runtime.files import ASSETS
from vibroscope.app.runtime.settings import Settings
from vibroscope.app.runtime.workers import jobs, shut_down, workers
from vibroscope.app.server import connections, endpoints
from vibroscope.app.server.admission import TOKEN_SECONDS, Admission, page_or_apology
from vibroscope.app.server.building import SWITCH_SECONDS, ThreadedApplication
from vibroscope.app.server.housekeeping import limit_cache, set_up_collection, trim_cache
from vibroscope.app.server.security import Misdirected, OtherHost, SecurityHeaders, allowed_hosts, allowed_origins
from vibroscope.app.server.static_files import Libraries, Module, StaticFile, documentation_routes
from vibroscope.app.server.websocket import SessionSocket
from vibroscope.engine import CompileProgress

_MOST_MESSAGE_BYTES = 1 << 18  # the page sends a few hundred bytes at a time
# Control characters, escaped or not: file functions fail on some of them in ways of their own.
_UNREADABLE = r"(?is).*(?:%[01][0-9a-f]|%7f|[\x00-\x1f\x7f]).*"
# Bokeh's own routes beyond these could build a session for each request or import a module that the address names.
_NOT_SERVED = r"(?s)(?!/static/|/favicon\.ico$).*"
_RECONNECT_SECONDS = 15  # in which a browser that lost its connection finds its session again
FINISH_SECONDS, CANCEL_SECONDS = 20, 5  # for the figures that are asked for, and for what is cancelled


class Server(BaseServer):
    """The explorer's server; it listens from the start and answers from `start` on.

    Raises
    ------
    OSError
        If the port is not available.
    """

    def __init__(self, chosen: Settings) -> None:
        sockets = bind_sockets(chosen.port, chosen.address)
        try:
            port = sockets[0].getsockname()[1]
            self.url = f"http://{chosen.host}:{port}"
            self.admission = Admission(chosen.sessions)
            app = _make_app(chosen, self.admission, port)
            listener = connections.Listener(app, xheaders=chosen.proxied == "yes", **connections.OPTIONS)
            super().__init__(IOLoop.current(), app, listener)
            self.io_loop.run_sync(lambda: self.admission.open(app))
            listener.add_sockets(sockets)  # last: while the loop runs above, no request must be answered
        except Exception:
            for sock in sockets:
                sock.close()
            raise

    async def finish(self) -> None:
        """Admit nobody, finish the figures, cancel the rest, and stop the loop; a second call does not wait."""
        if not self.admission.stopping:
            self.admission.stopping = True
            logs.event("stopping", sessions=self.admission.sessions, jobs=jobs())
            deadline = time.monotonic() + FINISH_SECONDS
            while jobs() and time.monotonic() < deadline:
                await asyncio.sleep(0.02)
            await asyncio.sleep(0.3)  # the last figures go out once the browsers have painted those before
        try:
            await self.admission.end_sessions()
        finally:  # the server stops whatever fails here
            logs.event("stopped", jobs=jobs())
            self.io_loop.stop()


def _make_app(chosen: Settings, admission: Admission, port: int) -> BokehTornado:
    """Return the web application with its routes."""
    bokeh_settings.perform_document_validation = False  # the tests do it: a tenth of the cost of a page
    (built,) = build_applications({"/": page_or_apology}, title=TITLE, location=False).values()
    app = BokehTornado(
        {"/": ThreadedApplication(*built.handlers)},
        websocket_max_message_size_bytes=_MOST_MESSAGE_BYTES,
        ico_path=str(DIST_DIR / "images" / "favicon.ico"),
        use_index=False,
        sign_sessions=True,
        secret_key=chosen.secret_key.encode(),
        session_token_expiration=TOKEN_SECONDS,
        unused_session_lifetime_milliseconds=1000 * _RECONNECT_SECONDS,
        check_unused_sessions_milliseconds=5000,
        transforms=[SecurityHeaders],
        log_function=endpoints.log_answer,
        admission=admission,
        origins=allowed_origins(chosen, port),
    )
    session_arguments = {"application_context": app.applications["/"], "bokeh_websocket_path": "/ws"}
    session_arguments |= {"compression_level": 6, "mem_level": 8}  # of the document; see `SessionSocket.on_message`
    app.add_handlers(  # they come before Bokeh's own
        ".*",
        [
            (OtherHost(allowed_hosts(chosen, port)), Misdirected),
            (_UNREADABLE, endpoints.UnreadableAddress),
            (r"/ws", SessionSocket, session_arguments),
            (r"/?", endpoints.Page),
            (r"/liveness", endpoints.Liveness),
            (r"/metrics", endpoints.Metrics),
            (r"/static/page/([0-9a-f]{12})/([\w/]+\.js)", Module, {"path": str(folder_of_modules())}),
            (r"/static/libraries/([0-9a-f]{12}\.js)", Libraries, {"path": "static/libraries"}),
            (r"/static/extensions/panel/(.*)", StaticFile, {"path": str(DIST_DIR)}),
            (r"/static/(.*)", StaticFile, {"path": str(bokeh_settings.bokehjs_path())}),
            (r"/speed/(.*)", StaticFileHandler, {"path": str(ASSETS / "speed")}),
            *documentation_routes(),
            (_NOT_SERVED, ErrorHandler, {"status_code": 404}),
        ],
    )
    return app


def serve(chosen: Settings | None = None, *, show: bool = False) -> None:
    """Serve the explorer until a signal ends it: the first SIGTERM or SIGINT lets figures finish, a second does not.

    Parameters
    ----------
    chosen
        The settings; by default those of the environment.
    show
        Whether to open a browser.

    Raises
    ------
    ValueError
        If a setting in the environment is invalid.
    OSError
        If the port is not available.
    """
    chosen = chosen or settings.from_environment()
    settings.use_settings(chosen)
    logs.configure(chosen.log_format, chosen.log_level)
    for name in settings.unknown_variables():
        logs.event("no such setting", logging.WARNING, name=name)
    limit_cache(chosen.cache_mb)
    compute.warm()
    compilation.watch(_LogCompilation())
    load_diagram("table")
    sys.setswitchinterval(SWITCH_SECONDS)
    set_up_collection()
    server = Server(chosen)
    server.io_loop.asyncio_loop.set_default_executor(ThreadPoolExecutor(chosen.threads, "loop"))
    workers().submit(trim_cache)
    _finish_on_signals(server)
    server.start()
    logs.event("started", address=chosen.address, port=server.port)
    if chosen.log_format == "text":
        print(f"Launching server at {server.url}")
    if show:
        server.io_loop.add_callback(view, server.url, new="tab")
    try:
        server.io_loop.start()
    finally:
        server.stop(wait=False)
        compilation.stop()
    unfinished = shut_down(CANCEL_SECONDS)
    if unfinished:  # jobs that cannot be cancelled: the interpreter would wait for them without a limit
        logs.event("left unfinished", logging.WARNING, jobs=unfinished)
        logging.shutdown()
        os._exit(0)


class _LogCompilation:
    """Logs which solver is being compiled, once each."""

    def __init__(self) -> None:
        self._begun = time.monotonic()
        self._what = ""

    def __call__(self, progress: CompileProgress | None) -> None:
        if progress is None:
            logs.event("compiled", seconds=time.monotonic() - self._begun)
        elif progress.what != self._what:
            self._what = progress.what
            logs.event("compiling", what=progress.what)


def _finish_on_signals(server: Server) -> None:
    loop = server.io_loop.asyncio_loop
    tasks = set()  # asyncio itself holds no strong reference to a task

    def finish() -> None:
        tasks.add(loop.create_task(server.finish()))

    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, finish)
