"""The page in a real browser: what a user does, and what must then be on the screen."""

import json
from urllib.parse import parse_qs, quote
from urllib.request import urlopen

from vibroscope.app.explorer.state import Setting

from .conftest import SOURCES, wait_until

FIGURES = ("phase1", "phase2", "displacement", "strip", "force", "diagram")


def address(explorer):
    return {name: texts[0] for name, texts in parse_qs(explorer.query()[1:]).items()}


def in_address(explorer, **wanted):
    wait_until(lambda: wanted.items() <= address(explorer).items(), 5, f"{wanted} in the address")


def test_a_slider_moved_by_the_keyboard_changes_all_figures_and_the_address(visit):
    explorer = visit()
    before = explorer.sources()
    explorer.slider("eta").focus()
    explorer.moved(lambda: explorer.page.keyboard.press("ArrowRight"))
    after = explorer.sources()
    assert [name for name in SOURCES if before[name] == after[name]] == []
    assert explorer.typed("eta").input_value() == "1.09"
    in_address(explorer, eta="1.09", K="2500", D="8", steps="2000")


def test_a_typed_value_is_taken_as_it_is(visit):
    explorer = visit()
    explorer.moved(lambda: explorer.type("K", "3141.59"))
    in_address(explorer, K="3141.59")
    assert explorer.typed("K").input_value() == "3141.59"


def test_what_is_being_typed_stays_while_answers_come(visit):
    explorer = visit()
    explorer.typed("K").fill("31")
    other = """document.dispatchEvent(new CustomEvent("vibroscope:set", { detail: { eta: "1.2" } }))"""
    explorer.moved(lambda: explorer.page.evaluate(other))
    assert explorer.typed("K").input_value() == "31"
    explorer.typed("K").press("End")
    explorer.typed("K").press_sequentially("41")
    explorer.moved(lambda: explorer.typed("K").press("Enter"))
    in_address(explorer, K="3141", eta="1.2")
    explorer.typed("D").fill("9")
    explorer.typed("D").press("Backspace")
    explorer.typed("D").press("8")  # what it was
    explorer.typed("D").blur()
    explorer.moved(lambda: explorer.scene("B"))
    in_address(explorer, D=explorer.typed("D").input_value())
    assert address(explorer)["D"] != "8"


def test_a_scene_comes_after_the_moves_that_still_wait(visit):
    explorer = visit()
    explorer.page.evaluate("""for (const eta of ["1.2", "1.25", "1.3"]) {
        document.dispatchEvent(new CustomEvent("vibroscope:set", { detail: { eta } }));
    }
    document.dispatchEvent(new CustomEvent("vibroscope:scene", { detail: { value: "C" } }))""")
    in_address(explorer, eta="2.76")
    explorer.page.wait_for_timeout(600)
    assert explorer.typed("eta").input_value() == address(explorer)["eta"] == "2.76"
    explorer.page.keyboard.press("Control+z")
    in_address(explorer, eta="1.3")


def test_only_the_penalty_solution_depends_on_the_penalty_numbers(visit):
    explorer = visit()
    before = explorer.sources()
    explorer.moved(lambda: explorer.type("D", "20"))
    after = explorer.sources()
    changed = {name for name in SOURCES if before[name] != after[name]}
    assert changed == {name for name in SOURCES if name.endswith("penalty")} | {"displacements"}
    assert before["displacements"]["reference1"] == after["displacements"]["reference1"]


def test_a_bad_value_is_refused_in_words_and_nothing_moves(visit):
    explorer = visit()
    before = explorer.sources()
    for name, text in (("eta", "7"), ("K", "nan"), ("steps", "1e999"), ("D", "²"), ("steps", "2000.5"), ("eta", "")):
        explorer.type(name, text)
        explorer.page.locator(f"#vibroscope-{name}-typed[aria-invalid=true]").wait_for()
        assert f"{name} must be" in explorer.error()
    assert explorer.sources() == before
    in_address(explorer, eta="1.08", K="2500", D="8", steps="2000")
    explorer.moved(lambda: explorer.type("eta", "1.2"))
    assert explorer.error() == ""


def test_sliders_and_switches_forged_in_the_browser_are_refused(visit):
    explorer = visit()
    before = explorer.sources()
    forged = [
        {"set": {"eta": 1e9}},
        {"set": {"eta": None}},
        {"set": {"frame": "__class__"}},
        {"set": ["eta"]},
        {"scene": 3},
        {"tab": ["help"]},
        {"tab": "nonsense"},
        {"take": {"csv": 1}},
        {"take": "csv:nonsense"},
        {"set": {"K": "2000", "D": "-1"}},
        "text",
        None,
        {"painted": "x"},
        {"move": "x"},
    ]
    explorer.page.evaluate(FORGE, forged)
    explorer.page.locator(".refusal:not([hidden])").first.wait_for()
    assert explorer.sources() == before
    explorer.moved(lambda: explorer.type("eta", "1.2"))


FORGE = """forged => {
  const model = [...Bokeh.documents[0].all_models].find(m => m.class_name === "Controls");
  const view = Bokeh.index.find_one_by_id(model.id);
  forged.forEach(data => view.model_proxy.send_msg(data));
}"""


def test_a_link_restores_its_state(visit):
    first = visit()
    first.moved(lambda: first.type("eta", "2.7612345"))
    first.page.get_by_text("System and solver").click()
    first.moved(lambda: first.page.locator("[name=vibroscope-joint_damping][value=derived]").set_checked(True))
    first.moved(lambda: first.page.get_by_text("absolute").click())
    in_address(first, eta="2.7612345", joint_damping="derived", frame="absolute")
    second = visit(first.query())
    assert second.sources() == first.sources()
    assert second.typed("eta").input_value() == "2.7612345"
    assert second.page.get_by_label("absolute").is_checked()


def test_a_half_valid_address_is_not_taken_at_all_and_the_page_says_so(visit):
    explorer = visit("?eta=2.76&K=nan&D=18")
    assert "K must be a number from 10 to 100000" in explorer.error()
    assert explorer.typed("eta").input_value() == "1.08"


def test_hostile_addresses_never_break_the_page(visit, server):
    long = "?steps=" + "9" * 5000
    for query in ("?eta=²", "?eta=" + "9" * 1900, "?eta=%FF%FE", "?eta=1&eta=2", "?eta=1e999", "?pin=eta%3D²", long):
        assert urlopen(server + "/" + quote(query, safe="?&=%"), timeout=20).status == 200, query
    for query in ("?eta=²", long):
        assert visit(query).error() != "", query


def test_a_second_session_is_independent(visit):
    first, second = visit(), visit()
    before = second.sources()
    first.moved(lambda: first.scene("C"))
    assert second.sources() == before
    assert second.typed("eta").input_value() == "1.08"
    second.moved(lambda: second.type("eta", "3.1"))
    assert first.typed("eta").input_value() == "2.76"


def test_scene_buttons_set_all_four_numbers(visit):
    explorer = visit()
    explorer.moved(lambda: explorer.scene("[B]", "Figure 14"))
    in_address(explorer, eta="2.76", K="12000", D="18", steps="4000")
    assert "Δτ = T/4000" in explorer.form.text_content()
    pressed = explorer.page.locator("button[aria-pressed=true]")
    assert [button.get_attribute("aria-label").split(":")[0] for button in pressed.all()] == ["Figure 14 [B]"]


def test_a_click_in_the_diagram_sets_eta(visit):
    explorer = visit()
    box = explorer.figure("diagram")["frame"]
    explorer.moved(lambda: explorer.page.mouse.click(box["x"] + box["width"] * 2 / 7, box["y"] + box["height"] / 2))
    eta = float(explorer.typed("eta").input_value())
    assert abs(eta - 1.5) < 0.01
    in_address(explorer, eta=explorer.typed("eta").input_value())


def test_zoom_survives_updates_and_a_scene_gives_it_back(visit):
    explorer = visit()
    explorer.zoom("displacement", 0.2, 0.6, 0.2, 0.7)
    wait_until(lambda: explorer.figure("displacement")["x"] != [0, 2], what="zoom")
    zoomed = explorer.figure("displacement")
    assert explorer.figure("force")["x"] == explorer.figure("strip")["x"] == zoomed["x"]
    explorer.page.wait_for_timeout(300)
    for text in ("1.1", "1.2", "2.5"):
        explorer.moved(lambda text=text: explorer.type("eta", text))
    now = explorer.figure("displacement")
    assert (now["x"], now["y"]) == (zoomed["x"], zoomed["y"])
    explorer.moved(lambda: explorer.scene("C"))
    now = explorer.figure("displacement")
    assert now["x"] == [0, 2]
    assert now["y"] != zoomed["y"]


def test_no_figure_is_rebuilt_by_an_update(visit):
    explorer = visit()
    identities = """() => [...Bokeh.documents[0].all_models].filter(m => m.type === "Figure").map(m => m.id).sort()"""
    before = explorer.page.evaluate(identities)
    explorer.moved(lambda: explorer.scene("D"))
    assert explorer.page.evaluate(identities) == before


def test_a_diverged_penalty_run_is_told_and_the_reference_stays(visit):
    explorer = visit("?eta=1.08&K=100000&D=100&steps=2000")
    before = explorer.sources()
    explorer.moved(lambda: explorer.type("steps", "100"))
    after = explorer.sources()
    if "step" not in explorer.line("penalty"):
        raise AssertionError(explorer.line("penalty"))
    assert after["phase_penalty"]["x1"] == []
    assert set(after["displacements"]["penalty1"]) == {None}
    assert after["phase_reference"] == before["phase_reference"]
    explorer.explained()
    assert "nothing to compare" in explorer.line("verdict")


def test_a_drag_ends_on_its_last_value(visit):
    explorer = visit("?eta=2.76&K=12000&D=18&steps=32000")
    slider = explorer.slider("eta")
    slider.focus()
    for _ in range(25):
        explorer.page.keyboard.press("ArrowRight")
    shown = lambda: explorer.source("section_reference")["eta"][0]  # noqa: E731
    wait_until(lambda: abs(shown() - 3.01) < 1e-5, 30, "the last value's figures")
    assert explorer.typed("eta").input_value() == "3.01"
    in_address(explorer, eta="3.01")


def test_slow_work_says_that_it_is_under_way(visit):
    explorer = visit("?eta=1.08&K=2500&D=8&steps=31999")
    explorer.page.evaluate("""() => {
      window.marks = [];
      const find = root => root.querySelector?.(".busy") ?? [...root.querySelectorAll("*")]
        .map(e => e.shadowRoot && find(e.shadowRoot)).find(Boolean);
      const mark = find(document);
      new MutationObserver(() => window.marks.push(mark.hidden)).observe(mark, {attributes: true});
    }""")
    explorer.moved(lambda: explorer.type("steps", "32000"))
    assert explorer.page.locator(".busy").is_hidden()
    assert explorer.page.evaluate("window.marks")[-1] is True


def test_on_a_phone_a_slider_is_in_view_beside_what_it_changes(visit):
    explorer = visit(width=390, height=844, has_touch=True)
    page = explorer.page
    slider, figure = page.locator("#vibroscope-eta-slider"), page.locator(".cell.force").first
    for each in (figure, slider):
        each.scroll_into_view_if_needed()
    inside = [box["y"] >= 0 and box["y"] + 100 <= 844 for box in (slider.bounding_box(), figure.bounding_box())]
    assert inside == [True, True]
    panel = page.locator(".sliders").bounding_box()
    assert panel["height"] < 0.35 * 844
    assert figure.bounding_box()["y"] + figure.bounding_box()["height"] > panel["y"] + panel["height"] + 100


def test_on_a_phone_nothing_overflows_and_everything_is_there(visit):
    explorer = visit(width=390, height=844, has_touch=True)
    sizes = explorer.page.evaluate("""() => {
      const wide = [];
      const walk = root => root.querySelectorAll("*").forEach(e => {
        const box = e.getBoundingClientRect();
        if (box.width > 0 && (box.right > innerWidth + 1 || box.left < -1)) wide.push(e.tagName + "." + e.className);
        if (e.shadowRoot && !e.classList.contains("bk-Figure")) walk(e.shadowRoot);
      });
      walk(document);
      return [document.documentElement.scrollWidth, wide];
    }""")
    assert sizes == [390, []]
    for name in FIGURES:
        assert explorer.figure(name)["box"]["width"] > 340
    explorer.moved(lambda: explorer.scene("C"))


def test_on_a_desktop_everything_is_in_view_without_scrolling(visit):
    explorer = visit()
    boxes = {name: explorer.figure(name)["box"] for name in FIGURES}
    boxes |= {name: explorer.page.locator(name).bounding_box() for name in ("form.panel", ".told .verdict")}
    for name, box in boxes.items():
        assert box["x"] >= 0, name
        assert box["y"] >= 0, name
        assert box["x"] + box["width"] <= 1440, name
        assert box["y"] + box["height"] <= 900, name
    assert explorer.form.evaluate("form => form.scrollHeight <= form.clientHeight + 1")


def test_the_time_figures_stand_above_each_other(visit):
    explorer = visit()
    frames = [explorer.figure(name)["frame"] for name in ("displacement", "strip", "force")]
    assert len({(round(f["x"]), round(f["width"])) for f in frames}) == 1


def test_axes_carry_symbols_and_units(visit):
    explorer = visit()
    labels = json.dumps([explorer.figure(name)["labels"] for name in FIGURES], ensure_ascii=False)
    for symbol in ("ξ₁ / base amplitude", "ξ₁′", "ξ₂′", "τ/T", "λ", "∫λ dτ", "η = Ω/ω₁", "base amplitude"):
        assert symbol in labels


def test_every_field_of_the_setting_has_a_control(visit):
    explorer = visit()
    for name in Setting._fields:
        assert explorer.page.locator(f"#vibroscope-{name}-typed, [name=vibroscope-{name}]").count() >= 1


def test_a_refused_link_leaves_complete_controls(visit):
    explorer = visit("?eta=nan")
    assert "The link was not taken" in explorer.error()
    assert explorer.typed("eta").input_value() == "1.08"
    assert explorer.page.locator("[aria-invalid=true]").count() == 0
    assert explorer.query() == "?eta=nan"
    explorer.moved(lambda: explorer.type("eta", "2"))
    assert explorer.error() == ""
    in_address(explorer, eta="2")


def test_the_figure_of_speed_and_error_is_shown_and_opens_by_itself(visit):
    explorer = visit()
    explorer.open_tab("Speed against error")
    explorer.page.locator("img.figure").evaluate("async image => { await image.decode(); return image.naturalWidth; }")
    link = explorer.page.get_by_role("link", name="Open the figure by itself")
    with explorer.page.context.expect_page() as opened:
        link.click()
    figure = opened.value
    figure.wait_for_load_state()
    assert figure.locator("svg text", has_text="Vibroscope").count() > 0
    figure.close()
