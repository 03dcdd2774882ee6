"""What Bokeh does for each paint and our figures leave out (`app/page/shared/painting.js`); what fails to, complains.

And which frames the page asks the browser for.
"""

import pytest

ASKED = """(() => {
  window.asked = 0;
  const ask = CSSStyleDeclaration.prototype.getPropertyValue;
  CSSStyleDeclaration.prototype.getPropertyValue = function (name) {
    window.asked += name.startsWith("--bk-");
    return ask.call(this, name);
  };
})()"""
KEEP = """(() => {
  const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name("phase1").id);
  window.legend = view.views.find_one(view.model.center.find(part => part.type === "Legend"));
  window.kept = legend.entries;
  window.curve = view.views.find_one(legend.model.items[1].renderers[0]);
})()"""
MUTE = "on => { for (const curve of legend.model.items[1].renderers) curve.muted = on; }"
PAINTED = """() => {
  curve.muted_glyph.paint(new Proxy(curve.plot_view.canvas_view.primary.ctx, {
    get: (context, name) => (typeof context[name] === "function" ? () => {} : context[name]),
    set: () => true,
  }), curve.all_indices.ones());
  return { x: Array.from(curve.muted_glyph.x), sx: Array.from(curve.muted_glyph.sx), base: Array.from(curve.glyph.x) };
}"""

# A point of the first displacement, on the page, and how many tooltips that figure shows.
NEAR = """(() => {
  const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name("displacement").id);
  const hover = [...view.tool_views.values()].find(tool => tool.model.type === "HoverTool");
  const { data } = Bokeh.documents[0].get_model_by_name("displacements");
  const column = name => data instanceof Map ? data.get(name) : data[name];
  const box = view.canvas_view.el.getBoundingClientRect(), n = Math.floor(column("t").length / 2);
  window.near = [box.x + view.frame.x_scale.compute(column("t")[n]),
    box.y + view.frame.y_scale.compute(column("reference1")[n])];
  window.tips = () => [...hover.ttmodels.values()].filter(tip => tip.position !== null).length;
})()"""


@pytest.fixture
def explorer(visit):
    page = visit()
    page.page.evaluate(KEEP)
    return page


def test_no_style_is_asked_for_while_figures_paint(explorer):
    explorer.page.evaluate(ASKED)
    explorer.moved(lambda: explorer.type("K", "9000"))
    assert explorer.page.evaluate("window.asked") == 0


def test_a_legend_keeps_its_entries_until_one_of_them_changes(explorer):
    explorer.moved(lambda: explorer.type("K", "9000"))
    assert explorer.page.evaluate("legend.entries === kept && kept.length === 2")
    explorer.page.evaluate(MUTE, True)
    explorer.until("legend.entries !== kept && legend.entries[1].el.className.includes('inactive')")
    assert explorer.page.evaluate("legend.entries.length") == 2


def test_a_legend_that_folds_makes_its_entries_anew(explorer):
    explorer.page.evaluate("legend.model.ncols = 1")
    explorer.until("legend.entries !== kept")


def test_a_look_that_was_not_seen_has_the_latest_numbers_when_it_is(explorer):
    explorer.moved(lambda: explorer.type("K", "9000"))
    explorer.page.evaluate(MUTE, True)
    explorer.settle()
    first = explorer.page.evaluate(PAINTED)
    assert first["x"] == first["base"] == explorer.page.evaluate("Array.from(curve.glyph.x)")
    explorer.moved(lambda: explorer.type("eta", "1.2"))
    second = explorer.page.evaluate(PAINTED)
    assert second["x"] == second["base"] != first["x"]
    assert len(second["sx"]) == len(second["x"])


def test_a_tooltip_waits_for_the_pointer_to_rest(explorer):
    """It is there where the pointer rests, and gone as soon as it moves on."""
    explorer.page.evaluate(NEAR)
    x, y = explorer.page.evaluate("near")
    explorer.page.mouse.move(x, y)
    assert explorer.page.evaluate("tips() === 0")
    explorer.until("tips() > 0")
    explorer.page.mouse.move(x + 60, y)
    assert explorer.page.evaluate("tips() === 0")
    explorer.page.mouse.move(x, y)
    explorer.until("tips() > 0")
    explorer.page.mouse.move(5, 5)
    explorer.until("tips() === 0")


LAYER = """Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name("displacement").id)
    .canvas_view.overlays.el.style.display"""


def test_the_layer_above_all_is_there_while_a_box_is_drawn(explorer):
    explorer.page.evaluate(NEAR)
    (x, y), mouse = explorer.page.evaluate("near"), explorer.page.mouse
    assert explorer.page.evaluate(LAYER) == "none"
    mouse.move(x, y)
    mouse.down()
    mouse.move(x + 40, y + 30, steps=4)
    explorer.until(f"{LAYER} === ''")
    mouse.up()
    explorer.until(f"{LAYER} === 'none'")


COUNT = """(() => {
  const ask = requestAnimationFrame;
  window.frames = 0;
  window.requestAnimationFrame = (act) => { window.frames += 1; return ask(act); };
})()"""


def asked_for(page):
    """Frames within half a second."""
    before = page.evaluate("window.frames")
    page.wait_for_timeout(500)
    return page.evaluate("window.frames") - before


def test_frames_are_asked_for_only_while_the_pendulums_swing_and_are_seen(explorer):
    page, play = explorer.page, explorer.page.get_by_role("button", name="Play", exact=True)
    page.evaluate(COUNT)
    assert asked_for(page) == 0
    play.click()
    assert asked_for(page) > 3
    explorer.open_tab("Help")
    explorer.settle()
    assert asked_for(page) == 0
    explorer.open_tab("Explore")
    explorer.settle()
    assert asked_for(page) > 3
    page.evaluate(NEAR)
    page.mouse.move(*page.evaluate("near"))  # what is pointed at stands still
    page.wait_for_timeout(500)
    assert asked_for(page) == 0
