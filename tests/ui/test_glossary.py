"""A term on the page opens its entry of the glossary, by click and by key."""

from vibroscope.app.explorer.glossary import glossary

from tests.ui.axe import AXE, serious
from tests.waiting import wait_until

MEANING = {word.lower(): entry for entry in glossary() for word in entry.opens}


def test_a_term_opens_its_entry(kept):
    explorer = kept().explained()
    page, note = explorer.page, explorer.page.locator(".entry")
    found = page.locator(".lines .term")
    words = [word.lower() for word in found.all_text_contents()]
    assert len(words) >= 5
    assert len({MEANING[word].head for word in words}) == len(words)  # each entry once
    said = explorer.line("verdict")
    term = page.locator(".line.verdict .term").first
    entry = MEANING[term.text_content().lower()]
    term.click()
    assert note.is_visible()
    assert note.locator("strong").text_content() == entry.head
    assert note.locator("p").text_content() == entry.text
    page.evaluate(AXE)
    assert serious(page) == []
    page.keyboard.press("Escape")
    assert note.is_hidden()
    assert explorer.line("verdict") == said
    page.keyboard.press("Enter")  # the term has the focus again
    assert note.is_visible()
    note.get_by_role("button", name="Close").click()
    label = page.locator("label", has_text="penalty stiffness").locator(".term").first
    label.press(" ")
    note.locator("strong:text-is('K')").wait_for()
    note.get_by_role("button", name="All terms").click()
    page.locator("[role=tab][aria-selected=true]:text-is('Help')").wait_for()


def test_the_terms_of_the_next_verdict_are_marked_too(kept):
    explorer = kept().open_view("explore").explained()
    explorer.moved(lambda: explorer.type("eta", "1.4"))
    explorer.explained()
    words = [word.lower() for word in explorer.page.locator(".lines .term").all_text_contents()]
    assert {"blurred", "repeats every period"} <= set(words)
    assert len({MEANING[word].head for word in words}) == len(words)
    assert explorer.page.locator(".term .term").count() == 0


def test_marked_terms_follow_from_the_texts_and_not_from_those_before(kept, visit):
    def marked(explorer):
        explorer.page.locator("form.panel details").evaluate_all("all => all.forEach(each => { each.open = true; })")
        return explorer.page.locator("form.panel .term:visible, .lines .term:visible").all_text_contents()

    walked = kept.anew("?bodies=wall&clearance=0.5&units=si").explained()
    walked.moved(lambda: walked.scene("C"))
    walked.unfold("System")
    walked.moved(lambda: walked.page.get_by_text("non-dimensional", exact=True).click())
    walked.explained().judged()
    wait_until(lambda: walked.address().get("eta") == "2.76" and "units" not in walked.address(), what="the link")
    linked = visit(walked.query()).explained().judged()
    wait_until(lambda: marked(walked) == marked(linked), what=f"{marked(linked)}")
