"""Documents are built and serialised in a thread, while the loop serves other sessions.

Both take some hundred milliseconds of Python code, for which the loop would answer nobody. A thread that runs such code
hands over the interpreter's lock whenever another one has waited for the switch interval, which the loop does each time
that it has waited for the network. Studies rest meanwhile: much of theirs is Python code, too.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from typing import TypeVar

from bokeh.application.application import SessionContext
from bokeh.document import Document
from bokeh.protocol.message import Message
from bokeh.server.connection import ServerConnection
from bokeh.server.session import ServerSession
from panel.io.application import Application
from vibroscope.app.compat import claim_document, forget_empty_defaults
from vibroscope.app.runtime.workers import ahead_of_jobs

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
