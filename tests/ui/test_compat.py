"""The contract of each hook into Bokeh's and Panel's scripts (`app/page/shared/compat.js`), and the animation frames.

Each test fails when a later version of the library no longer has the name or the behaviour that its hook relies on.
"""

import pytest

from tests.waiting import wait_until

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
HIDE = "() => { for (const curve of legend.model.items[1].renderers) curve.visible = false; }"
MUTE = "() => curve.model.setv({muted: true}, {sync: false})"
PAINTED = """() => {
  curve.muted_glyph.paint(new Proxy(curve.plot_view.canvas_view.primary.ctx, {
    get: (context, name) => (typeof context[name] === "function" ? () => {} : context[name]),
    set: () => true,
  }), curve.all_indices.ones());
  return { x: Array.from(curve.muted_glyph.x), sx: Array.from(curve.muted_glyph.sx), base: Array.from(curve.glyph.x) };
}"""

# How often the text of a style sheet reaches the browser: written twice, then changed.
SHEET = """(() => {
  const sheet = new (Bokeh.loader["core/dom"].InlineStyleSheet)();
  let written = 0;
  const { set } = Object.getOwnPropertyDescriptor(Node.prototype, "textContent");
  Object.defineProperty(sheet.el, "textContent", { set(text) { written += 1; set.call(this, text); } });
  const counts = [];
  for (const css of [":host { color: red }", ":host { color: red }", ":host { color: blue }"]) {
    sheet.replace(css);
    counts.push(written);
  }
  return counts.slice(1);
})()"""

# A point of the first displacement, on the page, and how many tooltips that figure shows.
NEAR = """(() => {
  const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name("displacement").id);
  const hover = [...view.tool_views.values()].find(tool => tool.model.type === "HoverTool");
  const { data } = Bokeh.documents[0].get_model_by_name("displacements");
  const column = name => data instanceof Map ? data.get(name) : data[name];
  const box = view.canvas_view.el.getBoundingClientRect(), n = Math.floor(column("t").length / 4);  // below the legend
  window.near = [box.x + view.frame.x_scale.compute(column("t")[n]),
    box.y + view.frame.y_scale.compute(column("reference1")[n])];
  window.tips = () => [...hover.ttmodels.values()].filter(tip => tip.position !== null).length;
})()"""


def with_legend(explorer):
    explorer.page.evaluate(KEEP)
    return explorer


@pytest.fixture
def explorer(kept):
    return with_legend(kept())


def test_a_page_that_was_just_opened_is_as_the_hooks_make_it(explorer):
    """The hooks "import" (Panel loads modules through ``window.importShim``), "sheets" and "switches"."""
    assert [complaint for complaint in explorer.complaints if "hook" in complaint] == []  # Bokeh has every name
    sources = explorer.page.evaluate("[...document.scripts].map(script => script.src).join(' ')")
    assert "static/libraries/" in sources
    for unused in ("panel.min.js", "es-module-shims", "bokeh-gl", "bokeh-tables", "bokeh-widgets"):
        assert unused not in sources
    assert explorer.page.evaluate("String(importShim).includes('import(')")
    assert explorer.page.evaluate(SHEET) == [1, 2]  # not written again with the same text
    assert explorer.page.evaluate("kept.map(({ el }) => [el.role, el.tabIndex, el.ariaChecked])") == [
        ["switch", 0, "true"],
        ["switch", 0, "true"],
    ]


LAID_OUT = """(() => {
  window.laidOut = [];
  window.viewOf = (name) => Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name(name).id);
  for (const name of ["phase1", "force"]) {
    const view = viewOf(name), measure = view._measure_layout;
    view._measure_layout = function () { laidOut.push(name); measure.call(this); };
  }
  window.layOutAll = () => {
    let root = viewOf("force");
    while (root.parent) root = root.parent;
    laidOut.length = 0;
    root.invalidate_layout();
    return laidOut;
  };
  window.widen = (by) => {
    laidOut.length = 0;
    viewOf("phase1").model.setv({ min_border_left: viewOf("phase1").model.min_border_left + by }, { sync: false });
    return laidOut;
  };
})()"""


def test_a_figure_is_laid_out_alone_and_not_in_a_hidden_view(kept):
    """The hooks "figures", "resizes" and "hidden"."""
    explorer = kept.anew()
    page = explorer.page
    page.evaluate(LAID_OUT)
    assert page.evaluate("layOutAll()") == ["phase1", "force"]
    width = explorer.figure("phase1")["frame"]["width"]
    assert page.evaluate("widen(30)") == ["phase1"]
    assert explorer.figure("phase1")["frame"]["width"] < width
    assert page.evaluate("widen(-30)") == ["phase1"]
    assert explorer.figure("phase1")["frame"]["width"] == width
    explorer.open_view("help")
    assert page.evaluate("layOutAll()") == []
    page.evaluate("laidOut.length = 0")
    explorer.resized(1300, 900)
    assert page.evaluate("laidOut") == []
    explorer.open_view("explore")
    wait_until(lambda: {"phase1", "force"} <= {*page.evaluate("laidOut")}, what="the layout of the figures")
    wait_until(lambda: explorer.figure("force")["box"]["width"] < 1300, what="figures of the new width")


CHOSEN = """(() => {
  const { set, ...more } = Object.getOwnPropertyDescriptor(HTMLSelectElement.prototype, "value");
  window.chosen = 0;
  const counted = function (value) { chosen += 1; set.call(this, value); };
  Object.defineProperty(HTMLSelectElement.prototype, "value", { ...more, set: counted });
})()"""


def test_a_move_does_no_more_than_it_must(explorer):
    """The hooks "colours", "positions" and "legends".

    Chromium examines all fields of the page whenever a script chooses in a list, which delays a key press by a quarter.
    """
    explorer.page.evaluate(ASKED)
    explorer.page.evaluate(CHOSEN)
    assert explorer.page.evaluate("curve.position.css") == ""
    explorer.moved(lambda: explorer.type("K", "9000"))
    assert explorer.page.evaluate("window.asked") == 0  # no colour was read from CSS while figures painted
    assert explorer.page.evaluate("curve.position.css") == ""
    assert explorer.page.evaluate("curve.el.childElementCount") == 0  # else its position would matter
    assert explorer.page.evaluate("legend.entries === kept && kept.length === 2")
    assert explorer.page.evaluate("chosen") == 0
    explorer.moved(
        lambda: explorer.page.evaluate(
            "document.dispatchEvent(new CustomEvent('vibroscope:set', {detail: {law: 'cut'}}))"
        )
    )
    assert explorer.page.evaluate("chosen") == 1


def test_a_glyph_that_was_not_seen_has_the_latest_data_when_it_is_painted(explorer):
    """The hook "glyphs"."""
    explorer.moved(lambda: explorer.type("K", "9100"))
    explorer.page.evaluate(MUTE)
    explorer.settle()
    first = explorer.page.evaluate(PAINTED)
    assert first["x"] == first["base"] == explorer.page.evaluate("Array.from(curve.glyph.x)")
    explorer.moved(lambda: explorer.type("eta", "1.2"))
    second = explorer.page.evaluate(PAINTED)
    assert second["x"] == second["base"] != first["x"]
    assert len(second["sx"]) == len(second["x"])


MARGIN = """() => ["displacement", "force", "strip"].map(name => {
  const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name(name).id);
  const { left, right } = view.frame.bbox;
  return [widthOfAxes(view, "left"), widthOfAxes(view, "right"), left, view.bbox.width - right];
})"""


def test_time_figures_have_the_margins_that_their_present_labels_need(explorer):
    explorer.page.evaluate("""() => {
      const { y_range } = Bokeh.documents[0].get_model_by_name("displacement");
      y_range.setv({ start: 99999.12341, end: 99999.12389 });
    }""")
    wide = wait_for_margins(explorer, lambda need: need[0][0] > 64)
    assert {left for _, _, left, _ in wide} == {max(left for left, *_ in wide)}
    explorer.page.evaluate("""() => {
      const { y_range } = Bokeh.documents[0].get_model_by_name("displacement");
      y_range.setv({ start: -1, end: 1 });
    }""")
    narrow = wait_for_margins(explorer, lambda need: need[0][2] < wide[0][2])
    assert {left for _, _, left, _ in narrow} == {max(60, *(need for need, *_ in narrow))}


def wait_for_margins(explorer, holds):
    wait_until(lambda: holds(explorer.page.evaluate(MARGIN)), what="other margins")
    explorer.settle()
    return explorer.page.evaluate(MARGIN)


def test_a_tooltip_waits_for_the_pointer_to_rest(kept):
    """The hook "tooltips": it appears where the pointer rests and vanishes as soon as the pointer moves on."""
    explorer = kept.anew()
    explorer.page.evaluate(NEAR)
    x, y = explorer.page.evaluate("near")
    explorer.page.mouse.move(x, y)
    explorer.until("tips() === 0")
    explorer.until("tips() > 0")
    explorer.page.mouse.move(x + 60, y)
    explorer.until("tips() === 0")
    explorer.page.mouse.move(x, y)
    explorer.until("tips() > 0")
    explorer.page.mouse.move(5, 5)
    explorer.until("tips() === 0")


COUNT = """(() => {
  const ask = requestAnimationFrame;
  window.frames = 0;
  window.requestAnimationFrame = (act) => { window.frames += 1; return ask(act); };
})()"""


def asked_for(page):
    """Number of frames that the page asks for within half a second."""
    before = page.evaluate("window.frames")
    page.wait_for_timeout(500)
    return page.evaluate("window.frames") - before


def rests(page):
    wait_until(lambda: asked_for(page) == 0, what="the page at rest, once all that is said of the motion has come")


def swings(page):
    wait_until(lambda: asked_for(page) > 3, what="a swinging pendulum")


def test_frames_are_requested_only_while_the_pendulums_swing_and_are_visible(kept):
    explorer = kept.anew()
    page, play = explorer.page, explorer.page.get_by_role("button", name="Play", exact=True)
    page.evaluate(COUNT)
    rests(page)
    play.click()
    swings(page)
    explorer.open_tab("Help")
    rests(page)
    explorer.open_tab("Explore")
    swings(page)
    page.evaluate(NEAR)
    page.mouse.move(*page.evaluate("near"))  # the pendulums stand still at the time that is pointed at
    rests(page)


def test_a_legend_keeps_its_entries_until_one_of_them_changes_or_it_changes_itself(kept):
    """The hook "legends". It comes last: no other test can do with the legend that it leaves."""
    explorer = with_legend(kept.anew())
    explorer.page.evaluate(HIDE)
    explorer.until("legend.entries !== kept && legend.entries[1].el.className.includes('inactive')")
    assert explorer.page.evaluate("legend.entries.length") == 2
    explorer.page.evaluate("() => { kept = legend.entries; legend.model.ncols = 1; }")
    explorer.until("legend.entries !== kept")
