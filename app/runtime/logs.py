"""One line per event: when, how grave, what, which session, how long, and what else there is to know.

``event("computed", seconds=0.02)`` is all that the rest calls. As text::

    2026-01-31 12:00:00 INFO computed session=3f2a91cc seconds=0.020

or, where ``VIBROSCOPE_LOG_FORMAT=json``, the same as one JSON object a line. A session is named by a digest: its
identifier lets whoever reads it into the session.
"""

from __future__ import annotations

import hashlib
import json
import logging
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

# The session at hand: set where its messages come in, read by whatever they lead to.
session: ContextVar[str] = ContextVar("session", default="")
_log = logging.getLogger("vibroscope")
_LONGEST = 10_000  # characters of a message or a traceback: Bokeh logs whatever a browser has sent


def name_of(session_id: str) -> str:
    """A short name of a session that gives nothing away."""
    return hashlib.sha256(session_id.encode()).hexdigest()[:8]


@contextmanager
def named(name: str) -> Iterator[None]:
    """What is logged in here is of the session of this name."""
    token = session.set(name)
    try:
        yield
    finally:
        session.reset(token)


def event(what: str, level: int = logging.INFO, /, *, error: BaseException | None = None, **details: object) -> None:
    """Log that something happened; ``session`` is added where one is at hand."""
    if session.get() and "session" not in details:
        details = {"session": session.get(), **details}
    _log.log(level, what, exc_info=error, extra={"details": details})


def configure(form: str = "text", level: str = "info") -> None:
    """Send everything that this process logs to the standard error stream, in one form."""
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(Json() if form == "json" else Text())
    handler.addFilter(left_in_the_middle)
    logging.basicConfig(handlers=[handler], level=logging.WARNING, force=True)
    logging.captureWarnings(True)
    for name in ("bokeh", "panel"):  # these come with handlers of their own
        library = logging.getLogger(name)
        library.handlers.clear()
        library.propagate = True
        library.setLevel(logging.WARNING)
    _log.setLevel(level.upper())


def left_in_the_middle(record: logging.LogRecord) -> bool:
    """False for the traceback that a library leaves when a browser goes while it is being written to.

    Tornado and Bokeh raise this one exception from a write to a websocket that is closed; Bokeh tells its session so by
    another way, and nothing is lost but a message to nobody.
    """
    kind = record.exc_info[0] if record.exc_info else None
    return kind is None or kind.__name__ not in ("WebSocketClosedError", "StreamClosedError")


def _fields(record: logging.LogRecord) -> dict[str, object]:
    return getattr(record, "details", {})


def _plain(value: object) -> object:
    """A value that is one line and printable, whatever came from outside."""
    if isinstance(value, float):
        return round(value, 6)
    if isinstance(value, int | bool) or value is None:
        return value
    return "".join(c if c.isprintable() else "�" for c in str(value)[:200])


def _bounded(text: str) -> str:
    """Beginning and end of a text that is too long."""
    half = _LONGEST // 2
    return text if len(text) <= _LONGEST else f"{text[:half]} … {text[-half:]}"


class Text(logging.Formatter):
    """For people."""

    def format(self, record: logging.LogRecord) -> str:
        """One line, and below it the traceback where there is one."""
        begun = time.strftime("%Y-%m-%d %H:%M:%S", time.gmtime(record.created))
        pairs = "".join(f" {name}={_plain(value)}" for name, value in _fields(record).items())
        line = f"{begun} {record.levelname} {_bounded(record.getMessage())}{pairs}"
        return f"{line}\n{_bounded(self.formatException(record.exc_info))}" if record.exc_info else line


class Json(logging.Formatter):
    """For machines: nothing but JSON, one object a line."""

    def format(self, record: logging.LogRecord) -> str:
        """One object."""
        told: dict[str, object] = {
            "time": time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(record.created)) + f".{int(record.msecs):03d}Z",
            "level": record.levelname.lower(),
            "logger": record.name,
            "event": _bounded(record.getMessage()),
        }
        told |= {name: _plain(value) for name, value in _fields(record).items()}
        if record.exc_info:
            told["traceback"] = _bounded(self.formatException(record.exc_info))
        return json.dumps(told, ensure_ascii=False)
