"""Stands for the page around a tab, and for the browser."""

import queue
import time

from bokeh.document import Document as BokehDocument
from panel.models.esm import DataEvent
from vibroscope.app.page import asker
from vibroscope.app.page.session import Session

from tests.waiting import PATIENCE


class Document(BokehDocument):
    """Bokeh's, but that callbacks after a time are never called."""

    def add_timeout_callback(self, *_):
        pass


class FakeHost:
    """A `TabHost` that writes at once, calls at once what workers send, and keeps what the tab sends."""

    view_titles = Session.view_titles

    def __init__(self, pinned=(), doc=None):
        self.doc, self.pinned, self.code = doc or BokehDocument(), pinned, ""
        self.moves, self.errors, self.settings, self.visits, self.summary = [], [], [], [], ""

    def push(self, move, write, follow=lambda: None):
        self.moves.append(move)
        write()
        follow()

    def call_later(self, callback):
        callback()

    def add_models(self, add, then):
        add()
        then()

    def report_error(self, text, move=None):
        self.errors.append(text)

    def summarise(self, text):
        self.summary = text

    def update_offers(self):
        pass

    def set(self, texts):
        self.settings.append(texts)

    def visit(self, key, texts, prepare=None):
        self.visits.append((key, texts, prepare))


class QueueingHost(FakeHost):
    """Calls what workers send when a test says so, in the thread of the test."""

    def __init__(self, **parts):
        super().__init__(**parts)
        self.waiting = queue.Queue()

    def call_later(self, callback):
        self.waiting.put(callback)

    def catch_up(self):
        """Make the next call, which may still have to come."""
        self.waiting.get(timeout=PATIENCE)()

    def catch_up_until(self, holds, seconds=120):
        """Make calls until something holds."""
        end = time.monotonic() + seconds
        while not holds():
            self.waiting.get(timeout=max(0.01, end - time.monotonic()))()


def send(component, message):
    """Send a message to a component as its browser does; Panel has no public way."""
    component._process_event(DataEvent(None, message))


class Asked:
    """Stands for `StudyJob`: nothing is computed before it is asked for, and every job is listed."""

    all = ()

    def __init__(self, question, grow, deliver):
        self.question, self.deliver, self.grow = question, deliver, grow
        self.cancelled = self.out_of_time = False
        Asked.all = (*Asked.all, self)

    def cancel(self):
        self.cancelled = True

    def run(self, most=None):
        """Deliver the results, at most so many."""
        for count, result in enumerate(self.grow(self.question, None, lambda: False), start=1):
            asker.RESULTS.put(self.question, result)
            self.deliver(self, result)
            if count == most:
                break
