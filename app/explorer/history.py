"""Undo and redo of what was set. No panel import."""

from __future__ import annotations

from collections import deque

from vibroscope.app.explorer.state import Setting

_REMEMBERED = 200
# Moves of the same controls that follow each other within so many seconds are one: a drag is undone as a whole.
_ONE_MOVE = 0.8


class History:
    """Settings that were left, and settings that were taken back."""

    def __init__(self) -> None:
        self._left: deque[Setting] = deque(maxlen=_REMEMBERED)
        self._taken_back: list[Setting] = []
        self._last: tuple[frozenset[str], float] = (frozenset(), -1e9)

    @property
    def can_undo(self) -> bool:
        """Whether there is anything to go back to."""
        return bool(self._left)

    @property
    def can_redo(self) -> bool:
        """Whether anything was taken back."""
        return bool(self._taken_back)

    def record(self, before: Setting, after: Setting, now: float) -> None:
        """The user went from ``before`` to ``after`` at the time ``now`` (seconds)."""
        names = frozenset(n for n in Setting._fields if getattr(before, n) != getattr(after, n))
        if not names:
            return
        same, at = self._last
        if not (self._left and names == same and now - at < _ONE_MOVE):
            self._left.append(before)
        self._last = names, now
        self._taken_back.clear()

    def undo(self, current: Setting) -> Setting | None:
        """The setting before the last move, or None."""
        return self._step(self._left, self._taken_back, current)

    def redo(self, current: Setting) -> Setting | None:
        """The setting that was last taken back, or None."""
        return self._step(self._taken_back, self._left, current)

    def _step(self, source, target, current: Setting) -> Setting | None:
        self._last = frozenset(), -1e9
        if not source:
            return None
        target.append(current)
        return source.pop()
