"""The Bokeh protocol of one connection, with patches that look up only the models that they name.

For each message in either direction Bokeh builds a table of all models of the document, about four hundred, of which
the message names a few. Without this module a move takes more time of the server's event loop (``benchmarks/hooks.py
patches``). The module also sends a prewarmed session's document in its stored form.
"""

from collections.abc import Callable
from functools import partial

from bokeh.core.serialization import Deserializer, Serialized, Serializer
from bokeh.document import Document
from bokeh.document.callbacks import invoke_with_curdoc
from bokeh.document.events import DocumentPatchedEvent
from bokeh.document.models import DocumentModelManager
from bokeh.model import Model
from bokeh.protocol import Protocol
from bokeh.protocol.message import Message
from bokeh.protocol.messages.patch_doc import patch_doc
from bokeh.protocol.messages.pull_doc_reply import pull_doc_reply
from vibroscope.app.compat import forget_empty_defaults


class PatchMessage(patch_doc):
    """A patch of a document; equal to Bokeh's own in what it sends and applies."""

    @classmethod
    def create(cls, events: list[DocumentPatchedEvent], **metadata) -> "PatchMessage":
        """See `bokeh.protocol.messages.patch_doc`; all events belong to one document."""
        models = events[0].document.models
        serializer = _Serializer(models)
        message = cls(cls.create_header(), metadata, {"events": serializer.encode(events)})
        forget_empty_defaults(filter(serializer.has_ref, serializer.unsent))
        models.flush_synced(lambda model: not serializer.has_ref(model))
        message.add_buffers(*serializer.buffers)
        _ = message.content_json  # written here and kept: this may be a thread
        return message

    def apply_to_document(self, doc: Document, setter: object = None) -> None:
        """Apply events that passed `app.server.validation`: each names a model of the document and brings none."""
        invoke_with_curdoc(doc, partial(self._apply, doc, setter))

    def _apply(self, doc: Document, setter: object) -> None:
        for event in self.content["events"]:
            reference = _model_of(event)
            models = [doc.models.get_by_id(reference["id"])] if reference else []
            if None not in models:  # a model may have been removed while the document was locked
                decoded = Deserializer(models, setter=setter).deserialize(event)
                DocumentPatchedEvent.handle_event(doc, decoded, setter)


class _Serializer(Serializer):
    """Encodes the models that the browser already has as references."""

    def __init__(self, models: DocumentModelManager) -> None:
        super().__init__()
        self._document_models = models
        self.unsent: set[Model] = set()
        models.flush_synced(lambda model: self.unsent.add(model) or True)  # collects them and changes nothing

    def get_ref(self, obj: object) -> dict | None:
        """See `bokeh.core.serialization.Serializer`."""
        ref = super().get_ref(obj)
        if ref is None and isinstance(obj, Model) and obj not in self.unsent:
            return obj.ref if self._document_models.get_by_id(obj.id) is obj else None
        return ref

    def has_ref(self, obj: object) -> bool:
        """See `bokeh.core.serialization.Serializer`."""
        return self.get_ref(obj) is not None


def _model_of(event: dict) -> dict | None:
    """Return the reference to the model that an event is about."""
    if "model" in event:
        return event["model"]
    return dict(event["msg_data"]["values"].get("entries", ())).get("model")


class PageProtocol(Protocol):
    """Creates and reads the messages of one connection; ``stored_json`` returns a document's stored form, or None."""

    def __init__(self, stored_json: Callable[[Document], Serialized | None] = lambda doc: None) -> None:
        super().__init__()
        self._stored_json = stored_json

    def create(self, msgtype: str, *args, **kwargs) -> Message:
        """See `bokeh.protocol.Protocol`."""
        if msgtype == "PATCH-DOC":
            return PatchMessage.create(*args, **kwargs)
        if msgtype == "PULL-DOC-REPLY" and (stored := self._stored_json(args[1])):
            message = pull_doc_reply(pull_doc_reply.create_header(args[0]), kwargs, {"doc": stored.content})
            message.add_buffers(*stored.buffers)
            return message
        return super().create(msgtype, *args, **kwargs)

    def assemble(self, header_json: str, metadata_json: str, content_json: str) -> Message:
        """See `bokeh.protocol.Protocol`; raises ValueError for a message without the name that its answer refers to."""
        message = super().assemble(header_json, metadata_json, content_json)
        if not isinstance(message.header.get("msgid"), str):
            raise ValueError("a message without a msgid")
        if message.msgtype == "PATCH-DOC":
            return PatchMessage(message.header, message.metadata, message.content)
        return message
