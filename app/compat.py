"""The only module of the app that uses private or undocumented names of Panel, Bokeh or Tornado.

Each part names what it uses and why: what cannot be had without it, or the measurement that justifies it, which
``benchmarks/hooks.py`` repeats. `tests/app/test_compat.py` has a contract test for each part, and pyproject.toml caps
the libraries' versions. The hooks into the libraries' scripts are in ``page/shared/compat.js``; what of these scripts a
browser gets is in ``server/libraries.py``.
"""

import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
from bokeh.core.property.wrappers import PropertyValueContainer
from bokeh.document import Document
from bokeh.document.events import DocumentChangedEvent, DocumentPatchedEvent
from bokeh.model import Model
from bokeh.models import ColumnDataSource
from bokeh.protocol.message import Message
from bokeh.server.connection import ServerConnection
from panel.io import document as panel_document
from panel.io.model import monkeypatch_events
from panel.io.state import set_curdoc, state
from tornado.iostream import IOStream
from tornado.websocket import WebSocketHandler


class FastUpdates:
    """Goes before `panel.custom.JSComponent`: handle messages and changes of a component with less work.

    The component must hold no other components.
    """

    def _process_bokeh_event(self, doc, event) -> None:
        """Handle an event without Panel's list of busy callbacks.

        Uses ``Syncable._process_bokeh_event`` and ``ReactiveESM._process_event``. Only Panel's busy indicator reads
        that list, and the page has none. Without this hook a move takes 23 to 32 % more time of the server's event loop
        (``benchmarks/hooks.py events``).
        """
        with set_curdoc(doc):
            self._process_event(event)

    def _update_model(self, events, msg, root, model, doc, comm) -> None:
        """Write parameters of the component straight into its data model, which is all that they change.

        Uses ``ReactiveESM._update_model``, ``Syncable._in_process__events`` and ``ReactiveCustomBase._set_on_model``.
        Panel's own way looks for child components and new models, and compares each value with the parameters of every
        base class. Without this hook a move takes 8 to 13 % more time of the server's event loop
        (``benchmarks/hooks.py updates``).
        """
        if msg.keys() <= model.data.properties() and not self._in_process__events.get(doc):
            self._set_on_model(msg, root, model.data)
        else:
            super()._update_model(events, msg, root, model, doc, comm)


def update_silently(source: ColumnDataSource, columns: Mapping[str, np.ndarray]) -> None:
    """Put columns into a source without sending them.

    Relies on ``source.data`` being a ``dict`` whose own ``update`` reports the change to the document. The page sends
    the columns of all sources in one message instead (`app.page.explore.column_sender`);
    without that a move takes 22 % more time of the server's event loop (``benchmarks/hooks.py columns``).
    """
    dict.update(source.data, columns)


def stop_compressing(handler: WebSocketHandler) -> None:
    """Send the messages of a websocket as they are from now on, which its protocol leaves to the sender.

    Uses ``WebSocketProtocol13._compressor``. The document of the page is text of 200 kB and shrinks to a fifth, for
    0.8 s of a line of 1.6 Mbit/s; the numbers that a move sends hardly shrink, and compressing them would delay it.
    """
    handler.ws_connection._compressor = None


def claim_document(doc: Document) -> None:
    """Make the calling thread the one that changes a document, which another thread has built.

    Uses ``panel.state._thread_id_``. Otherwise Panel puts each change off to the next turn of the loop: a
    move takes 14 % more time of the server's event loop, and its figures come 40 % later (``benchmarks/hooks.py
    claimed``).
    """
    state._thread_id_[doc] = threading.get_ident()


class Unsent(NamedTuple):
    """What a thread has changed in a document: messages for its connections, and events that are no change of it."""

    messages: list[tuple[ServerConnection, Message]]
    others: list[DocumentChangedEvent]


@contextmanager
def collected(doc: Document) -> Iterator[Unsent]:
    """Make the messages of what a thread that has claimed a document changes in it; `send` sends them, on the loop.

    Uses ``Document.callbacks._hold`` and ``_held_events``, ``ServerSession._subscribed_connections`` and Panel's
    ``monkeypatch_events``. Panel's own ``hold`` would write to the connection from the thread, or note its messages in
    dictionaries that the loop empties meanwhile: a message then came between the parts of another, or never.
    """
    unsent = Unsent([], [])
    doc.hold()
    try:
        yield unsent
    finally:
        events, doc.callbacks._held_events, doc.callbacks._hold = list(doc.callbacks._held_events), [], None
        changes = [event for event in events if isinstance(event, DocumentPatchedEvent)]
        unsent.others.extend(event for event in events if not isinstance(event, DocumentPatchedEvent))
        monkeypatch_events(changes)
        if changes and doc.session_context is not None:
            for connection in list(doc.session_context.session._subscribed_connections):  # a copy: they come and go
                unsent.messages.append((connection, connection.protocol.create("PATCH-DOC", changes)))


def send(doc: Document, unsent: Unsent) -> None:
    """Send what was `collected`, after what Panel has not sent yet; called on the loop.

    Uses ``panel.io.document._WRITE_MSGS`` and what `send_rest` uses.
    """
    for event in unsent.others:
        doc.callbacks.trigger_on_change(event)
    for connection, message in unsent.messages:
        panel_document._WRITE_MSGS.setdefault(doc, {}).setdefault(connection, []).append(message)
    send_rest(doc)


def send_rest(doc: Document) -> None:
    """Send the messages that wait to be written; called on the loop.

    Uses ``panel.io.document._WRITE_MSGS``, ``_WRITE_BLOCK``, ``_dispatch_msgs`` and ``_dispatch_write_task``. Panel
    writes them in a task that does nothing once another such task has ended in the same turn of the loop; they would
    wait for the next change of the page.
    """
    if doc in panel_document._WRITE_MSGS:
        panel_document._WRITE_BLOCK[doc] = True
        panel_document._dispatch_write_task(doc, panel_document._dispatch_msgs, doc)


def forget_empty_defaults(models: Iterable[Model]) -> None:
    """Let go of the empty lists, dictionaries and sets that stand for values which nobody has set.

    Uses ``HasProps._unstable_default_values``. To serialise models, Bokeh asks each for all its properties and keeps
    what it gets: of a new page 2,300 containers, each in a cycle with its owner. Who asks again gets a new one. Without
    this a session takes 15,400 objects in place of 6,000, and a full collection, which holds everybody up, three times
    as long (``benchmarks/hooks.py defaults``).
    """
    for model in models:
        defaults = model._unstable_default_values
        unset = [name for name, value in defaults.items() if isinstance(value, PropertyValueContainer) and not value]
        for name in unset:
            del defaults[name]


def leave_collections_out() -> None:
    """Keep Panel from collecting garbage 5 s after a session has ended; `app.server.housekeeping` does that.

    Replaces ``panel.io.document._garbage_collect``, which runs on the event loop: 60 to 130 ms for the sessions of an
    address that opens two a second, again and again, while another visitor's move waits (``benchmarks/fairness.py``).
    """
    panel_document._garbage_collect = lambda: None


def stream_of(handler: WebSocketHandler) -> IOStream:
    """Return the stream that a websocket writes to.

    Uses ``HTTP1Connection.stream`` of the request, before the connection becomes a websocket. The limits cannot
    do without it: what a client sends and does not read is counted at the stream, which Tornado's handlers do not show.
    """
    return handler.request.connection.stream


# Tornado writes this to a client whose request it cannot read, without calling a handler or transform.
# `connections.Stream` replaces it by an answer with the security headers.
BARE_REFUSAL = b"HTTP/1.1 400 Bad Request\r\n\r\n"
