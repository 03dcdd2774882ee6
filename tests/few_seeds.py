"""Searches for branches that begin with few runs: for tests of what becomes of branches, not of what is found."""

from contextlib import contextmanager

import pytest
from vibroscope.engine.continuation import search


@contextmanager
def few_seeds():
    """Within it a search makes some thirty runs, not two thousand."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search, "SEEDS", 5)
        patch.setattr(search, "STARTS_AT_EACH", 2)
        patch.setattr(search, "FINE_SEEDS", 10)
        yield
