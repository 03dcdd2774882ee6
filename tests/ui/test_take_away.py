"""On each tab everything that it shows can be taken away, and each file is of the requested kind."""

import csv
import json
import tomllib
import xml.etree.ElementTree as ET

import pytest
from vibroscope.app.page.tabs import VIEWS

from .explorer import wait_until
from .taking import menu, shapes, taken


def test_figures_data_and_report_can_be_taken_away(visit):
    explorer = visit().explained()
    name, picture = taken(explorer, "Displacements as PNG")
    assert (name, picture[:8]) == ("vibroscope-displacement.png", b"\x89PNG\r\n\x1a\n")
    name, drawing = taken(explorer, "Phase plot 1 as SVG")
    assert name.endswith(".svg")
    assert b"<path" in drawing
    assert "velocity ξ₁′".encode() in drawing
    _, table = taken(explorer, "Contact force: data as CSV")
    rows = list(csv.DictReader(table.decode().splitlines()))
    assert {row["series"] for row in rows} >= {"reference", "penalty", "reference impulse"}
    _, data = taken(explorer, "Save all data as JSON")
    assert json.loads(data)["setting"]["eta"] == 1.08
    _, report = taken(explorer, "Save the report")
    assert explorer.line("verdict") in report.decode()
    assert report.count(b"<svg") == 10  # seven figures, three curves over one number alone
    _, toml = taken(explorer, "Save the parameters")
    assert b"eta = 1.08" in toml


def test_a_suggestion_is_offered_as_long_as_it_is_shown(visit):
    explorer = visit()
    assert "Suggestion" not in menu(explorer)
    explorer.page.keyboard.press("Escape")  # the open menu may cover the button
    explorer.page.get_by_role("button", name="Suggest K, D, Δτ").click()
    explorer.page.locator(".suggest[data-phase=done]").wait_for(timeout=60_000)
    wait_until(lambda: "Suggestion" in menu(explorer), 5, "the suggestion in the menu")
    _, drawing = taken(explorer, "Suggestion as SVG")
    _, table = taken(explorer, "Suggestion: data as CSV")
    rows = list(csv.DictReader(table.decode().splitlines()))
    assert sum(kind == "circle" for kind, _ in shapes(drawing)) == len(rows) > 1
    assert set(rows[0]) == {"series", "steps", "error", "K", "D"}
    assert taken(explorer, "Suggestion as PNG")[1][:8] == b"\x89PNG\r\n\x1a\n"
    explorer.page.get_by_role("button", name="Close the result of the search").click()
    wait_until(lambda: "Suggestion" not in menu(explorer), 5, "a menu without it")


def test_the_report_opens_without_a_server(visit, tmp_path):
    explorer = visit().explained()
    _, report = taken(explorer, "Save the report")
    path = tmp_path / "report.html"
    path.write_bytes(report)
    page = explorer.page.context.new_page()
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(path.as_uri())
    assert page.locator("figure svg").count() == 10
    assert page.locator("figure svg").first.bounding_box()["height"] > 100
    link = page.locator("a[data-page]")
    assert link.get_attribute("href") == link.text_content()
    assert link.text_content().startswith(f"{explorer.server}/?eta=1.08")
    assert asked == [path.as_uri()]
    page.close()


@pytest.mark.parametrize("title", ["Phase plot 1", "Displacements", "Contact strip", "Contact force"])
def test_a_picture_shows_what_the_page_shows_after_a_move(visit, title):
    """Columns that a move changes reach the page otherwise than those that it was opened with."""
    opened = visit("?eta=1.12")
    moved = visit("?eta=1.08")
    moved.moved(lambda: moved.type("eta", "1.12"))
    drawings = [taken(explorer.explained(), f"{title} as SVG")[1] for explorer in (opened, moved)]
    first, second = ([at["d"] for kind, at in shapes(drawing) if kind == "path"] for drawing in drawings)
    assert first == second


STUDY = "eta=2.76&K=12000&D=18&steps=2000"
COLUMNS = {  # some of them, by figure
    "phase1": {"xi1", "velocity1"},
    "displacement": {"time", "xi1", "xi2"},
    "strip": {"contact_begin", "contact_end"},
    "force": {"time", "force", "impulse"},
    "diagram": {"eta", "xi2"},
    "bifurcation": {"eta", "xi2"},
    "bifurcation_strip": {"from_eta", "to_eta", "period"},
    "plane_penalty": {"K", "D", "period", "contact_steps"},
    "plane_exact": {"K", "D", "period", "impacts_per_period"},
    "basin_reference": {"xi2", "v2", "motion"},
    "basin_penalty": {"xi2", "v2", "motion", "periods"},
    "step_phase_fixed": {"xi2", "v2"},
    "step_spread": {"n", "scatter"},
    "speed": {"steps", "us_per_period", "error"},
    "claims": {"claim", "agrees", "found"},
}
KEYS = dict.fromkeys(("plane_penalty", "plane_exact"), ("below 1 %", "above 100 %", "blown up"))  # of colours
KEYS |= dict.fromkeys(("basin_reference", "basin_penalty"), ("Motion:", "motion 1 (period 1)"))
KEYS["bifurcation_strip"] = ("period 1", "artefact of the time step", "chaotic", "ended early")
CALLS = {
    "bifurcation": "EtaStudy(",
    "plane": "PlaneStudy(",
    "basin": "BasinStudy.over(",
    "step": "StepStudy(",
    "paper": "CLAIMS",
}


@pytest.mark.parametrize("tab", VIEWS)
def test_each_tab_offers_files_of_each_kind(visit, tab):
    explorer = visit(f"?view={tab}&{STUDY}")
    if tab == "explore":
        explorer.explained()
    if tab != "help":
        wait_until(lambda: "All data (JSON)" in menu(explorer), 60, "something to take away")
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
    for title, kinds in figures.items():
        name, table = taken(explorer, f"{title}: data as CSV")
        rows = list(csv.DictReader(table.decode().splitlines()))
        assert rows
        assert COLUMNS.get(name.removeprefix("vibroscope-").removesuffix(".csv"), {"series"}) <= set(rows[0])
        if "PNG" in kinds:
            picture = taken(explorer, f"{title} as PNG")[1]
            assert picture.startswith(b"\x89PNG\r\n\x1a\n")
            assert len(picture) > 1000
            root = ET.fromstring(taken(explorer, f"{title} as SVG")[1])
            assert root.tag == "{http://www.w3.org/2000/svg}svg"
            assert title in root.findtext("{http://www.w3.org/2000/svg}title")
            assert len(list(root.iter())) > 20
            words = [text.text for text in root.iter("{http://www.w3.org/2000/svg}text")]
            assert set(KEYS.get(name.removeprefix("vibroscope-").removesuffix(".csv"), ())) <= set(words)
            assert taken(explorer, f"{title} as PDF")[1].startswith(b"%PDF-1.4")
            compile(taken(explorer, f"{title}: Script (matplotlib) that draws the CSV")[1], "script", "exec")
    if tab == "paper":
        return
    report = taken(explorer, "Save the report")[1].decode()
    assert report.count("<svg") >= sum("PNG" in kinds for kinds in figures.values())
    assert f"view={tab}" in report or tab == "explore"


@pytest.mark.parametrize("bodies", ["pendulums", "two", "wall"])
def test_the_drawing_of_the_bodies_is_taken_as_any_picture(visit, bodies):
    explorer = visit(f"?bodies={bodies}")
    for kind, begins in (("PNG", b"\x89PNG"), ("SVG", b"<svg"), ("PDF", b"%PDF-1.4")):
        assert taken(explorer, f"Bodies as {kind}")[1].startswith(begins)
    assert explorer.error() == ""


def test_a_field_without_a_number_shows_what_that_means(visit):
    explorer = visit()
    explorer.page.get_by_text("Take away", exact=True).click()
    room = """fields => fields.filter(field => field.placeholder && !field.value).map(field => {
      const pen = document.createElement("canvas").getContext("2d"), style = getComputedStyle(field), SPIN = 18;
      pen.font = style.font;
      return field.clientWidth - 2 * parseFloat(style.paddingLeft) - SPIN - pen.measureText(field.placeholder).width;
    })"""
    left = explorer.page.locator(".sizes input").evaluate_all(room)
    assert len(left) == 2
    assert min(left) >= 0


def test_the_menu_follows_the_tab(visit):
    explorer = visit()
    assert "Contact force" in menu(explorer)
    explorer.open_tab("Help")
    wait_until(lambda: "Contact force" not in menu(explorer), what="a menu without figures")
    explorer.open_tab("Explore")
    wait_until(lambda: "Contact force" in menu(explorer), what="a menu with figures")


def test_an_error_in_making_a_picture_is_shown_like_any_other(visit):
    explorer = visit().explained()
    explorer.page.evaluate("""() => {
      const draw = window.withCopyOf;
      window.withCopyOf = (figure, ...more) => {
        if (figure.name === "phase1") throw new Error("no canvas");
        return draw(figure, ...more);
      };
      const find = Bokeh.index.find_one_by_id;
      const hidden = Bokeh.documents[0].get_model_by_name("phase2").id;
      Bokeh.index.find_one_by_id = (id) => (id === hidden ? null : find.call(Bokeh.index, id));
    }""")
    menu(explorer)
    click = explorer.page.locator("details.take-away").get_by_role
    for button, why in (("Phase plot 1 as PNG", "no canvas"), ("Phase plot 2 as SVG", "phase2 is not drawn")):
        click("button", name=button, exact=True).click()
        wait_until(lambda why=why: why in explorer.error(), what="an error on the page")
    explorer.page.get_by_role("button", name="Close this message").click()
    assert explorer.error() == ""
    menu(explorer)  # a click elsewhere has closed it
    click("button", name="Save the report", exact=True).click()
    wait_until(lambda: "vibroscope-report.html could not be made (no canvas)" in explorer.error(), what="an error")
    taken(explorer, "Displacements as PNG")
    assert explorer.error() == ""


def test_a_button_keeps_the_keyboard_while_more_is_offered(visit):
    explorer = visit()
    wait_until(lambda: "Displacements" in menu(explorer), 60, "something to take away")
    button = explorer.page.get_by_role("button", name="Displacements: data as CSV")
    button.focus()
    explorer.page.evaluate("document.dispatchEvent(new CustomEvent('vibroscope:pin', {detail: {}}))")
    wait_until(lambda: "Comparison of pins" in menu(explorer), 60, "more to take away")
    assert button.evaluate("button => button.getRootNode().activeElement === button")
