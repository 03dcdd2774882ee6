"""Message validation: what a browser may send over the websocket; everything else is dropped before it is applied.

Bokeh's protocol lets a client set any property of any model, replace the whole document, and send arrays. The page
needs almost none of that. The following list was recorded from a browser in use:

- the request for the document, and the report that it is shown;
- messages of the page's own components (`app.page.session` reads them as text and decides), taps and new ranges;
- the ends of an axis range, the visibility of a curve, the size of a frame, all plain finite values;
- that an error message was closed.

Any other event is removed from its message, and a message of another kind is refused. No forged value reaches a model,
the engine, or another browser in the same session.
"""

import math
from collections.abc import Callable

from bokeh.document import Document
from bokeh.model import DataModel, Model
from bokeh.models import GlyphRenderer, Plot, Range1d

_DEPTH = 4
_MOST_CHARACTERS = 4000
_MOST_ENTRIES = 64
_Check = Callable[[object], bool]


def is_plain(value: object, depth: int = _DEPTH) -> bool:
    """Return whether a value is text, a finite number, a truth value, None, or a small map of these by name."""
    if value is None or isinstance(value, bool):
        return True
    if isinstance(value, str):
        return len(value) <= _MOST_CHARACTERS
    if isinstance(value, int | float):
        return abs(value) < 1e300 if isinstance(value, int) else math.isfinite(value)
    return depth > 0 and _is_plain_map(value, depth)


def _is_plain_map(value: object, depth: int) -> bool:
    if value == {"type": "map"}:  # an empty one
        return True
    entries = value["entries"] if _is_map_by_name(value) else None
    return entries is not None and len(entries) <= _MOST_ENTRIES and all(is_plain(e[1], depth - 1) for e in entries)


def _is_map_by_name(value: object) -> bool:
    return (
        isinstance(value, dict)
        and value.keys() == {"type", "entries"}
        and value["type"] == "map"
        and isinstance(value["entries"], list)
        and all(map(_is_named_entry, value["entries"]))
    )


def _is_named_entry(entry: object) -> bool:
    return isinstance(entry, list) and len(entry) == 2 and isinstance(entry[0], str)


def _is_finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and is_plain(value)


def _is_truth_value(value: object) -> bool:
    return isinstance(value, bool)


def _is_length(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= 20_000


def _is_number_or_none(value: object) -> bool:
    return value is None or _is_finite(value)


# Changes of properties: kind of model and attribute → check of the new value.
_CHANGES: dict[tuple[type, str], _Check] = {
    (Range1d, "start"): _is_finite,
    (Range1d, "end"): _is_finite,
    (GlyphRenderer, "visible"): _is_truth_value,
    (DataModel, "error"): lambda value: value == "",  # the user has closed a message
    **{(Plot, f"{side}_{length}"): _is_length for side in ("inner", "outer") for length in ("width", "height")},
}
# Events: name → kind of model and checks of the fields.
_EVENTS: dict[str, tuple[type, dict[str, _Check]]] = {
    "data_event": (Model, {"data": is_plain}),
    "tap": (Plot, {**dict.fromkeys(("sx", "sy", "x", "y"), _is_number_or_none), "modifiers": is_plain}),
    "rangesupdate": (Plot, dict.fromkeys(("x0", "x1", "y0", "y1"), _is_number_or_none)),
}


def _is_valid(event: object, document: Document) -> bool:
    if not isinstance(event, dict):
        return False
    if event.get("kind") == "ModelChanged" and event.keys() == {"kind", "model", "attr", "new"}:
        return _is_valid_change(event, document)
    if event.get("kind") == "MessageSent" and event.keys() == {"kind", "msg_type", "msg_data"}:
        return event["msg_type"] == "bokeh_event" and _is_valid_event(event["msg_data"], document)
    return False


def _is_valid_change(event: dict, document: Document) -> bool:
    model = _model(event["model"], document)
    return any(
        isinstance(model, kind) and event["attr"] == attribute and check(event["new"])
        for (kind, attribute), check in _CHANGES.items()
    )


def _is_valid_event(data: object, document: Document) -> bool:
    if not isinstance(data, dict) or data.keys() != {"type", "name", "values"} or data["type"] != "event":
        return False
    values = data["values"]
    if data["name"] == "document_ready":
        return values in ({"type": "map"}, {"type": "map", "entries": []})
    if not isinstance(data["name"], str) or data["name"] not in _EVENTS or not _is_map_by_name(values):
        return False
    kind, checks = _EVENTS[data["name"]]
    fields = dict(values["entries"])
    model = _model(fields.pop("model", None), document)
    return isinstance(model, kind) and all(name in checks and checks[name](value) for name, value in fields.items())


def _model(reference: object, document: Document) -> Model | None:
    """Return the model that a reference names, or None if the document does not have it."""
    if not isinstance(reference, dict) or reference.keys() != {"id"} or not isinstance(reference["id"], str):
        return None
    return document.models.get_by_id(reference["id"])


def _events_of(content: object) -> list | None:
    events = content.get("events") if isinstance(content, dict) else None
    return events if isinstance(events, list) else None


def valid_events(content: object, document: Document) -> tuple[list, int]:
    """Return the events of a patch that may be applied, and how many were removed.

    Parameters
    ----------
    content
        The patch, decoded from JSON.
    document
        The document of the session.
    """
    events = _events_of(content)
    if events is None:
        return [], 1
    valid = [event for event in events if _is_valid(event, document)]
    return valid, len(events) - len(valid)


def cost_of(content: object) -> int:
    """Return the cost of a patch: two, plus one for each event, or four for a message to a component of the page."""
    return 2 + sum(4 if _is_component_message(event) else 1 for event in _events_of(content) or ())


def _is_component_message(event: object) -> bool:
    data = event.get("msg_data") if isinstance(event, dict) else None
    return isinstance(data, dict) and data.get("name") == "data_event"


# What every browser reports of itself and nothing here reads: dropped without a log entry.
_UNUSED_REPORTS = (
    "dark_mode",
    "device_pixel_ratio",
    "language",
    "scroll_position",
    "timezone",
    "timezone_offset",
    "webdriver",
    "webgl",
)


def is_worth_logging(content: object) -> bool:
    """Return whether a patch holds more than what every browser reports of itself."""
    events = _events_of(content)
    return events is None or any(
        not (isinstance(e, dict) and e.get("kind") == "ModelChanged" and e.get("attr") in _UNUSED_REPORTS)
        for e in events
    )
