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
