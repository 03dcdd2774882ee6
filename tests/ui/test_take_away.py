"""On each tab everything that it shows can be taken away, and each file is of the requested kind."""

import csv
import io
import json
import re
import tomllib
from importlib.metadata import version

import pytest
from PIL import Image
from vibroscope.app.page.tabs import VIEWS

from tests.share import every
from tests.ui.taking import menu, taken
from tests.waiting import wait_until


def test_figures_data_and_report_can_be_taken_away(kept, tmp_path):
    explorer = kept().explained()
    name, picture = taken(explorer, "Displacements as PNG")
    assert (name, picture[:8]) == ("vibroscope-displacement.png", b"\x89PNG\r\n\x1a\n")
    name, drawing = taken(explorer, "Phase plot 1 as SVG")
    assert name.endswith(".svg")
    assert b"<path" in drawing
    assert "velocity ξ₁′".encode() in drawing
    assert b"fill: #ffffff" in drawing  # of the light page
    _, table = taken(explorer, "Contact force: data as CSV")
    rows = list(csv.DictReader(table.decode().splitlines()))
    assert {row["series"] for row in rows} >= {"reference", "penalty", "reference impulse"}
    _, data = taken(explorer, "Save all data as JSON")
    assert json.loads(data)["setting"]["eta"] == 1.08
    _, toml = taken(explorer, "Save the parameters")
    assert b"eta = 1.08" in toml
    assert taken(explorer, "Displacements as PDF")[1].startswith(b"%PDF-1.4")
    for script in ("Save the Python script", "Displacements: Script (matplotlib) that draws it"):
        compile(taken(explorer, script)[1], "script", "exec")
    assert taken(explorer, "Save the commands")[1].startswith(b"vibroscope ")
    _, report = taken(explorer, "Save the report")
    assert explorer.line("verdict") in report.decode()
    assert report.count(b"<svg") == 10  # seven figures, three curves over one number alone
    check_report_alone(explorer, report, tmp_path / "report.html")


def check_report_alone(explorer, report, path):
    """It opens without a server."""
    path.write_bytes(report)
    page = explorer.page.context.new_page()
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(path.as_uri())
    assert page.locator("figure svg").count() == 10
    assert page.locator("figure svg").first.bounding_box()["height"] > 100
    link = page.locator("p a")
    assert link.get_attribute("href") == link.text_content()
    assert link.text_content().startswith(f"{explorer.server}/?eta=1.08")
    assert asked == [path.as_uri()]
    page.close()


def test_a_suggestion_is_offered_as_long_as_it_is_shown(kept):
    explorer = kept()
    assert "Suggestion" not in menu(explorer)
    explorer.page.keyboard.press("Escape")  # the open menu may cover the button
    explorer.page.get_by_role("button", name="Suggest K, D, Δτ").click()
    explorer.page.locator(".suggest[data-phase=done]").wait_for()
    wait_until(lambda: "Suggestion" in menu(explorer), what="the suggestion in the menu")
    _, drawing = taken(explorer, "Suggestion as SVG")
    _, table = taken(explorer, "Suggestion: data as CSV")
    rows = list(csv.DictReader(table.decode().splitlines()))
    assert b"tolerance" in drawing
    assert len(rows) > 1
    assert set(rows[0]) == {"series", "steps", "error", "K", "D"}
    assert taken(explorer, "Suggestion as PNG")[1][:8] == b"\x89PNG\r\n\x1a\n"
    explorer.page.get_by_role("button", name="Close the result of the search").click()
    wait_until(lambda: "Suggestion" not in menu(explorer), what="a menu without it")


@pytest.mark.parametrize("elsewhere", ["a point of the front", "a term", "a figure", "Escape in a field"])
def test_the_menu_closes_from_elsewhere(kept, elsewhere):
    explorer = kept.anew().explained()
    page = explorer.page
    if elsewhere == "a point of the front":
        page.get_by_role("button", name="Suggest K, D, Δτ").click()
        page.locator(".suggest[data-phase=done]").wait_for()
    closing = {
        "a point of the front": lambda: page.locator(".suggest circle").first.click(),
        "a term": lambda: page.locator(".term").first.click(),
        "a figure": lambda: page.get_by_role("figure", name=re.compile("Phase plot, body 1")).click(),
        "Escape in a field": lambda: page.get_by_role("textbox", name=re.compile("K")).first.press("Escape"),
    }
    menu(explorer)
    box = page.locator("details.take-away")
    assert box.evaluate("menu => menu.open")
    closing[elsewhere]()
    wait_until(lambda: not box.evaluate("menu => menu.open"), what="the menu to close")


def test_pictures_show_what_the_page_shows_after_a_move(kept, visit):
    """Columns that a move changes reach the page otherwise than those that it was opened with."""
    opened = visit("?eta=1.12").explained()
    moved = kept.anew("?eta=1.08")
    moved.moved(lambda: moved.type("eta", "1.12"))
    moved.explained()
    for title in ("Phase plot 1", "Displacements", "Contact strip", "Contact force"):
        first, second = (
            taken(explorer, f"{title} as SVG")[1].partition(b"</metadata>")[2] for explorer in (opened, moved)
        )
        assert first == second, title


STUDY = "eta=2.76&K=12000&D=18&steps=2000"
CALLS = {
    "bifurcation": "EtaStudy(",
    "plane": "PlaneStudy(",
    "basin": "BasinStudy.over(",
    "step": "StepStudy(",
    "paper": "CLAIMS",
}


# Tabs with more or less to take away than others; of these a share: their files are tested without a browser.
PARTICULAR = ("paper", "help")
OTHERS = [tab for tab in VIEWS if tab not in ("explore", *PARTICULAR)]


@pytest.mark.parametrize("tab", [*PARTICULAR, *every(OTHERS)])
def test_each_tab_offers_files_of_each_kind(visit, tab):
    """Of Explore: the first test."""
    explorer = visit(f"?view={tab}&{STUDY}")
    if tab != "help":
        wait_until(lambda: "All data (JSON)" in menu(explorer), what="something to take away")
    if tab == "paper":  # files that hold all claims are tested without a browser
        _, picture = taken(explorer, "Figure 14 [D] as SVG")  # which never came into view
        assert "displacement ξ".encode() in picture
    offered = menu(explorer)
    assert tomllib.loads(taken(explorer, "Save the parameters")[1].decode())["setting"]["K"] == 12000
    script = taken(explorer, "Save the Python script")[1].decode()
    compile(script, "script", "exec")
    assert CALLS.get(tab, "import") in script
    assert taken(explorer, "Save the commands")[1].startswith(b"vibroscope ")
    if tab == "help":
        assert set(offered) == {
            "Link to this view", "Parameters (TOML)", "Parameters from a file", "Python", "Command line",
            "Deck for"
        }  # fmt: skip
        return
    figures = {title: kinds for title, kinds in offered.items() if "CSV" in kinds}
    assert figures
    if tab == "paper":
        figures = {"Figure 14 [D]": figures["Figure 14 [D]"]}
    else:
        name, data = taken(explorer, "Save all data as JSON")
        assert name == f"vibroscope-{tab}.json"
        assert json.loads(data)["data"]
    for title in [title for title, kinds in figures.items() if "PNG" in kinds][:1]:
        table = taken(explorer, f"{title}: data as CSV")[1]
        assert list(csv.DictReader(table.decode().splitlines()))
        picture = taken(explorer, f"{title} as PNG")[1]
        assert picture.startswith(b"\x89PNG\r\n\x1a\n")
        assert len(picture) > 1000
        assert taken(explorer, f"{title} as PDF")[1].startswith(b"%PDF-1.4")
        compile(taken(explorer, f"{title}: Script (matplotlib) that draws it")[1], "script", "exec")
    if tab == "paper":
        return
    report = taken(explorer, "Save the report")[1].decode()
    assert report.count("<svg") >= sum("PNG" in kinds for kinds in figures.values())
    assert f"view={tab}" in report


@pytest.mark.parametrize("bodies", ["pendulums", "two", "wall"])
def test_the_drawing_of_the_bodies_is_taken_as_any_picture(kept, bodies):
    explorer = kept() if bodies == "pendulums" else kept().at(bodies=bodies, steps="2000")
    files = {kind: taken(explorer, f"Bodies as {kind}")[1] for kind in ("PNG", "SVG", "PDF")}
    for kind, begins in (("PNG", b"\x89PNG"), ("SVG", b"<?xml"), ("PDF", b"%PDF-1.4")):
        assert files[kind].startswith(begins)
    drawn, shown = files["SVG"].decode().lower(), explorer.page.locator("svg.moving .reference .bob")
    assert drawn.count("fill: #0072b2") == shown.count() == (1 if bodies == "wall" else 2)
    assert drawn.count("fill: none; stroke: #d55e00") + drawn.count('style="fill: none; stroke: #d55e00') > 1
    assert explorer.error() == ""


def test_the_menu_follows_the_tab(kept):
    explorer = kept()
    assert "Contact force" in menu(explorer)
    explorer.open_tab("Help")
    wait_until(lambda: "Contact force" not in menu(explorer), what="a menu without figures")
    explorer.open_tab("Explore")
    wait_until(lambda: "Contact force" in menu(explorer), what="a menu with figures")


def test_a_button_keeps_the_keyboard_while_more_is_offered_and_fields_say_what_no_number_means(kept):
    explorer = kept()
    wait_until(lambda: "Displacements" in menu(explorer), what="something to take away")
    room = """fields => fields.filter(field => field.placeholder && !field.value).map(field => {
      const pen = document.createElement("canvas").getContext("2d"), style = getComputedStyle(field), SPIN = 18;
      pen.font = style.font;
      return field.clientWidth - 2 * parseFloat(style.paddingLeft) - SPIN - pen.measureText(field.placeholder).width;
    })"""
    left = explorer.page.locator(".sizes input").evaluate_all(room)
    assert len(left) == 2
    assert min(left) >= 0
    button = explorer.page.get_by_role("button", name="Displacements: data as CSV")
    button.focus()
    explorer.page.evaluate("document.dispatchEvent(new CustomEvent('vibroscope:pin', {detail: {}}))")
    wait_until(lambda: "Comparison of pins" in menu(explorer), what="more to take away")
    assert button.evaluate("button => button.getRootNode().activeElement === button")


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
    for name in ("Width in mm", "Height in mm", "PNG in dpi"):
        page.get_by_label(name, exact=True).fill("")
    page.evaluate("localStorage.clear()")


def test_a_picture_has_the_colours_of_the_page_and_what_is_seen_in_it(kept):
    """Of the dark page; the others are taken from a light one."""
    explorer = kept.anew("?eta=2.76&K=12000&D=18&steps=2000")
    explorer.page.emulate_media(color_scheme="dark", reduced_motion="reduce")
    wait_until(lambda: explorer.model("phase1", "background_fill_color").upper() == "#171E26", what="a dark page")
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
