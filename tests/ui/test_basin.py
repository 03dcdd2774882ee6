"""Basins in a browser: two pictures that grow, a hover that names the motion, a click that starts Explore there."""

import pytest

from tests.ui.test_studies import complete, panel, place
from tests.ui.test_symbols import OPEN
from tests.waiting import wait_until

CLASSES = """name => {
  const image = Bokeh.documents[0].get_model_by_name(name).get_column("image")[0];
  return [...new Set(image)].sort();
}"""
TIPS = """() => {
  const texts = (root) => [...root.querySelectorAll("*")].map((node) => node.shadowRoot ? texts(node.shadowRoot) : "")
    .join("") + [...root.childNodes].map((node) => node.nodeName === "STYLE" ? "" : node.textContent).join("");
  return texts(document.body);
}"""
BASIN = "?view=basin&eta=3.2&K=12000&D=18&steps=2000"


@pytest.fixture
def basins(kept):
    return complete(kept(BASIN).open_view("basin"))


def test_both_basins_grow_and_say_where_they_differ(basins):
    assert basins.figure("basin_reference")["title"].startswith("Reference, η = 3.2: motion 1 ")
    assert basins.figure("basin_penalty")["title"].startswith("Penalty model without a time step, η = 3.2: motion ")
    text = panel(basins).locator(".statements").text_content()
    assert "% of the starts the penalty model ends on another motion than the reference" in text
    assert "motion 1 (period 6) from" in text.split("Penalty model")[0]
    key = panel(basins).locator(".key").text_content()
    assert "motion 1 (period 6)" in key
    assert "bodies would overlap" in key
    classes = {side: basins.page.evaluate(CLASSES, f"basin_{side}_cells") for side in ("reference", "penalty")}
    assert classes == {"reference": [2, 3, 4], "penalty": [4]}  # no start, period 6, period 2


def test_a_hover_names_the_motion(basins):
    basins.page.mouse.move(*place(basins, "basin_penalty", 3, 2))
    tip = basins.page.locator(".bk-Tooltip, .bk-tooltip").locator("visible=true")
    tip.wait_for()
    said = "motion:2repeatsafter(periods):2"
    wait_until(lambda: said in "".join(basins.page.evaluate(TIPS).split()), what="the motion under the mouse")


def test_a_click_starts_explore_there(basins):
    basins.page.mouse.click(*place(basins, "basin_reference", 3, 2))
    basins.page.locator("[role=tab][aria-selected=true]:text-is('Explore')").wait_for()
    wait_until(lambda: float(basins.address().get("start_xi2", 0)) == pytest.approx(3, abs=0.1), what="the start")
    assert float(basins.address()["start_v2"]) == pytest.approx(2, abs=0.1)


def test_other_axes_are_in_the_link_and_a_start_that_is_typed_moves_the_mark_alone(basins):
    basins.page.get_by_role("combobox", name="Starts over").select_option("v1-v2")
    wait_until(lambda: "v1-v2" in basins.query(), what="the axes in the address")
    complete(basins)
    basins.page.evaluate(OPEN)
    basins.moved(lambda: basins.type("start_v1", "2"))
    assert basins.source("basin_mark")["x"][0] == 2
    assert float(panel(basins).get_attribute("data-share")) == 1  # the basins are the same
