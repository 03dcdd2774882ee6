"""Documents are built and serialised in a thread, while the loop serves other sessions.

Both take some hundred milliseconds of Python code, for which the loop would answer nobody. A thread that runs such code
hands over the interpreter's lock whenever another one has waited for the switch interval, which the loop does each time
that it has waited for the network. Studies rest meanwhile: much of theirs is Python code, too.

A session built in advance for the next visitor, because building one takes most of the time before the first figure.

A page request gets the prewarmed session together with its token, once, and only if the request has no address query.
The next one is built when no browser has sent anything for a while, since that slows what the server answers. A flood
of page requests therefore builds no session, and pages that are never opened cost at most one session per minute.
"""

import asyncio
import logging
import time
from collections.abc import Callable
from functools import partial
from typing import TypeVar
from weakref import WeakKeyDictionary

from bokeh.application.application import SessionContext
from bokeh.core.serialization import Serialized
from bokeh.document import Document
from bokeh.document.events import DocumentChangedEvent, DocumentPatchedEvent
from bokeh.protocol.message import Message
from bokeh.server.connection import ServerConnection
from bokeh.server.contexts import ApplicationContext
from bokeh.server.session import ServerSession
from panel.io.application import Application
from tornado.httputil import HTTPHeaders, HTTPServerRequest, RequestStartLine
from vibroscope.app.compat import claim_document, forget_empty_defaults
from vibroscope.app.runtime import logs
from vibroscope.app.runtime.workers import ahead_of_jobs, jobs

Result = TypeVar("Result")

SWITCH_SECONDS = 0.0002  # each of the dozen waits of a move may be delayed so much; Python's own is 0.005


class ThreadedApplication(Application):
    """An application that builds one document at a time, in a thread."""

    def __init__(self, *args, **kwargs) -> None:
        super().__init__(*args, **kwargs)
        self._building = asyncio.Lock()

    async def on_session_created(self, session_context: SessionContext) -> None:
        """Build the document; Bokeh awaits this before it calls `initialize_document`."""
        await super().on_session_created(session_context)
        await session_context.with_locked_document(self._build)

    async def _build(self, doc: Document) -> None:
        async with self._building:
            with ahead_of_jobs():
                await asyncio.to_thread(super().initialize_document, doc)
        claim_document(doc)

    def initialize_document(self, doc: Document) -> None:
        """Do nothing if the document has been built; if that has failed, which Bokeh only logs, fail again."""
        if not doc.roots:
            super().initialize_document(doc)


async def in_thread(session: ServerSession, work: Callable[..., Result], *arguments: object) -> Result:
    """Return what ``work`` makes of a session's document, which is locked meanwhile, in a thread."""
    with ahead_of_jobs():
        return await session.with_document_locked(partial(asyncio.to_thread, work, *arguments))


async def pull(message: Message, connection: ServerConnection) -> Message:
    """Return the answer to a request for the document."""
    return await in_thread(connection.session, _reply, message, connection)


def _reply(message: Message, connection: ServerConnection) -> Message:
    doc = connection.session.document
    reply = connection.protocol.create("PULL-DOC-REPLY", message.header["msgid"], doc)
    _ = reply.content_json  # written here and kept, so that the loop need not write 400 kB
    forget_empty_defaults(doc.models)
    return reply


# Panel reads the arguments of the request that a session is built for; this one has none.
PLAIN_REQUEST = HTTPServerRequest(
    start_line=RequestStartLine("GET", "/", "HTTP/1.1"), headers=HTTPHeaders({"Host": "localhost"})
)
_CHECK_SECONDS = 0.5
_LONGEST_PAUSE = 60.0  # s between two tries while none succeeds


class PrewarmedSession:
    """Builds and hands out the prewarmed session of one server.

    Parameters
    ----------
    context
        Bokeh's registry of sessions.
    new_id
        Returns an identifier for a session.
    quiet_seconds
        Time without a message from any browser before a session is built.
    claim_seconds
        Time in which a browser must open a session that was handed out; then it ends and the next is built.
    """

    def __init__(
        self,
        context: ApplicationContext,
        new_id: Callable[[], str],
        *,
        quiet_seconds: float = 3.0,
        claim_seconds: float = 60.0,
    ) -> None:
        self._context, self._new_id = context, new_id
        self._quiet_seconds, self._claim_seconds = quiet_seconds, claim_seconds
        self._building = ""  # identifier of the session that is being built
        self._ready = ""  # identifier of the session that can be handed out
        self._handed_out = ""  # identifier of the one that was, until a browser opens it
        self._handed_out_at = 0.0
        self._active_at = 0.0
        self._stored: WeakKeyDictionary[Document, Serialized] = WeakKeyDictionary()

    def note_activity(self) -> None:
        """Record that a browser has sent a message."""
        self._active_at = time.monotonic()

    def quiet_seconds(self) -> float:
        """Return the time since the last message."""
        return time.monotonic() - self._active_at

    def owns(self, session_id: str) -> bool:
        """Return whether this is a prewarmed session that no browser has opened yet."""
        return bool(session_id) and session_id in (self._building, self._ready, self._handed_out)

    def hand_out(self) -> str:
        """Return the identifier of the prewarmed session, once, or an empty text if there is none."""
        session_id, self._ready = self._ready, ""
        if session_id:
            self._handed_out, self._handed_out_at = session_id, time.monotonic()
        return session_id

    def release(self, session_id: str) -> None:
        """Treat the session like any other, because a browser has opened it."""
        if session_id == self._handed_out:
            self._handed_out = ""  # whatever the next line meets
            self._context.get_session(session_id).unblock_expiration()

    async def run(self, wanted: Callable[[], bool]) -> None:
        """Keep a session ready while ``wanted()``; never returns. A failure is logged, and tried again ever later."""
        pause = _CHECK_SECONDS
        while True:
            await asyncio.sleep(pause)
            try:
                await self.update(wanted())
            except Exception as error:  # of any kind: visitors do without a prewarmed session until it works again
                pause = min(2 * pause, _LONGEST_PAUSE)
                logs.event("session not kept ready", logging.ERROR, error=error, again_in=pause)
            else:
                pause = _CHECK_SECONDS

    async def update(self, wanted: bool) -> None:
        """Release a session that nobody opened in time; build one if it is wanted and the server is idle."""
        if self._handed_out and time.monotonic() - self._handed_out_at > self._claim_seconds:
            self.release(self._handed_out)  # Bokeh ends a session without connections
        idle = self.quiet_seconds() > self._quiet_seconds and not jobs()
        if idle and wanted and not self._ready and not self._handed_out:
            await self._build()

    async def _build(self) -> None:
        session_id = self._building = self._new_id()
        with logs.in_session(logs.session_name(session_id)):
            try:
                await self._build_as(session_id)
                self._ready = session_id
            finally:
                self._building = ""
            logs.event("session kept ready", logging.DEBUG)

    async def _build_as(self, session_id: str) -> None:
        session = await self._context.create_session_if_needed(session_id, PLAIN_REQUEST)
        session.block_expiration()
        try:
            await self._store_json(session)
        except BaseException:
            session.unblock_expiration()  # Bokeh ends it
            raise

    async def _store_json(self, session: ServerSession) -> None:
        """Serialise the document now, which would be most of the wait for it, and drop the result when it changes."""
        doc, changed = session.document, False

        def drop(event: DocumentChangedEvent) -> None:
            nonlocal changed
            if isinstance(event, DocumentPatchedEvent):  # a change that the browser sees
                changed = True
                self.take_json(doc)
                doc.remove_on_change(drop)

        doc.on_change(drop)
        stored = await in_thread(session, doc.to_json)
        if not changed:
            self._stored[doc] = stored

    def take_json(self, doc: Document) -> Serialized | None:
        """Return the stored form of a document once, or None if there is none or the document has changed since."""
        return self._stored.pop(doc, None)
