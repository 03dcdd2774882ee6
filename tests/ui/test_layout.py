"""Where the parts of the page are, on a desktop and on a phone."""

import pytest

from .test_figures import FIGURES


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


def test_on_a_phone_the_verdict_on_a_system_of_ones_own_is_where_it_is_for_a_scene(visit):
    own = "bodies=two&clearance=0.5&joint_damping=derived&start_xi2=1"
    place = "line => line.getBoundingClientRect().top + scrollY"
    tops = []
    for query in ("", f"?{own}", f"?{own}&units=si"):
        explorer = visit(query, width=390, height=844, has_touch=True)
        tops.append(explorer.page.locator(".line.verdict").evaluate(place))
    assert max(tops) - min(tops) < 150  # px: a line for each slider that has a unit
    heads = explorer.page.locator("details.more > summary")
    assert heads.all_text_contents() == ["System: two bodies", "Start: own", "Solver: own"]
    heads.first.click()
    assert explorer.typed("mass1_kg").is_visible()


def test_on_a_desktop_everything_is_in_view_without_scrolling(visit):
    explorer = visit()
    boxes = {name: explorer.figure(name)["box"] for name in FIGURES}
    boxes |= {name: explorer.page.locator(name).bounding_box() for name in ("form.panel", ".lines .verdict")}
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


@pytest.mark.parametrize("scene", ["eta=2.76&K=12000&D=18&steps=2000", "eta=1.7&K=12000&D=18&steps=8000"])
def test_all_findings_are_in_view_on_a_desktop_with_units_too(visit, scene):
    explorer = visit(f"?{scene}&units=si").explained().judged()
    explorer.settle()
    assert explorer.page.locator(".line.penalty").text_content().count("Peak force") == 1
    assert explorer.page.locator(".cell.findings").get_attribute("data-more") is None
