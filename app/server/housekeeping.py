"""Regular clean-up by the server: the cache folder, and the memory that visitors leave.

The cache folder has a size limit; the least recently used studies are deleted first. The engine deletes them after each
study that it stores, and spares those that another process works on. The settings of the server say how many megabytes
may stay.
"""

import asyncio
import contextlib
import ctypes
import gc
import sys
import time
from collections.abc import Callable

from vibroscope.app.compat import leave_collections_out
from vibroscope.engine import cache_root
from vibroscope.engine.sweeps import cache

_QUIET_SECONDS = 1.0  # without a message of any browser, after which the next one is not likely to come at once
_EMPTY_SECONDS = 3.0  # without a visitor: a browser that loads the page again is back by then
# Objects that have survived, in units of Python's second generation; a session leaves about one unit, of up to 2 MB.
_DUE, _LATE = 20, 60
_NEVER = 1_000_000  # such units, after which Python makes a full collection of its own accord


def limit_cache(megabytes: int) -> None:
    """Store no more than this from now on."""
    cache.BYTES_KEPT = megabytes * 1_000_000


def trim_cache() -> None:
    """Delete what exceeds the limit now; it may have been larger when the server last ran."""
    with contextlib.suppress(OSError):  # there is no folder yet
        cache.drop_oldest(cache_root() / "studies")


def set_up_collection() -> None:
    """Leave out what is imported from collections, since it stays, and full collections to `GarbageCollection`."""
    leave_collections_out()
    gc.freeze()
    first, second, _ = gc.get_threshold()
    gc.set_threshold(first, second, _NEVER)


class GarbageCollection:
    """Full collections at moments when they delay nobody.

    A full collection visits all objects of all sessions and holds every thread up meanwhile, for 0.1 s with the
    sessions of forty visitors. Python would make one whenever a quarter more objects have survived, and Panel after the
    end of each session, while another visitor waits.

    Parameters
    ----------
    visitors : callable
        Number of visitors.
    quiet_seconds : callable
        Time since the last message of any browser.
    """

    def __init__(self, visitors: Callable[[], int], quiet_seconds: Callable[[], float]) -> None:
        self._visitors, self._quiet_seconds = visitors, quiet_seconds
        self._last_visitor: float | None = None  # time at which the last one was seen; None once that is tidied up

    async def run(self) -> None:
        """Look for such moments; never returns."""
        while True:
            await asyncio.sleep(0.5)
            if self.is_empty():
                self._last_visitor = None
                gc.collect()
                await asyncio.to_thread(return_free_memory)
            elif self.is_due():
                gc.collect()

    def is_due(self) -> bool:
        """Whether enough objects have survived, for a moment as quiet as this one."""
        survived = gc.get_count()[2]
        return survived >= _LATE or (survived >= _DUE and self._quiet_seconds() > _QUIET_SECONDS)

    def is_empty(self) -> bool:
        """Whether the last visitor has been gone for a while, and nothing has been tidied up since."""
        now = time.monotonic()
        if self._visitors():
            self._last_visitor = now
        return self._last_visitor is not None and now - self._last_visitor >= _EMPTY_SECONDS


def return_free_memory() -> None:
    """Give the system back what is free between allocations, where the C library can; else a peak stays for ever."""
    if sys.platform == "linux" and (trim := getattr(ctypes.CDLL(None), "malloc_trim", None)):
        trim(0)
