"""The figures of Explore in a real browser, and the findings beside them."""

import json

from tests.ui.axe import AXE, serious
from tests.ui.explorer import PAPER
from tests.waiting import wait_until

FIGURES = ("phase1", "phase2", "displacement", "strip", "force", "diagram")


def test_zoom_survives_updates_and_a_scene_gives_it_back(kept):
    explorer = kept()
    explorer.zoom("displacement", 0.2, 0.6, 0.2, 0.7)
    zoomed = explorer.figure("displacement")
    assert explorer.figure("force")["x"] == explorer.figure("strip")["x"] == zoomed["x"]
    explorer.wait_for_zoom("displacement")
    for text in ("1.1", "1.2", "2.5"):
        explorer.moved(lambda text=text: explorer.type("eta", text))
    now = explorer.figure("displacement")
    assert (now["x"], now["y"]) == (zoomed["x"], zoomed["y"])
    explorer.moved(lambda: explorer.scene("C"))
    now = explorer.figure("displacement")
    assert now["x"] == [0, 2]
    assert now["y"] != zoomed["y"]


def test_axes_have_units_a_click_in_the_diagram_sets_eta_and_no_figure_is_rebuilt_by_an_update(kept):
    explorer = kept()
    labels = json.dumps([explorer.figure(name)["labels"] for name in FIGURES], ensure_ascii=False)
    for symbol in ("ξ₁ / base amplitude", "ξ₁′", "ξ₂′", "τ/T", "λ", "∫λ dτ", "η = Ω/ω₁", "base amplitude"):
        assert symbol in labels
    identities = """() => [...Bokeh.documents[0].all_models].filter(m => m.type === "Figure").map(m => m.id).sort()"""
    before = explorer.page.evaluate(identities)
    box = explorer.figure("diagram")["frame"]
    explorer.moved(lambda: explorer.page.mouse.click(box["x"] + box["width"] * 2 / 7, box["y"] + box["height"] / 2))
    assert abs(float(explorer.typed("eta").input_value()) - 1.5) < 0.01
    explorer.wait_for_address(eta=explorer.typed("eta").input_value())
    explorer.moved(lambda: explorer.scene("D"))
    assert explorer.page.evaluate(identities) == before


def test_a_diverged_penalty_run_is_reported_and_the_reference_stays(kept):
    explorer = kept.anew("?eta=1.08&K=100000&D=100&steps=2000")
    before = explorer.sources()
    explorer.moved(lambda: explorer.type("steps", "100"))
    after = explorer.sources()
    assert "step" in explorer.line("penalty")
    assert after["phase_penalty"]["x1"] == []
    assert set(after["displacements"]["penalty1"]) == {None}
    assert after["phase_reference"] == before["phase_reference"]
    explorer.explained()
    assert "nothing to compare" in explorer.line("verdict")


def labels_of(explorer, figure):
    """Labels of its axes; a long one is in two lines."""
    return [" ".join(label.split()) for label in explorer.figure(figure)["labels"]]


DRAWN = """name => Bokeh.documents[0].get_model_by_name(name).center.find(part => part.type === "Legend").items
  .filter(({renderers}) => renderers.every(({visible}) => visible)).map(({label}) => label.value)"""
DISPLACEMENTS, PARTS = (
    ["ξ₁ reference", "ξ₂ reference", "ξ₁ penalty", "ξ₂ penalty"],
    ["difference", "time step", "K and D", "joint damping"],
)


def test_the_difference_is_drawn_in_parts_in_place_of_the_displacements(kept, visit):
    explorer = kept.anew()
    form = explorer.page.get_by_role("form", name="Settings")
    assert explorer.page.evaluate(DRAWN, "displacement") == DISPLACEMENTS
    assert explorer.source("difference")["total"] == []
    explorer.unfold("Display")
    explorer.moved(lambda: form.get_by_text("difference", exact=True).click())
    wait_until(lambda: len(explorer.source("difference")["total"]) > 100, what="the difference")
    assert explorer.page.evaluate(DRAWN, "displacement") == PARTS
    assert "difference of ξ₂ / base amplitude" in labels_of(explorer, "displacement")
    explorer.wait_for_address(frame="difference")
    assert visit(explorer.query()).page.evaluate(DRAWN, "displacement") == PARTS
    explorer.moved(lambda: form.get_by_text("relative", exact=True).click())
    assert explorer.page.evaluate(DRAWN, "displacement") == DISPLACEMENTS
    assert "displacements ξ₁, ξ₂ / base amplitude" in labels_of(explorer, "displacement")


def test_a_pin_keeps_the_result_and_its_curves(kept):
    explorer = kept.anew(PAPER)
    first = explorer.sources()
    assert explorer.page.locator(".comparison-table").is_hidden()
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Keep this result").click())
    wait_until(lambda: explorer.source("pinned1_phase_penalty") == first["phase_penalty"], what="the curves of the pin")
    explorer.moved(lambda: explorer.type("K", "9000"))
    assert explorer.source("pinned1_phase_penalty") == first["phase_penalty"] != explorer.source("phase_penalty")
    explorer.wait_for_address(K="9000", pin="eta=1.08&K=2500&D=8&steps=2000")
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Unpin 1").click())
    assert explorer.source("pinned1_phase_penalty")["x1"] == []
    wait_until(lambda: "pin" not in explorer.address(), what="an address without a pin")


def test_the_first_thing_to_change_is_a_button(kept):
    explorer = kept.anew("?eta=1.08&K=100&D=50&steps=2000").explained()
    before = float(explorer.page.locator(".part.total .number").text_content().split()[0])
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Try D =").click())
    explorer.explained()
    assert float(explorer.typed("D").input_value()) < 20
    assert float(explorer.page.locator(".part.total .number").text_content().split()[0]) < before / 3
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Undo").click())
    assert explorer.typed("D").input_value() == "50"


def test_scatter_of_the_time_step_is_named_an_artefact_and_looks_unlike_chaos(kept):
    explorer = kept("?eta=2.76&K=12000&D=18&steps=2000").judged()
    kind, line = explorer.page.locator(".line.penalty .kind"), explorer.page.locator(".line.penalty")
    assert "blurred by the time step" in kind.text_content()
    assert kind.evaluate("(e) => getComputedStyle(e).borderTopStyle") == "dashed"
    explorer.unfold("More: ")
    explorer.page.get_by_text("The blur is an artefact").wait_for()
    explorer.moved(lambda: explorer.type("eta", "1.7"))
    assert line.get_attribute("data-kind") == ""  # not that of the setting before
    explorer.judged()
    assert "chaotic" in kind.text_content()
    assert kind.evaluate("(e) => getComputedStyle(e).borderTopStyle") == "none"


def test_the_verdict_of_another_setting_is_not_read_as_that_of_the_figures(kept):
    """While verdict or figures of a new setting are not known, the one before is hidden after half a second."""
    explorer = kept().explained()
    text = explorer.page.locator(".line.verdict p").first
    mark = explorer.page.locator(".line.verdict .stale-mark")
    assert text.is_visible()
    assert not mark.is_visible()
    set_pending = """on => {
      const model = [...Bokeh.documents[0].all_models].find(model => model.class_name?.startsWith("Findings"));
      model.data.setv({ content: { ...Object.fromEntries(Object.entries(model.data.content)), pending: on } });
    }"""
    for _ in range(3):  # as while a slider moves: each result starts without a verdict
        explorer.page.evaluate(set_pending, True)
    mark.wait_for()
    assert not text.is_visible()
    explorer.page.evaluate(set_pending, False)
    text.wait_for()
    assert not mark.is_visible()
    set_moving = "on => document.dispatchEvent(new CustomEvent('vibroscope:moving', { detail: { value: on } }))"
    explorer.page.evaluate(set_moving, True)  # as while the figures of another setting are computed
    mark.wait_for()
    assert not text.is_visible()
    explorer.page.evaluate(set_moving, False)
    text.wait_for()


COLOURED = """name => {
  const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name(name).id);
  const {x0, y0, x1, y1} = view.frame.bbox;
  const copy = new OffscreenCanvas(x1 - x0 - 4, y1 - y0 - 4).getContext("2d", { willReadFrequently: true });
  copy.drawImage(view.canvas_view.primary.canvas, -x0 - 2, -y0 - 2);
  const { data } = copy.getImageData(0, 0, copy.canvas.width, copy.canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) {
    const pixel = data.slice(i, i + 3);
    count += Math.max(...pixel) - Math.min(...pixel) > 40;
  }
  return count;
}"""


def test_pins_of_a_link_are_compared_in_a_table_and_in_curves_of_their_own_colours(visit):
    pins = ";".join(f"eta=2.5%26K={K}%26D=18%26steps=200" for K in (300, 1000, 30))  # quickly explained
    explorer = visit(f"?eta=2.76&K=2500&D=18&steps=200&pin={pins}").explained()
    pin = explorer.page.get_by_role("button", name="Keep this result")
    table = explorer.page.locator(".comparison-table")
    total = explorer.page.locator(".part.total .number").text_content()
    explorer.moved(pin.click)
    explorer.moved(lambda: explorer.type("eta", "2.5"))
    explorer.explained()
    wait_until(lambda: "computing" not in table.text_content(), what="the numbers of all pins")
    now, *pinned = rows_of(table)
    assert [row[1] for row in pinned] == ["300", "1000", "30", "2500"]
    assert pinned[3][4] == total
    assert now[4] == explorer.page.locator(".part.total .number").text_content()
    for width in (390, 1100):  # others: see `test_sizes`
        explorer.resized(width, 900)
        box, below = (explorer.page.locator(each).bounding_box() for each in (".comparison-table", ".lines"))
        assert box["x"] >= 0, width
        assert box["x"] + box["width"] <= width
        assert box["y"] + box["height"] <= below["y"], width
    coloured = [explorer.page.evaluate(COLOURED, "phase1")]
    for entry in explorer.page.locator(".cell.phase1").get_by_role("switch", name="pin").all():
        entry.press("Enter")
        wait_until(lambda: explorer.page.evaluate(COLOURED, "phase1") != coloured[-1], what="a curve less")
        coloured.append(explorer.page.evaluate(COLOURED, "phase1"))
    assert len(set(coloured)) == 5  # each pin was painted
    explorer.wait_for_address(mute="phase1:pinned,pinned2,pinned3,pinned4")
    explorer.page.evaluate(AXE)
    assert serious(explorer.page) == []
    before = explorer.query()
    pin.click()
    wait_until(lambda: "At most 4 settings can be pinned" in explorer.error(), what="the bound")
    assert explorer.query() == before
    explorer.moved(lambda: table.get_by_role("button", name="Unpin 1").click())
    wait_until(lambda: [row[1] for row in rows_of(table)[1:]] == ["1000", "30", "2500"], what="one pin less")
    explorer.moved(lambda: table.get_by_role("button", name="Set the sliders to pin 2").click())
    assert explorer.typed("K").input_value() == "30"
    assert explorer.source("pinned2_phase_penalty") == explorer.source("phase_penalty")


def rows_of(table):
    return [row.locator("td.number").all_text_contents() for row in table.locator("tr").all()[1:]]


def test_a_muted_legend_entry_hides_its_curve(kept):
    explorer = kept.anew("?eta=1.38")
    for figure in ("phase1", "displacement", "force"):
        coloured = [explorer.page.evaluate(COLOURED, figure)]
        for entry in explorer.page.locator(f".cell.{figure}").get_by_role("switch").all():
            entry.click()
            what = f"something hidden in {figure}"
            wait_until(lambda: explorer.page.evaluate(COLOURED, figure) not in coloured, what=what)  # noqa: B023
            coloured.append(explorer.page.evaluate(COLOURED, figure))
        assert coloured[-1] == 0, figure
