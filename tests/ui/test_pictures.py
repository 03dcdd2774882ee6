"""A picture that is saved has the size that was asked for, looks as on the page, and says what it shows."""

import io
import re
import xml.etree.ElementTree as ET
import zlib
from importlib.metadata import version

import pytest
from PIL import Image

from .explorer import wait_until
from .taking import menu, shapes, taken


def test_a_picture_has_the_size_that_was_asked_for_and_says_what_it_shows(visit):
    explorer = visit()
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
    root = ET.fromstring(taken(explorer, "Phase plot 1 as SVG")[1])
    assert (root.get("width"), root.get("height")) == ("85.000mm", "70.000mm")
    assert root.findtext("{*}desc") == about
    texts = {text.text: float(text.get("font-size").removesuffix("px")) for text in root.iterfind(".//{*}text")}
    assert texts["velocity ξ₁′ / (Aω₁)"] == 12  # drawn anew, not magnified
    _, paper = taken(explorer, "Phase plot 1 as PDF")
    [box] = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", paper)
    assert [float(side) for side in box] == pytest.approx([85 / 25.4 * 72, 70 / 25.4 * 72], abs=0.1)
    assert "Vibroscope, Explore: Phase plot 1".encode("utf-16-be").hex().encode() in paper
    streams = re.findall(rb"stream\n(.*?)\nendstream", paper, re.DOTALL)
    drawn = b"\n".join(map(zlib.decompress, streams)).decode()
    assert b"velocity ".hex() in drawn
    assert drawn.count(" l") > 100
    assert explorer.figure("phase1") == before  # the figure of the page stays as it was
    assert page.locator(".copy").count() == 0
    with page.expect_download() as download:  # the toolbar's own button makes the same file
        page.evaluate("""() => {
          const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name("phase1").id);
          [...view.tool_views.values()].find((tool) => tool.model.type === "SaveTool").doit();
        }""")
    assert download.value.suggested_filename == "vibroscope-phase1.png"
    page.get_by_label("Width in mm", exact=True).fill("5")
    page.locator("details.take-away").get_by_role("button", name="Phase plot 1 as PNG").click()
    wait_until(lambda: "width from 20 to 500 mm" in explorer.error(), 5, "why not")
    page.evaluate("localStorage.clear()")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_drawing_of_the_page_looks_the_same_outside_it(visit, scheme):
    explorer = visit("?eta=2.76&K=12000&D=18&steps=2000", color_scheme=scheme)
    name, drawing = taken(explorer, "Bodies as SVG")
    assert name == "vibroscope-mechanism.svg"
    looks = [look for kind, look in shapes(drawing) if kind == "circle"]
    reference, paper = {"light": ("0, 114, 178", "#FFFFFF"), "dark": ("86, 180, 233", "#171E26")}[scheme]
    assert sum(look["fill"] == f"rgb({reference})" for look in looks) == 2
    assert next(look for kind, look in shapes(drawing) if kind == "rect")["fill"] == paper
    assert b"class=" not in drawing
    name, picture = taken(explorer, "Bodies as PNG")
    assert picture[:8] == b"\x89PNG\r\n\x1a\n"
    with Image.open(io.BytesIO(picture)) as image:
        assert image.size == (813, 594)  # 260 × 190 pixels of 1/96 inch, at 300 dpi
        assert len(image.convert("RGB").getcolors(100_000)) > 20  # a blank one has 1
    assert "CSV" not in menu(explorer)["Bodies"]
