"""Tab One impact in a browser: the sentence, another speed, the step that is taken over, a click in the band."""

import pytest

from .axe import AXE, serious
from .explorer import wait_until
from .test_studies import place


def complete(explorer):
    panel = explorer.page.locator("section.study").locator("visible=true")
    wait_until(lambda: float(panel.get_attribute("data-share")) == 1, 120, "the table")
    explorer.settle()
    return explorer


def said(explorer):
    return explorer.page.locator("section.study .statements").locator("visible=true").inner_text()


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (390, 844)])
def test_one_sentence_answers_for_another_speed_too_and_the_step_is_taken_over(visit, width, height):
    explorer = visit("?eta=2.76&K=2500&D=8&steps=500", width=width, height=height)
    explorer.open_tab("One impact")
    complete(explorer)
    assert "You asked for 0.50; with 9.69 steps in a contact you get" in said(explorer)
    assert "impacts of the reference" in said(explorer)
    assert len(explorer.source("impact_over_steps")["steps"]) == 64
    explorer.page.evaluate(AXE)
    assert serious(explorer.page) == []
    speed = explorer.page.locator(".study input[name=speed]")
    speed.fill("1")
    speed.press("Enter")
    explorer.wait_for_address(view="impact", choice="speed:1.0")
    wait_until(lambda: "impacts of the reference" not in said(explorer), what="the typed speed")
    complete(explorer)
    rows = explorer.page.locator("section.branches-list tr").locator("visible=true")
    taken = rows.filter(has_text="Take this step over")
    steps = taken.locator("td").nth(1).inner_text().removeprefix("time step Δτ = T/")
    taken.get_by_role("button").click()
    wait_until(lambda: explorer.address().get("steps") == steps, what="the largest step in Explore")
    explorer.page.locator("[role=tab][aria-selected=true]:text-is('Explore')").wait_for()
    explorer.open_tab("One impact")
    complete(explorer)
    assert "you get 0.4" in said(explorer)


def test_a_click_in_the_band_sets_the_step(visit):
    explorer = complete(visit("?view=impact&eta=2.76&K=2500&D=8&steps=500"))
    explorer.page.mouse.click(*place(explorer, "impact_band", 50, 0.8))
    wait_until(lambda: 2400 < int(explorer.address()["steps"]) < 2800, what="fifty steps in a contact")
