"""A picture that is saved has the size that was asked for, looks as on the page, and says what it shows."""

import io
from importlib.metadata import version

import pytest
from PIL import Image

from tests.ui.taking import menu, taken
from tests.waiting import wait_until


def test_a_picture_is_as_large_as_on_the_page(kept):
    explorer = kept.anew()
    _, picture = taken(explorer, "Contact strip as PNG")
    width = explorer.page.evaluate("Bokeh.documents[0].get_model_by_name('strip').outer_width")
    with Image.open(io.BytesIO(picture)) as image:
        assert image.width == pytest.approx(width / 96 * 300, abs=1)


def test_a_picture_has_the_size_that_was_asked_for_and_says_what_it_shows(kept):
    explorer = kept.anew()
    assert "Phase plot 1" in menu(explorer)
    page, before = explorer.page, explorer.figure("phase1")
    for name, value in {"Width in mm": "85", "Height in mm": "70", "PNG in dpi": "600"}.items():
        page.get_by_label(name, exact=True).fill(value)
    _, picture = taken(explorer, "Phase plot 1 as PNG")
    with Image.open(io.BytesIO(picture)) as image:
        assert image.size == (round(85 / 25.4 * 600), round(70 / 25.4 * 600))
        assert image.info["dpi"] == pytest.approx((600, 600), abs=0.1)
        assert image.text["Title"] == "Vibroscope, Explore: Phase plot 1"
        about = image.text["Description"]
    assert "η = 1.08, K = 100, D = 50, T/Δτ = 2000" in about
    assert f"vibroscope {version('vibroscope')}" in about
    assert f"{explorer.server}/?eta=1.08" in about
    assert explorer.figure("phase1") == before  # the figure of the page stays as it was
    with page.expect_download() as download:  # the toolbar's own button makes the same file
        page.evaluate("""() => {
          const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name("phase1").id);
          [...view.tool_views.values()].find((tool) => tool.model.type === "SaveTool").doit();
        }""")
    assert download.value.suggested_filename == "vibroscope-phase1.png"
    page.get_by_label("Width in mm", exact=True).fill("5")
    page.locator("details.take-away").get_by_role("button", name="Phase plot 1 as PNG").click()
    wait_until(lambda: "width = 5: give mm from 20 to 500" in explorer.error(), what="why not")
    page.evaluate("localStorage.clear()")


def test_a_picture_has_the_colours_of_the_page_and_what_is_seen_in_it(visit):
    """Of the dark page; the others are taken from a light one."""
    explorer = visit("?eta=2.76&K=12000&D=18&steps=2000", scheme="dark")
    for title in ("Bodies", "Phase plot 1"):
        drawing = taken(explorer, f"{title} as SVG")[1].decode()
        assert "#56b4e9" in drawing
        assert "fill: #171e26" in drawing
    explorer.page.evaluate("""() => {
      const figure = Bokeh.documents[0].get_model_by_name("phase1");
      const legend = [...figure.center, ...figure.above].find((part) => part.type === "Legend");
      legend.items[1].renderers[0].visible = false;
      [figure.x_range.start, figure.x_range.end] = [figure.x_range.start - 3, figure.x_range.end + 4];
    }""")
    wait_until(lambda: b">penalty</text>" not in taken(explorer, "Phase plot 1 as SVG")[1])
    assert "CSV" not in menu(explorer)["Bodies"]
