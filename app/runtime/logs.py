"""The log: one line per event with its time, level, name, session and further fields.

The rest of the app calls only ``event("computed", seconds=0.02)``. In text form that is::

    2026-01-31 12:00:00 INFO computed session=3f2a91cc seconds=0.020

A traceback stands in the line of its event, its own lines separated by bars.
With ``VIBROSCOPE_LOG_FORMAT=json`` it is one JSON object per line. A session appears as a digest, because its
identifier gives access to the session.
"""

import hashlib
import json
import logging
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

# The session that the current code works for: set where its messages arrive, read by all that they cause.
session: ContextVar[str] = ContextVar("session", default="")
_log = logging.getLogger("vibroscope")
_MOST_CHARACTERS = 10_000  # of a message or a traceback: Bokeh logs whatever a browser has sent


def session_name(session_id: str) -> str:
    """Return a short name of a session that does not disclose its identifier."""
    return hashlib.sha256(session_id.encode()).hexdigest()[:8]


@contextmanager
def in_session(name: str) -> Iterator[None]:
    """Attribute the events of this block to the session with this name."""
    token = session.set(name)
    try:
        yield
    finally:
        session.reset(token)


def event(what: str, level: int = logging.INFO, /, *, error: BaseException | None = None, **details: object) -> None:
    """Log an event; the name of the current session is added if there is one."""
    if session.get() and "session" not in details:
        details = {"session": session.get(), **details}
    _log.log(level, what, exc_info=error, extra={"details": details})


def configure(form: str = "text", level: str = "info") -> None:
    """Write everything that this process logs to the standard error stream, in one format."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(Json() if form == "json" else Text())
    handler.addFilter(is_not_a_closed_connection)
    logging.basicConfig(handlers=[handler], level=logging.WARNING, force=True)
    logging.captureWarnings(True)
    for name in ("bokeh", "panel"):  # these two install handlers of their own
        library = logging.getLogger(name)
        library.handlers.clear()
        library.propagate = True
        library.setLevel(logging.WARNING)
    _log.setLevel(level.upper())


def is_not_a_closed_connection(record: logging.LogRecord) -> bool:
    """Return False for the traceback of a write to a connection that the browser has closed.

    Tornado and Bokeh raise these exceptions whenever a browser leaves during an update. Bokeh ends the session by
    another way, so that nothing is lost but a message without a receiver.
    """
    kind = record.exc_info[0] if record.exc_info else None
    return kind is None or kind.__name__ not in ("WebSocketClosedError", "StreamClosedError")


def _fields(record: logging.LogRecord) -> dict[str, object]:
    return getattr(record, "details", {})


def _printable(value: object) -> object:
    """Return a value for one line of the log: text is cut and freed of unprintable characters."""
    if isinstance(value, float):
        return round(value, 6)
    if isinstance(value, int | bool) or value is None:
        return value
    return "".join(c if c.isprintable() else "�" for c in str(value)[:200])


def _shorten(text: str) -> str:
    """Return the text, or its beginning and end if it is too long."""
    half = _MOST_CHARACTERS // 2
    return text if len(text) <= _MOST_CHARACTERS else f"{text[:half]} … {text[-half:]}"


def _one_line(text: str) -> str:
    """The lines of a text in one, so that whoever reads a log line by line takes nothing for an event of its own."""
    return " | ".join(line.strip() for line in text.splitlines())


class Text(logging.Formatter):
    """Format for people: one line, with the traceback in it if there is one."""

    def format(self, record: logging.LogRecord) -> str:
        """See `logging.Formatter.format`."""
        created = time.strftime("%Y-%m-%d %H:%M:%S", time.gmtime(record.created))
        pairs = "".join(f" {name}={_printable(value)}" for name, value in _fields(record).items())
        line = f"{created} {record.levelname} {_shorten(_one_line(record.getMessage()))}{pairs}"
        return f"{line} | {_shorten(_one_line(self.formatException(record.exc_info)))}" if record.exc_info else line


class Json(logging.Formatter):
    """Format for programs: one JSON object per line."""

    def format(self, record: logging.LogRecord) -> str:
        """See `logging.Formatter.format`."""
        entry: dict[str, object] = {
            "time": time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(record.created)) + f".{int(record.msecs):03d}Z",
            "level": record.levelname.lower(),
            "logger": record.name,
            "event": _shorten(record.getMessage()),
        }
        entry |= {name: _printable(value) for name, value in _fields(record).items()}
        if record.exc_info:
            entry["traceback"] = _shorten(self.formatException(record.exc_info))
        return json.dumps(entry, ensure_ascii=False)
