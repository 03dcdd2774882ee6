"""One session kept ready for whoever asks for the page next: building one takes longer than all else before a figure.

It is lent with the page's token, once, and only where the page is asked for as it comes, without an address that says
otherwise. The next is built when nobody has said anything for a while, since nothing is answered meanwhile; so a flood
of requests builds none, and a page that is never opened costs one session in a minute at most.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable

from bokeh.core.serialization import Serialized
from bokeh.document import Document
from bokeh.document.events import DocumentChangedEvent, DocumentPatchedEvent
from bokeh.server.contexts import ApplicationContext
from tornado.httputil import HTTPHeaders, HTTPServerRequest, RequestStartLine
from vibroscope.app.runtime import logs
from vibroscope.app.runtime.workers import jobs

# For the page as it comes; Panel asks for the arguments of whatever request a session was built for.
PLAIN = HTTPServerRequest(
    start_line=RequestStartLine("GET", "/", "HTTP/1.1"), headers=HTTPHeaders({"Host": "localhost"})
)
_QUIET = 3.0  # s without a word from any browser before one is built
_LOOKS = 0.5  # s between two looks whether it is quiet
_LENT = 60.0  # s in which a lent one is to be opened; then it ends and the next is built


class Spare:
    """Looks after the spare session of one server, from `keep` on; ``new_id`` names sessions."""

    def __init__(self, context: ApplicationContext, new_id: Callable[[], str]) -> None:
        self._context, self._new_id = context, new_id
        self._ready = ""  # the session that can be lent
        self._lent = ""  # the one that was, until it is opened
        self._lent_at = 0.0
        self._heard = 0.0

    def heard(self) -> None:
        """Some browser has said something."""
        self._heard = time.monotonic()

    def holds(self, session_id: str) -> bool:
        """Whether this is a session that no browser has opened."""
        return bool(session_id) and session_id in (self._ready, self._lent)

    def lend(self) -> str:
        """The session for one page, or nothing."""
        lent, self._ready = self._ready, ""
        if lent:
            self._lent, self._lent_at = lent, time.monotonic()
        return lent

    def opened(self, session_id: str) -> None:
        """A browser has come: it is a session as any other."""
        if session_id == self._lent:
            self._context.get_session(session_id).unblock_expiration()
            self._lent = ""

    async def keep(self, wanted: Callable[[], bool]) -> None:
        """See to it that there is one, while it is ``wanted()``."""
        while True:
            await asyncio.sleep(_LOOKS)
            await self.look(wanted())

    async def look(self, wanted: bool) -> None:
        """End one that was lent in vain; build one, if it is wanted and quiet."""
        if self._lent and time.monotonic() - self._lent_at > _LENT:
            self.opened(self._lent)  # Bokeh ends what nobody is connected to
        quiet = time.monotonic() - self._heard > _QUIET and not jobs()
        if quiet and wanted and not self._ready and not self._lent:
            await self._build()

    async def _build(self) -> None:
        session_id = self._new_id()
        with logs.named(logs.name_of(session_id)):
            session = await self._context.create_session_if_needed(session_id, PLAIN)
            logs.event("session kept ready", logging.DEBUG)
        session.block_expiration()
        _write_down(session.document)
        self._ready = session_id


def _write_down(doc: Document) -> None:
    """Make now what a browser is told first: making it would be most of the wait for it."""
    written = doc.to_json()

    def told_once(**_) -> Serialized:
        forget()
        return written

    def changed(event: DocumentChangedEvent) -> None:
        if isinstance(event, DocumentPatchedEvent):  # the browser would see it
            forget()

    def forget() -> None:
        doc.remove_on_change(changed)
        del doc.to_json

    doc.to_json = told_once
    doc.on_change(changed)
