"""Where the parts of the page are, on a desktop and on a phone."""

import pytest

from tests.ui.explorer import PHONE
from tests.ui.test_figures import FIGURES


def test_on_a_phone_a_slider_is_in_view_beside_what_it_changes(kept):
    explorer = kept(**PHONE)
    page = explorer.page
    slider, figure = page.locator("#vibroscope-eta-slider"), page.locator(".cell.force").first
    for each in (figure, slider):
        each.scroll_into_view_if_needed()
    inside = [box["y"] >= 0 and box["y"] + 100 <= 844 for box in (slider.bounding_box(), figure.bounding_box())]
    assert inside == [True, True]
    panel = page.locator(".sliders").bounding_box()
    assert panel["height"] < 0.25 * 844
    assert figure.bounding_box()["y"] + 100 < panel["y"]


def resized(explorer, sizes):
    """Each width and height, once the page has it."""
    for width, height in sizes:
        explorer.resized(width, height)
        yield width, height


def test_the_first_screen_of_a_small_window_shows_a_picture_and_the_sliders(kept):
    """720 × 450 is a desktop at 200 %."""
    explorer = kept.anew("", 390, 844).explained()
    for width, height in resized(explorer, [(390, 844), (320, 568), (720, 450)]):
        sliders = explorer.page.locator(".sliders").bounding_box()
        frame = explorer.figure("displacement")["frame"]
        assert frame["y"] > 0, width
        assert frame["height"] > 70, width
        assert frame["y"] + frame["height"] <= sliders["y"], width
        assert sliders["y"] + sliders["height"] <= height, width


AT = """([x, y]) => {
  let at = document.elementFromPoint(x, y);
  let inner;
  while ((inner = at.shadowRoot?.elementFromPoint(x, y)) && inner !== at) at = inner;
  return Boolean(at?.closest(".sliders"));
}"""


@pytest.mark.parametrize(("width", "height"), [(390, 844), (320, 568)])
def test_nothing_slides_over_the_sliders_of_a_phone(kept, width, height):
    explorer = kept(**PHONE).explained().resized(width, height)
    below = explorer.page.evaluate("document.scrollingElement.scrollHeight - innerHeight")
    for top in range(0, below - 400, 90):
        explorer.page.evaluate("top => scrollTo({top, behavior: 'instant'})", top)
        box = explorer.slider("K").bounding_box()
        assert explorer.page.evaluate(AT, [box["x"] + box["width"] / 2, box["y"] + box["height"] / 2]), top


END_OF_TITLE = """() => {
  const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name("displacement").id);
  const { title } = view.model;
  const pen = document.createElement("canvas").getContext("2d");
  pen.font = [title.text_font_style, title.text_font_size, title.text_font].join(" ");
  const widest = Math.max(...title.text.split("\\n").map(line => pen.measureText(line).width));
  return view.canvas_view.el.getBoundingClientRect().x + view.frame.bbox.left + widest;
}"""


def test_the_button_for_a_measurement_covers_no_title(kept):
    explorer = kept.anew("?eta=1.08&K=100&D=50&steps=2000&frame=difference")
    explorer.explained().unfold("More: ")
    for width, _ in resized(explorer, [(1440, 900), (1100, 900), (390, 844), (320, 568)]):
        assert explorer.figure("displacement")["title"].startswith("Difference: up to ")
        end = explorer.page.evaluate(END_OF_TITLE)
        assert end < explorer.page.locator(".choose button").bounding_box()["x"], width


def test_on_a_phone_nothing_overflows_and_everything_is_there(kept):
    explorer = kept(**PHONE)
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


def test_on_a_phone_the_verdict_on_a_system_of_ones_own_is_where_it_is_for_a_scene(kept):
    own = "bodies=two&clearance=0.5&joint_damping=derived&start_xi2=1"
    place = "line => line.getBoundingClientRect().top + scrollY"
    tops = []
    for query in ("", f"?{own}", f"?{own}&units=si"):
        explorer = kept.anew(query, **PHONE)
        tops.append(explorer.page.locator(".line.verdict").evaluate(place))
    assert max(tops) - min(tops) < 150  # px: a line for each slider that has a unit
    heads = explorer.page.locator("details.more > summary")
    assert heads.all_text_contents() == ["System: two bodies", "Start: own", "Solver: own", "Display"]
    heads.first.click()
    assert explorer.typed("mass1_kg").is_visible()


def test_on_a_desktop_everything_is_in_view_and_the_time_figures_stand_above_each_other(kept):
    explorer = kept.anew()
    boxes = {name: explorer.figure(name)["box"] for name in FIGURES}
    boxes |= {name: explorer.page.locator(name).bounding_box() for name in ("form.panel", ".lines .verdict")}
    for name, box in boxes.items():
        assert box["x"] >= 0, name
        assert box["y"] >= 0, name
        assert box["x"] + box["width"] <= 1440, name
        assert box["y"] + box["height"] <= 900, name
    assert explorer.form.evaluate("form => form.scrollHeight <= form.clientHeight + 1")
    frames = [explorer.figure(name)["frame"] for name in ("displacement", "strip", "force")]
    assert len({(round(f["x"]), round(f["width"])) for f in frames}) == 1


@pytest.mark.parametrize("scene", ["eta=2.76&K=12000&D=18&steps=2000", "eta=1.7&K=12000&D=18&steps=500"])
def test_all_findings_are_in_view_on_a_desktop_with_units_too(kept, scene):
    explorer = kept.anew(f"?{scene}&units=si").explained().judged()
    explorer.settle()
    assert explorer.page.locator(".cell.findings").get_attribute("data-more") is None
    assert explorer.page.locator(".line.further .rest").last.text_content().count("Peak force") == 1
