"""The Paper tab in a browser: claims are checked as they come into view, and open where they can be tried."""

from tests.waiting import wait_until

PAPER = "?view=paper&theme=dark"
FIGURES = "[...Bokeh.documents[0].all_models].filter(m => m.type === 'Figure').length"


def checked(explorer):
    return explorer.page.locator("article.claim[data-agrees]:not([data-agrees=''])").count()


def test_claims_are_checked_as_they_come_into_view_and_their_figures_have_the_theme(kept):
    """The theme is chosen by the link against what the system prefers."""
    explorer = kept(PAPER, width=800, height=700)
    cards = explorer.page.locator("article.claim")
    wait_until(lambda: checked(explorer) >= 2, what="the claims in view")
    assert cards.count() == 20
    explorer.settle()
    some = checked(explorer)
    assert some < 10
    explorer.until(f"{FIGURES} === {some}")
    explorer.until("Bokeh.documents[0].get_model_by_name('paper4A')?.background_fill_color.toUpperCase() === '#171E26'")
    assert explorer.page.evaluate("document.documentElement.dataset.theme") == "dark"
    last = cards.filter(has_text="Figure 14 [D]")
    last.scroll_into_view_if_needed()
    last.locator(".verdict", has_text="differs").wait_for()
    explorer.until("Bokeh.documents[0].get_model_by_name('paper14D') !== null")
    explorer.settle()
    frame = explorer.figure("paper14D")["frame"]
    assert frame["width"] > 150
    assert frame["height"] > 100
    assert checked(explorer) < 20


def test_a_claim_opens_where_it_can_be_tried(kept):
    explorer = kept(PAPER).open_view("paper")
    explorer.page.get_by_role("button", name="setting of Figure 9 [B]").click()
    explorer.page.locator("[role=tab][aria-selected=true]:text-is('Explore')").wait_for()
    wait_until(lambda: "K=100&D=50&steps=2000" in explorer.query(), what="the scene in the address")
    explorer.open_tab("Help", "The paper’s claims")
    explorer.page.get_by_role("button", name="setting of Figure 12 ").click()
    explorer.page.locator("[role=tab][aria-selected=true]:text-is('K–D plane')").wait_for()
    wait_until(lambda: "K=12000&D=18&steps=2000&view=plane" in explorer.query(), what="the plane in the address")
    explorer.open_tab("Help")  # or the plane would be computed on while the next test runs
