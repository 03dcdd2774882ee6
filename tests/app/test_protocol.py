"""Patches: what is sent equals Bokeh's own, and what is received reaches the models that exist."""

import json

import numpy as np
from bokeh.document import Document
from bokeh.models import ColumnDataSource, Range1d
from bokeh.plotting import figure
from bokeh.protocol import Protocol
from vibroscope.app.server.protocol import PageProtocol, PatchMessage

from tests.browserless import changed, event, mapped


def document():
    doc, events = Document(), []
    plot = figure(x_range=Range1d(0, 1))
    doc.add_root(plot)
    doc.models.flush_synced()
    doc.on_change(events.append)
    return doc, plot, events


def unsent(doc):
    """The models that the browser does not have yet."""
    return set(doc.models) - doc.models.synced_references


def frames(message):
    """The content and the buffers of a message as they are sent, with the buffers numbered."""
    text = message.content_json
    for number, buffer in enumerate(message.buffers):
        text = text.replace(str(buffer.id), f"buffer {number}")
    return text, [buffer.to_bytes() for buffer in message.buffers]


def test_what_is_sent_equals_bokehs_own_with_models_new_and_known(monkeypatch):
    doc, plot, events = document()
    source = ColumnDataSource({"x": [1.0, 2.0]})
    plot.title.text = "η"
    plot.line("x", "x", source=source)
    source.data["x"] = np.arange(3.0)
    assert unsent(doc)
    with monkeypatch.context() as patched:
        patched.setattr(doc.models, "flush_synced", lambda still_new: None)  # the next message has the same changes
        theirs = Protocol().create("PATCH-DOC", events)
    ours = PageProtocol().create("PATCH-DOC", events)
    assert unsent(doc) == set()
    assert isinstance(ours, PatchMessage)
    assert frames(ours) == frames(theirs)
    assert "tags" not in plot.renderers[0]._unstable_default_values  # what serialising it has made is gone


def test_an_event_for_a_model_that_was_removed_is_dropped_and_the_others_are_applied():
    doc, plot, _ = document()
    removed = Range1d(0, 1)
    events = [
        changed(removed.id, "start", 5.0),
        changed(plot.x_range.id, "end", 7.0),
        event("document_ready", mapped({})),
    ]
    ready = []
    doc.on_event("document_ready", ready.append)
    message = PageProtocol().assemble('{"msgid": "1", "msgtype": "PATCH-DOC"}', "{}", json.dumps({"events": events}))
    assert isinstance(message, PatchMessage)
    message.apply_to_document(doc)
    assert (plot.x_range.start, plot.x_range.end, removed.start) == (0, 7.0, 0)
    assert len(ready) == 1


def test_a_stored_document_is_sent_in_place_of_a_new_serialisation():
    doc, plot, _ = document()
    stored = doc.to_json()
    plot.x_range.end = 9
    reply = PageProtocol(lambda asked: stored if asked is doc else None).create("PULL-DOC-REPLY", "7", doc)
    assert (reply.header["reqid"], reply.content["doc"]) == ("7", stored.content)
    assert PageProtocol().create("PULL-DOC-REPLY", "7", doc).content["doc"] != stored.content
