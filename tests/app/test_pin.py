"""What is pinned is solved once, drawn as the present setting draws, and told where it cannot be had."""

import pytest
from vibroscope.app.explorer.compute import frame_of
from vibroscope.app.explorer.state import Explorer
from vibroscope.app.page.explore import pin

SETTING = Explorer().setting()
PINNED = SETTING._replace(K=3000.0)


class Desk:
    doc = None

    def __init__(self):
        self.pinned, self.errors = PINNED, []

    def later(self, callback):
        callback()

    def tell(self, error):
        self.errors.append(error)


class Latest:
    """Stands for the threads: what is asked is kept, and answered when a test says so."""

    def __init__(self, deliver):
        self.deliver, self.asked, self.closed = deliver, [], False

    def submit(self, move, setting):
        self.asked.append(setting)

    def withdraw(self):
        pass

    def close(self):
        self.closed = True


@pytest.fixture
def pinned(monkeypatch):
    """A pin of which nothing is kept, and what it has drawn."""
    monkeypatch.setattr(pin, "Latest", Latest)
    monkeypatch.setattr(pin, "kept_frame", lambda _: None)
    drawn = []
    return pin.Pin(Desk(), drawn.append), drawn


def test_a_pin_is_solved_once_however_often_the_page_is_drawn(pinned):
    one, drawn = pinned
    for eta in (1.1, 1.2, 1.3):
        one.follow(SETTING._replace(eta=eta))
    assert one._latest.asked == [PINNED]
    one._latest.deliver(0, frame_of(PINNED))
    one.follow(SETTING)
    assert len(one._latest.asked) == len(drawn) == 1
    one.follow(SETTING._replace(frame="absolute"))  # drawn otherwise
    assert one._latest.asked == [PINNED, PINNED._replace(frame="absolute")]


def test_what_comes_after_it_was_unpinned_is_not_drawn(pinned):
    one, drawn = pinned
    one.follow(SETTING)
    one.desk.pinned = None
    one.follow(SETTING)
    one._latest.deliver(0, frame_of(PINNED))
    one._latest.deliver(0, ValueError("late"))
    assert drawn == [None]
    assert one.desk.errors == []


def test_a_pin_that_fails_is_told_and_not_tried_again(pinned):
    one, drawn = pinned
    one.follow(SETTING)
    one._latest.deliver(0, ValueError("out of memory"))
    one.follow(SETTING._replace(eta=2.0))
    assert drawn == [None]
    assert len(one._latest.asked) == 1
    assert "out of memory" in one.desk.errors[0]


def test_with_the_page_the_pin_is_withdrawn(pinned):
    one, _ = pinned
    one.close()
    assert one._latest.closed


def test_a_pin_that_is_kept_is_drawn_at_once(pinned, monkeypatch):
    one, drawn = pinned
    monkeypatch.setattr(pin, "kept_frame", frame_of)
    one.follow(SETTING)
    assert one._latest.asked == []
    assert len(drawn) == 1
