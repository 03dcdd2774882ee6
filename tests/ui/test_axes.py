"""Axes of the figures: labels of ticks that can be told apart, and frames below each other that share an axis."""

from itertools import pairwise

import pytest

from tests.waiting import wait_until

# A body that moves by some micrometres, in metres.
SMALL = "?eta=1.8667&K=2000&D=4&steps=200&bodies=two&kappa=2.1&units=si&omega1=94&m1=2&amplitude=0.001"
SMALL += "&view=bifurcation&choice=count:4;transient:20"
AT_LINE = "?view=bifurcation&eta=3.95&K=2500&D=8&steps=200&choice=count:4;transient:20"

# Texts that a repaint of all figures writes, with where they begin and end across, by canvas and height.
WRITTEN = """async () => {
  const canvases = [], rows = new Map(), { prototype } = CanvasRenderingContext2D, write = prototype.fillText;
  prototype.fillText = function (text, x, y, ...more) {
    const { a, b, e, f } = this.getTransform();
    const width = this.measureText(text).width, left = e + a * x;
    if (!canvases.includes(this.canvas)) canvases.push(this.canvas);
    const key = `${canvases.indexOf(this.canvas)} ${Math.round(f + a * y)}`;
    if (Math.abs(b) < 1e-6) rows.set(key, [...(rows.get(key) ?? []), [left, left + a * width, text]]);
    write.call(this, text, x, y, ...more);
  };
  const figures = [...Bokeh.documents[0].all_models].filter(({ type }) => type === "Figure")
    .map(({ id }) => Bokeh.index.find_one_by_id(id)).filter((view) => view?.el.getBoundingClientRect().width);
  for (const view of figures) view.request_repaint();
  await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  prototype.fillText = write;
  return [...rows.values()];
}"""
FRAME = """name => {
  const view = Bokeh.index.find_one_by_id(Bokeh.documents[0].get_model_by_name(name).id);
  const left = view.canvas_view.el.getBoundingClientRect().x;
  return [view.frame.bbox.left + left, view.frame.bbox.right + left];
}"""


@pytest.mark.parametrize(("tab", "width"), [("basin", 1440), ("step", 390), ("explore", 390)])
def test_labels_of_ticks_do_not_run_into_each_other(kept, tab, width):
    explorer = kept(SMALL, width, 900).open_view(tab)
    wait_until(lambda: max(map(len, explorer.page.evaluate(WRITTEN)), default=0) >= 3, what="labels in a row")
    for row in map(sorted, explorer.page.evaluate(WRITTEN)):
        for (_, end, one), (begin, _, other) in pairwise(row):
            assert begin > end, (one, other)


def test_a_power_of_ten_has_no_zeros_that_say_nothing(kept):
    formatted = kept(AT_LINE, 390, 844).page.evaluate("""() => {
      const formatter = new (Bokeh.loader["models/formatters/basic_tick_formatter"].BasicTickFormatter)();
      return [[-2e-6, 0, 2e-6], [1.5e-7, 2e-7]].map((ticks) => formatter.doFormat(ticks, {}));
    }""")
    assert formatted == [["−2e−6", "0", "2e−6"], ["1.5e−7", "2e−7"]]


# What a repaint of all figures writes, where it ends across, and the width of its canvas.
ENDS = """async () => {
  const found = [], { prototype } = CanvasRenderingContext2D, write = prototype.fillText;
  prototype.fillText = function (text, x, y, ...more) {
    const { a, b, e } = this.getTransform();
    const shift = { right: 1, end: 1, center: 0.5 }[this.textAlign] ?? 0;
    const width = a * this.measureText(text).width, left = e + a * x - shift * width;
    if (Math.abs(b) < 1e-6) found.push([text, left, left + width, this.canvas.width]);
    write.call(this, text, x, y, ...more);
  };
  const figures = [...Bokeh.documents[0].all_models].filter(({ type }) => type === "Figure")
    .map(({ id }) => Bokeh.index.find_one_by_id(id)).filter((view) => view?.el.getBoundingClientRect().width);
  for (const view of figures) view.request_repaint();
  await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  prototype.fillText = write;
  return found;
}"""


def words_at_line(explorer):
    return [ends for text, *ends in explorer.page.evaluate(ENDS) if text.startswith("η = ")]


@pytest.mark.parametrize("eta", ["3.95", "0.55"])
def test_the_words_at_the_line_stay_in_the_figure(kept, eta):
    words = words_at_line(kept(AT_LINE, 390, 844).at(eta=eta))
    assert words
    for left, right, width in words:
        assert left >= 0
        assert right <= width


def test_a_line_outside_the_figure_has_no_words(visit):
    assert not words_at_line(visit(f"{AT_LINE}&zoom=eta:1,2", 390, 844))


def test_the_strip_of_the_diagram_lies_below_the_values_that_it_is_of(kept):
    explorer = kept(SMALL).open_view("bifurcation")
    page = explorer.page
    explorer.until("Bokeh.documents[0].get_model_by_name('bifurcation_periods').data.left?.length > 0")
    explorer.settle()
    diagram, strip = (page.evaluate(FRAME, name) for name in ("bifurcation", "bifurcation_strip"))
    assert diagram == pytest.approx(strip, abs=1)
    label = page.evaluate("Bokeh.documents[0].get_model_by_name('bifurcation').left[0].axis_label")
    assert label.endswith("/ m")
