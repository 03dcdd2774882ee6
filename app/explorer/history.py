"""Undo and redo of the setting. No panel import."""

from __future__ import annotations

import math
from collections import deque

from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.explorer.state import Setting

# Moves of the same control within so many seconds count as one move, so that a drag is undone as a whole.
_SAME_MOVE = 0.8  # s


class History:
    """The settings before the present one, and those that were undone."""

    def __init__(self) -> None:
        self._past: deque[Setting] = deque(maxlen=200)
        self._undone: list[Setting] = []
        self._last_move: tuple[frozenset[str], float] = (frozenset(), -math.inf)

    @property
    def can_undo(self) -> bool:
        """Whether there is a setting to go back to."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone setting."""
        return bool(self._undone)

    def add(self, before: Setting, after: Setting, now: float) -> None:
        """Add the user's move from ``before`` to ``after`` at the time ``now`` (s)."""
        names = frozenset(name for name in FIELDS if getattr(before, name) != getattr(after, name))
        if not names:
            return
        last_names, last_time = self._last_move
        if not (self._past and names == last_names and now - last_time < _SAME_MOVE):
            self._past.append(before)
        self._last_move = names, now
        self._undone.clear()

    def undo(self, current: Setting) -> Setting | None:
        """The setting before the last move, or None."""
        return self._step(self._past, self._undone, current)

    def redo(self, current: Setting) -> Setting | None:
        """The setting that was undone last, or None."""
        return self._step(self._undone, self._past, current)

    def _step(self, source: deque | list, target: deque | list, current: Setting) -> Setting | None:
        self._last_move = frozenset(), -math.inf
        if not source:
            return None
        target.append(current)
        return source.pop()
