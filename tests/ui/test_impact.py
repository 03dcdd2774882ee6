"""Tab One impact in a browser: the sentence, another speed, the step that is taken over, a click in the band."""

from tests.ui.test_studies import complete, place
from tests.waiting import wait_until

TAB = "?view=impact&eta=2.76&K=2500&D=8&steps=500"


def said(explorer):
    return explorer.page.locator("section.study .statements").locator("visible=true").inner_text()


def test_one_sentence_answers_for_another_speed_too_and_the_step_is_taken_over(kept):
    """On a phone: the last test."""
    explorer = complete(kept(TAB))
    assert "You asked for 0.50; with 9.69 steps in a contact you get" in said(explorer)
    assert "impacts of the reference" in said(explorer)
    assert len(explorer.source("impact_over_steps")["steps"]) == 64
    assert max(explorer.source("impact_force_worst")["force"]) > max(explorer.source("impact_force_exact")["force"])
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


def test_a_click_in_the_band_sets_the_step(kept):
    explorer = complete(kept(TAB))
    explorer.page.mouse.click(*place(explorer, "impact_band", 50, 0.8))
    wait_until(lambda: 2400 < int(explorer.address()["steps"]) < 2800, what="fifty steps in a contact")


def test_a_click_anywhere_in_a_row_sets_its_integrator_and_contact_status(kept):
    explorer = complete(kept(TAB))
    rows = explorer.page.locator("section.branches-list tr").locator("visible=true")
    cell = rows.filter(has_text="Bathe").filter(has_text="end, iterated").locator("td").nth(2)
    cell.click(force=True)  # the button of the row lies over it
    explorer.wait_for_address(integrator="bathe", status="end", view="impact")
    complete(explorer)
    assert "Bathe; contact status iterated" in said(explorer)
    chosen = rows.filter(has=explorer.page.locator(".mark:text('◆')"))
    assert "end, iterated" in chosen.inner_text()


def test_nobody_needs_a_system_to_get_the_step_of_a_contact_in_seconds_on_a_phone(visit):
    """Typed K and D, and those of a permitted penetration: for e = 0.5, which is that of the system at first."""
    explorer = visit("?view=impact", 390, 844)
    explorer.unfold("System")
    explorer.page.get_by_role("radio", name="SI", exact=True).check()
    explorer.wait_for_address(units="si")

    def enter(**numbers):
        for name, text in numbers.items():
            field = explorer.page.locator(f".study input[name={name}]")
            field.fill(text)
            field.press("Enter")

    enter(mass="1 kg", speed="1 m/s", depth="1 mm")
    explorer.page.locator("section.branches-list button[data-open=contact]").click()
    wait_until(lambda: "From 18 steps on it stays within 0.05" in said(explorer), what="the largest step")
    assert 0.000999 <= float(said(explorer).partition("Restitution 0.5; penetration ")[2].split()[0]) <= 0.001
    assert " = 241.1 µs." in said(explorer)  # of K = 550,600 N/m
    enter(depth="")
    explorer.type("K", "1e6 N/m")
    explorer.type("D", "430.9 N s/m")
    wait_until(lambda: " = 178.9 µs." in said(explorer), what="the step of the damper of 0.5")
    complete(explorer)
    assert "Reduced mass 1 kg, closing speed 1 m/s" in said(explorer)
    assert "Restitution 0.5;" in said(explorer)
    assert "From 18 steps on it stays within 0.05: a step of at most T/" in said(explorer)
