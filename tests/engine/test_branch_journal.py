"""A search for branches keeps what it has followed, and takes it up again to the last bit."""

from itertools import islice

import numpy as np
import pytest
from vibroscope.engine import BranchQuestion, ExactPenalty, Reference, System, search_branches
from vibroscope.engine.continuation import search

from tests.few_seeds import few_seeds

# each with a period doubling, so that a second branch begins where the first one is kept
CASES = [(Reference(), (2.76, 2.81)), (ExactPenalty(12_000.0, 18.0), (2.76, 2.8))]


@pytest.fixture(autouse=True)
def _few_seeds():
    with few_seeds():
        yield


@pytest.fixture
def followed(monkeypatch):
    """The values at which branches begin to be followed."""
    starts = []

    class Counted(search.BranchTracer):
        def __init__(self, curve, start, *how):
            starts.append(start.value)
            super().__init__(curve, start, *how)

    monkeypatch.setattr(search, "BranchTracer", Counted)
    return starts


def found(method, reach, **how):
    return search_branches(BranchQuestion(System(), 2.76, method, low=reach[0], high=reach[1], max_period=2), **how)


def assert_same(first, second):
    assert len(first) == len(second)
    for one, other in zip(first, second, strict=True):
        assert (one.ends, one.sequences) == (other.ends, other.sequences)
        for name in ("values", "sections", "multipliers"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        assert [(p.kind, p.value, p.index) for p in one.points] == [(p.kind, p.value, p.index) for p in other.points]


@pytest.mark.parametrize(("method", "reach"), CASES, ids=["reference", "exact"])
def test_a_search_that_was_left_goes_on_where_it_was_with_the_same_bits(tmp_path, followed, method, reach):
    whole = tuple(found(method, reach))
    traces = len(followed)
    followed.clear()
    assert len(tuple(islice(found(method, reach, keep=tmp_path), len(whole) - 1))) == len(whole) - 1
    before = len(followed)
    assert 0 < before < traces
    assert_same(tuple(found(method, reach, keep=tmp_path)), whole)
    assert len(followed) == traces  # each once
    assert_same(tuple(found(method, reach, keep=tmp_path)), whole)
    assert len(followed) == traces


def test_a_damaged_trace_is_followed_again(tmp_path, followed):
    method, reach = CASES[0]
    whole = tuple(found(method, reach, keep=tmp_path))
    traces = len(followed)
    damaged = tmp_path / "trace-1.json"
    damaged.write_bytes(damaged.read_bytes()[:-100])
    assert_same(tuple(found(method, reach, keep=tmp_path)), whole)
    assert len(followed) == traces + 1


def test_another_search_is_refused(tmp_path):
    method, reach = CASES[0]
    next(found(method, reach, keep=tmp_path))
    with pytest.raises(ValueError, match="holds another search"):
        next(found(method, (2.76, 2.82), keep=tmp_path))
    with pytest.raises(ValueError, match="holds another search"):
        next(found(Reference(threshold=0.001), reach, keep=tmp_path))
