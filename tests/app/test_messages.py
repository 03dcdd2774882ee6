"""Messages of the browser: each calls one method of the session; others are ignored."""

from unittest.mock import Mock, call

import pytest
from vibroscope.app.page.session import acts_of
from vibroscope.app.page.shared.component import act_on


def calls(message):
    session = Mock(move=0)
    act_on(message, acts_of(session))
    return session.method_calls


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        ({"set": {"eta": "1.2"}}, call.set({"eta": "1.2"})),
        ({"scene": "C"}, call.choose("C")),
        ({"undo": True}, call.undo()),
        ({"redo": True}, call.redo()),
        ({"reset": True}, call.reset()),
        ({"pin": True}, call.pin(True)),
        ({"pin": 0}, call.pin(False)),
        ({"theme": "dark"}, call.choose_theme("dark")),
        ({"view": "help"}, call.open("help")),
        ({"take": "csv:force"}, call.take("csv:force")),
        ({"painted": 3}, call.painted(3)),
    ],
)
def test_a_message_calls_one_method(message, expected):
    assert calls(message) == [expected]


@pytest.mark.parametrize(
    "message",
    [
        None,
        "text",
        ["set"],
        {},
        {"set": ["eta"]},
        {"scene": 3},
        {"view": ["help"]},
        {"take": {"csv": 1}},
        {"theme": None},
        {"move": "x"},
        {"close": True},
    ],
)
def test_a_message_of_another_form_is_ignored(message):
    assert calls(message) == []


def test_the_number_of_a_move_is_noted():
    session = Mock(move=0)
    for move in (7, "x", None):
        act_on({"move": move, "undo": True}, acts_of(session))
    assert session.move == 7
