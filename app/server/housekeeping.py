"""The cache folder, kept within its bound: sweeps that were not used for the longest go first.

The engine drops them, after each study that it keeps, and knows which of them another process is at work on; how many
megabytes may stay is for whoever serves to say.
"""

from __future__ import annotations

import contextlib

from vibroscope.engine import cache_root
from vibroscope.engine.sweeps import cache


def bound_cache(megabytes: int) -> None:
    """Keep no more than this from now on."""
    cache.BYTES_KEPT = megabytes * 1_000_000


def drop_oldest() -> None:
    """Drop now what is beyond the bound; it may have been larger when the server ran last."""
    with contextlib.suppress(OSError):  # there is none yet
        cache.drop_oldest(cache_root() / "studies")
