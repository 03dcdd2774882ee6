"""The panel of inputs in a real browser: sliders, typed values, scenes, refusals."""

from vibroscope.app.explorer.parameters import FIELDS, FORM_FIELDS

from tests.ui.explorer import PAPER, SOURCES
from tests.waiting import wait_until

SCENE_A = {"eta": "1.08", "K": "2500", "D": "8", "steps": "2000"}


def test_a_slider_moved_by_the_keyboard_changes_all_figures_and_the_address(kept):
    explorer = kept(PAPER)
    before = explorer.sources()
    explorer.slider("eta").focus()
    explorer.moved(lambda: explorer.page.keyboard.press("ArrowRight"))
    after = explorer.sources()
    assert [name for name in SOURCES if before[name] == after[name]] == []
    assert explorer.typed("eta").input_value() == "1.09"
    explorer.wait_for_address(eta="1.09", K="2500", D="8", steps="2000")


def test_a_typed_value_is_accepted_as_it_is_and_separators_are_read_or_refused_in_words(kept):
    explorer = kept(PAPER)
    explorer.moved(lambda: explorer.type("K", "3141.59"))
    explorer.wait_for_address(K="3141.59")
    assert explorer.typed("K").input_value() == "3141.59"
    explorer.moved(lambda: explorer.type("steps", "20,000"))
    explorer.wait_for_address(steps="20000")
    assert explorer.typed("steps").input_value() == "20000"
    explorer.type("K", "12,000")
    wait_until(lambda: "“12,000” can mean 12000 or 12" in explorer.error(), what="a refusal")
    explorer.moved(lambda: explorer.type("K", "12 000"))
    explorer.wait_for_address(K="12000", steps="20000")


def test_a_field_takes_what_its_slider_does_not_reach(kept):
    explorer = kept.anew("?eta=2.76&K=120000&D=18&steps=2000").open_view("plane")
    assert explorer.typed("K").input_value() == "120000"
    assert explorer.figure("plane_penalty")["x"] == [10, 1e6]  # the mark is in view
    explorer.open_tab("Explore")
    assert explorer.figure("diagram")["x"] == [0.5, 4]
    explorer.moved(lambda: explorer.type("D", "0"))
    explorer.wait_for_address(D="0", K="120000")
    assert float(explorer.slider("D").input_value()) == -1
    explorer.slider("K").focus()
    explorer.moved(lambda: explorer.page.keyboard.press("ArrowLeft"))
    explorer.wait_for_address(K="97700")  # one step below the end of the slider


def test_an_answer_does_not_change_what_is_being_typed(kept):
    explorer = kept(PAPER).at(**SCENE_A)
    explorer.typed("K").fill("31")
    other = """document.dispatchEvent(new CustomEvent("vibroscope:set", { detail: { eta: "1.2" } }))"""
    explorer.moved(lambda: explorer.page.evaluate(other))
    assert explorer.typed("K").input_value() == "31"
    explorer.typed("K").press("End")
    explorer.typed("K").press_sequentially("41")
    explorer.moved(lambda: explorer.typed("K").press("Enter"))
    explorer.wait_for_address(K="3141", eta="1.2")
    explorer.typed("D").fill("9")
    explorer.typed("D").press("Backspace")
    explorer.typed("D").press("8")  # what it was
    explorer.typed("D").blur()
    explorer.moved(lambda: explorer.scene("B"))
    explorer.wait_for_address(D=explorer.typed("D").input_value())
    assert explorer.address()["D"] != "8"


def test_a_scene_comes_after_the_moves_that_still_wait(kept):
    explorer = kept.anew()
    explorer.page.evaluate("""for (const eta of ["1.2", "1.25", "1.3"]) {
        document.dispatchEvent(new CustomEvent("vibroscope:set", { detail: { eta } }));
    }
    document.dispatchEvent(new CustomEvent("vibroscope:scene", { detail: { value: "C" } }))""")
    explorer.wait_for_address(eta="2.76")
    assert explorer.typed("eta").input_value() == "2.76"  # the address comes after the last answer
    explorer.page.keyboard.press("Control+z")
    explorer.wait_for_address(eta="1.3")


def test_only_the_penalty_solution_depends_on_the_penalty_numbers_and_a_scene_sets_all_four(kept):
    explorer = kept(PAPER).at(**SCENE_A)
    before = explorer.sources()
    explorer.moved(lambda: explorer.type("D", "20"))
    after = explorer.sources()
    changed = {name for name in SOURCES if before[name] != after[name]}
    assert changed == {name for name in SOURCES if name.endswith("penalty")} | {"displacements"}
    assert before["displacements"]["reference1"] == after["displacements"]["reference1"]
    explorer.moved(lambda: explorer.scene("14B"))
    explorer.wait_for_address(eta="2.76", K="12000", D="18", steps="4000")
    assert "Δτ = T/4000" in explorer.form.text_content()
    pressed = explorer.page.locator("button[aria-pressed=true]")
    assert [button.get_attribute("data-scene") for button in pressed.all()] == ["14B"]


def test_a_drag_ends_on_its_last_value(kept):
    explorer = kept(PAPER).at(eta="2.76", K="12000", D="18", steps="32000")
    slider = explorer.slider("eta")
    slider.focus()
    for _ in range(25):
        explorer.page.keyboard.press("ArrowRight")
    shown = "section_reference"
    wait_until(lambda: abs(explorer.source(shown)["eta"][0] - 3.01) < 1e-5, what="the last value's figures")
    assert explorer.typed("eta").input_value() == "3.01"
    explorer.wait_for_address(eta="3.01")


def test_a_slow_computation_is_announced(kept):
    explorer = kept(PAPER).at(**SCENE_A | {"steps": "31999"})
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


def test_the_page_says_why_a_bad_value_is_refused_and_nothing_moves_and_escape_restores_it(kept):
    explorer = kept(PAPER).at(**SCENE_A)
    before = explorer.sources()
    labels = {"eta": "η", "steps": "T/Δτ"}
    for name, text in (("eta", "7e3"), ("K", "nan"), ("steps", "1e999"), ("D", "²"), ("steps", "2000.5"), ("eta", "")):
        explorer.type(name, text)
        explorer.page.locator(f"#vibroscope-{name}-typed[aria-invalid=true]").wait_for()
        assert f"{labels.get(name, name)} must be" in explorer.error()
    assert explorer.sources() == before
    explorer.wait_for_address(eta="1.08", K="2500", D="8", steps="2000")
    explorer.moved(lambda: explorer.type("eta", "1.2"))
    assert explorer.error() == ""
    explorer.type("K", "-7")
    explorer.page.locator("#vibroscope-K-refusal:not([hidden])").wait_for()
    assert "Escape brings back 2500" in explorer.error()
    explorer.typed("K").press("Escape")
    wait_until(lambda: explorer.error() == "", what="no error")
    assert explorer.typed("K").input_value() == "2500"


def test_every_field_has_a_control_and_what_is_forged_in_the_browser_is_refused(kept):
    explorer = kept(PAPER)
    before = explorer.sources()
    forged = [
        {"set": {"eta": 1e9}},
        {"set": {"eta": None}},
        {"set": {"frame": "__class__"}},
        {"set": ["eta"]},
        {"scene": 3},
        {"view": ["help"]},
        {"view": "nonsense"},
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
    explorer.moved(lambda: explorer.type("eta", "1.35"))
    # The four numbers of the start set one of them; the fields of the system say in which form a number was given.
    for name in set(FIELDS) - {"zero_start", "held", *FORM_FIELDS}:
        assert explorer.page.locator(f"#vibroscope-{name}-typed, [name=vibroscope-{name}]").count() >= 1
    assert explorer.typed("restitution").is_hidden()  # system and solver are folded


FORGE = """forged => {
  const model = [...Bokeh.documents[0].all_models].find(m => m.class_name === "Controls");
  const view = Bokeh.index.find_one_by_id(model.id);
  forged.forEach(data => view.model_proxy.send_msg(data));
}"""


def test_system_and_solver_are_unfolded_where_one_is_not_the_default(visit):
    other = visit("?restitution=0.8&located=yes")
    assert other.typed("restitution").input_value() == "0.8"
    other.moved(lambda: other.type("kappa", "3"))
    other.wait_for_address(kappa="3", restitution="0.8", located="yes")
    other.type("kappa3", "3.5")
    other.page.locator("#vibroscope-kappa3-refusal:not([hidden])").wait_for()
    assert "between 1 and kappa" in other.error()


def test_a_damper_that_follows_the_restitution_locks_its_slider(kept):
    explorer = kept.anew("?eta=1.08&K=2500&D=8&steps=200")
    switch = explorer.page.get_by_role("group", name="Damper")
    slider, typed = (explorer.page.locator(f"#vibroscope-D-{kind}") for kind in ("slider", "typed"))
    explorer.page.locator("summary", has_text="Solver").click()
    explorer.page.locator("#vibroscope-law").select_option("impact")  # no formula gives its damper
    explorer.wait_for_address(law="impact")
    assert switch.is_hidden()
    explorer.page.locator("#vibroscope-law").select_option("constant-restitution")
    explorer.wait_for_address(law="constant-restitution")
    switch.get_by_label("from the restitution").check()
    explorer.wait_for_address(damper="restitution")
    assert slider.is_disabled()
    assert typed.is_disabled()
    assert typed.input_value() != "8"
    switch.get_by_label("D as typed").check()
    wait_until(lambda: "damper" not in explorer.address(), what="the damper as typed")
    assert slider.is_enabled()
    assert typed.input_value() == "8"


def test_undo_redo_and_reset(visit):
    explorer = visit(PAPER)
    explorer.moved(lambda: explorer.type("eta", "1.5"))
    explorer.moved(lambda: explorer.type("K", "9000"))
    explorer.page.locator("h1").click()
    explorer.moved(lambda: explorer.page.keyboard.press("Control+z"))
    assert (explorer.typed("eta").input_value(), explorer.typed("K").input_value()) == ("1.5", "2500")
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Undo").click())
    assert explorer.typed("eta").input_value() == "1.08"
    assert explorer.page.get_by_role("button", name="Undo").is_hidden()  # it has nothing to do
    explorer.page.locator("h1").click()
    explorer.moved(lambda: explorer.page.keyboard.press("Control+Shift+Z"))
    assert explorer.typed("eta").input_value() == "1.5"
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Back to the opening scene").click())
    explorer.wait_for_address(eta="1.08", K="100")  # the opening scene


def test_located_steps_of_another_law_are_explained_and_judged_by_rules(kept):
    explorer = kept.anew("?eta=2.76&K=1200&D=18&steps=200&law=limited").explained()
    whole = explorer.source("phase_penalty")["v2"]
    explorer.unfold("Solver")
    switch = explorer.page.get_by_role("group", name="Contact changes")
    explorer.moved(lambda: switch.get_by_label("cut at contact").check())
    explorer.wait_for_address(located="yes", law="limited")
    assert explorer.source("phase_penalty")["v2"] != whole
    explorer.explained()
    assert explorer.error() == ""
    explorer.open_tab("Your code")
    words = explorer.page.locator("section.study").locator("visible=true")
    wait_until(lambda: "every step has a solution" in words.text_content(), what="whether steps have solutions")
    assert "steps cut where contact changes; contact law limited damper" in words.text_content()


def test_a_stiffness_that_follows_the_step_locks_its_slider(kept):
    explorer = kept.anew("?eta=2.76&K=12000&D=18&steps=200")
    switch = explorer.page.get_by_role("group", name="Stiffness")
    slider, typed = (explorer.page.locator(f"#vibroscope-K-{kind}") for kind in ("slider", "typed"))
    scale = explorer.typed("step_scale")
    explorer.page.locator("summary", has_text="Solver").click()
    assert scale.is_hidden()
    explorer.moved(lambda: switch.get_by_label("follows the step").check())
    explorer.wait_for_address(stiffness="step")
    assert slider.is_disabled()
    assert typed.is_disabled()
    before = float(typed.input_value())
    explorer.moved(lambda: explorer.type("steps", "400"))
    wait_until(lambda: abs(float(typed.input_value()) / before - 4) < 1e-3, what="four times K at half the step")
    explorer.moved(lambda: explorer.type("step_scale", "0.2"))
    wait_until(lambda: abs(float(typed.input_value()) / before - 8) < 1e-3, what="twice K with twice s")
    explorer.moved(lambda: switch.get_by_label("K as typed").check())
    wait_until(lambda: "stiffness" not in explorer.address(), what="K as typed")
    assert slider.is_enabled()
    assert scale.is_hidden()


TWO_CYCLES = "?eta=3.2&K=12000&D=18&steps=2000"  # the reference: 2 periods from rest, 6 from other starts


def test_a_start_is_typed_and_a_click_on_a_coexisting_motion_runs_it(kept):
    page = kept.anew(TWO_CYCLES).explained()
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
