"""Bifurcation, K–D plane and time step in a browser: growing, set by a click or a drag, silent while hidden."""

import functools
import re

import pytest

from tests.ui.explorer import PHONE
from tests.waiting import PATIENCE, wait_until

SETTING = "eta=2.76&K=12000&D=18&steps=2000"
TABS = {"bifurcation": "Bifurcation", "plane": "K–D plane"}

UPDATES = """() => {
  window.updates = [];
  for (const socket of window.sockets) socket.addEventListener("message", ({data}) => {
    // A message begins with its header; what follows, pictures and columns among it, is part of it.
    if (typeof data === "string" && data.startsWith('{"msgid"')) window.updates.push(0);
    window.updates[window.updates.length - 1] += data.size ?? data.byteLength ?? data.length;
  });
}"""


FRAME_TOP = """(name) =>
  Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name(name).id).frame.bbox.top"""


def panel(explorer):
    return explorer.page.locator("section.study").locator("visible=true")


def share(explorer):
    return float(panel(explorer).get_attribute("data-share"))


def complete(explorer, seconds=PATIENCE):
    wait_until(lambda: share(explorer) == 1, seconds, "a complete study")
    explorer.settle()
    return explorer


def opened(visit, tab):
    return complete(visit(f"?view={tab}&{SETTING}"))


def place(explorer, name, x, y):
    """Where a figure has the point (x, y) of its axes, the axes logarithmic or not."""
    return explorer.page.evaluate(
        """([name, x, y]) => {
          const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name(name).id);
          const canvas = view.canvas_view.el.getBoundingClientRect();
          return [canvas.x + view.frame.x_scale.compute(x), canvas.y + view.frame.y_scale.compute(y)];
        }""",
        [name, x, y],
    )


def test_the_plane_grows_and_a_click_sets_K_and_D(kept):
    explorer = opened(kept, "plane")
    assert explorer.figure("plane_penalty")["title"].startswith("Newmark T/2000, η = 2.76: error against reference ")
    assert explorer.figure("plane_exact")["title"].startswith("No time step, η = 2.76: error against reference ")
    text = panel(explorer).locator(".statements").text_content()
    assert "repeats every period" in text.split("Exact penalty, cell at")[1]
    explorer.page.mouse.click(*place(explorer, "plane_exact", 1000, 5))
    wait_until(lambda: abs(explorer.source("plane_mark")["K"][0] - 1000) < 30, what="the mark at the click")
    assert explorer.source("plane_mark")["D"][0] == pytest.approx(5, rel=0.03)
    wait_until(lambda: explorer.address().get("K") != "12000", what="an address with the new K")
    assert float(explorer.address()["D"]) == pytest.approx(5, rel=0.03)
    assert share(explorer) == 1  # the plane itself is the same


def test_the_plane_shows_the_error_of_what_is_set_as_explore_does(kept):
    """The cell that holds it has its middle elsewhere, with another error."""
    explorer = kept.anew("?eta=1.08&K=100&D=50&steps=2000").explained()
    total = explorer.page.locator(".part.total .number").text_content()
    explorer.open_tab("K–D plane")
    text = panel(explorer).locator(".statements")
    wait_until(lambda: f"Error {total}." in text.text_content(), what=f"an error of {total}")
    assert "Newmark, what is set: K = 100, D = 50Repeats every period" in text.text_content()
    assert panel(explorer).get_by_label("Short contact below").is_hidden()
    wait_until(lambda: share(explorer) > 0.01, what="a coarse picture")
    wait_until(lambda: ": error against reference" in explorer.figure("plane_penalty")["title"], what="errors")


def test_where_the_reference_does_not_repeat_the_plane_shows_the_period_and_says_so(visit):
    explorer = visit("?view=plane&eta=1.7&K=12000&D=18&steps=200&zoom=K:1000,2000;D:5,8")
    said, why = panel(explorer).locator(".statements"), "The reference does not repeat itself here"
    wait_until(lambda: why in said.text_content(), what="why there is no error")
    wait_until(lambda: ": period " in explorer.figure("plane_penalty")["title"], what="the period")


def test_the_plane_follows_the_limit_of_steps_and_the_quantity(kept):
    explorer = opened(kept, "plane")
    explorer.page.get_by_role("combobox", name="Colour").select_option("contact")
    key = panel(explorer).locator(".key")
    wait_until(lambda: "fewer than 30 steps" in key.text_content())
    limit = explorer.page.get_by_label("Short contact below")
    limit.fill("50")
    limit.press("Enter")
    wait_until(lambda: "fewer than 50 steps" in key.text_content())
    assert "longest contact" in explorer.figure("plane_penalty")["title"]


def test_the_plane_offers_steps_without_a_solution_where_the_status_is_that_of_the_end(visit):
    numbers = "eta=2.76&K=12000&D=18&steps=200&integrator=hht&status=end&without_solution=keep&choice=quantity:period"
    explorer = visit(f"?view=plane&{numbers}")  # a coarse picture is enough
    colour = explorer.page.get_by_role("combobox", name="Colour")
    colour.select_option("without_solution")
    key = panel(explorer).locator(".key")
    wait_until(lambda: "10 to 99" in key.text_content(), what="the classes of the counts")
    title = ": steps without a solution "
    wait_until(lambda: title in explorer.figure("plane_penalty")["title"], what="the title of the counts")
    top = functools.partial(explorer.page.evaluate, FRAME_TOP)
    wait_until(lambda: top("plane_penalty") > top("plane_exact"), what="room for the second line of the title")
    statements = panel(explorer).locator(".statements")
    wait_until(lambda: "without a solution" in statements.text_content(), what="how many of the cell")
    wait_until(lambda: "a step has no solution" in statements.text_content(), what="how many of all cells")
    explorer.page.get_by_text("start of the step", exact=True).click()  # the panel is open, since it is not as usual
    wait_until(lambda: colour.locator("option[value=without_solution]").is_disabled(), what="nothing to count")
    wait_until(lambda: "10 to 99" not in key.text_content(), what="the first picture of another method")


def test_a_study_is_cancelled_and_goes_on(visit):
    explorer = visit("?view=plane&eta=1.08&K=2500&D=8&steps=1000")
    explorer.page.locator("summary", has_text="Solver").click()
    explorer.page.get_by_text("cut at contact", exact=True).click()
    stop = panel(explorer).locator("button[data-stop]")
    wait_until(lambda: 0 < share(explorer) < 1, what="a first picture")
    stop.click()
    panel(explorer).get_by_role("button", name="Go on").wait_for()
    explorer.moved(lambda: explorer.type("K", "4000"))  # a slider is answered all the same, after what was under way
    held = share(explorer)
    explorer.moved(lambda: explorer.type("K", "5000"))
    assert share(explorer) == held
    stop.click()
    panel(explorer).get_by_role("button", name="Cancel").wait_for()
    wait_until(lambda: share(explorer) > held, what="it to go on")
    panel(explorer).get_by_role("button", name="Cancel").click()


def test_the_line_in_the_diagram_is_dragged_in_the_browser_and_sets_eta(kept):
    explorer = opened(kept, "bifurcation")
    low, high = explorer.figure("bifurcation")["y"]
    middle = 0.5 * (low + high)
    explorer.page.mouse.move(*place(explorer, "bifurcation", 2.76, middle))
    explorer.page.mouse.down()
    sent = explorer.keep_sent()
    explorer.page.mouse.move(*place(explorer, "bifurcation", 2.0, middle), steps=5)
    at_two = pytest.approx(2.0, abs=0.02)
    wait_until(lambda: explorer.model("bifurcation_cursor", "location") == at_two, what="the line at the mouse")
    assert explorer.model("bifurcation_label", "text").startswith("η = ")
    assert sent() == []
    explorer.page.mouse.up()
    wait_until(lambda: abs(float(explorer.typed("eta").input_value()) - 2.0) < 0.02, what="η at the line")
    assert explorer.figure("bifurcation")["x"] == [0.5, 4]  # the drag zoomed nothing


def test_a_hover_over_the_bifurcation_diagram_reads_eta_value_and_period(kept):
    explorer = opened(kept, "bifurcation")
    source = explorer.source("bifurcation_reference")
    at = min(range(len(source["eta"])), key=lambda i: abs(source["eta"][i] - 2.3))
    x, y = place(explorer, "bifurcation", source["eta"][at], source["value"][at])
    explorer.page.mouse.move(x - 30, y - 30)
    explorer.page.mouse.move(x, y)
    tooltip = explorer.page.locator(".bk-Tooltip")
    tooltip.wait_for()
    text = tooltip.evaluate("tip => tip.shadowRoot.textContent")
    assert f"{source['eta'][at]:.4g}" in text
    assert "period" in text


def test_a_finger_drags_the_line_and_does_not_scroll(kept):
    explorer = kept(f"?view=bifurcation&{SETTING}", **PHONE).open_view("bifurcation")
    wait_until(lambda: share(explorer) > 0, what="a first picture")
    page = explorer.page
    page.evaluate("""Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name("bifurcation").id)
        .el.scrollIntoView({ block: "center" })""")
    explorer.settle()  # once it has scrolled
    tools, scrolled = page.context.new_cdp_session(page), page.evaluate("scrollY")
    low, high = explorer.figure("bifurcation")["y"]

    def touch(kind, eta=None, lower=0.0):
        at = [] if eta is None else [place(explorer, "bifurcation", eta, low + (0.5 - lower) * (high - low))]
        points = [{"x": round(x), "y": round(y)} for x, y in at]
        tools.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    touch("touchStart", 2.76 + 0.1)  # a finger is not as exact as a mouse
    for eta, lower in ((2.5, 0.1), (2.2, 0.2), (2.0, 0.3)):
        touch("touchMove", eta, lower)
    touch("touchEnd")
    wait_until(lambda: abs(float(explorer.typed("eta").input_value()) - 2.0) < 0.03, what="η at the line")
    assert page.evaluate("scrollY") == scrolled


def test_a_tap_marks_the_time_in_all_figures(kept):
    explorer = kept(f"?view=bifurcation&{SETTING}", **PHONE).open_view("explore")
    page = explorer.page
    box = page.locator(".displacement").first
    box.scroll_into_view_if_needed()
    explorer.settle()  # once it has scrolled
    frame = box.bounding_box()
    page.touchscreen.tap(frame["x"] + 0.7 * frame["width"], frame["y"] + 0.5 * frame["height"])
    readout = page.locator(".player output")
    wait_until(lambda: float(readout.text_content().split()[1]) > 0.5, what="the time that was tapped")


def test_a_zoom_of_the_diagram_is_computed_anew_in_its_range(kept):
    explorer = opened(kept, "bifurcation")
    explorer.zoom("bifurcation", 0.6, 0.1, 0.8, 0.9)
    low, high = explorer.figure("bifurcation")["x"]
    wait_until(
        lambda: len({eta for eta in explorer.source("bifurcation_reference")["eta"] if low < eta < high}) > 300,
        what="values of η in the range",
    )
    complete(explorer)


def test_range_resolution_and_swept_number_are_typed(visit):
    explorer = visit(f"?view=bifurcation&choice=count:40;transient:100&{SETTING}")
    typed = explorer.page.locator(".numbers")
    for label, text in (("From", "2.7"), ("To", "2,9"), ("Values", "20")):
        typed.get_by_label(label, exact=True).fill(text)
        typed.get_by_label(label, exact=True).press("Enter")
    wait_until(lambda: explorer.figure("bifurcation")["x"] == [2.7, 2.9], what="the range")
    wait_until(lambda: "20 values, 100 + " in explorer.figure("bifurcation")["title"], what="the number of values")
    explorer.wait_for_address(choice="count:20;transient:100")
    typed.get_by_label("Values").fill("1")
    typed.get_by_label("Values").press("Enter")
    explorer.page.get_by_role("alert").filter(has_text="Values must be a whole number from 2").wait_for()
    explorer.page.get_by_label("Swept").select_option("K")
    wait_until(lambda: explorer.figure("bifurcation")["x"] == [10, 1e5], what="the range of K")
    wait_until(lambda: explorer.model("bifurcation_label", "text").startswith("K = "), what="the line at K")


def test_up_and_down_are_laid_over_each_other_and_the_solver_has_its_colour(visit):
    explorer = visit(f"?view=bifurcation&choice=count:480;transient:100&{SETTING}")
    for choice in ("up", "down"):
        panel(explorer).get_by_label("Start").select_option(choice)
        wait_until(lambda choice=choice: f"{choice}wards" in explorer.figure("bifurcation")["title"])
        complete(explorer)
    assert len(explorer.source("bifurcation_other")["eta"]) > 400
    explorer.page.evaluate(UPDATES)
    panel(explorer).get_by_label("Start").select_option("up")  # both are kept, and change places
    wait_until(lambda: "upwards" in explorer.figure("bifurcation")["title"])
    assert max(explorer.page.evaluate("window.updates")) < 50_000
    panel(explorer).get_by_label("Solver").select_option("exact")
    wait_until(lambda: len(explorer.source("bifurcation_penalty")["eta"]) > 0, what="the exact penalty solution")
    assert explorer.source("bifurcation_reference")["eta"] == []


def test_a_click_on_the_time_step_figure_sets_n(kept):
    explorer = opened(kept, "step")
    assert "T/2000, constant step" in explorer.figure("step_phase_fixed")["title"]
    explorer.page.mouse.click(*place(explorer, "step_error_time_step", 8300, 1e-3))
    wait_until(
        lambda: "T/8000, constant step" in explorer.figure("step_phase_fixed")["title"], what="the motion of T/8000"
    )
    explorer.wait_for_address(steps="8000", view="step")
    assert re.search(r"power of −(2\.0|1\.99)", panel(explorer).locator(".statements").text_content())


def put(explorer, **texts):
    """Set numbers as a scene or a link would, whichever tab is open."""
    act = "detail => document.dispatchEvent(new CustomEvent('vibroscope:set', {detail}))"
    explorer.moved(lambda: explorer.page.evaluate(act, texts))


@pytest.mark.parametrize("tab", ["bifurcation", "plane"])
def test_no_update_is_large_and_what_is_hidden_costs_nothing(kept, tab):
    explorer = opened(kept, tab)
    if tab == "plane":
        explorer.page.get_by_role("combobox", name="Colour").select_option("contact")  # with stripes: the most
    explorer.settle()
    explorer.page.evaluate(UPDATES)
    put(explorer, kappa="2.4")
    complete(explorer)
    assert 1_000 < max(explorer.page.evaluate("window.updates")) < 50_000
    explorer.open_tab("Help")
    explorer.settle()
    received, costs = explorer.count_messages(), []
    for kappa in ("2.38", "2.39"):  # what was asked for before may still come during the first
        before = received()
        put(explorer, K="3000", kappa=kappa)
        explorer.page.wait_for_timeout(400)  # long enough for what must not come
        costs.append(received() - before)
    assert min(costs) < 4_000
    put(explorer, K="12000", kappa="2.4")
    before = received()
    explorer.open_tab(TABS[tab])
    complete(explorer)
    assert received() - before < 50_000  # it is kept, and does not grow anew


# Colours of patches; of one that has just been replaced there is none.
PATCH_COLOURS = """all => all
  .map(patch => getComputedStyle(patch).backgroundColor.match(/\\d+/g))
  .map(parts => parts && "#" + parts.map(part => Number(part).toString(16).padStart(2, "0")).join("").toUpperCase())
"""


def test_the_key_has_the_colours_of_the_cells_in_the_dark_too(visit):
    explorer = visit("?view=plane&choice=quantity:error&theme=dark")
    wait_until(lambda: "no number" in panel(explorer).locator(".key").text_content(), what="the key")
    mapper = "[...Bokeh.documents[0].all_models].find(model => model.type === 'LinearColorMapper')"
    explorer.until(f"!!{mapper}")
    palette = explorer.page.evaluate(f"{mapper}.palette")
    patches = panel(explorer).locator(".key .patch:not(.cross, .veil)")
    seen = []

    def complete_key():
        seen[:] = patches.evaluate_all(PATCH_COLOURS)
        return len(seen) == 7 and None not in seen

    wait_until(complete_key, what="seven patches, none of which is drawn anew")
    assert set(seen) <= set(palette)
