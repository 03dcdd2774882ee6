import numpy as np
import pytest
from vibroscope.app.page.explore.column_sender import ColumnSender
from vibroscope.app.page.shared.figure import empty_source


class Sender(ColumnSender):
    """Keeps its messages."""

    def __init__(self):
        super().__init__()
        self.sent = []

    def send_message(self, message):
        self.sent.append(message)


@pytest.fixture
def sender():
    return Sender()


def column(*values):
    return np.array(values, np.float32)


def unpacked(message):
    """Columns by source and name, as `column_sender.js` unpacks them."""
    values, begin, found = np.frombuffer(message["values"], np.float32), 0, {}
    for source, name, length in message["names"]:
        found[source, name] = values[begin : begin + length].tolist()
        begin += length
    assert begin == len(values)
    return found


def test_until_the_browser_listens_bokeh_sends(sender):
    source = empty_source("one", "x", "y")
    heard = []
    source.on_change("data", lambda attr, old, new: heard.append(new))
    sender.put(source, {"x": column(1, 2), "y": column(3, 4)})
    sender.send()
    assert len(heard) == 1
    assert sender.sent == []


def test_then_changed_columns_go_in_one_message_and_the_source_holds_them(sender):
    one, two = empty_source("one", "x", "y"), empty_source("two", "z")
    sender.start_listening()
    heard = []
    one.on_change("data", lambda attr, old, new: heard.append(new))
    sender.put(one, {"x": column(1, 2), "y": column(3, 4)})
    sender.put(two, {"z": column(5)})
    sender.send()
    sender.put(one, {"x": column(1, 2), "y": column(3, 9)})
    sender.send()
    sender.send()
    assert heard == []
    assert [unpacked(message) for message in sender.sent] == [
        {(one.id, "x"): [1, 2], (one.id, "y"): [3, 4], (two.id, "z"): [5]},
        {(one.id, "y"): [3, 9]},
    ]
    assert one.data["y"].tolist() == [3, 9]


def test_a_browser_that_listens_again_gets_all_columns(sender):
    source = empty_source("one", "x")
    sender.start_listening()
    sender.put(source, {"x": column(1)})
    sender.send()
    sender.start_listening()
    assert unpacked(sender.sent[-1]) == {(source.id, "x"): [1]}
