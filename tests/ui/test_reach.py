"""Keys, names, sizes for fingers: every part of the page can be reached and is named."""

import re

from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.report import Findings, as_report
from vibroscope.app.page.tabs import TABS

from tests.ui.explorer import PHONE
from tests.waiting import wait_until

# Elements that the keyboard reaches, and that a screen reader would read without a name.
UNNAMED = """() => {
  const unnamed = [];
  const walk = root => root.querySelectorAll("*").forEach(node => {
    if (node.checkVisibility()) {
      const text = node.ariaLabel || node.textContent.trim() || node.title || node.getAttribute("aria-labelledby")
        || node.labels?.length;
      if (node.tabIndex >= 0 && !text && !node.getAttribute("role")?.includes("main")) unnamed.push(node.outerHTML);
    }
    if (node.shadowRoot) walk(node.shadowRoot);
  });
  walk(document.body);
  return unnamed.map(html => html.slice(0, 120));
}"""


def test_quick_arrow_presses_on_the_tabs_all_count(visit):
    explorer = visit("?view=help")
    tabs = explorer.page.get_by_role("tablist", name="Parts of the page").get_by_role("tab")
    tabs.last.focus()
    for _ in range(len(TABS) - 4):
        explorer.page.keyboard.press("ArrowLeft")
    explorer.page.keyboard.press("ArrowRight")
    explorer.page.locator("[role=tab][aria-selected=true]").and_(tabs.nth(4)).wait_for()
    wait_until(lambda: explorer.address().get("view") == TABS[4].views[0].key, what="the view in the link")


FOCUSED = """() => {
  let at = document.activeElement;
  while (at.shadowRoot?.activeElement) at = at.shadowRoot.activeElement;
  return at.className;
}"""


def test_the_first_stop_of_the_keyboard_leads_to_the_results(visit):
    explorer = visit()
    explorer.page.keyboard.press("Tab")
    link = explorer.page.get_by_role("button", name="Skip to the results")
    for view, place in (("explore", "line verdict"), ("step", "study"), ("help", "tab-area")):
        if view != "explore":
            explorer.open_view(view)
            link.focus()
        assert link.evaluate("link => link.getBoundingClientRect().width") > 100  # it is seen while it has the focus
        explorer.page.keyboard.press("Enter")
        assert place in explorer.page.evaluate(FOCUSED), view


NAMED = """() => {
  let named = 0;
  const walk = root => root.querySelectorAll("*").forEach(node => {
    if (node.getAttribute("role") === "figure" && node.getAttribute("aria-label")) named += 1;
    if (node.shadowRoot) walk(node.shadowRoot);
  });
  walk(document.body);
  return named;
}"""


def test_every_stop_of_the_keyboard_has_a_name_however_late_figures_come(visit):
    """On a loaded machine Bokeh takes long, and a figure is not laid out when it is named."""
    explorer = visit("?view=step")
    wait_until(lambda: explorer.page.evaluate(NAMED) == 4, what="the names of the open tab")
    assert explorer.page.evaluate(UNNAMED) == []
    explorer.page.evaluate("""() => {
      const wait = window.setTimeout;
      window.setTimeout = (act, time, ...rest) => wait(act, time / 50, ...rest);  // as if 50 times as long went by
      Object.defineProperty(Bokeh.documents[0], "is_idle", { get: () => false, configurable: true });
    }""")
    explorer.open_tab("Explore")
    explorer.page.wait_for_timeout(3000)
    explorer.page.evaluate("delete Bokeh.documents[0].is_idle")
    wait_until(lambda: explorer.page.evaluate(NAMED) == 10, what="names of all figures, hidden ones too")
    assert explorer.page.evaluate(UNNAMED) == []
    names = [figure.get_attribute("aria-label") for figure in explorer.page.get_by_role("figure").all()]
    seen, axes = r"amplitude [\d.]+, penalty [\d.]+", r"displacement ξ₁ / base amplitude, velocity ξ₁′ / \(Aω₁\)"
    assert any(re.fullmatch(f"Phase plot, body 1: {seen}, {axes}", name) for name in names), names
    assert any(name.startswith("Contact strip: reference ") for name in names)


def test_on_a_phone_legends_are_for_fingers_and_the_question_mark_is_help(visit):
    explorer = visit(**PHONE)
    entries = explorer.page.get_by_role("switch")
    wait_until(lambda: min(entry.bounding_box()["height"] for entry in entries.all()) >= 24, what="high entries")
    explorer.page.get_by_role("button", name="help").tap()
    dialog = explorer.page.get_by_role("dialog")
    assert "Ctrl" not in dialog.text_content()  # no keys where there are none
    dialog.get_by_role("button", name="Open Help").tap()
    explorer.page.locator("[role=tab][aria-selected=true]:text-is('Help')").wait_for()
    assert explorer.page.locator("dialog[open]").count() == 0


def test_a_report_does_not_scroll_sideways_on_a_phone(windows):
    page = windows(320, 568).new_page()
    source = {"program": "Vibroscope", "made": "today", "address": "?" + "&".join(f"name{i}={i}" for i in range(200))}
    words = {"A very_long_word" + "x" * 80: "y" * 200}
    page.set_content(as_report("Explore", Findings(words), Setting(), [], ["print(" + "z" * 300 + ")"], source))
    assert page.evaluate("document.scrollingElement.scrollWidth") == 320
    page.close()
