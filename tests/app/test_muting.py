"""Muted legend entries: their curves are hidden, and a link holds them."""

import panel as pn
import pytest
from bokeh.document import Document
from bokeh.models import HoverTool
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.muting import show_entry
from vibroscope.app.page.tabs import VIEWS

from tests.app.fakes import FakeHost

SETTING = Setting()


def press(item):
    """What the browser does at a click on an entry."""
    for renderer in item.renderers:
        renderer.visible = not renderer.visible


def add_all(tab):
    """Add the entries of all pins and of a measurement, which come with the first of them."""
    if tab.key == "explore":
        tab.motion.add([*tab.motion.pins, tab.motion.measured, tab.motion.closed])


@pytest.mark.parametrize("tab", [tab for tab in VIEWS.values() if tab.legends and tab.key != "paper"])
def test_an_entry_that_is_muted_goes_into_the_link_and_comes_back(tab):
    made = tab(FakeHost())
    page = made.build()
    add_all(made)
    figures = {pane.object.name: pane.object for pane in page.objects if hasattr(getattr(pane, "object", None), "name")}
    heard = []
    made.muting.on_mute = lambda: heard.append(made.view_texts()["mute"])
    for name, entries in tab.legends.items():
        for entry, item in zip(entries, figures[name].legend[0].items, strict=True):
            show_entry(item, True)
            press(item)
            assert heard[-1] == f"{name}:{entry}"
            press(item)
            assert heard[-1] == ""
    for name in tab.legends:
        for item in figures[name].legend[0].items[::2]:
            press(item)
    again = tab(FakeHost())
    again.build()
    again.restore(tab.read_view("", "", heard[-1]))
    assert again.view_texts() == made.view_texts()


def test_names_of_entries_are_those_of_their_solvers():
    tab = VIEWS["explore"](FakeHost())
    tab.build()
    tab.restore(tab.read_view("", "", "displacement:penalty2,time_step;force:penalty"))
    plots = {name: tab.motion.figures[name] for name in ("displacement", "force")}
    muted = {
        name: [item.label.value for item in plot.legend[0].items if item.visible and not item.renderers[0].visible]
        for name, plot in plots.items()
    }
    assert muted == {"displacement": ["ξ₂ penalty"], "force": ["penalty"]}


def test_curves_without_an_entry_in_the_legend_are_hidden_and_the_muted_stay_so():
    tab = VIEWS["explore"](FakeHost())
    tab.build()
    tab.motion.add(tab.motion.pins[:1])
    items = {item.label.value: item for item in tab.motion.figures["displacement"].legend[0].items}

    def drawn():
        assert all(item.visible or not item.renderers[0].visible for item in items.values())
        return {label for label, item in items.items() if item.renderers[0].visible}

    displacements = {"ξ₁ reference", "ξ₂ reference", "ξ₁ penalty", "ξ₂ penalty"}
    assert drawn() == displacements
    press(items["ξ₁ reference"])
    tab.motion.draw_beside([{}], {}, {})
    assert drawn() == displacements - {"ξ₁ reference"} | {"pin 1"}
    hover = next(tool for tool in tab.motion.figures["displacement"].tools if isinstance(tool, HoverTool))
    (hovered,) = hover.renderers
    assert (hovered.glyph.y, hovered.visible) == ("reference2", True)
    tab.motion.explain({}, SETTING._replace(frame="difference"))
    assert drawn() == {"difference", "time step", "K and D", "joint damping"}
    tab.motion.update(SETTING, fresh=True)
    assert drawn() == displacements - {"ξ₁ reference"} | {"pin 1"}
    assert tab.view_texts()["mute"] == "displacement:reference1"


def test_curves_follow_their_entries_while_a_document_holds_its_events():
    """As in a session: callbacks of what is changed then are not called."""
    tab, document = VIEWS["explore"](FakeHost()), Document()
    document.add_root(tab.build().get_root(document))
    figure = tab.motion.figures["displacement"]
    with pn.io.hold(document):
        tab.motion.explain({}, SETTING._replace(frame="difference"))
    drawn = {item.label.value for item in figure.legend[0].items if item.renderers[0].visible}
    assert drawn == {"difference", "time step", "K and D", "joint damping"}
    assert [line.visible for tool in figure.tools if isinstance(tool, HoverTool) for line in tool.renderers] == [False]
