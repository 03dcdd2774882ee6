"""The contract of each hook in `app.compat`.

A test fails when a later version of the library no longer has the name or the behaviour that its hook relies
on.
"""

import asyncio
import inspect
import socket
from types import SimpleNamespace

import numpy as np
import param
import pytest
from bokeh.core.property.wrappers import PropertyValueContainer
from bokeh.document import Document
from bokeh.document.events import SessionCallbackAdded
from bokeh.events import Event
from bokeh.models import ColumnDataSource
from bokeh.plotting import figure
from bokeh.protocol import Protocol
from panel.custom import JSComponent
from panel.io import document as panel_document
from panel.io.state import set_curdoc, state
from panel.reactive import ReactiveCustomBase, Syncable
from tornado.web import Application
from tornado.websocket import WebSocketHandler, websocket_connect
from vibroscope.app.compat import (
    FastUpdates,
    claim_document,
    collected,
    forget_empty_defaults,
    leave_collections_out,
    send,
    send_rest,
    stop_compressing,
    stream_of,
    update_silently,
)
from vibroscope.app.page.shared.component import Component
from vibroscope.app.server.connections import Listener, Stream

from tests.waiting import PATIENCE


class Written:
    """Stands for a connection and its websocket."""

    def __init__(self):
        self._socket, self.protocol = self, Protocol()


class Example(Component):
    script = "header/header"

    text = param.String()
    numbers = param.Dict(default={})


@pytest.fixture
def shown():
    """A component, its document and its model."""
    component, doc = Example(), Document()
    model = component.get_root(doc)
    doc.add_root(model)
    return component, doc, model


def needs(owner, name):
    assert hasattr(owner, name), f"{owner.__module__}.{owner.__qualname__} has no {name} any more: see app/compat.py"


@pytest.mark.parametrize(
    ("owner", "name"),
    [
        (Syncable, "_process_bokeh_event"),
        (JSComponent, "_process_event"),
        (JSComponent, "_update_model"),
        (ReactiveCustomBase, "_set_on_model"),
        (JSComponent, "_send_msg"),
    ],
)
def test_panel_has_the_methods_that_the_hooks_replace_or_call(owner, name):
    needs(owner, name)


def test_panel_calls_the_hooks_with_the_arguments_that_they_take():
    for name in ("_process_bokeh_event", "_update_model"):
        theirs = inspect.signature(getattr(JSComponent, name)).parameters
        ours = inspect.signature(getattr(FastUpdates, name)).parameters
        assert [*ours] == [*theirs], f"Panel calls {name} with other arguments: see app/compat.py"


def test_an_event_reaches_its_component_without_the_list_of_busy_callbacks(shown, monkeypatch):
    component, doc, _ = shown
    heard = []
    monkeypatch.setattr(component, "_process_event", heard.append)
    event = Event()
    component._process_bokeh_event(doc, event)
    assert heard == [event]


def test_a_parameter_is_written_into_the_data_model_and_equals_panels_own_result(shown, monkeypatch):
    component, _, model = shown
    written = []
    set_on_model = ReactiveCustomBase._set_on_model
    monkeypatch.setattr(
        ReactiveCustomBase,
        "_set_on_model",
        lambda self, msg, root, target: written.append(target) or set_on_model(self, msg, root, target),
    )
    component.param.update(text="new", numbers={"a": 1})
    assert written
    assert all(target is model.data for target in written), "Panel wrote it: the hook _update_model was not called"
    assert (model.data.text, model.data.numbers) == ("new", {"a": 1})


def test_a_change_that_comes_from_the_browser_is_left_to_panel(shown):
    component, doc, model = shown
    needs(component, "_in_process__events")
    component._in_process__events[doc] = {"text": "typed"}
    component.text = "typed"
    assert model.data.text == "", "Panel no longer holds back what the browser has already: see app/compat.py"


def test_silent_columns_are_stored_and_not_sent():
    doc, events = Document(), []
    source = ColumnDataSource({"x": np.zeros(2)})
    doc.add_root(source)
    doc.on_change(events.append)
    update_silently(source, {"x": np.ones(3)})
    assert events == [], "ColumnDataSource.data reports what dict.update does: see app/compat.py"
    assert list(source.data["x"]) == [1, 1, 1]
    source.data.update(x=np.ones(4))
    assert len(events) == 1


def test_what_is_collected_is_not_dispatched_before_it_is_sent():
    needed = {"_WRITE_BLOCK", "_WRITE_MSGS", "_dispatch_msgs", "_dispatch_write_task"}
    assert needed <= vars(panel_document).keys(), "Panel keeps what it has to write elsewhere: see app/compat.py"
    doc, heard = Document(), []
    doc.on_change(heard.append)
    with collected(doc) as unsent:
        doc.title = "new"
        doc.add_next_tick_callback(int)
    assert heard == [], "Document.hold dispatches what it should hold: see app/compat.py"
    send(doc, unsent)
    assert [type(event) for event in heard] == [
        SessionCallbackAdded
    ]  # the title goes to connections, of which it has none


def test_connections_may_come_while_messages_for_them_are_made():
    class Connection:
        @property
        def protocol(self):
            connections.add(Connection())
            return Protocol()

    connections = {Connection()}
    doc, context = Document(), SimpleNamespace(session=SimpleNamespace(_subscribed_connections=connections))
    doc._session_context = lambda: context
    with collected(doc) as unsent:
        doc.title = "new"
    assert len(unsent.messages) == 1


def test_messages_that_panel_has_forgotten_are_sent_with_the_next_look():
    async def steps():
        doc, written = Document(), []
        panel_document.extra_socket_handlers[Written] = lambda _, msg: written.append(msg) or []
        panel_document._WRITE_MSGS[doc] = {Written(): ["message"]}
        await panel_document._dispatch_msgs(doc)
        assert written == [], "Panel no longer forgets messages: `send_rest` of app/compat.py can go"
        send_rest(doc)
        await asyncio.sleep(0.01)
        del panel_document.extra_socket_handlers[Written]
        return written

    assert asyncio.run(steps()) == ["message"]


def test_the_stream_of_a_request_is_the_one_that_its_websocket_writes_to():
    found = []

    class Handler(WebSocketHandler):
        def prepare(self):
            found.append(stream_of(self))

        def open(self):
            self.write_message("opened")

    async def steps():
        listener = Listener(Application([("/", Handler)]))
        with socket.create_server(("127.0.0.1", 0)) as sock:
            url = f"ws://127.0.0.1:{sock.getsockname()[1]}/"
            listener.add_sockets([sock])
            client = await websocket_connect(url)
            assert await client.read_message() == "opened"
            assert isinstance(found[0], Stream), "the stream is not the one that Listener.handle_stream made"
            assert not found[0].closed()
            client.close()
            listener.stop()
            await listener.close_all_connections()

    asyncio.run(asyncio.wait_for(steps(), PATIENCE))


def test_a_websocket_compresses_until_it_is_stopped_and_the_client_reads_both():
    sent = []

    class Handler(WebSocketHandler):
        def get_compression_options(self):
            return {}

        def open(self):
            for compress in (True, False):
                if not compress:
                    stop_compressing(self)
                before = self.ws_connection._wire_bytes_out
                self.write_message("a" * 10_000)
                sent.append(self.ws_connection._wire_bytes_out - before)

    async def steps():
        listener = Listener(Application([("/", Handler)]))
        with socket.create_server(("127.0.0.1", 0)) as sock:
            url = f"ws://127.0.0.1:{sock.getsockname()[1]}/"
            listener.add_sockets([sock])
            client = await websocket_connect(url, compression_options={})
            assert [len(await client.read_message()) for _ in sent or range(2)] == [10_000, 10_000]
            client.close()
            listener.stop()
            await listener.close_all_connections()

    asyncio.run(asyncio.wait_for(steps(), PATIENCE))
    assert sent[0] < 100 < 10_000 < sent[1]


def test_a_document_that_another_thread_has_built_is_changed_at_once_by_the_one_that_claims_it():
    doc = Document()
    state._thread_id_[doc] = -1
    with set_curdoc(doc):
        assert not state._unblocked(doc)
        claim_document(doc)
        assert state._unblocked(doc)


def test_panel_collects_no_garbage_after_a_session(monkeypatch):
    collected, scheduled = [], []
    needs(panel_document, "_garbage_collect")
    monkeypatch.setattr(panel_document, "_garbage_collect", panel_document._garbage_collect)
    monkeypatch.setattr(panel_document, "GC_DEBOUNCE", 0)
    monkeypatch.setattr(panel_document.gc, "collect", lambda: collected.append(True))
    monkeypatch.setattr(type(state), "schedule_task", lambda _, name, callback, at: scheduled.append(callback))

    def end_session():
        doc = Document()
        doc.destroy = None  # Panel's own, which it then deletes
        panel_document._destroy_document(doc, None)
        scheduled.pop()()
        assert not scheduled, "Panel schedules more at the end of a session: see app/compat.py"
        return len(collected)

    assert end_session() == 1, "Panel no longer collects garbage at the end of a session: see app/compat.py"
    leave_collections_out()
    assert end_session() == 1, "Panel collects garbage in another way: see app/compat.py"


def test_empty_defaults_are_forgotten_and_come_again():
    doc, drawn = Document(), figure()
    drawn.line([1, 2], [3, 4])
    doc.add_root(drawn)

    def kept():
        values = (value for model in doc.models for value in model._unstable_default_values.values())
        return [value for value in values if isinstance(value, PropertyValueContainer) and not value]

    before = doc.to_json(deferred=False)
    assert len(kept()) > 50
    drawn.tags.append("set")  # is kept, since it is no default any more
    forget_empty_defaults(doc.models)
    assert kept() == []
    drawn.tags.remove("set")
    drawn.css_classes.append("new")
    assert (drawn.tags, drawn.css_classes) == ([], ["new"])
    del drawn.css_classes, drawn.tags
    assert doc.to_json(deferred=False) == before
