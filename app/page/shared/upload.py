"""A file that the browser sends in parts, a character for each byte (`upload.js`)."""

from __future__ import annotations

from collections.abc import Callable

from vibroscope.app.explorer.measured import LARGEST_FILE

LONGEST_NAME = 80


class Upload:
    """Puts the parts of a file together.

    Parameters
    ----------
    begin : callable
        Called with the name, as it may be shown, and the size in bytes; of a larger file than LARGEST_FILE nothing
        follows.
    take : callable
        Called with the content.
    """

    def __init__(self, begin: Callable[[str, float], None], take: Callable[[bytes], None]) -> None:
        self._begin, self._take = begin, take
        self._parts: list[str] = []

    def receive(self, message: object) -> None:
        """Act on a message from the browser as far as it is one of a file."""
        if not isinstance(message, dict):
            return
        if isinstance(file := message.get("file"), dict):
            self._parts.clear()
            name = "".join(c if c.isprintable() else "�" for c in str(file.get("name", "")))[:LONGEST_NAME]
            size = file.get("size")
            self._begin(name, size if isinstance(size, int | float) else 0)
        if isinstance(parts := message.get("part"), dict):
            self._parts += [text for text in parts.values() if isinstance(text, str)]
            if sum(map(len, self._parts)) > LARGEST_FILE:
                self._parts.clear()
        if "end" in message:
            content = "".join(self._parts).encode("latin-1", errors="replace")
            self._parts.clear()
            self._take(content)
