"""The page around the figures: tabs, keys, tour, summaries, terms, access, content security policy."""

from vibroscope.app.explorer.glossary import glossary
from vibroscope.app.page.tabs import TABS

from tests.ui.axe import AXE, serious, serious_in
from tests.waiting import wait_until

MEANING = {word.lower(): entry for entry in glossary() for word in entry.opens}


def test_the_policy_is_in_force_and_a_page_complains_of_what_it_blocks(kept):
    """That it blocks nothing the page needs is seen by every test in a browser."""
    explorer = kept()
    blocked = explorer.page.evaluate(
        "new Promise(done => { document.addEventListener('securitypolicyviolation', e => done(e.violatedDirective), "
        "{once: true}); fetch('http://192.0.2.1/').catch(() => {}); setTimeout(() => done('nothing'), 3000); })"
    )
    assert blocked == "connect-src"
    assert any("Content Security Policy" in complaint for complaint in explorer.complaints)
    explorer.complaints.clear()
    policy = explorer.page.request.get(explorer.server).headers["content-security-policy"]
    assert "unsafe-eval" not in policy
    assert "http" not in policy


def test_a_view_is_built_when_it_is_opened_and_costs_nothing_while_it_is_hidden(visit):
    explorer = visit("?view=help")
    assert explorer.page.get_by_role("tab", name="Help").get_attribute("aria-selected") == "true"
    models = "() => [...Bokeh.documents[0].all_models].filter(m => m.type === 'Figure').length"
    assert explorer.page.evaluate(models) == 0
    explorer.open_tab("Explore")
    wait_until(lambda: "view" not in explorer.address(), what="an address without a view")
    explorer.until("Bokeh.documents[0].get_model_by_name('phase_reference')?.data.x1.length > 0")
    assert explorer.page.evaluate(models) == 6
    explorer.settle(1)
    received = explorer.count_messages()
    explorer.moved(lambda: explorer.type("eta", "1.3"))
    visible = received()
    shown = explorer.source("section_reference")["eta"][0]
    explorer.open_tab("Help")
    explorer.settle()
    before = received()
    explorer.page.evaluate("document.dispatchEvent(new CustomEvent('vibroscope:scene', {detail: {value: 'C'}}))")
    explorer.wait_for_address(eta="2.76", view="help")
    assert visible > 10_000
    assert received() - before < 4_000
    assert explorer.source("section_reference")["eta"][0] == shown
    explorer.open_tab("Explore")
    wait_until(lambda: abs(explorer.source("section_reference")["eta"][0] - 2.76) < 1e-5, what="the figures of 2.76")


def test_keys_choose_scenes_and_can_be_switched_off(kept):
    explorer = kept().open_view("explore")
    explorer.moved(lambda: explorer.page.keyboard.press("3"))
    explorer.wait_for_address(eta="2.76")
    explorer.page.keyboard.press("?")
    dialog = explorer.page.get_by_role("dialog", name="Tour, keys and help")
    dialog.wait_for()
    dialog.get_by_role("checkbox").uncheck()
    explorer.page.keyboard.press("Escape")
    explorer.page.keyboard.press("1")
    explorer.type("K", "9000")  # it comes after the scene, if there is one
    explorer.wait_for_address(eta="2.76", K="9000")
    explorer.page.evaluate("localStorage.clear()")


def test_a_first_visit_begins_with_the_tour_and_the_second_does_not(visit, windows):
    context = windows(whose="newcomer").context
    context.add_init_script("Object.defineProperty(Navigator.prototype, 'webdriver', { get: () => false })")
    explorer = visit(whose="newcomer")
    explorer.page.get_by_role("dialog", name="Tour").get_by_role("button", name="Skip").click()
    assert explorer.page.get_by_role("tab").count() == len(TABS)
    explorer.page.reload()
    explorer.settle(update=1)
    assert explorer.page.get_by_role("tab").count() == len(TABS)
    assert explorer.page.get_by_role("dialog", name="Tour").count() == 0


def test_the_summary_is_of_the_open_view_and_follows_the_findings(kept):
    explorer = kept.anew().explained()
    summary = explorer.page.locator(".summary")
    text = summary.text_content()
    assert text.startswith("Explore. Do they agree?")
    assert explorer.line("verdict") in text
    assert summary.get_attribute("aria-live") == "polite"
    for tab, view, words in (
        ("Help", "Model, figures, glossary", "The model and its equations"),
        ("Bifurcation", "Diagram and branches", ""),
    ):
        explorer.open_tab(tab, view)
        said = f"{view}. {words}"
        wait_until(lambda said=said: summary.text_content().startswith(said), what=f"the summary of {view}")
    explorer.open_tab("Explore")
    wait_until(lambda: summary.text_content() == text, what="the verdict again")
    explorer.moved(lambda: explorer.scene("D"))
    wait_until(lambda: "every 2 periods" in summary.text_content(), what="the summary of [D]")


def test_a_term_opens_its_entry(kept):
    explorer = kept.anew().explained()
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


def test_axe_finds_no_serious_fault_in_folded_parts_and_the_keys_light_or_dark(kept):
    explorer = kept.anew()
    explorer.page.evaluate(AXE)
    explorer.unfold("System", "Start", "Solver", "Display", "More scenes", "Other systems", "More: ")
    explorer.page.locator("details.take-away summary").click()
    assert serious_in(explorer.page, "dark", "light") == []
    explorer.page.keyboard.press("?")  # the other dialogs, tour and exercises: see `test_first_minute`
    explorer.page.get_by_role("dialog", name="Tour, keys and help").wait_for()
    assert serious_in(explorer.page, "light", "dark") == []
