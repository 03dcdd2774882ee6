"""The start of the run on Explore: typed, refused, kept in the address, and taken from a coexisting motion."""

from tests.waiting import wait_until

TWO_CYCLES = "?eta=3.2&K=12000&D=18&steps=2000"  # the reference: 2 periods from rest, 6 from other starts


def test_a_start_is_typed_and_a_click_on_a_coexisting_motion_runs_it(visit):
    page = visit(TWO_CYCLES).explained()
    assert "every 2 periods" in page.line("reference")
    page.unfold("System", "Start: rest", "More: ")
    page.moved(lambda: page.type("start_xi2", "1,5"))
    page.page.get_by_text("Start: own", exact=True).wait_for()
    page.wait_for_address(start_xi2="1.5")
    page.type("start_xi1", "2")
    wait_until(lambda: "ξ₁(0) must be at most ξ₂(0), not 2 with 1.5" in page.error(), what="a refusal")
    page.typed("start_xi1").press("Escape")
    wait_until(lambda: not page.error(), what="no refusal")

    page.page.get_by_role("button", name="Coexisting motions").click()
    page.page.locator(".coexisting[data-phase=done]").wait_for()
    motion = page.page.locator(".motion", has_text="period 6").first
    page.moved(motion.click)
    page.explained()
    assert "every 6 periods" in page.line("reference")
    page.page.locator(".motion[aria-pressed=true]", has_text="period 6").wait_for()
    wait_until(lambda: page.address()["start_xi2"] != "1.5", what="the start in the address")
    assert page.typed("start_xi1").input_value() == page.address()["start_xi1"]

    page.moved(page.page.get_by_role("button", name="Undo").click)
    wait_until(lambda: page.typed("start_xi2").input_value() == "1.5", what="the typed start")
    page.moved(page.page.get_by_role("button", name="From rest").click)
    page.explained()
    assert "every 2 periods" in page.line("reference")
    wait_until(lambda: "start_" not in page.query(), what="an address without a start")
    assert page.page.locator(".motion[aria-pressed=true]", has_text="period 2").count()
    page.moved(lambda: page.type("eta", "3.1"))
    page.page.locator(".coexisting[data-phase=idle]").wait_for()
