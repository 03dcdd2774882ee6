"""Full collections of garbage: when the last visitor has gone, in quiet moments, and late where there are none."""

import asyncio
import ctypes
import gc
import os
import platform
import weakref
from pathlib import Path

import pytest
from vibroscope.app.server import housekeeping
from vibroscope.app.server.housekeeping import GarbageCollection


@pytest.fixture
def looks(monkeypatch):
    """Runs a collection through looks a second apart; returns those, counted from 0, at which it collected, and how.

    Each look is (visitors, objects that survived, seconds since the last message).
    """

    def run(seen, collect=lambda: None):
        look, what = [-1], []

        async def sleep(_):
            await asyncio.to_thread(lambda: None)
            look[0] += 1
            if look[0] == len(seen):
                raise asyncio.CancelledError

        def collected():
            what.append(look[0])
            collect()

        monkeypatch.setattr(housekeeping.asyncio, "sleep", sleep)
        monkeypatch.setattr(housekeeping.time, "monotonic", lambda: float(look[0]))
        monkeypatch.setattr(housekeeping.gc, "get_count", lambda: (0, 0, seen[look[0]][1]))
        monkeypatch.setattr(housekeeping.gc, "collect", collected)
        monkeypatch.setattr(housekeeping, "return_free_memory", lambda: what.append("returned"))
        with pytest.raises(asyncio.CancelledError):
            asyncio.run(GarbageCollection(lambda: seen[look[0]][0], lambda: seen[look[0]][2]).run())
        return what

    return run


@pytest.mark.parametrize(
    ("visitors", "collected"),
    [
        ([0] * 8, []),  # nobody has been there
        ([2, 1, 0, 0, 0, 0, 0, 0], [4, "returned"]),
        ([1, 0, 0, 1, 0, 0, 0, 0, 0, 0], [6, "returned"]),  # came back before
        ([1, 0, 0, 0, 1, 0, 0, 0], [3, "returned", 7, "returned"]),
    ],
)
def test_memory_is_freed_once_after_the_last_visitor_has_gone(visitors, collected, looks):
    assert looks([(number, 0, 9.0) for number in visitors]) == collected


@pytest.mark.parametrize(
    ("survived", "quiet", "collected"),
    [(19, 9.0, []), (20, 9.0, [0]), (20, 0.9, []), (59, 0.0, []), (60, 0.0, [0])],
)
def test_while_somebody_is_there_it_is_done_in_a_quiet_moment_or_late(survived, quiet, collected, looks):
    assert looks([(1, survived, quiet)]) == collected


def test_neither_python_nor_panel_makes_a_full_collection(monkeypatch):
    thresholds, frozen = [], []
    monkeypatch.setattr(housekeeping, "leave_collections_out", lambda: frozen.append("Panel"))
    monkeypatch.setattr(housekeeping.gc, "set_threshold", lambda *units: thresholds.append(units))
    monkeypatch.setattr(housekeeping.gc, "freeze", lambda: frozen.append("imported"))
    housekeeping.set_up_collection()
    ((first, second, third),) = thresholds
    assert (first, second) == gc.get_threshold()[:2]
    assert third > 1000 * 60  # the latest that is tried above
    assert frozen == ["Panel", "imported"]


def test_what_refers_to_itself_is_collected(looks):
    class Session:
        pass

    session, collect = Session(), gc.collect
    session.itself, gone = session, weakref.ref(session)
    del session
    looks([(1, 0, 9.0)] * 2 + [(0, 0, 9.0)] * 4, collect)
    assert gone() is None


def resident():
    """Bytes of this process in memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other C libraries keep no free memory, or cannot trim")
def test_free_memory_goes_back_to_the_system():
    library = ctypes.CDLL(None)
    library.malloc.restype, library.malloc.argtypes = ctypes.c_void_p, [ctypes.c_size_t]
    library.free.argtypes = [ctypes.c_void_p]
    blocks = [library.malloc(4096) for _ in range(10_000)]
    for block in blocks:
        ctypes.memset(block, 1, 4096)
    for block in blocks[:-1]:  # the last one keeps the others from being returned by themselves
        library.free(block)
    held = resident()
    housekeeping.return_free_memory()
    assert resident() < held - 20e6
    library.free(blocks[-1])
