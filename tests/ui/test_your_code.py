"""Tab Your code in a browser: choosing a code sets it, rules come one after the other, and one of them can be set."""

from tests.ui.test_studies import complete
from tests.waiting import wait_until

SETTING = "?view=code&eta=1.08&K=2500&D=8&steps=2000"


def rows(explorer):
    return explorer.page.locator("section.codes tbody tr")


def choose(explorer, code):
    explorer.page.locator("select").filter(has_text="choose a code").select_option(code)
    explorer.wait_for_address(choice=f"code:{code}")


def test_choosing_a_code_sets_it_and_undo_goes_back(kept):
    explorer = kept(SETTING)
    choose(explorer, "mujoco")
    explorer.wait_for_address(integrator="semi-implicit-euler", law="cut", view="code")
    words = explorer.page.locator("section.codes pre")
    wait_until(lambda: "solref" in words.text_content(), what="the words of the code")
    explorer.page.get_by_role("button", name="Undo").click()
    explorer.wait_for_address(K="2500", D="8")
    wait_until(lambda: "law" not in explorer.address(), what="the former law")


def test_choosing_codes_leaves_k_d_and_the_step_and_reset_chooses_none(kept):
    explorer = kept(SETTING)
    for code in ("abaqus-standard", "ls-dyna-explicit", "opensees"):
        choose(explorer, code)
        explorer.wait_for_address(K="2500", D="8", steps="2000")
    words = explorer.page.locator("section.codes pre")
    wait_until(lambda: "integrator" in words.text_content(), what="the input for OpenSees")
    assert words.locator(".term").count() == 0  # none is marked in what is to be copied
    explorer.page.get_by_role("button", name="Reset").click()
    wait_until(lambda: "choice" not in explorer.address(), what="no code")
    assert explorer.page.locator("select").filter(has_text="choose a code").input_value() == "none"
    wait_until(lambda: "integrator" not in explorer.address(), what="the opening scene")


def test_the_rules_come_with_pictures_and_one_can_be_set(visit):
    explorer = complete(visit(f"{SETTING}&choice=code:ls-dyna-explicit;elements:5"))
    assert rows(explorer).count() == 17
    assert explorer.page.locator("section.codes button:focus").count() == 0  # it stays where it was
    marked = explorer.page.locator("section.codes tr.marked")
    assert marked.count() == 3  # those of the code come first
    assert rows(explorer).nth(1).get_attribute("class") == "marked"
    assert explorer.page.locator("section.codes svg path.penalty").count() > 8
    row = rows(explorer).filter(has_text="50 times the stiffness of the elements")
    row.get_by_role("button").click()
    wait_until(lambda: explorer.address()["K"] == "250", what="50 times the elements")


def test_it_fits_a_phone_and_the_code_is_chosen_first(visit):
    explorer = complete(visit(f"{SETTING}&choice=code:calculix", 390, 844))
    assert explorer.page.evaluate("document.documentElement.scrollWidth") <= 390
    panel = explorer.page.locator("section.study").locator("visible=true").bounding_box()
    assert panel["y"] < rows(explorer).first.bounding_box()["y"]
    figure = explorer.page.locator("section.codes svg").first.bounding_box()
    assert 0 <= figure["x"] < figure["x"] + figure["width"] <= 390


def test_words_of_one_code_are_shown_in_those_of_another_and_can_be_set(visit):
    explorer = visit(f"{SETTING}&units=si&omega1=10&m1=2&amplitude=3&choice=code:mujoco;target:bullet")
    explorer.page.locator("section.study input[name=words]").fill("solref=-250 -4")
    explorer.page.keyboard.press("Enter")
    panel = explorer.page.locator("section.study .statements").locator("visible=true")
    wait_until(lambda: "contactStiffness=" in panel.text_content(), what="the words of Bullet")
    assert "K = " in panel.text_content()
    row = rows(explorer).filter(has_text="Words of MuJoCo")
    row.get_by_role("button").click()
    explorer.wait_for_address(law="cut")
    wait_until(lambda: explorer.address()["K"] != "2500", what="the stiffness that the words say")
