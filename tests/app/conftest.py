"""Fixtures of several files."""

import queue
import threading
from contextlib import suppress

import pytest
from vibroscope.app.explorer import suggestion
from vibroscope.app.runtime.cache import Cache
from vibroscope.engine import Cancelled


@pytest.fixture(scope="session")
def server(plain_server):
    """A server as it is by default, for all tests that leave it as it is."""
    return plain_server


@pytest.fixture
def searches(monkeypatch):
    """`recommend` replaced by one that waits for its answer, at most until the test ends; what it was called with."""
    calls, ended = queue.Queue(), threading.Event()

    def recommend(question, *, cancelled, progress, **asked):
        answer = queue.Queue()
        calls.put((question, asked, progress, answer, cancelled))
        while not (cancelled() or ended.is_set()):
            with suppress(queue.Empty):
                return answer.get(timeout=0.01)
        raise Cancelled

    monkeypatch.setattr(suggestion, "recommend", recommend)
    monkeypatch.setattr(suggestion, "CACHE", Cache(2))
    yield calls
    ended.set()
