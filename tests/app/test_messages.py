"""Messages of the browser: each calls one method of the session; others are ignored."""

from unittest.mock import Mock, call

import pytest
from vibroscope.app.explorer.presets import scenes
from vibroscope.app.page.session import route


def calls(message):
    session = Mock(move=0)
    route(session, message)
    return session.method_calls


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        ({"set": {"eta": "1.2"}}, call.set({"eta": "1.2"})),
        ({"scene": "C"}, call.set(scenes()["C"].texts(), fresh=True)),
        ({"undo": True}, call.undo()),
        ({"redo": True}, call.redo()),
        ({"reset": True}, call.reset()),
        ({"pin": True}, call.pin(True)),
        ({"pin": 0}, call.pin(False)),
        ({"theme": "dark"}, call.choose_theme("dark")),
        ({"view": "help"}, call.open("help")),
        ({"take": "csv:force"}, call.take("csv:force")),
        ({"load": {"0": "x"}}, call.load({"0": "x"})),
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
        {"scene": "Z"},
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
        route(session, {"move": move, "undo": True})
    assert session.move == 7
