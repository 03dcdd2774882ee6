"""What was found is kept for whoever asks for it again: a bounded memory that all sessions share."""

from __future__ import annotations

import threading
from collections import OrderedDict


class Cache:
    """Values by key, at most ``size`` of them, the least recently used dropped first; safe between threads."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._kept: OrderedDict[object, object] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: object):
        """What is kept under ``key``, or None."""
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
            return self._kept.get(key)

    def put(self, key: object, value: object) -> None:
        """Keep ``value``, dropping the one that was not asked for the longest."""
        with self._lock:
            self._kept[key] = value
            self._kept.move_to_end(key)
            while len(self._kept) > self._size:
                self._kept.popitem(last=False)

    def __len__(self) -> int:
        return len(self._kept)
