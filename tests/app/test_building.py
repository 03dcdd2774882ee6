"""Documents are built and serialised in a thread: the loop serves others meanwhile."""

import asyncio
import threading
from contextlib import suppress

import pytest
from bokeh.application.handlers import FunctionHandler
from bokeh.core.json_encoder import serialize_json
from bokeh.core.validation.check import check_integrity
from bokeh.document import Document
from bokeh.models import Range1d
from bokeh.protocol import Protocol, message
from bokeh.server.contexts import ApplicationContext
from panel.io import document as panel_document
from panel.io.state import set_curdoc, state
from tornado.ioloop import IOLoop
from vibroscope.app.page.tabs import VIEWS
from vibroscope.app.page.updates import SessionLoop
from vibroscope.app.server.building import PLAIN_REQUEST, ThreadedApplication, pull

from tests.app.fakes import FakeHost

SECONDS = 20  # after which a loop that waits for the thread, which waits for the loop, is found out


def while_the_loop_goes_on(steps):
    """Run ``steps(wait)``: ``wait()`` in a thread lasts until the loop has gone round; false if it never has."""
    reached, answered = threading.Event(), threading.Event()

    def wait():
        reached.set()
        return answered.wait(SECONDS)

    async def answer():
        while not reached.is_set():
            await asyncio.sleep(0)
        answered.set()

    async def both():
        answering = asyncio.ensure_future(answer())
        try:
            return await asyncio.wait_for(steps(wait), 2 * SECONDS)
        finally:
            answering.cancel()
            with suppress(asyncio.CancelledError):
                await answering

    return asyncio.run(both())


async def session_of(build, number="1"):
    context = ApplicationContext(ThreadedApplication(FunctionHandler(build)), io_loop=IOLoop.current(), url="/")
    session = await context.create_session_if_needed(number, PLAIN_REQUEST)
    session.kept = context  # a document knows its session as long as that exists
    return session


def test_the_loop_goes_on_while_a_document_is_built():
    served = []

    def build(doc, wait):
        served.append(wait())
        doc.add_root(Range1d(start=0, end=1))

    session = while_the_loop_goes_on(lambda wait: session_of(lambda doc: build(doc, wait)))
    assert served == [True]
    assert len(session.document.roots) == 1  # and is built once


def test_the_loop_goes_on_while_models_are_added_and_what_follows_is_called_on_it():
    served, threads = [], []

    async def steps(wait):
        session = await session_of(lambda doc: doc.add_root(Range1d(start=0, end=1)))
        done, page = asyncio.Event(), SessionLoop(session.document)
        page.start()

        def add():
            served.append(wait())
            threads.append(threading.get_ident())
            session.document.add_root(Range1d(start=1, end=2))

        def then():
            threads.append(threading.get_ident())
            done.set()

        page.add_models(add, then, done.set)
        await done.wait()
        return session

    session = while_the_loop_goes_on(steps)
    assert served == [True]
    assert len(session.document.models) == 2
    assert [thread == threading.get_ident() for thread in threads] == [False, True]


class Connection:
    """Stands for a connection and its websocket."""

    def __init__(self):
        self._socket, self.protocol = self, Protocol()
        self.sent = []  # of each message whether the loop has sent it, and what it holds

    def send(self, message):
        self.sent.append((threading.current_thread() is threading.main_thread(), message.content_json))
        return []


def test_models_that_are_added_while_an_older_message_is_written_come_after_it(monkeypatch):
    def write(connection, events=None, msg=None):
        return connection.send(msg or connection.protocol.create("PATCH-DOC", events))

    monkeypatch.setitem(panel_document.extra_socket_handlers, Connection, write)
    monkeypatch.setattr(type(state), "loaded", True)

    async def steps(wait):
        session = await session_of(lambda doc: doc.add_root(Range1d(start=0, end=1)))
        doc, connection, done = session.document, Connection(), asyncio.Event()
        session._subscribed_connections.add(connection)
        page = SessionLoop(doc)
        page.start()

        def change():
            doc.hold()
            doc.title = "older"
            events, doc.callbacks._held_events, doc.callbacks._hold = doc.callbacks._held_events, [], None
            panel_document.schedule_write_events(doc, session._subscribed_connections, events)

        def add():
            assert wait()  # the loop writes the older message, and has none left
            doc.add_root(Range1d(start=0, end=0.7, name="added"))

        await session.with_document_locked(change)
        page.add_models(add, done.set, done.set)
        await done.wait()
        while len(connection.sent) < 2:
            await asyncio.sleep(0.001)
        return connection.sent

    older, added = while_the_loop_goes_on(steps)
    assert "older" in older[1]
    assert "added" in added[1]
    assert older[0]
    assert added[0]


def test_models_that_could_not_be_added_are_reported_and_leave_the_document_as_it_was():
    async def steps():
        session = await session_of(lambda doc: doc.add_root(Range1d(start=0, end=1)))
        failed, page = asyncio.Event(), SessionLoop(session.document)
        page.start()
        page.add_models(lambda: 1 / 0, lambda: None, failed.set)
        await failed.wait()
        await session.with_document_locked(session.document.add_root, Range1d(start=1, end=2))
        return len(session.document.models)

    assert asyncio.run(asyncio.wait_for(steps(), SECONDS)) == 2  # its models are not frozen


def test_what_a_worker_has_to_say_while_its_session_ends_is_dropped(monkeypatch):
    """Bokeh takes the callbacks of a document away in the loop's thread, at any time for the worker."""
    said = []

    async def steps():
        session = await session_of(lambda doc: doc.add_root(Range1d(start=0, end=1)))
        doc, page = session.document, SessionLoop(session.document)
        page.start()
        add = doc.add_next_tick_callback

        def add_too_late(callback):
            session.destroy()
            return add(callback)

        monkeypatch.setattr(doc, "add_next_tick_callback", add_too_late)
        page.call_later(lambda: said.append("late"))

    asyncio.run(asyncio.wait_for(steps(), SECONDS))
    assert not said


def test_one_document_is_built_at_a_time():
    building = []

    def build(doc):
        building.append("begin")
        doc.add_root(Range1d(start=0, end=1))
        building.append("end")

    async def steps():
        context = ApplicationContext(ThreadedApplication(FunctionHandler(build)), io_loop=IOLoop.current(), url="/")
        await asyncio.gather(*(context.create_session_if_needed(str(n), PLAIN_REQUEST) for n in range(4)))

    asyncio.run(steps())
    assert building == ["begin", "end"] * 4


def test_the_loop_goes_on_while_a_document_is_serialised_and_the_document_is_locked_meanwhile(monkeypatch):
    served, locked, written, changed = [], [], [], threading.Event()

    def write(content):
        written.append(threading.current_thread() is threading.main_thread())
        return serialize_json(content)

    monkeypatch.setattr(message, "serialize_json", write)

    async def steps(wait):
        session = await session_of(lambda doc: doc.add_root(Range1d(start=0, end=1)))
        loop = asyncio.get_running_loop()

        async def change():
            await asyncio.wait({asyncio.ensure_future(session.with_document_locked(changed.set))}, timeout=0.05)

        class Slow(Protocol):
            def create(self, *arguments):
                asyncio.run_coroutine_threadsafe(change(), loop).result(SECONDS)
                served.append(wait())
                locked.append(not changed.is_set())
                return super().create(*arguments)

        class Connection:
            protocol = Slow()

        Connection.session = session
        request = Protocol().create("PULL-DOC-REQ")
        return await pull(request, Connection), request, session

    reply, request, session = while_the_loop_goes_on(steps)
    assert served == locked == [True]
    assert reply.content_json
    assert written == [False]  # in the thread, and not again
    assert reply.header["reqid"] == request.header["msgid"]
    assert reply.content["doc"] == session.document.to_json().content


def test_changes_on_the_loop_are_made_at_once_although_a_thread_has_built_the_document():
    async def steps():
        session = await session_of(lambda doc: doc.add_root(Range1d(start=0, end=1)))
        with set_curdoc(session.document):
            state._connected[session.document] = True
            return state._unblocked(session.document)

    assert asyncio.run(steps())


# What the server does not check for each visitor.
UNFILLED = "EMPTY_LAYOUT"  # a tab's place is empty until the tab is opened


@pytest.mark.parametrize("key", VIEWS)
def test_the_documents_of_all_tabs_are_sound(key):
    doc = Document()
    with set_curdoc(doc):
        doc.add_root(VIEWS[key](FakeHost()).build().get_root(doc))
    issues = check_integrity(doc.roots[0].references())
    assert not issues.error
    assert {issue.name for issue in issues.warning} <= {UNFILLED}


def test_a_document_that_cannot_be_built_is_no_empty_page():
    def build(doc):
        raise ZeroDivisionError

    application = ThreadedApplication(FunctionHandler(build, trap_exceptions=False))
    with pytest.raises(ZeroDivisionError):
        application.initialize_document(Document())
