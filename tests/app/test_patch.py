"""Patches say what Bokeh's own say, and hear what is meant for a model that is there."""

import numpy as np
from bokeh.document import Document
from bokeh.models import ColumnDataSource, Range1d
from bokeh.plotting import figure
from bokeh.protocol import Protocol
from bokeh.protocol.messages.patch_doc import patch_doc
from vibroscope.app.server.patch import Patch, speak

from tests.browserless import mapped


def changed(model, attr, new):
    return {"kind": "ModelChanged", "model": {"id": model.id}, "attr": attr, "new": new}


def document():
    doc, events = Document(), []
    plot = figure(x_range=Range1d(0, 1))
    doc.add_root(plot)
    doc.models.flush_synced()
    doc.on_change(events.append)
    return doc, plot, events


def test_what_is_sent_is_bokehs_own_with_models_new_and_known():
    doc, plot, events = document()
    source = ColumnDataSource({"x": [1.0, 2.0]})
    plot.title.text = "η"
    plot.line("x", "x", source=source)
    source.data["x"] = np.arange(3.0)
    new = set(doc.models._new_models)
    assert new
    theirs = patch_doc.create(events)
    doc.models._new_models = set(new)
    ours = Patch.create(events)
    assert doc.models._new_models == set()
    assert "ref" not in str(ours.content["events"][0]["new"])

    def plain(message):
        text = message.content_json
        for buffer in message._buffers:
            text = text.replace(str(buffer.id), "buffer")
        return text

    assert plain(ours) == plain(theirs)
    assert [b.to_bytes() for b in ours._buffers] == [b.to_bytes() for b in theirs._buffers]


def test_what_is_meant_for_a_model_that_went_is_dropped_and_the_rest_taken():
    doc, plot, told = document()
    gone = Range1d(0, 1)
    ready = {"type": "event", "name": "document_ready", "values": mapped({})}
    events = [
        changed(gone, "start", 5.0),
        changed(plot.x_range, "end", 7.0),
        {"kind": "MessageSent", "msg_type": "bokeh_event", "msg_data": ready},
    ]
    heard = []
    doc.on_event("document_ready", heard.append)
    protocol = Protocol()
    speak(protocol)
    plot.title.text = "another"
    message = protocol.create("PATCH-DOC", told)
    assert isinstance(message, Patch)
    message.content = {"events": events}
    message.apply_to_document(doc)
    assert (plot.x_range.start, plot.x_range.end, gone.start) == (0, 7.0, 0)
    assert len(heard) == 1
