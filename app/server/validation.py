"""What a browser may say over the websocket; all else is dropped before anything of it is applied.

Bokeh's protocol lets a client set any property of any model, replace the whole document, and send arrays. The page
needs next to none of that (this list was taken from a browser in use), so this is what passes:

- the request for the document, and the word that it is shown;
- messages of the page's own components (`app.page.session` reads them as text and decides), taps and new ranges;
- the ends of an axis range, the mute of a legend entry, the size of a frame, all plain finite values;
- that an error message was closed.

An event that is not of these kinds is taken out of its message; a message that is none at all is refused. So no forged
value reaches a model, the engine, or whoever else looks at the same session.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from bokeh.document import Document
from bokeh.model import DataModel, Model
from bokeh.models import GlyphRenderer, Plot, Range1d

_DEPTH = 4
_LONGEST_TEXT = 4000
_MOST_ENTRIES = 64


def plain(value: object, depth: int = _DEPTH) -> bool:
    """Whether a value is text, a finite number, a truth value, nothing, or a small map of such by name."""
    if value is None or isinstance(value, bool):
        return True
    if isinstance(value, str):
        return len(value) <= _LONGEST_TEXT
    if isinstance(value, int | float):
        return abs(value) < 1e300 if isinstance(value, int) else math.isfinite(value)
    return depth > 0 and _plain_map(value, depth)


def _plain_map(value: object, depth: int) -> bool:
    if value == {"type": "map"}:  # an empty one
        return True
    entries = value["entries"] if _map_by_name(value) else None
    return entries is not None and len(entries) <= _MOST_ENTRIES and all(plain(e[1], depth - 1) for e in entries)


def _pair(entry: object) -> bool:
    return isinstance(entry, list) and len(entry) == 2 and isinstance(entry[0], str)


def _map_by_name(value: object) -> bool:
    return (
        isinstance(value, dict)
        and value.keys() == {"type", "entries"}
        and value["type"] == "map"
        and isinstance(value["entries"], list)
        and all(map(_pair, value["entries"]))
    )


def _finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and plain(value)


def _truth(value: object) -> bool:
    return isinstance(value, bool)


def _length(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= 20_000


# (kind of model, attribute): what a value must be
_CHANGES: dict[tuple[type, str], Callable[[object], bool]] = {
    (Range1d, "start"): _finite,
    (Range1d, "end"): _finite,
    (GlyphRenderer, "muted"): _truth,
    (DataModel, "error"): lambda value: value == "",  # a message that the user has closed
    **{(Plot, f"{side}_{length}"): _length for side in ("inner", "outer") for length in ("width", "height")},
}


def _number(value: object) -> bool:
    return value is None or _finite(value)


# name of an event: kind of model that it is about, and what its fields must be
_EVENTS: dict[str, tuple[type, dict[str, Callable[[object], bool]]]] = {
    "data_event": (Model, {"data": plain}),
    "tap": (Plot, {**dict.fromkeys(("sx", "sy", "x", "y"), _number), "modifiers": plain}),
    "rangesupdate": (Plot, dict.fromkeys(("x0", "x1", "y0", "y1"), _number)),
}


def _passes(event: object, document: Document) -> bool:
    if not isinstance(event, dict):
        return False
    if event.get("kind") == "ModelChanged" and event.keys() == {"kind", "model", "attr", "new"}:
        return _change_passes(event, document)
    if event.get("kind") == "MessageSent" and event.keys() == {"kind", "msg_type", "msg_data"}:
        return event["msg_type"] == "bokeh_event" and _event_passes(event["msg_data"], document)
    return False


def _change_passes(event: dict, document: Document) -> bool:
    model = _model(event["model"], document)
    return any(
        isinstance(model, kind) and event["attr"] == attribute and good(event["new"])
        for (kind, attribute), good in _CHANGES.items()
    )


def _event_passes(data: object, document: Document) -> bool:
    if not isinstance(data, dict) or data.keys() != {"type", "name", "values"} or data["type"] != "event":
        return False
    values = data["values"]
    if data["name"] == "document_ready":
        return values in ({"type": "map"}, {"type": "map", "entries": []})
    if not isinstance(data["name"], str) or data["name"] not in _EVENTS or not _map_by_name(values):
        return False
    kind, fields = _EVENTS[data["name"]]
    told = dict(values["entries"])
    model = _model(told.pop("model", None), document)
    return isinstance(model, kind) and all(name in fields and fields[name](value) for name, value in told.items())


def _model(reference: object, document: Document):
    """The model that is meant, if the document has it."""
    if not isinstance(reference, dict) or reference.keys() != {"id"} or not isinstance(reference["id"], str):
        return None
    return document.models.get_by_id(reference["id"])


def sift(content: object, document: Document) -> tuple[list, int]:
    """The events of a patch that may be applied, and how many were taken out.

    Parameters
    ----------
    content
        The patch as JSON gave it.
    document
        The session's.
    """
    events = content.get("events") if isinstance(content, dict) else None
    if not isinstance(events, list):
        return [], 1
    passed = [event for event in events if _passes(event, document)]
    return passed, len(events) - len(passed)


def price(content: object) -> int:
    """What a patch costs its session: two, and one for each event, four where a component of the page is spoken to."""
    events = content.get("events") if isinstance(content, dict) else None
    return 2 + sum(4 if _spoken(event) else 1 for event in events) if isinstance(events, list) else 2


def _spoken(event: object) -> bool:
    data = event.get("msg_data") if isinstance(event, dict) else None
    return isinstance(data, dict) and data.get("name") == "data_event"


# What a browser reports of itself and nobody here asks for: dropped without a word.
_IDLE = (
    "dark_mode",
    "device_pixel_ratio",
    "language",
    "scroll_position",
    "timezone",
    "timezone_offset",
    "webdriver",
    "webgl",
)


def worth_a_word(content: object) -> bool:
    """Whether a patch holds more than what every browser reports of itself."""
    events = content.get("events") if isinstance(content, dict) else None
    return not isinstance(events, list) or any(
        not (isinstance(e, dict) and e.get("kind") == "ModelChanged" and e.get("attr") in _IDLE) for e in events
    )
