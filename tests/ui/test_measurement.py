"""A measurement that is dropped on the page: its points, its words, and the way back."""

import gzip
from pathlib import Path

from tests.ui.test_symbols import TEXTS, nameless

SETTING = "?eta=2.76&K=12000&D=18&steps=8000&theme=dark"
DOCS = Path(__file__).parents[2] / "docs"
EXAMPLE = Path(__file__).parents[2] / "assets" / "example-measurement.csv"
DROP = """([name, text]) => {
  const files = new DataTransfer();
  files.items.add(new File([Uint8Array.from(text, sign => sign.charCodeAt())], name));
  for (const kind of ["dragover", "drop"])
    document.body.dispatchEvent(new DragEvent(kind, {bubbles: true, cancelable: true, dataTransfer: files}));
}"""
MUTED = """() => Bokeh.documents[0].get_model_by_name("displacement").center.find(part => part.items)
  .items.filter(item => item.label.value === "measured").map(item => item.renderers[0].visible)"""


def test_a_file_is_dropped_laid_over_both_solutions_and_removed(kept):
    explorer = kept(SETTING)
    page = explorer.page
    page.evaluate(DROP, ["broken.csv", "time, x1, x2\n0, 1\n"])
    card = page.locator(".measurement-card")
    page.get_by_text("Line 2: 2 columns, the header has 3").wait_for()
    page.evaluate(DROP, ["own.csv.gz", gzip.compress(EXAMPLE.read_bytes()).decode("latin-1")])
    card.and_(page.locator("[data-phase=done]")).wait_for()
    assert "Fit to the measurement" in page.evaluate(TEXTS)[0]
    assert nameless(explorer) == []
    assert "The reference is nearer: 0.7 % off against 2.9 %." in card.locator(".words").text_content()
    explorer.until(f"({MUTED})()[0] === true")
    assert len(explorer.source("measured_time")["t"]) == 300
    colour = MUTED.replace("item.renderers[0].visible", "item.renderers[0].glyph.line_color.value")
    explorer.until(f"({colour})()[0] === '#E4E9EE'")  # the points are dark on a light page only
    bottom = card.bounding_box()["y"] + card.bounding_box()["height"]
    assert bottom <= page.locator(".cell.displacement").bounding_box()["y"]
    page.get_by_text("Take away", exact=True).click()
    with page.expect_download() as download:
        page.get_by_role("button", name="Displacements: data as CSV").click()
    assert "\nmeasured," in Path(download.value.path()).read_text(encoding="utf-8")
    page.get_by_role("button", name="Remove the measurement").click()
    explorer.until("(" + MUTED.replace("item.renderers[0].visible", "item.visible") + ")()[0] === false")
    assert card.is_hidden()


def test_a_system_file_that_is_dropped_sets_the_system(kept):
    explorer = kept(SETTING)
    explorer.page.evaluate(DROP, ["TWO.toml", (DOCS / "two.toml").read_text(encoding="utf-8")])
    explorer.page.get_by_text("The bodies on their base").wait_for()
    explorer.wait_for_address(bodies="two")
    assert explorer.page.locator(".measurement-card").is_hidden()
    explorer.page.evaluate(DROP, ["long.toml", "#" * 65_537])
    explorer.page.get_by_text("This file is larger than 65536 bytes, so it is no parameter file.").wait_for()
