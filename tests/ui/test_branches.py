"""Branches in a browser: searched for, listed, opened in Explore by key and by click, and followed from there."""

import pytest

from tests.ui.axe import AXE, serious
from tests.ui.explorer import PHONE
from tests.ui.test_studies import complete, place
from tests.waiting import wait_until

QUERY = (
    "?view=bifurcation&eta=1.42&K=12000&D=18&steps=2000&zoom=eta:1.3,1.5&choice=count:60;transient:200;branches:both"
)


def found(explorer):
    """Wait until all branches are found."""
    section = explorer.page.locator("section.branches-list")
    section.wait_for()
    wait_until(lambda: section.get_attribute("data-running") == "false", what="all branches")
    complete(explorer)
    return section


def tap(explorer, source, at):
    """Click on a vertex of a line in the diagram."""
    columns = explorer.source(source)
    explorer.page.mouse.click(*place(explorer, "bifurcation", columns["eta"][at], columns["value"][at]))


def test_a_key_opens_a_motion_and_the_way_back_leads_to_the_branches(kept):
    explorer = kept(QUERY).open_view("bifurcation")
    section, page = found(explorer), explorer.page
    assert "Reference: 2 branches" in section.locator(".status").text_content()
    assert "The exact penalty stands for Newmark T/2000" in section.locator(".notes").text_content()
    heads = section.locator(".points th").all_text_contents()
    assert heads == ["kind", "period", "reference", "exact penalty", "shift"]
    doublings = section.locator(".points tr[data-kind='period doubling']")
    assert "+" in doublings.first.text_content()
    section.get_by_label("Kind of points").select_option("period doubling")
    assert section.locator(".points tr[data-kind]:visible").count() == doublings.count()
    motion = section.get_by_role("button", name="unstable, period 1").first
    motion.focus()
    page.keyboard.press("Enter")
    line = page.locator("section.opened")
    line.wait_for()
    explorer.settle()
    assert "the reference repeats every period, unstable" in line.text_content()
    assert explorer.source("phase_closed")["x1"]
    wait_until(lambda: "start_xi1" in explorer.address(), what="the start of the motion, which follows its figures")
    assert float(explorer.address()["eta"]) == pytest.approx(1.42, abs=0.01)
    page.evaluate(AXE)
    assert serious(page) == []
    explorer.open_tab("Bifurcation")  # the tab was left without its click
    explorer.open_tab("Explore")
    line.get_by_role("button", name="Back to the branches").click()
    wait_until(lambda: explorer.address().get("view") == "bifurcation", what="the way back")
    assert explorer.address()["choice"] == "branches:both;count:60;transient:200"
    explorer.open_tab("Explore")
    line.get_by_role("button", name="Close").click()
    line.wait_for(state="hidden")
    wait_until(lambda: explorer.source("phase_closed")["x1"] == [], what="no curve of the branch")


def test_a_click_on_a_branch_opens_it_and_beside_it_sets_the_number(kept):
    explorer = kept(QUERY).open_view("bifurcation")
    found(explorer)
    tap(explorer, "branches_reference_unstable", 3)
    explorer.page.locator("section.opened").wait_for()
    explorer.settle()
    assert "unstable" in explorer.page.locator("section.opened").text_content()
    wait_until(lambda: "start_xi1" in explorer.address(), what="the start of the motion, which follows its figures")
    opened = explorer.address()["eta"]
    explorer.open_tab("Bifurcation")
    found(explorer)
    low, high = explorer.figure("bifurcation")["y"]
    explorer.page.mouse.click(*place(explorer, "bifurcation", 1.32, low + 0.02 * (high - low)))
    wait_until(lambda: explorer.address()["eta"] != opened, what="another η")
    assert float(explorer.address()["eta"]) == pytest.approx(1.32, abs=0.01)
    assert explorer.address()["view"] == "bifurcation"


def test_a_motion_is_followed_from_explore_on_a_phone(visit):
    explorer = visit("?eta=1.42&K=12000&D=18&steps=500", **PHONE)
    explorer.unfold("More: ")
    explorer.page.get_by_role("button", name="Follow this motion").tap()
    section = explorer.page.locator("section.branches-list")
    section.wait_for()
    wait_until(lambda: explorer.address().get("view") == "bifurcation", what="the view")
    assert explorer.address()["choice"] == "branches:on;followed:1.42"
    section.get_by_role("button", name="period 1").first.wait_for()
    assert explorer.page.evaluate("document.scrollingElement.scrollWidth") == 390
    section.get_by_role("button", name="Stop").tap()
    section.get_by_role("button", name="Go on").wait_for()
    assert "stopped" in section.locator(".status").text_content()


def test_a_branch_between_two_stops_opens_as_a_motion_from_wall_to_wall(visit):
    system = "bodies=wall&d1=0.05&stops=two&clearance=0.5&clearance2=0.8&restitution=0.6&restitution2=0.8"
    choice = "zoom=eta:1.469,1.471&choice=count:20;transient:200;branches:on"
    explorer = visit(f"?view=bifurcation&eta=1.47&K=4000&D=5&steps=500&{system}&{choice}")
    section = found(explorer)
    assert explorer.source("branches_reference_stable")["eta"]
    section.get_by_role("button", name="stable, period 1").first.click()
    opened = explorer.page.locator("section.opened")
    opened.wait_for()
    explorer.settle()
    assert "the reference repeats every period, stable" in opened.text_content()
    closed = explorer.source("phase_closed")["x1"]
    assert (min(closed), max(closed)) == pytest.approx((-0.8, 0.5), abs=0.01)
