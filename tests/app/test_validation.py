"""Message validation: which events of a browser reach the document."""

import math

import pytest
from bokeh.document import Document
from bokeh.models import ColumnDataSource, Plot, Range1d
from hypothesis import given, settings
from hypothesis import strategies as st
from vibroscope.app.server.validation import cost_of, is_worth_logging, valid_events

from tests.browserless import changed, event, mapped
from tests.share import share

JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(["type", "entries", "id", "x"]), inner),
    max_leaves=12,
)


def document():
    doc, ends, source = Document(), Range1d(0, 1), ColumnDataSource({"x": [1.0]})
    doc.add_root(ends)
    doc.add_root(source)
    return doc, ends, source


@given(JSON)
@settings(max_examples=share(300))
def test_any_json_is_accepted_and_only_finite_numbers_pass(value):
    doc, ends, source = document()
    assert valid_events(value, doc)[0] == []
    assert valid_events({"events": [changed(source.id, "data", value)]}, doc)[0] == []
    passed, _ = valid_events({"events": [changed(ends.id, "start", value), value]}, doc)
    for change in passed:
        assert isinstance(change["new"], int | float)
        assert math.isfinite(change["new"])


def test_a_zoom_passes():
    doc, ends, _ = document()
    zoom = changed(ends.id, "start", 0.5)
    assert valid_events({"events": [zoom, changed(ends.id, "name", "x")]}, doc) == ([zoom], 1)


@pytest.mark.parametrize(("size", "passes"), [(0, True), (1440, True), (4.01, False), (-1, False), (10**9, False)])
def test_a_frame_has_a_whole_number_of_pixels(size, passes):
    doc, plot = Document(), Plot()
    doc.add_root(plot)
    change = changed(plot.id, "inner_width", size)
    assert valid_events({"events": [change]}, doc) == (([change], 0) if passes else ([], 1))


@pytest.mark.parametrize(
    ("name", "fields", "passes"),
    [
        ("tap", {"sx": 1, "sy": 2, "x": 0.5, "y": None, "modifiers": mapped({"shift": False})}, True),
        ("tap", {"x": "0.5"}, False),
        ("tap", {"z": 1}, False),
        ("rangesupdate", {"x0": 0, "x1": 1, "y0": 0, "y1": 1}, True),
        ("rangesupdate", {"x": 1}, False),
        ("data_event", {"data": mapped({"painted": 1})}, True),
        ("data_event", {"x": 1}, False),
        (["tap"], {}, False),
    ],
)
def test_an_event_may_hold_only_the_fields_of_its_kind(name, fields, passes):
    doc, plot = Document(), Plot()
    doc.add_root(plot)
    sent = event(name, mapped({"model": {"id": plot.id}, **fields}))
    assert valid_events({"events": [sent]}, doc) == (([sent], 0) if passes else ([], 1))


def test_a_tap_outside_a_plot_is_dropped():
    doc, ends, _ = document()
    assert valid_events({"events": [event("tap", mapped({"model": {"id": ends.id}, "x": 1}))]}, doc) == ([], 1)


def test_reports_of_a_browser_about_itself_are_not_logged():
    doc, ends, _ = document()
    idle = {"events": [changed(ends.id, "scroll_position", 120)]}
    assert valid_events(idle, doc) == ([], 1)
    assert not is_worth_logging(idle)
    assert is_worth_logging({"events": [*idle["events"], changed(ends.id, "name", "x")]})


def test_a_message_to_a_component_costs_more_than_another_event():
    message = {"events": [event("data_event", mapped({"data": 1})), *[changed("p1", "start", 0.5)] * 2]}
    assert (cost_of(message), cost_of({"events": []}), cost_of("nothing")) == (8, 2, 2)
