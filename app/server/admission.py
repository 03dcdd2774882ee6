"""The house: who gets a page, whether there is room for a session, and what a session shows.

A request for the page costs about a millisecond: the page is the same for everyone but for a signed token, so it
is made once. Only when the browser then opens its websocket with that token is a session built, from the address that
Bokeh's script sends along; so a flood of page requests builds nothing. One session is kept ready
(`app.server.prewarmed`).
"""

from __future__ import annotations

import asyncio
import logging
from functools import partial

import panel as pn
from bokeh.server import tornado as bokeh_tornado
from bokeh.server.session import ServerSession
from bokeh.util.token import generate_jwt_token, generate_session_id
from panel.io.resources import Resources
from panel.io.server import DocHandler, server_html_page_for_session
from panel.io.state import set_curdoc
from vibroscope.app.page.files import style, template
from vibroscope.app.page.page import create_app
from vibroscope.app.runtime import logs, metrics
from vibroscope.app.server.prewarmed import PLAIN, Spare

TOKEN_SECONDS = 300
_FULL = "This server holds as many sessions as it can. Please try again in a minute."
_BROKEN = "This page could not be built. The fault is the server's, and it has been noted. Please load the page again."
_STOPPING = "This server is being restarted. Please try again in a moment."


class _Scripts(Resources):
    """Those of Bokeh and Panel that the page uses: it draws without WebGL, and its modules import nothing.

    The loader for modules tries out import maps before the browser reads anything else.
    """

    _LEFT_OUT = ("bokeh-gl", "es-module-shims")

    @property
    def js_files(self) -> list[str]:
        """Addresses, in the order in which they are read."""
        return [file for file in super().js_files if not any(name in file for name in self._LEFT_OUT)]

    def clone(self, **_) -> _Scripts:
        """Itself: Panel reads the page's scripts from a copy, which would be one of its own kind."""
        return self


class House:
    """What all requests of one server share: the page as it is sent, and whether there is room."""

    _MARK = "THE-TOKEN-OF-THIS-SESSION"
    _OWN = "the page itself"

    def __init__(self, most: int) -> None:
        self._most = most
        self._page = ""
        self._tasks: set[asyncio.Task] = set()  # a task that nobody holds may vanish
        self.stopping = False

    async def open(self, server: bokeh_tornado.BokehTornado) -> None:
        """Make the page from a session that no browser comes to, and that therefore ends soon."""
        self._context = server.applications["/"]
        session = await self._context.create_session_if_needed(self._OWN, PLAIN)
        doc = session.document
        with set_curdoc(doc):
            resources = _Scripts.from_bokeh(server.resources())
            self._page = server_html_page_for_session(
                session, resources, doc.title, self._MARK, doc.template, doc.template_variables
            )
        self.spare = Spare(self._context, partial(generate_session_id, secret_key=server.secret_key, signed=True))
        self._tasks.add(asyncio.get_running_loop().create_task(self.spare.keep(lambda: not self.refusal())))
        metrics.SESSIONS.read = lambda: self.sessions

    @property
    def sessions(self) -> int:
        """Sessions held, those included whose browser has just gone."""
        return sum(session.id != self._OWN and not self.spare.holds(session.id) for session in self._context.sessions)

    def refusal(self) -> str:
        """Why nobody may come in now, or nothing."""
        if self.stopping:
            return _STOPPING
        return _FULL if self.sessions >= self._most else ""

    def session(self, session_id: str) -> ServerSession | None:
        """The session that a browser has opened before."""
        held = (session for session in self._context.sessions if session.id == session_id)
        return None if self.spare.holds(session_id) else next(held, None)

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
            logs.event("refused", logging.WARNING, what="page", reason=reason, address=self.request.remote_ip)
            self.set_status(503)
            self.set_header("Retry-After", "60")
            self.write(template("shared/refused.html").replace("REASON", reason))
            return
        spare = "" if self.request.query or self.request.method != "GET" else house.spare.lend()
        session_id = spare or generate_session_id(secret_key=app.secret_key, signed=True)
        self.write(
            house.page(generate_jwt_token(session_id, secret_key=app.secret_key, signed=True, expiration=TOKEN_SECONDS))
        )

    async def head(self, *args, **kwargs) -> None:
        """The same without the body."""
        await self.get(*args, **kwargs)


def page_or_words() -> pn.viewable.Viewable:
    """What a session shows; if it cannot be built, that in our words: the traceback is for the log."""
    try:
        return create_app()
    except Exception as error:  # whatever it is
        logs.event("session not built", logging.ERROR, error=error)
        words = pn.pane.HTML(f'<p role="alert">{_BROKEN}</p>')
        return pn.Column(words, css_classes=["page"], stylesheets=[style("shared/page")])
