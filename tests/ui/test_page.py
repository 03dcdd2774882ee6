"""The page around the figures: tabs, linked figures, pin, undo, take-away, keys, light and dark, access."""

from pathlib import Path

import axe_playwright_python
import pytest
from vibroscope.app.page.tabs import TABS

from .conftest import Explorer, wait_until
from .test_explorer import address, in_address

AXE = Path(axe_playwright_python.__file__).with_name("axe.min.js").read_text(encoding="utf-8")


def count_messages(page):
    """Count what the server sends from now on, in bytes."""
    page.evaluate("""() => {
      window.received = 0;
      for (const socket of window.sockets) socket.addEventListener("message",
        event => { window.received += event.data.size ?? event.data.byteLength ?? event.data.length; });
    }""")
    return lambda: page.evaluate("window.received")


@pytest.fixture
def counted(windows):
    """Every page of the usual window remembers its sockets."""
    context = windows(viewport={"width": 1440, "height": 900})
    if not getattr(context, "counts_sockets", False):
        context.add_init_script("""
          window.sockets = [];
          const Plain = WebSocket;
          window.WebSocket = class extends Plain { constructor(...all) { super(...all); window.sockets.push(this); } };
        """)
        context.counts_sockets = True


def test_a_tab_is_built_when_it_is_opened_and_costs_nothing_while_it_is_hidden(counted, visit):
    explorer = visit("?tab=help")
    models = "() => [...Bokeh.documents[0].all_models].filter(m => m.type === 'Figure').length"
    assert explorer.page.evaluate(models) == 0
    explorer.open_tab("Explore")
    explorer.until("Bokeh.documents[0].get_model_by_name('phase_reference')?.data.x1.length > 0")
    assert explorer.page.evaluate(models) == 6
    explorer.settle(1)
    received = count_messages(explorer.page)
    explorer.moved(lambda: explorer.type("eta", "1.3"))
    visible = received()
    shown = explorer.source("section_reference")["eta"][0]
    explorer.open_tab("Help")
    explorer.settle()
    before = received()
    explorer.page.evaluate("document.dispatchEvent(new CustomEvent('vibroscope:scene', {detail: {value: 'C'}}))")
    in_address(explorer, eta="2.76", tab="help")
    assert visible > 10_000
    assert received() - before < 4_000
    assert explorer.source("section_reference")["eta"][0] == shown
    explorer.open_tab("Explore")
    wait_until(lambda: abs(explorer.source("section_reference")["eta"][0] - 2.76) < 1e-5, what="the figures of 2.76")


def test_the_tab_is_part_of_the_address_and_an_unknown_one_is_told(visit):
    explorer = visit()
    assert "tab" not in address(explorer)
    explorer.open_tab("Help")
    in_address(explorer, tab="help")
    assert visit(explorer.query()).page.get_by_role("tab", name="Help").get_attribute("aria-selected") == "true"
    assert "There is no tab “nonsense”" in visit("?tab=nonsense").error()


def test_every_tab_is_reached_by_key(visit):
    explorer = visit()
    for number, tab in enumerate(TABS.values(), 1):
        explorer.page.keyboard.press(f"Shift+Digit{number}")
        explorer.page.locator(f"[role=tab][aria-selected=true]:text-is('{tab.title}')").wait_for()
    explorer.page.get_by_role("tab", selected=True).focus()
    explorer.page.keyboard.press("Home")
    explorer.page.locator("[role=tab][aria-selected=true]:text-is('Explore')").wait_for()


def mark(explorer, name):
    """Where a mark of the present phase stands: in the data of its figure, and on the page."""
    return explorer.page.locator(f"[data-mark={name}]").evaluate("""element => {
        const { left, top } = element.getBoundingClientRect();
        return { x: Number(element.dataset.x), y: Number(element.dataset.y), left, top };
    }""")


def test_marks_follow_a_zoom_and_leave_with_it(visit):
    explorer = visit()
    at = {n: mark(explorer, f"reference{n}") for n in "12"}
    for n in "12":
        box = explorer.figure(f"phase{n}")
        (x0, x1), (y0, y1), frame = box["x"], box["y"], box["frame"]
        assert abs(at[n]["left"] + 5.5 - frame["x"] - frame["width"] * (at[n]["x"] - x0) / (x1 - x0)) < 1
        assert abs(at[n]["top"] + 5.5 - frame["y"] - frame["height"] * (y1 - at[n]["y"]) / (y1 - y0)) < 1
    explorer.zoom("displacement", 0.5, 0.9, 0.1, 0.9)
    line = explorer.page.locator("[data-mark=now-displacement]")
    assert line.is_visible()  # where the pointer was last
    explorer.page.locator(".player input").fill("0")
    wait_until(lambda: not line.is_visible(), what="the line at τ = 0 gone from a view that begins later")


def test_a_time_under_the_pointer_is_marked_in_every_figure(visit):
    explorer = visit()
    frame = explorer.figure("force")["frame"]
    explorer.page.mouse.move(frame["x"] + 0.25 * frame["width"], frame["y"] + 0.5 * frame["height"])
    wait_until(lambda: abs(mark(explorer, "now-displacement")["x"] - 0.5) < 0.005, what="a mark at half a period")
    line = mark(explorer, "now-displacement")
    time = line["x"]
    for name in ("strip", "force"):
        assert mark(explorer, f"now-{name}") == line | {"top": mark(explorer, f"now-{name}")["top"]}
    assert abs(line["left"] - (frame["x"] + 0.25 * frame["width"])) < 2
    columns = explorer.source("displacements")
    nearest = min(range(len(columns["t"])), key=lambda i: abs(columns["t"][i] - time))
    for solver in ("reference", "penalty"):
        for n in "12":
            state = mark(explorer, f"{solver}{n}")
            assert abs(state["x"] - columns[f"{solver}{n}"][nearest]) < 0.05
            assert abs(state["y"] - columns[f"{solver}_v{n}"][nearest]) < 0.1
    assert explorer.page.locator(".readout").text_content() == f"τ/T {time:.3f}"


def test_the_marks_are_relative_to_the_base_also_when_the_curves_are_not(visit):
    explorer = visit()
    relative = mark(explorer, "reference1")["x"]
    explorer.moved(lambda: explorer.page.get_by_text("absolute").click())
    wait_until(lambda: explorer.page.evaluate("Bokeh.documents[0].is_idle"))
    assert abs(mark(explorer, "reference1")["x"] - relative) < 1e-3


def test_playing_moves_the_pendulums_without_the_server(counted, visit):
    explorer = visit()
    received = count_messages(explorer.page)
    bob = explorer.page.locator(".reference .bob").first
    before = bob.get_attribute("cx")
    explorer.page.get_by_role("button", name="Play").click()
    wait_until(lambda: bob.get_attribute("cx") != before, what="motion")
    wait_until(lambda: mark(explorer, "now-force")["x"] > 0.05, what="a line that moves along")
    explorer.page.get_by_role("button", name="Pause").click()
    assert received() == 0


def test_undo_redo_and_reset(visit):
    explorer = visit()
    explorer.moved(lambda: explorer.type("eta", "1.5"))
    explorer.moved(lambda: explorer.type("K", "9000"))
    explorer.page.locator("h1").click()
    explorer.moved(lambda: explorer.page.keyboard.press("Control+z"))
    assert (explorer.typed("eta").input_value(), explorer.typed("K").input_value()) == ("1.5", "2500")
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Undo").click())
    assert explorer.typed("eta").input_value() == "1.08"
    assert explorer.page.get_by_role("button", name="Undo").is_disabled()
    explorer.page.locator("h1").click()
    explorer.moved(lambda: explorer.page.keyboard.press("Control+Shift+Z"))
    assert explorer.typed("eta").input_value() == "1.5"
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Back to the default").click())
    in_address(explorer, eta="1.08", K="2500")


def test_a_pin_keeps_the_result_and_the_link_brings_it_back(visit):
    explorer = visit()
    first = explorer.sources()
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Keep this result").click())
    assert explorer.source("pinned_phase_penalty") == first["phase_penalty"]
    explorer.moved(lambda: explorer.type("K", "9000"))
    assert explorer.source("pinned_phase_penalty") == first["phase_penalty"] != explorer.source("phase_penalty")
    in_address(explorer, K="9000", pin="eta=1.08&K=2500&D=8&steps=2000")
    second = visit(explorer.query())
    wait_until(lambda: second.source("pinned_phase_penalty") == first["phase_penalty"], what="the pinned curves")
    assert second.source("phase_penalty") == explorer.source("phase_penalty")
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Keep this result").click())
    assert explorer.source("pinned_phase_penalty")["x1"] == []
    wait_until(lambda: "pin" not in address(explorer), what="an address without a pin")


def test_keys_choose_scenes_and_can_be_switched_off(visit):
    explorer = visit()
    explorer.moved(lambda: explorer.page.keyboard.press("3"))
    in_address(explorer, eta="2.76")
    explorer.page.keyboard.press("?")
    dialog = explorer.page.get_by_role("dialog", name="Keys")
    dialog.wait_for()
    dialog.get_by_role("checkbox").uncheck()
    explorer.page.keyboard.press("Escape")
    explorer.page.keyboard.press("1")
    explorer.page.wait_for_timeout(300)
    in_address(explorer, eta="2.76")
    explorer.page.evaluate("localStorage.clear()")


def test_dark_recolours_page_and_figures_and_is_remembered(visit):
    explorer = visit()
    line = "Bokeh.documents[0].get_model_by_name('phase1')"
    light = explorer.page.evaluate(f"{line}.background_fill_color")
    explorer.page.get_by_role("button", name="Dark page").click()
    assert explorer.page.evaluate("document.documentElement.dataset.theme") == "dark"
    assert (light.upper(), explorer.model("phase1", "background_fill_color")) == ("#FFFFFF", "#171E26")
    explorer.open_tab("Help")
    again = visit()
    assert again.model("phase1", "background_fill_color") == "#171E26"
    again.page.get_by_role("button", name="Light page").click()
    assert again.model("phase1", "background_fill_color").upper() == "#FFFFFF"
    again.page.evaluate("localStorage.clear()")


def test_the_tour_has_five_steps_and_can_be_skipped(visit):
    explorer = visit()
    assert explorer.page.get_by_role("dialog", name="Tour").count() == 0
    explorer.page.get_by_role("button", name="Five steps").click()
    dialog = explorer.page.get_by_role("dialog", name="Tour")
    seen = []
    for _ in range(5):
        seen.append(dialog.locator("h2").text_content())
        dialog.get_by_role("button", name="Next").or_(dialog.get_by_role("button", name="Done")).click()
    assert len(set(seen)) == 5
    dialog.wait_for(state="detached")
    explorer.page.get_by_role("button", name="Five steps").click()
    dialog.get_by_role("button", name="Skip").click()
    dialog.wait_for(state="detached")
    explorer.page.evaluate("localStorage.clear()")


def test_a_first_visit_begins_with_the_tour_and_the_second_does_not(visit, windows):
    window = windows(viewport={"width": 1441, "height": 900})  # of its own: nobody was here before
    window.add_init_script("Object.defineProperty(Navigator.prototype, 'webdriver', { get: () => false })")
    explorer = visit(width=1441)
    explorer.page.get_by_role("dialog", name="Tour").get_by_role("button", name="Skip").click()
    assert explorer.page.get_by_role("tab").count() == 7
    explorer.page.reload()
    explorer.settle(frame=1)
    assert explorer.page.get_by_role("tab").count() == 7
    assert explorer.page.get_by_role("dialog", name="Tour").count() == 0


def test_the_difference_is_drawn_in_parts_in_place_of_the_displacements(visit):
    explorer = visit("?eta=2.76&K=12000&D=18&steps=2000")
    assert explorer.source("difference")["total"] == []
    explorer.moved(lambda: explorer.page.get_by_text("difference", exact=True).click())
    wait_until(lambda: len(explorer.source("difference")["total"]) > 100, what="the difference")
    assert "Δξ₂ / base amplitude" in explorer.figure("displacement")["labels"]
    in_address(explorer, frame="difference")
    explorer.moved(lambda: explorer.page.get_by_text("relative", exact=True).click())
    assert "ξ / base amplitude" in explorer.figure("displacement")["labels"]


def test_a_summary_tells_what_the_figures_show(visit):
    explorer = visit().explained()
    summary = explorer.page.locator(".summary")
    assert explorer.line("verdict") in summary.text_content()
    assert summary.get_attribute("aria-live") == "polite"
    explorer.moved(lambda: explorer.scene("D"))
    wait_until(lambda: "Two periods" in summary.text_content(), what="the summary of [D]")


def test_the_summary_is_of_the_open_tab(visit):
    explorer = visit().explained()
    summary = explorer.page.locator(".summary")
    told = summary.text_content()
    assert told.startswith("Explore. Do they agree?")
    for title, words in (
        ("Help", "Help. The model and its equations"),
        ("Paper", "Paper. 0 of 20 claims checked"),
        ("Bifurcation", "Bifurcation. "),
    ):
        explorer.open_tab(title)
        wait_until(lambda words=words: summary.text_content().startswith(words), what=f"the summary of {title}")
    explorer.open_tab("Explore")
    wait_until(lambda: summary.text_content() == told, what="the verdict again")


def test_the_first_thing_to_change_is_a_button(visit):
    explorer = visit("?eta=1.08&K=100&D=50&steps=2000").explained()
    before = float(explorer.page.locator(".part.total .number").text_content().split()[0])
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Try K =").click())
    explorer.explained()
    assert float(explorer.typed("K").input_value()) > 100
    assert float(explorer.page.locator(".part.total .number").text_content().split()[0]) < before / 3
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Undo").click())
    assert explorer.typed("K").input_value() == "100"


def test_a_failure_is_told_with_a_way_out_and_escape_brings_the_value_back(visit):
    explorer = visit()
    explorer.type("K", "7")
    explorer.page.locator("#vibroscope-K-refusal:not([hidden])").wait_for()
    assert "Escape brings back 2500" in explorer.error()
    explorer.typed("K").press("Escape")
    wait_until(lambda: explorer.error() == "", what="no error")
    assert explorer.typed("K").input_value() == "2500"


def test_system_and_solver_are_folded_away_until_they_matter(visit):
    explorer = visit()
    assert explorer.typed("restitution").is_hidden()
    other = visit("?restitution=0.8&located=yes")
    assert other.typed("restitution").input_value() == "0.8"
    other.moved(lambda: other.type("kappa", "3"))
    in_address(other, kappa="3", restitution="0.8", located="yes")
    other.type("kappa3", "3.5")
    other.page.locator("#vibroscope-kappa3-refusal:not([hidden])").wait_for()
    assert "between 1 and kappa" in other.error()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_serious_fault_in_what_is_folded_away(visit, scheme):
    explorer = visit(color_scheme=scheme)
    explorer.page.evaluate(AXE)
    explorer.page.get_by_text("System and solver").click()
    explorer.page.locator("details.take summary").click()
    assert serious(explorer.page) == []


def serious(page):
    """What axe calls serious or critical, shadow roots included: rule and elements."""
    found = page.evaluate("axe.run(document, {runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa']})")
    return [
        (fault["id"], [node["html"][:200] for node in fault["nodes"]])
        for fault in found["violations"]
        if fault["impact"] in ("serious", "critical")
    ]


SOCKETS = """window.sockets = [];
window.WebSocket = class extends WebSocket {
  constructor(...given) { super(...given); window.sockets.push(this); }
}"""


def test_a_page_that_loses_its_line_comes_back_to_its_view(windows, server):
    page = windows(viewport={"width": 1440, "height": 870}).new_page()  # nobody else's
    page.add_init_script(SOCKETS)
    explorer = Explorer(page, server).open()
    explorer.moved(lambda: explorer.type("K", "9000"))
    page.wait_for_timeout(6000)  # a page that loses it sooner is not brought back: it might do so for ever
    page.context.set_offline(True)
    page.evaluate("sockets.at(-1).close()")
    assert "The line to the server is broken" in page.locator(".lost [role=alert]").text_content()
    page.wait_for_timeout(2500)
    assert explorer.typed("K").input_value() == "9000"  # what is shown stays
    with page.expect_navigation():
        page.context.set_offline(False)
    explorer.settle(frame=1)
    assert explorer.typed("K").input_value() == "9000"
    assert page.locator(".lost").count() == 0
    explorer.moved(lambda: explorer.type("K", "9001"))
    page.close()


def test_a_session_that_the_server_ends_is_told_why(windows, server):
    page = windows(viewport={"width": 1440, "height": 900}).new_page()
    page.add_init_script(SOCKETS)
    explorer = Explorer(page, server).open()
    page.evaluate("sockets[0].send('nonsense'); sockets[0].send('nonsense'); sockets[0].send('nonsense')")
    page.locator(".lost").wait_for()
    assert "The server has ended this session: " in page.locator(".lost [role=alert]").text_content()
    with page.expect_navigation():
        page.get_by_role("link", name="Load the page again").click()
    explorer.settle(frame=1)
    page.close()
