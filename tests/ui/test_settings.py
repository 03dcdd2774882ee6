"""Ways to set what is shown: a suggestion, a file, other units."""

from tests.waiting import wait_until

TOLERANCE = "Tolerance: relative rms error in per cent"


def test_the_tolerance_offered_is_met_at_the_first_click(kept):
    """The joint damping alone makes 7.7 % here."""
    explorer = kept.anew("?eta=1.08&K=2500&D=8&steps=2000").explained()
    field = explorer.page.get_by_label(TOLERANCE)
    wait_until(lambda: field.input_value() == "10", what="a tolerance that can be met")
    explorer.page.get_by_role("button", name="Suggest K").click()
    explorer.page.locator(".suggest[data-phase=done]").wait_for()
    assert explorer.page.locator(".suggest .status").text_content() == "An error of 10 % is met"


def test_a_suggestion_moves_the_sliders_and_is_one_step_back(kept):
    explorer = kept.anew("?eta=2.76&K=12000&D=18&steps=2000&located=yes")
    explorer.page.get_by_label(TOLERANCE).fill("2")
    explorer.page.get_by_role("button", name="Suggest K").click()
    explorer.page.locator(".suggest[data-phase=done]").wait_for()
    assert explorer.page.locator(".suggest .status").text_content() == "An error of 2 % is met"
    wait_until(lambda: explorer.typed("steps").input_value() != "2000", what="moved sliders")
    assert int(explorer.typed("steps").input_value()) < 100
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Undo").click())
    assert explorer.typed("steps").input_value() == "2000"
    explorer.moved(lambda: explorer.page.locator(".suggest circle").first.click())
    assert explorer.typed("steps").input_value() != "2000"
    explorer.moved(lambda: explorer.type("eta", "2.7"))
    explorer.page.locator(".suggest[data-phase=idle]").wait_for()  # it was an answer for another η


def test_a_tolerance_that_is_none_is_told_where_it_was_typed(kept):
    explorer = kept()
    explorer.page.get_by_label(TOLERANCE).fill("0")
    explorer.page.get_by_role("button", name="Suggest K").click()
    explorer.page.locator(".suggest[data-phase=failed]").wait_for()
    assert "tolerance must be a number from 0.01 to 100" in explorer.page.locator(".suggest .status").text_content()


def test_limits_a_held_stiffness_and_a_range_are_typed_where_a_search_runs(kept):
    explorer = kept.anew("?eta=2.76&K=9000&D=18&steps=2000&located=yes")
    explorer.unfold("More: ")
    explorer.page.get_by_role("button", name="Options").click()
    assert not explorer.page.get_by_label("Search over the integrators").is_visible()  # no code is chosen
    explorer.page.get_by_label(TOLERANCE).fill("50")
    explorer.page.get_by_label("Keep the present K").check()
    explorer.page.get_by_label("Most steps per period").fill("5 000 000")
    explorer.page.get_by_label("Most steps per period").press("Enter")
    explorer.page.locator(".suggest[data-phase=failed] .status", has_text="T/Δτ allowed must be").wait_for()
    explorer.page.get_by_label("Most steps per period").fill("1,000")
    explorer.page.get_by_label("Most steps per period").press("Enter")
    explorer.page.locator(".suggest[data-phase=done]").wait_for()
    wait_until(lambda: int(explorer.typed("steps").input_value()) <= 1000, what="moved sliders")
    check_box(explorer.page)
    explorer.at(eta="2.76", K="9000", D="18", steps="2000")
    for label, text in (("lowest excitation", "2.6"), ("highest excitation", "2.76")):
        explorer.page.get_by_label(label).fill(text)
    explorer.page.get_by_role("button", name="Suggest K").click()
    explorer.page.get_by_text("An error of 50 % over the range is met").wait_for(timeout=400_000)  # a minute alone
    wait_until(lambda: explorer.typed("steps").input_value() != "2000", what="moved sliders")
    assert explorer.typed("K").input_value() == "9000"
    assert "The range is limited at η = 2.76" in explorer.page.locator(".suggest .found").text_content()


def check_box(page):
    """The box of a search ends within the window, and a cue says that it scrolls."""
    box = page.locator(".suggest > .more")
    edges = box.bounding_box()
    assert edges["y"] + edges["height"] <= 900
    scrolls = box.evaluate("box => box.scrollHeight > box.clientHeight + 12")
    assert (box.get_attribute("data-more") is not None) == scrolls
    field = page.get_by_label("Most steps per period that the search may try")
    field.scroll_into_view_if_needed()
    assert field.bounding_box()["y"] < 900


def test_what_a_code_has_is_offered_once_it_is_chosen(visit):
    explorer = visit("?view=code&choice=code:abaqus-standard&eta=1.08&K=100&D=4&steps=200")
    explorer.open_tab("Explore")
    explorer.unfold("More: ")
    explorer.page.get_by_role("button", name="Options").click()
    explorer.page.get_by_text("what Abaqus/Standard has").wait_for()
    code = explorer.page.get_by_label("Search over the integrators")
    code.check()
    for label, text in ((TOLERANCE, "90"), ("Most steps per period", "64")):
        explorer.page.get_by_label(label).fill(text)
    for name in "KD":
        explorer.page.get_by_label(f"Keep the present {name}").check()
    explorer.page.get_by_role("button", name="Suggest K").click()
    explorer.page.locator(".suggest[data-phase=done]").wait_for()
    assert "What to set in Abaqus/Standard: *DYNAMIC" in explorer.page.locator(".suggest .found").text_content()


def test_a_file_is_taken_whole_or_not_at_all(kept):
    explorer = kept()
    field = explorer.page.locator(".load input")

    def load(text):
        field.set_input_files({"name": "a.toml", "mimeType": "application/toml", "buffer": text.encode()})

    filler = f"# {'x' * 9000}\n"  # longer than one part of a message
    explorer.moved(lambda: load(f"{filler}[setting]\neta = 1.3\nK = 9000\n"))
    assert (explorer.typed("eta").input_value(), explorer.typed("K").input_value()) == ("1.3", "9000")
    load("[setting]\neta = 1.4\nK = -1\n")
    wait_until(lambda: "The file was not accepted: K must be a number" in explorer.error(), what="a refusal")
    assert explorer.typed("eta").input_value() == "1.3"


def test_what_a_system_file_leaves_out_is_said_until_the_next_move(kept):
    explorer = kept()
    note = explorer.page.locator(".message.note")
    text = b"[system]\nkappa = 2.5\nmass_ratio = 2\n"
    file = {"name": "a.toml", "mimeType": "application/toml", "buffer": text}
    explorer.moved(lambda: explorer.page.locator(".load input").set_input_files(file))
    note.wait_for()
    assert note.text_content().startswith("The file was loaded. [system] describes bodies other than the paper's")
    explorer.moved(lambda: explorer.type("eta", "1.25"))
    note.wait_for(state="hidden")


def test_physical_units_reach_every_figure_and_the_address(kept):
    explorer = kept.anew("?eta=2.76&omega1=20&amplitude=2")
    plain = explorer.source("displacements")
    explorer.unfold("System")
    explorer.moved(lambda: explorer.page.get_by_label("mm-t-s").check())
    explorer.wait_for_address(units="mm-t-s", omega1="20", amplitude="2")
    physical = explorer.source("displacements")
    assert abs(physical["t"][-1] - 2 * 6.283185307 / 2.76 / 20) < 1e-6
    assert abs(physical["penalty1"][7] / plain["penalty1"][7] - 2) < 1e-5
    labels = {name: explorer.figure(name)["labels"] for name in ("phase1", "displacement", "force", "diagram")}
    assert labels["phase1"] == ["displacement x₁ / mm", "velocity x₁′ / (mm/s)"]
    assert labels["displacement"][1] == "displacements x₁, x₂ / mm"
    assert labels["force"][1:] == ["contact force / N", "impulse / (N·s)"]
    assert labels["diagram"][1].endswith("/ mm")
    low, high = explorer.figure("displacement")["x"]
    assert low == 0
    assert abs(high - physical["t"][-1]) < 1e-6
