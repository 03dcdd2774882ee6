"""Patches of a document, without Bokeh's tables of all its models.

For each message, either way, Bokeh makes a table of every model in the document, some four hundred, of which the
message names a handful: with many visitors that adds up on the one loop that serves them all.
"""

from __future__ import annotations

from functools import partial

from bokeh.core.serialization import Deserializer, Serializer
from bokeh.document import Document
from bokeh.document.callbacks import invoke_with_curdoc
from bokeh.document.events import DocumentPatchedEvent
from bokeh.document.models import DocumentModelManager
from bokeh.model import Model
from bokeh.protocol import Protocol
from bokeh.protocol.messages.patch_doc import patch_doc


class Patch(patch_doc):
    """A patch that looks up the models it names."""

    @classmethod
    def create(cls, events: list[DocumentPatchedEvent], **metadata) -> Patch:
        """See `bokeh.protocol.messages.patch_doc`; all events are of one document."""
        models = events[0].document.models
        serializer = _Serializer(models)
        message = cls(cls.create_header(), metadata, {"events": serializer.encode(events)})
        models.flush_synced(lambda model: not serializer.has_ref(model))
        message.add_buffers(*serializer.buffers)
        return message

    def apply_to_document(self, doc: Document, setter: object = None) -> None:
        """Apply what has passed `app.server.validation`: so each event names models that are there, and brings none."""
        invoke_with_curdoc(doc, partial(self._apply, doc, setter))

    def _apply(self, doc: Document, setter: object) -> None:
        for event in self.content["events"]:
            reference = _model_of(event)
            meant = [doc.models.get_by_id(reference["id"])] if reference else []
            if None not in meant:  # one that went while the document was locked has nothing to hear any more
                told = Deserializer(meant, setter=setter).deserialize(event)
                DocumentPatchedEvent.handle_event(doc, told, setter)


class _Serializer(Serializer):
    """Refers to the models that the browser has, as they come up."""

    def __init__(self, models: DocumentModelManager) -> None:
        super().__init__()
        self._models, self._new = models, models._new_models

    def get_ref(self, obj: object) -> dict | None:
        ref = super().get_ref(obj)
        if ref is None and isinstance(obj, Model) and obj not in self._new and self._models.get_by_id(obj.id) is obj:
            return obj.ref
        return ref

    def has_ref(self, obj: object) -> bool:
        return self.get_ref(obj) is not None


def _model_of(event: dict) -> dict | None:
    """The reference in an event to the model that it is about."""
    if "model" in event:
        return event["model"]
    return dict(event["msg_data"]["values"].get("entries", ())).get("model")


def speak(protocol: Protocol) -> None:
    """Let a connection's protocol, which its receiver has too, make and read such patches."""
    protocol._messages = protocol._messages | {"PATCH-DOC": Patch}
