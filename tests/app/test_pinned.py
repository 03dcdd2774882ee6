"""A pinned setting is computed once, drawn like the present one, and an error is shown where that fails."""

import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.explore.pinned import PinnedResult

from .fakes import FakeHost

SETTING = Setting()
PINNED = SETTING._replace(K=3000.0)


class Queue:
    """Stands for the worker threads: keeps what is requested, and a test delivers."""

    def __init__(self, deliver):
        self.deliver, self.requested, self.closed = deliver, [], False

    def submit(self, move, setting):
        self.requested.append(setting)

    def withdraw(self):
        pass

    def close(self):
        self.closed = True


class Case:
    """A pinned result, its queue, and the columns that it has drawn."""

    def __init__(self, cached=lambda _: None):
        self.host, self.drawn = FakeHost(PINNED), []
        self.pinned = PinnedResult(self.host, self.drawn.append, self.make_queue, cached)

    def make_queue(self, deliver):
        self.queue = Queue(deliver)
        return self.queue


@pytest.fixture
def case():
    return Case()


def test_a_pinned_setting_is_computed_once_however_often_the_page_is_drawn(case):
    for eta in (1.1, 1.2, 1.3):
        case.pinned.follow(SETTING._replace(eta=eta))
    assert case.queue.requested == [PINNED]
    case.queue.deliver(0, compute_runs(PINNED))
    case.pinned.follow(SETTING)
    assert len(case.queue.requested) == len(case.drawn) == 1
    case.pinned.follow(SETTING._replace(frame="absolute"))
    assert case.queue.requested == [PINNED, PINNED._replace(frame="absolute")]


def test_a_result_that_comes_after_it_was_unpinned_is_not_drawn(case):
    case.pinned.follow(SETTING)
    case.host.pinned = None
    case.pinned.follow(SETTING)
    case.queue.deliver(0, compute_runs(PINNED))
    case.queue.deliver(0, ValueError("late"))
    assert case.drawn == [None]
    assert case.host.errors == []


def test_a_failure_is_shown_and_not_tried_again(case):
    case.pinned.follow(SETTING)
    case.queue.deliver(0, ValueError("out of memory"))
    case.pinned.follow(SETTING._replace(eta=2.0))
    assert case.drawn == [None]
    assert len(case.queue.requested) == 1
    assert "out of memory" in case.host.errors[0]


def test_its_computation_ends_with_the_page(case):
    case.pinned.close()
    assert case.queue.closed


def test_a_cached_result_is_drawn_at_once():
    case = Case(compute_runs)
    case.pinned.follow(SETTING)
    assert case.queue.requested == []
    assert len(case.drawn) == 1
