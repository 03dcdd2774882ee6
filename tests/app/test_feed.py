import numpy as np
import pytest
from vibroscope.app.page.shared.feed import Feed
from vibroscope.app.page.shared.figure import sources


class Wire(Feed):
    """A feed whose messages are kept."""

    def __init__(self):
        super().__init__()
        self.sent = []

    def _send_msg(self, data):
        self.sent.append(data)


@pytest.fixture
def wire():
    return Wire()


def column(*values):
    return np.array(values, np.float32)


def unpacked(message):
    """Columns by source and name, as `feed.js` takes them apart."""
    values, begin, found = np.frombuffer(message["values"], np.float32), 0, {}
    for source, name, length in message["names"]:
        found[source, name] = values[begin : begin + length].tolist()
        begin += length
    assert begin == len(values)
    return found


def test_until_the_browser_listens_bokeh_sends(wire):
    source = sources({"one": ("x", "y")})["one"]
    heard = []
    source.on_change("data", lambda attr, old, new: heard.append(new))
    wire.put(source, {"x": column(1, 2), "y": column(3, 4)})
    wire.send()
    assert len(heard) == 1
    assert wire.sent == []


def test_then_what_changed_goes_in_one_message_and_the_source_holds_it(wire):
    one, two = sources({"one": ("x", "y"), "two": ("z",)}).values()
    wire._heard(None)
    heard = []
    one.on_change("data", lambda attr, old, new: heard.append(new))
    wire.put(one, {"x": column(1, 2), "y": column(3, 4)})
    wire.put(two, {"z": column(5)})
    wire.send()
    wire.put(one, {"x": column(1, 2), "y": column(3, 9)})
    wire.send()
    wire.send()
    assert heard == []
    assert [unpacked(message) for message in wire.sent] == [
        {(one.id, "x"): [1, 2], (one.id, "y"): [3, 4], (two.id, "z"): [5]},
        {(one.id, "y"): [3, 9]},
    ]
    assert one.data["y"].tolist() == [3, 9]


def test_a_browser_that_listens_anew_gets_everything(wire):
    source = sources({"one": ("x",)})["one"]
    wire._heard(None)
    wire.put(source, {"x": column(1)})
    wire.send()
    wire._heard(None)
    assert unpacked(wire.sent[-1]) == {(source.id, "x"): [1]}
