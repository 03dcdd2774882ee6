"""Located steps of another contact law, and a stiffness that follows the step, in a browser."""

from tests.waiting import wait_until


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
