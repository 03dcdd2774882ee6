"""Axis ranges: they change little, keep the zoom of the user, and return to the data with a scene."""

import numpy as np
import pytest
from bokeh.document import Document
from vibroscope.app.page.shared.ranges import OwnedRange, extent, fitted_range


def column(low, high):
    return [np.linspace(low, high, 11)]


def test_small_changes_leave_the_range_alone():
    owned = OwnedRange(-1, 1)
    owned.follow(column(-0.8, 0.9))
    home = owned.home
    owned.follow(column(-0.78, 0.93))
    assert owned.home == home


def test_data_that_leave_the_range_or_hardly_fill_it_move_it():
    owned = OwnedRange(-1, 1)
    owned.follow(column(-3, 3))
    assert owned.home[0] < -3
    assert owned.home[1] > 3
    owned.follow(column(-0.5, 0.5))
    assert -0.7 < owned.home[0] < -0.5


@pytest.mark.parametrize("before", [(), (1.0, 2.2, 3.7), (4.4, 3.95), (20.0,), (0.0,)])
def test_the_range_does_not_depend_on_the_data_before(before):
    owned, linked = OwnedRange(-10, 10), OwnedRange(-10, 10)
    linked.follow(column(-3.8, 3.9), fresh=True)
    for top in before:
        owned.follow(column(-top, top))
    owned.follow(column(-3.8, 3.9))
    assert owned.home == linked.home
    owned.follow([np.empty(0)])
    assert owned.home == (-10, 10)


def test_the_data_fill_most_of_the_range():
    for span in np.geomspace(1e-9, 1e9, 200):
        low, high = fitted_range((0.3 * span, 1.3 * span))
        assert low < 0.3 * span < 1.3 * span < high
        assert span > 0.7 * (high - low)


def test_a_zoomed_range_stays_until_a_scene():
    owned = OwnedRange(-1, 1)
    owned.range.update(start=0.1, end=0.2)
    owned.follow(column(-5, 5))
    assert (owned.range.start, owned.range.end) == (0.1, 0.2)
    owned.follow(column(-5, 5), fresh=True)
    assert owned.range.end > 5


def test_the_ends_of_a_zoom_are_those_of_its_link():
    owned = OwnedRange(0.5, 4)
    owned.range.update(start=1.9097222222, end=3.3058333333)  # by a mouse
    assert owned.ends == (1.90972, 3.30583)
    owned.restore(1.23456789, 3.3)  # typed, or of a link
    assert owned.ends == (1.23456789, 3.3)
    owned.put(0.123456789, 4)
    owned.range.update(start=0.123456789, end=4)  # by the reset tool
    assert not owned.zoomed


def test_the_reset_tool_returns_to_where_the_page_would_be():
    owned = OwnedRange(-1, 1)
    owned.follow(column(-3, 3), fresh=True)
    assert (owned.range.reset_start, owned.range.reset_end) == owned.home


def test_the_reset_tool_of_a_zoomed_range_returns_to_the_data_too():
    owned = OwnedRange(-1, 1)
    owned.range.update(start=0.1, end=0.2)
    owned.follow(column(-5, 5))
    assert owned.zoomed
    assert owned.range.reset_end == owned.home[1] > 5


def test_the_zoom_of_a_link_outlives_the_first_data_but_no_scene():
    owned = OwnedRange(-1, 1)
    owned.restore(0.1, 0.2)
    owned.follow([np.empty(0)], fresh=True)  # nothing yet
    owned.follow(column(-5, 5), fresh=True)
    assert owned.ends == (0.1, 0.2)
    assert owned.home[1] > 5
    owned.follow(column(-5, 5), fresh=True)
    assert owned.ends == owned.home


def test_a_range_knows_where_it_stands_while_its_document_holds_its_events():
    owned = OwnedRange(-1, 1)
    document = Document()
    document.add_root(owned.range)
    document.hold("combine")
    owned.follow(column(-5, 5))
    assert not owned.zoomed
    owned.restore(0.1, 0.2)
    assert owned.zoomed
    document.unhold()
    assert owned.ends == (0.1, 0.2)


def test_a_range_calls_back_whenever_an_end_moves():
    owned, heard = OwnedRange(-1, 1), []
    owned.on_move = lambda: heard.append(owned.ends)
    owned.range.start = 0.5
    owned.put(-3, 3)
    owned.unzoom()
    assert heard == [(0.5, 1), (-3, 1), (-3, 3)]


def test_every_zoom_can_be_ended():
    owned = OwnedRange(-1, 1)
    for zoom in (owned.restore, lambda low, high: owned.range.update(start=low, end=high)):
        zoom(0.1, 0.2)
        owned.unzoom()
        assert owned.ends == owned.home == (-1, 1)


def test_nothing_to_show_leaves_the_range_alone():
    owned = OwnedRange(-1, 1)
    owned.follow([np.empty(0), np.array([np.nan])], fresh=True)
    assert owned.home == (-1, 1)
    assert extent([np.array([np.nan])]) is None


def test_constant_data_get_a_range_of_some_width():
    low, high = fitted_range((0.0, 0.0))
    assert low < 0 < high


def test_room_for_a_legend_is_kept_while_data_grow():
    owned = OwnedRange(0, 1, headroom=0.34)
    owned.follow(column(0, 10), fresh=True)
    for top in np.linspace(10, 14, 40):
        owned.follow(column(0, top))
        assert owned.home[1] >= 1.19 * top


def test_values_kept_in_view_hold_a_range_open_over_flat_data():
    owned = OwnedRange(-1, 1)
    owned.follow(column(0, 0), fresh=True, always=(0.0, 1.0))
    assert owned.home[0] < 0
    assert owned.home[1] > 1
