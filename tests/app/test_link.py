"""The setting and the view of a tab come back from the address, whole or not at all."""

from urllib.parse import urlencode

import numpy as np
import panel as pn
import pytest
from bokeh.document import Document
from hypothesis import given
from hypothesis import strategies as st
from panel.io.state import set_curdoc
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.link import (
    LINEAR,
    LOGARITHMIC,
    ViewChoice,
    print_address,
    print_choice,
    print_mute,
    print_zoom,
    read_view,
    rounded_span,
)
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.address import THEMES, Address, read_opening
from vibroscope.app.page.session import Session
from vibroscope.app.page.tab import Move
from vibroscope.app.page.tabs import VIEWS

from tests.app.fakes import Asked, FakeHost
from tests.app.settings_strategy import settings
from tests.app.test_study_tab import opened  # noqa: F401 - a fixture

SETTING = Setting()
AXES = {"time": LINEAR, "x1": LINEAR, "K": LOGARITHMIC}
CHOICES = (
    ViewChoice("quantity", "Colour", "period", {"period": "period", "error": "error"}),
    ViewChoice("limit", "Limit", 30, bounds=(2, 200)),
)
LEGENDS = {"phase1": ("reference", "penalty", "pinned"), "force": ("reference", "penalty")}
spans = st.tuples(st.floats(*LINEAR), st.floats(*LINEAR)) | st.tuples(st.floats(), st.floats())
zooms = st.dictionaries(st.sampled_from(list(AXES)), spans)
choices = st.fixed_dictionaries(
    {}, optional={"quantity": st.sampled_from(["period", "error"]), "limit": st.integers(2, 200)}
)


def mutes(legends):
    """Some entries of some legends."""
    some = {name: st.lists(st.sampled_from(entries), min_size=1, unique=True) for name, entries in legends.items()}
    return st.fixed_dictionaries({}, optional=some)


@given(spans)
def test_rounded_ends_are_more_precise_than_a_pixel_of_a_linear_and_of_a_logarithmic_axis(span):
    low, high = rounded_span(span)
    width = span[1] - span[0]
    if not 0 < width < np.inf:  # an axis of which one end has moved, and the other not yet
        assert repr((low, high)) == repr(span)
        return
    for end, exact in zip((low, high), span, strict=True):
        assert abs(end - exact) <= 1e-5 * max(min(abs(exact), width), 1e-30)


@given(settings, settings, st.sampled_from(list(VIEWS)), st.sampled_from(["", *THEMES]), st.data())
def test_an_address_restores_setting_tab_view_pin_and_theme(setting, pinned, tab, theme, data):
    axes, usual = VIEWS[tab].axes, VIEWS[tab].chosen
    zoom = data.draw(st.dictionaries(st.sampled_from(list(axes)), spans)) if axes else {}
    choice = {"quantity": "period", "limit": 40} if tab == "plane" else usual
    choice = {name: value for name, value in choice.items() if value is not None}  # an empty field is no choice
    mute = data.draw(mutes(VIEWS[tab].legends))
    view = {"zoom": print_zoom(zoom, axes), "choice": print_choice(choice), "mute": print_mute(mute)}
    asked = read_opening("?" + print_address(setting, tab, [pinned], **view, theme=theme))
    assert (asked.setting, asked.view, asked.pinned, asked.theme) == (setting, tab, (pinned,), theme)
    assert (asked.state.choice, asked.state.mute) == (choice, mute)
    assert asked.state.zoom.keys() <= zoom.keys()


def test_a_printed_view_is_short():
    zoom = {"time": (0.2, 0.7000000001), "K": (100.0, 1234.5678901)}
    assert print_zoom({name: rounded_span(span) for name, span in zoom.items()}, AXES) == "time:0.2,0.7;K:100,1234.57"
    assert print_address(SETTING, zoom="time:0.2,0.7;x1:-1,2").endswith("&zoom=time:0.2,0.7;x1:-1,2")


NAMES = ["time", "K", "eta", "quantity", "limit", "force", "speed", "penalty", "fixed"]
parts = st.sampled_from([*NAMES, ":", ";", ",", "1", "-2.5", "1e999", "nan", "error"])


@given(st.sampled_from(list(VIEWS)), *4 * [st.text(max_size=60) | st.lists(parts).map("".join)])
def test_every_text_is_read_or_refused(tab, zoom, choice, mute, theme):
    try:
        asked = read_opening(
            "?" + urlencode({"view": tab, "zoom": zoom, "choice": choice, "mute": mute, "theme": theme})
        )
    except Refused:
        return
    for name, (low, high) in asked.state.zoom.items():
        assert VIEWS[tab].axes[name][0] <= low < high <= VIEWS[tab].axes[name][1]
    assert asked.state.choice.keys() <= VIEWS[tab].chosen.keys()
    assert all(set(names) <= set(VIEWS[tab].legends[figure]) for figure, names in asked.state.mute.items())
    assert asked.theme in ("", *THEMES)


@pytest.mark.parametrize(
    ("zoom", "word"),
    [
        ("time", "two numbers"),
        ("time:", "two numbers"),
        ("time:1", "two numbers"),
        ("time:1,2,3", "two numbers"),
        ("time:0.7,0.2", "from a smaller to a larger"),
        ("time:1,1", "from a smaller to a larger"),
        ("time:1,1.0000000000001", "from a smaller to a larger"),
        ("time:nan,1", "must be a number"),
        ("time:0,inf", "must be a number"),
        ("time:-1e13,1", "must be a number"),
        ("time:0,1e999", "must be a number"),
        ("K:-1,10", "must be a number"),
        ("K:0,10", "must be a number"),
        ("time:0,1;time:0,2", "twice"),
        ("time:0,1;", "one of time, x1, K"),
        ("nonsense:0,1", "one of time, x1, K"),
        ("time:0,1;x1:²,3", "must be a number"),
    ],
)
def test_a_zoom_that_makes_no_sense_is_refused_in_words(zoom, word):
    with pytest.raises(Refused, match=word):
        read_view(zoom, "", "", AXES, CHOICES, LEGENDS)


@pytest.mark.parametrize(
    "choice", ["quantity:__class__", "quantity", "limit:1", "limit:30.5", "limit:nan", "x:1", "limit:3;limit:4"]
)
def test_a_choice_that_is_not_offered_is_refused(choice):
    with pytest.raises(Refused):
        read_view("", choice, "", AXES, CHOICES, LEGENDS)


@pytest.mark.parametrize(
    ("mute", "word"),
    [
        ("force", "reference, penalty, not “”"),
        ("force:", "reference, penalty, not “”"),
        ("force:pinned", "reference, penalty, not “pinned”"),
        ("force:penalty,", "not “”"),
        ("force:penalty,penalty", "twice"),
        ("force:penalty;force:reference", "twice"),
        ("strip:penalty", "one of phase1, force"),
        ("force:__class__", "not “__class__”"),
    ],
)
def test_an_unknown_legend_entry_is_refused_in_words(mute, word):
    with pytest.raises(Refused, match=word):
        read_view("", "", mute, AXES, CHOICES, LEGENDS)


@pytest.mark.parametrize("theme", ["auto", "Dark", "dark ", "0", "²"])
def test_an_unknown_theme_is_refused_in_words(theme):
    with pytest.raises(Refused, match="theme must be light or dark, not"):
        read_opening("?" + urlencode({"theme": theme}))


def test_a_tab_without_axes_and_legends_says_so():
    with pytest.raises(Refused, match="it has none"):
        VIEWS["help"].read_view("time:0,1", "", "")
    with pytest.raises(Refused, match="it has none"):
        VIEWS["help"].read_view("", "", "force:penalty")


@pytest.mark.parametrize("tab", [tab for tab in VIEWS.values() if tab.axes])
def test_every_axis_of_a_tab_is_there_and_is_the_axis_of_a_figure(tab):
    made = tab(FakeHost())
    page = made.build()
    assert set(made.ranges) == set(tab.axes)
    figures = [pane.object for pane in page.objects if hasattr(pane, "object") and hasattr(pane.object, "x_range")]
    shown = [r for plot in figures for r in (plot.x_range, plot.y_range, *plot.extra_y_ranges.values())]
    assert all(any(owned.range is r for r in shown) for owned in made.ranges.values())


def test_the_first_question_of_a_study_is_that_of_the_link(opened):  # noqa: F811
    kind = VIEWS["plane"]
    tab = kind(FakeHost())
    tab.build()
    tab.restore(kind.read_view("K:100,1000", "quantity:period;limit:40", ""))
    tab.show(Move(1, SETTING))
    assert Asked.all[-1].question.K == (100.0, 1000.0)
    assert not Asked.all[-1].question.errors
    assert tab.view_texts() == {"zoom": "K:100,1000", "choice": "quantity:period;limit:40", "mute": ""}
    tab.show(Move(2, SETTING, fresh=True))  # a scene was chosen
    assert Asked.all[-1].question.K == (10.0, 1e5)
    assert tab.view_texts() == {"zoom": "", "choice": "quantity:period;limit:40", "mute": ""}


@pytest.mark.parametrize("key", ["bifurcation", "plane", "basin"])
def test_a_zoom_by_mouse_asks_the_question_of_its_link(opened, key):  # noqa: F811
    kind = VIEWS[key]
    tabs = [kind(FakeHost()), kind(FakeHost())]
    for tab in tabs:
        tab.build()
    tabs[0].show(Move(1, SETTING))
    for owned in tabs[0].ranges.values():
        low, high = owned.ends
        owned.range.update(start=low + 0.4027770856 * (high - low), end=low + 0.8016658478 * (high - low))
    tabs[1].restore(kind.read_view(**tabs[0].view_texts()))
    for tab in tabs:
        tab.show(Move(2, SETTING))
    first, second = (tab.question(SETTING) for tab in tabs)
    assert first == second != Asked.all[0].question


@pytest.mark.parametrize(
    ("link", "words"),
    [
        ("bodies=wall&kappa=2", "bodies=wall and kappa: a wall has no such number, it has no effect"),
        ("bodies=wall&mass_ratio=3&force2=1", "and mass_ratio, force2: a wall has no such number, they have no effect"),
        ("bodies=two&kappa3=2", "and kappa3: the mass ratio is given instead, it has no effect"),
        ("mass_ratio=3", "bodies=pendulums and mass_ratio: the mass ratio follows from kappa and kappa3"),
        ("clearance2=3", "stops=one and clearance2: there is no second stop, it has no effect"),
    ],
)
def test_a_number_of_a_link_that_the_bodies_do_not_have_is_named(link, words):
    opening = read_opening(link)
    assert words in opening.note
    with set_curdoc(Document()):
        assert Session(link).header.note == opening.note


def test_the_links_of_a_page_that_went_from_two_bodies_to_a_wall_keep_working():
    setting = read_setting({"bodies": "wall"}, read_setting({"bodies": "two", "mass_ratio": "3", "clearance": "0.5"}))
    opening = read_opening(print_address(setting))
    assert opening.setting == setting
    assert "mass_ratio" in opening.note
    assert not read_opening("bodies=wall&clearance=0.5&force1=1").note


def test_the_phase_that_the_pendulums_are_held_at_goes_into_the_link_and_comes_back():
    kind, heard = VIEWS["explore"], []
    tab, again = kind(FakeHost()), kind(FakeHost())
    tab.build()
    tab.watch_view(lambda: heard.append(tab.view_texts()["choice"]))
    for message in (
        {"held": 0.3514},
        {"held": None},
        {"held": 0},
        {"held": "0.5"},
        {"held": 9},
        {"held": True},
        "held",
    ):
        tab.mechanism.receive(message)
    assert heard == ["phase:0.351", "", "phase:0"]
    again.build()
    again.restore(kind.read_view("", "phase:0.351", ""))
    assert again.mechanism.held == 0.351
    with pytest.raises(Refused, match="phase must be"):
        kind.read_view("", "phase:600", "")


@pytest.mark.parametrize("key", VIEWS)
def test_every_entry_of_a_legend_has_a_name_in_links(key):
    tab = VIEWS[key](FakeHost())
    plots = {pane.object for pane in tab.build().select(pn.pane.Bokeh)}
    for plot in plots:
        for legend in plot.legend:
            assert len(legend.items) <= len(tab.legends[plot.name])
    assert plots or not tab.legends or key == "paper"  # whose figures come with its claims


def test_a_refused_link_stays_in_the_address_until_the_view_is_changed():
    address, view = Address(FakeHost(), lambda: None), VIEWS["explore"](FakeHost())
    assert address.open("eta=nan")[1].endswith("this is the opening scene.")
    shown = []
    for zoom in ("", "time:0,1"):
        view.view_texts = lambda zoom=zoom: {"zoom": zoom, "choice": "", "mute": ""}
        shown.append(address.current(view, Setting()))
    assert shown[0] == ""
    assert shown[1].endswith("zoom=time:0,1")
