"""The size limit of the cache folder: the least recently used studies are deleted first.

The engine deletes them after each study that it stores, and spares those that another process works on. The settings of
the server say how many megabytes may stay.
"""

from __future__ import annotations

import contextlib

from vibroscope.engine import cache_root
from vibroscope.engine.sweeps import cache


def limit_cache(megabytes: int) -> None:
    """Store no more than this from now on."""
    cache.BYTES_KEPT = megabytes * 1_000_000


def trim_cache() -> None:
    """Delete what exceeds the limit now; it may have been larger when the server last ran."""
    with contextlib.suppress(OSError):  # there is no folder yet
        cache.drop_oldest(cache_root() / "studies")
