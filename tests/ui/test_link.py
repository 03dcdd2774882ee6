"""A link restores the exact view in another page: numbers, zoom, choices, muted entries and theme; or is refused."""

from urllib.parse import quote
from urllib.request import urlopen

import pytest

from tests.ui.test_studies import SETTING, panel
from tests.waiting import PATIENCE, wait_until

ZOOMED = ("displacement", "phase1", "force", "diagram")


def zoomed(explorer, *figures):
    """Zoom into these figures and wait for the link."""
    for name in figures:
        explorer.zoom(name, 0.2, 0.6, 0.2, 0.7)
        explorer.wait_for_zoom(name)
    return explorer


def begun(explorer, figure):
    """Wait until the figure of a study has data."""
    wait_until(lambda: not explorer.figure(figure)["title"].startswith("Being"), what=f"something in {figure}")
    explorer.settle()
    return explorer


def same_view(first, second, names):
    view = [pytest.approx(ends, rel=2e-5, abs=2e-4) for ends in first.ranges(*names)]
    wait_until(lambda: second.ranges(*names) == view, what="the view")


def test_a_zoom_goes_into_the_link_and_comes_back(kept, visit):
    explorer = zoomed(kept.anew(f"?{SETTING}"), *ZOOMED)
    names = {part.split(":")[0] for part in explorer.address()["zoom"].split(";")}
    assert names == {"time", "displacement", "x1", "v1", "force", "impulse", "eta", "section"}
    second = visit(explorer.query())
    same_view(explorer, second, [*ZOOMED, "phase2", "strip"])
    second.moved(lambda: second.type("K", "9000"))
    same_view(explorer, second, ZOOMED)  # nothing of it is lost by a move
    assert second.address()["zoom"] == explorer.address()["zoom"]
    second.moved(lambda: second.scene("C"))
    assert second.figure("force")["x"] == [0, 2]
    wait_until(lambda: "zoom" not in second.address(), what="a link without a zoom")


def test_the_reset_tool_takes_a_zoom_out_of_the_link(visit):
    explorer = visit("?eta=1.08&K=2500&D=8&steps=2000&zoom=x1:-1,2;v1:-1,1;time:0.2,0.7")
    assert explorer.figure("phase1")["x"] == [-1, 2]
    explorer.page.evaluate("Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name('phase1').id).reset()")
    wait_until(lambda: explorer.address().get("zoom") == "time:0.2,0.7", what="a link with the other zoom alone")
    low, high = explorer.figure("phase1")["x"]
    points = explorer.source("phase_reference")["x1"]
    assert low < min(points) < max(points) < high  # it knows where the data are, although it began zoomed


def test_the_view_of_a_study_comes_back(kept, visit):
    """What the links of all studies hold: tests/app/test_link.py, tests/app/test_walked_links.py."""
    figures = ["plane_penalty", "plane_exact"]
    explorer = begun(kept(f"?{SETTING}").open_view("plane"), figures[0])
    panel(explorer).get_by_role("combobox", name="Colour").select_option("contact")
    # What is chosen is drawn at the range of its data: a zoom before that would be taken back.
    wait_until(lambda: "contact" in explorer.address().get("choice", ""), what="the choice drawn")
    explorer.settle()
    zoomed(explorer, figures[0])
    second = visit(explorer.query())
    assert panel(second).get_by_role("combobox", name="Colour").input_value() == "contact"
    same_view(explorer, begun(second, figures[0]), figures)


MUTED = """names => names.map(name => Bokeh.documents[0].get_model_by_name(name).center
  .find(part => part.type === "Legend").items
  .filter(item => item.visible && !item.renderers.some(renderer => renderer.visible))
  .map(item => item.label.value)).flat()"""
LEGEND = """name => {
  const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name(name).id);
  const legend = view.model.center.find(part => part.type === "Legend");
  const box = view.views.find_one(legend).bbox;
  const canvas = view.canvas_view.el.getBoundingClientRect();
  return {x: canvas.x + box.x, y: canvas.y + box.y, width: box.width, height: box.height};
}"""


def click_last_entry(explorer, figure):
    """Click the last visible entry of the legend of a figure."""
    box = explorer.page.evaluate(LEGEND, figure)
    explorer.page.mouse.click(box["x"] + box["width"] - 12, box["y"] + box["height"] / 2)


def test_muted_entries_and_the_theme_come_back_and_dark_recolours_page_and_figures(visit):
    explorer = visit(whose="dark")  # a browser of its own, which remembers for no other test
    assert "theme" not in explorer.address()  # nobody has chosen
    assert explorer.model("phase1", "background_fill_color").upper() == "#FFFFFF"
    explorer.change_theme("Dark page")
    assert explorer.page.evaluate("document.documentElement.dataset.theme") == "dark"
    assert explorer.model("phase1", "background_fill_color") == "#171E26"
    click_last_entry(explorer, "phase1")
    click_last_entry(explorer, "force")
    wanted = {"theme": "dark", "mute": "phase1:penalty;force:penalty_impulses"}
    wait_until(lambda: wanted.items() <= explorer.address().items(), what="theme and mute in the link")
    second = visit(explorer.query())
    assert second.page.evaluate("document.documentElement.dataset.theme") == "dark"
    assert second.model("phase1", "background_fill_color") == "#171E26"
    assert second.page.evaluate(MUTED, ["phase1", "phase2", "force"]) == ["penalty", "its impulses"]
    second.moved(lambda: second.type("K", "9000"))
    wait_until(lambda: second.address()["K"] == "9000", what="the move in the link")
    assert wanted.items() <= second.address().items()
    click_last_entry(second, "phase1")
    wait_until(lambda: second.address()["mute"] == "force:penalty_impulses", what="one muted entry less")
    # The link's theme is for this page alone, and that of an earlier visit is in the link from the start.
    assert second.page.evaluate("localStorage.getItem('vibroscope-theme')") is None
    third = visit(whose="dark")
    wait_until(lambda: third.address().get("theme") == "dark", what="the theme that was chosen on an earlier visit")
    assert third.model("phase1", "background_fill_color") == "#171E26"
    third.change_theme("Light page")
    assert third.model("phase1", "background_fill_color").upper() == "#FFFFFF"


def test_legend_entries_are_switches_for_the_keyboard_too(kept):
    explorer = kept.anew()
    keys, entry = explorer.page.keyboard, explorer.page.locator(".phase2").get_by_role("switch", name="penalty")
    assert entry.get_attribute("aria-checked") == "true"
    entry.focus()
    keys.press("Enter")
    wait_until(lambda: explorer.address().get("mute") == "phase2:penalty", what="the muted entry in the link")
    assert entry.get_attribute("aria-checked") == "false"
    explorer.until("""(() => {
        let at = document.activeElement;
        while (at.shadowRoot) at = at.shadowRoot.activeElement;
        return at.role === "switch" && at.textContent === "penalty";
    })()""")
    keys.press(" ")  # the entry made anew still has the keyboard
    wait_until(lambda: "mute" not in explorer.address(), what="no muted entry in the link")
    assert entry.get_attribute("aria-checked") == "true"
    assert explorer.page.get_by_role("button", name="Play", exact=True).count() == 1  # not the page's Space


def test_a_link_restores_its_state_in_a_session_that_is_independent(kept, visit):
    first = kept.anew()
    first.moved(lambda: first.type("eta", "2.7612345"))
    first.unfold("Solver", "Display")
    first.moved(lambda: first.page.locator("[name=vibroscope-joint_damping][value=derived]").set_checked(True))
    first.moved(lambda: first.page.get_by_text("absolute", exact=True).click())
    first.wait_for_address(eta="2.7612345", joint_damping="derived", frame="absolute")
    second = visit(first.query())
    assert second.sources() == first.sources()
    assert second.typed("eta").input_value() == "2.7612345"
    second.unfold("Display")
    assert second.page.get_by_role("radio", name="absolute", exact=True).is_checked()
    before = second.sources()
    first.moved(lambda: first.scene("C"))
    assert second.sources() == before
    assert second.typed("eta").input_value() == "2.7612345"
    second.moved(lambda: second.type("eta", "3.1"))
    assert first.typed("eta").input_value() == "2.76"


def test_a_half_valid_address_is_refused_as_a_whole_and_leaves_complete_controls(visit):
    explorer = visit("?eta=2.76&K=nan&D=18")
    assert "The link was not accepted" in explorer.error()
    assert "K must be a number from 1e-6 to 1e12" in explorer.error()
    assert explorer.typed("eta").input_value() == "1.08"
    assert explorer.page.locator("[aria-invalid=true]").count() == 0
    assert explorer.query() == "?eta=2.76&K=nan&D=18"
    explorer.moved(lambda: explorer.type("eta", "2"))
    assert explorer.error() == ""
    explorer.wait_for_address(eta="2")


def test_hostile_addresses_never_break_the_page(server):
    """What the page says of them: tests/app/test_hostile_clients.py."""
    long = "?steps=" + "9" * 5000
    for query in ("?eta=²", "?eta=" + "9" * 1900, "?eta=%FF%FE", "?eta=1&eta=2", "?eta=1e999", "?pin=eta%3D²", long):
        assert urlopen(server + "/" + quote(query, safe="?&=%"), timeout=PATIENCE).status == 200, query
