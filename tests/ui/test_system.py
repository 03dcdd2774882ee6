"""The panel System: a system of one's own, its drawing, the shelf, errors beside the fields; on a phone, too."""

from tests.served import ROOT
from tests.ui.axe import AXE, serious_in
from tests.waiting import wait_until

PHONE = {"width": 320, "height": 640, "has_touch": True, "is_mobile": True}


def panel(explorer):
    return explorer.page.locator("details.system")


def open_panel(explorer):
    panel(explorer).locator("> summary").click()
    return explorer


def between(explorer):
    """Pixels between the bodies of the drawing at rest."""
    found = explorer.page.locator(".at-rest .bob").evaluate_all(
        "bodies => bodies.map(body => body.getBoundingClientRect()).map(({left, right}) => [left, right])"
    )
    return found[1][0] - found[0][1]


def test_an_analysts_system_is_entered_as_on_a_data_sheet(kept, visit):
    explorer = open_panel(kept.anew("?units=si"))
    explorer.moved(lambda: panel(explorer).get_by_label("two bodies").check())
    panel(explorer).get_by_label("spring between body 1 and the base; 0: none: its unit").select_option("frequency1_Hz")
    panel(explorer).get_by_label("spring between body 2 and the base; 0: none: its unit").select_option("frequency2_Hz")
    numbers = {"mass1_kg": "2", "frequency1_Hz": "15", "mass2_kg": "1.2", "frequency2_Hz": "32", "clearance_mm": "0.25"}
    numbers |= {"damping1_ratio": "1 %", "damping2_ratio": "1 %", "restitution": "0.7", "base_amplitude_mm": "0.5"}
    for name, text in (numbers | {"eta": "28 Hz"}).items():
        explorer.type(name, text)  # without a look at the figures of each
    explorer.wait_for_address(bodies="two", mass_ratio="0.6", clearance="0.5", restitution="0.7", units="si")
    assert explorer.error() == ""
    assert explorer.typed("mass1_kg").input_value() == "2"
    assert explorer.typed("stiffness1_N_per_m").is_hidden()
    second = visit(explorer.query())
    assert second.typed("clearance_mm").input_value() == "0.25"
    assert second.typed("damping1_ratio").input_value() == "0.01"
    assert "Two bodies" in second.page.locator(".at-rest").get_attribute("aria-label")


def test_the_drawing_follows_what_is_typed_before_it_is_sent(kept):
    explorer = kept.anew("?bodies=two&clearance=1")
    explorer.unfold("System")
    wide = between(explorer)
    assert wide > 10
    explorer.typed("clearance").fill("0.5")  # not entered yet
    assert 0 < between(explorer) < wide
    explorer.typed("clearance").fill("-1")
    assert abs(between(explorer)) < 1  # a preload presses them together
    assert "clearance=1" in explorer.query()
    assert "preload" in explorer.page.locator(".at-rest").text_content()


def test_a_field_tells_its_range_and_units_and_what_is_wrong_and_escape_brings_the_number_back(kept):
    explorer = kept.anew("?bodies=wall&units=si&clearance=1")
    explorer.unfold("System")
    explorer.typed("clearance_mm").focus()
    about = explorer.page.locator("#vibroscope-clearance_mm-about")
    assert about.is_visible()
    assert about.text_content().startswith("-1e15 to 1e15 mm")
    assert about.get_attribute("id") in explorer.typed("clearance_mm").get_attribute("aria-describedby")
    assert explorer.typed("mass2_kg").is_hidden()
    assert explorer.page.get_by_label("body 2", exact=True).is_hidden()
    explorer.type("mass1_kg", "-3")
    refusal = explorer.page.locator("#vibroscope-mass1_kg-refusal:not([hidden])")
    refusal.wait_for()
    assert "m₁ must be a number from" in refusal.text_content()
    assert explorer.typed("mass1_kg").get_attribute("aria-invalid") == "true"
    explorer.typed("mass1_kg").press("Escape")
    wait_until(lambda: explorer.error() == "", what="no error")
    assert explorer.typed("mass1_kg").input_value() == "1"


def test_a_system_of_the_shelf_is_shown_and_moves_in_the_same_drawing(kept):
    explorer = kept()
    explorer.unfold("More scenes", "Other systems")
    explorer.moved(lambda: explorer.page.locator("[data-scene='wall']").click())
    explorer.explained()
    assert explorer.page.locator("[data-scene='wall']").get_attribute("aria-pressed") == "true"
    assert " N/m" in explorer.page.locator(".lines").text_content()
    bodies = explorer.page.locator("svg.moving .reference .bob")
    assert bodies.count() == 1
    phase = explorer.page.get_by_label("Phase τ/T in the periods that are shown")
    phase.fill("0")
    explorer.settle()
    before = bodies.first.get_attribute("x")
    phase.fill("0.5")
    wait_until(lambda: bodies.first.get_attribute("x") != before, what="motion")
    explorer.moved(lambda: explorer.scene("A"))
    assert explorer.page.locator("svg.moving circle.bob").count() == 4


def test_an_impact_pair_is_loaded_from_a_file_with_both_walls_and_its_symmetric_motion_in_words(kept, visit):
    explorer = kept.anew()
    explorer.moved(lambda: explorer.page.locator(".load input").set_input_files(ROOT / "docs/pair.toml"))
    explorer.wait_for_address(bodies="wall", stops="two", clearance2="5")
    assert explorer.typed("clearance2_mm").input_value() == "5"
    pair = visit(explorer.query() + "&start_xi1=0.8&start_v1=3.5")
    assert "a second wall on the other side" in pair.page.locator(".at-rest").get_attribute("aria-label")
    wall = pair.page.locator(".at-rest .stop").bounding_box()
    body = pair.page.locator(".at-rest .bob").bounding_box()
    post = pair.page.locator(".at-rest .base .post").last.bounding_box()
    assert wall["x"] + wall["width"] < body["x"] < body["x"] + body["width"] < post["x"] + 1
    lines = pair.page.locator(".lines")
    wait_until(lambda: "symmetric between the stops" in lines.text_content(), what="the motion in words")
    wait_until(lambda: min(pair.source("impulse_reference")["impulse"]) < 0, what="impulses at the second stop")
    assert "second stop" in pair.figure("force")["labels"][1]


def test_the_diagram_of_another_system_covers_its_slider_in_its_units(kept):
    explorer = kept()
    explorer.unfold("More scenes", "Other systems")
    explorer.moved(lambda: explorer.page.locator("[data-scene='wall']").click())
    explorer.open_tab("Bifurcation")
    wait_until(lambda: explorer.figure("bifurcation")["x"] == [0.25, 6], what="the range of the slider")
    ends = """() => { const range = Bokeh.documents[0].get_model_by_name("bifurcation").extra_x_ranges.units;
      return [range.start, range.end]; }"""
    wait_until(lambda: [round(end, 3) for end in explorer.page.evaluate(ends)] == [2.5, 60], what="the axis in Hz")
    wait_until(lambda: len(explorer.source("bifurcation_reference")["value"]) > 200, what="the diagram")
    assert "x₁" in explorer.figure("bifurcation")["labels"][1]


def test_the_panel_fits_a_narrow_phone_and_axe_finds_no_serious_fault_light_or_dark(visit):
    explorer = visit("?bodies=two&units=si&clearance=1", scheme="dark", **PHONE)
    explorer.unfold("System")
    explorer.page.evaluate(AXE)
    assert explorer.page.evaluate("document.documentElement.scrollWidth") <= 320
    for name in ("mass1_kg", "clearance_mm", "force1_N"):
        box = explorer.typed(name).bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 320
    assert serious_in(explorer.page, "dark", "light") == []
