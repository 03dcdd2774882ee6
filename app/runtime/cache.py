"""A bounded cache in memory that all sessions of the process share."""

import threading
from collections import OrderedDict
from collections.abc import Callable


class Cache:
    """At most ``size`` values by key; the least recently used is dropped first. Safe between threads.

    Keys of different types are different, even if they are equal, as tuples with names are that hold the same.
    """

    def __init__(self, size: int) -> None:
        self._size = size
        self._values: OrderedDict[object, object] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: object):
        """Return the value stored under ``key``, or None."""
        key = type(key), key
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
            return self._values.get(key)

    def put(self, key: object, value: object) -> None:
        """Store ``value`` and drop the least recently used values beyond ``size``."""
        key = type(key), key
        with self._lock:
            self._values[key] = value
            self._values.move_to_end(key)
            while len(self._values) > self._size:
                self._values.popitem(last=False)

    def get_or(self, key: object, make: Callable[[], object]):
        """Return the value stored under ``key``; where there is none, what ``make`` returns, which is stored."""
        value = self.get(key)
        if value is None:
            value = make()
            self.put(key, value)
        return value

    def __len__(self) -> int:
        return len(self._values)
