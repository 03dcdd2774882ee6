"""Admission of visitors: the page that all of them get, the limit on sessions, and what a session shows.

A page request costs about a millisecond, because the page is the same for everyone but for a signed token and is made
once. A session is built only when the browser opens its websocket with that token, from the address that Bokeh's script
sends along; a flood of page requests therefore builds no session.

The token of a page: it names the session that its websocket may open, for some minutes.

Its age is what the monotonic clock says: the time of day may jump by a year when it is set. Another replica's token has
no other age than the time of day in it, so that a jump there costs the visitors of that moment one reload.
"""

import asyncio
import logging
import re
import secrets
import time
from html import escape

import panel as pn
from bokeh.document import Document
from bokeh.models import ImportedStyleSheet
from bokeh.server.session import ServerSession
from bokeh.server.tornado import BokehTornado
from bokeh.util.token import check_token_signature, generate_jwt_token, generate_session_id, get_token_payload
from panel.io.server import server_html_page_for_session
from panel.io.state import set_curdoc
from vibroscope.app.page.files import style
from vibroscope.app.page.page import create_app
from vibroscope.app.runtime import logs, metrics
from vibroscope.app.runtime.limits import Turns
from vibroscope.app.server import libraries
from vibroscope.app.server.building import PLAIN_REQUEST, PrewarmedSession
from vibroscope.app.server.housekeeping import GarbageCollection

TOKEN_SECONDS = 300
PROCESS = secrets.token_hex(8)  # whose monotonic clock it is


def make_token(session_id: str, key: bytes) -> str:
    """Return the signed token of a session."""
    made = {"process": PROCESS, "made": time.monotonic()}
    return generate_jwt_token(
        session_id, secret_key=key, signed=True, expiration=TOKEN_SECONDS, extra_payload={"vibroscope": made}
    )


def is_valid_token(token: str, key: bytes) -> bool:
    """Return whether this server, or a replica with the same key, signed the token and it has not expired."""
    try:
        return check_token_signature(token, secret_key=key, signed=True) and not _has_expired(get_token_payload(token))
    except (ValueError, KeyError, TypeError):  # this is no token
        return False


def _has_expired(payload: dict) -> bool:
    own = payload["vibroscope"]
    if own["process"] == PROCESS:
        return time.monotonic() - own["made"] > TOKEN_SECONDS
    return time.time() > payload["session_expiry"]


_FULL = "This server holds as many sessions as it can. Please try again in a minute."
_BROKEN = "This page could not be built. The fault is the server's, and it has been noted. Please load the page again."
_STOPPING = "This server is being restarted. Please try again in a moment."
_PLACEHOLDER = "THE-TOKEN-OF-THIS-SESSION"
_TEMPLATE_SESSION = "the page itself"
# The page draws without WebGL; for the next see page/shared/compat.js, for the others `libraries`.
_UNUSED_SCRIPT = re.compile(
    r'<script[^>]*src="[^"]*/(?:bokeh-(?:gl|widgets|tables)|es-module-shims)[^"]*"[^>]*></script>'
)
_PANEL = re.compile(r'<script[^>]*src="[^"]*/panel(?:\.min)?\.js[^"]*"[^>]*></script>')
_SCRIPT_OF_BOKEH = re.compile(r'<script type="text/javascript">(\s*Bokeh\.[^<]*)</script>')


class Admission:
    """The state that all requests of one server share: the page, the sessions and the limit on their number."""

    def __init__(self, most_sessions: int) -> None:
        self._most = most_sessions
        self._page = ""
        self.openings = Turns()  # of the addresses that visitors come from
        self._tasks: set[asyncio.Task] = set()  # asyncio itself holds no strong reference to a task
        self.stopping = False

    async def open(self, app: BokehTornado) -> None:
        """Make the page from a session that no browser opens, and start to prewarm sessions and to tidy up."""
        self._app, self._context = app, app.applications["/"]
        session = await self._context.create_session_if_needed(_TEMPLATE_SESSION, PLAIN_REQUEST)
        doc = session.document
        with set_curdoc(doc):
            html = server_html_page_for_session(
                session, app.resources(), doc.title, _PLACEHOLDER, doc.template, doc.template_variables
            )
        self._page = _with_styles(_defer_scripts(_without_unused(html)), doc)
        self.prewarmed = PrewarmedSession(self._context, self._new_id)
        garbage = GarbageCollection(lambda: self.sessions, self.prewarmed.quiet_seconds)
        for work in (self.prewarmed.run(lambda: not self.refusal()), garbage.run()):
            self._tasks.add(asyncio.get_running_loop().create_task(work))
        metrics.SESSIONS.read = lambda: self.sessions
        metrics.TASKS.read = lambda: len(asyncio.all_tasks())

    def _new_id(self) -> str:
        return generate_session_id(secret_key=self._app.secret_key, signed=True)

    @property
    def sessions(self) -> int:
        """Number of visitors' sessions, including those whose browser has just gone."""
        return sum(s.id != _TEMPLATE_SESSION and not self.prewarmed.owns(s.id) for s in self._context.sessions)

    def refusal(self) -> str:
        """Return why no visitor is admitted now, or an empty text."""
        if self.stopping:
            return _STOPPING
        return _FULL if self.sessions >= self._most else ""

    def session(self, session_id: str) -> ServerSession | None:
        """Return the session if a browser has opened it before."""
        found = (session for session in self._context.sessions if session.id == session_id)
        return None if self.prewarmed.owns(session_id) else next(found, None)

    def page(self, *, plain: bool) -> str:
        """Return the page for one visitor; a ``plain`` request, without a query, may get the prewarmed session."""
        session_id = (plain and self.prewarmed.hand_out()) or self._new_id()
        return self._page.replace(_PLACEHOLDER, make_token(session_id, self._app.secret_key))

    async def end_sessions(self) -> None:
        """Tell every session that it ends, so that it cancels what is still computed for it."""
        for session in list(self._context.sessions):
            await self._context.application.on_session_destroyed(session.document.session_context)


def _without_unused(html: str) -> str:
    """The page without the scripts that it has no use for."""
    return _PANEL.sub(f'<script defer src="{libraries.address()}"></script>', _UNUSED_SCRIPT.sub("", html))


def _with_styles(html: str, doc: Document) -> str:
    """The page with what fetches the style sheets of its models at once, not when the models are drawn.

    For no medium, so that nothing waits for them; of a preload Chromium complains where a page is drawn late.
    """
    addresses = sorted({model.url for model in doc.select({"type": ImportedStyleSheet})})
    links = "".join(f'<link rel="stylesheet" media="not all" href="{escape(address)}">' for address in addresses)
    return html.replace("</head>", f"{links}</head>", 1)


def _defer_scripts(html: str) -> str:
    """The page with its scripts deferred, so that a browser shows what there is to read before they have come.

    They run in their order, and before the script that embeds the document. A module is deferred, too.
    """
    html = html.replace('<script type="text/javascript" src=', "<script defer src=")
    return _SCRIPT_OF_BOKEH.sub(r'<script type="module">\1</script>', html)


def page_or_apology() -> pn.viewable.Viewable:
    """Return what a session shows; if it cannot be built, an apology, while the traceback goes to the log."""
    try:
        return create_app()
    except Exception as error:
        logs.event("session not built", logging.ERROR, error=error)
        apology = pn.pane.HTML(f'<p role="alert">{_BROKEN}</p>')
        return pn.Column(apology, css_classes=["page"], stylesheets=[style("shared/page")])
