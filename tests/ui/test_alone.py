"""The curves over each number alone in a real browser: seen, clicked, and gone with a move."""

from tests.ui.taking import menu
from tests.waiting import wait_until

OPENING = "?eta=1.08&K=100&D=50&steps=2000"
SEEN = """name => {
  const plot = Bokeh.documents[0].get_model_by_name(name), view = plot && Bokeh.index.find_one(plot);
  if (!view) return { title: "" };
  const box = view.el.getBoundingClientRect();
  const filled = source => [...(source.data.values?.() ?? Object.values(source.data))][0].length;
  const drawn = plot.renderers.filter(each => each.visible && filled(each.data_source));
  return { width: box.width, height: box.height, drawn: drawn.map(each => each.glyph.type), title: plot.title.text };
}"""
PLACE = """([name, x, y]) => {
  const plot = Bokeh.documents[0].get_model_by_name(name), view = Bokeh.index.find_one(plot);
  const box = view.el.getBoundingClientRect(), frame = view.frame;
  return [box.left + frame.x_scale.compute(x), box.top + frame.y_scale.compute(y)];
}"""
GLYPHS = {"VStrip", "HSpan", "VSpan", "Line", "Scatter"}


def seen(explorer, name):
    return explorer.page.evaluate(SEEN, name)


def searched(explorer):
    explorer.explained().unfold("More: ")
    wait_until(lambda: "; " in seen(explorer, "alone_steps")["title"], what="at best, or that there is no better value")
    return explorer


def click_at(explorer, name, x, y):
    explorer.page.evaluate(
        "name => Bokeh.index.find_one(Bokeh.documents[0].get_model_by_name(name)).el.scrollIntoView()", name
    )
    explorer.page.mouse.click(*explorer.page.evaluate(PLACE, [name, x, y]))


def test_three_curves_come_when_they_are_looked_at_and_a_click_on_a_minimum_sets_it_and_undo_takes_it_back(kept):
    explorer = kept(OPENING).explained()
    assert seen(explorer, "alone_K") == {"title": ""}
    assert {"PNG", "SVG"} <= set(menu(explorer)["Difference over K"])
    explorer.page.keyboard.press("Escape")
    searched(explorer)
    for name in ("alone_K", "alone_D", "alone_steps"):
        found = seen(explorer, name)
        assert found["height"] >= 110
        assert found["width"] >= 200
        assert set(found["drawn"]) == GLYPHS
        assert found["title"].startswith("now 54 %; at best ")
    explorer.page.get_by_role("heading", name="Change one number alone: what is left of the difference").wait_for()
    wait_until(lambda: "Difference over the step" in menu(explorer), what="the figures in the menu")
    for title in ("Difference over K", "Difference over D", "Difference over the step"):
        assert {"PNG", "SVG", "CSV"} <= set(menu(explorer)[title])
    explorer.page.keyboard.press("Escape")  # the open menu may cover the curves
    marks = explorer.source("marks_over_D")
    explorer.moved(lambda: click_at(explorer, "alone_D", marks["best"][0], marks["best_left"][0]))
    assert float(explorer.typed("D").input_value()) == round(marks["best"][0], 4)
    searched(explorer)
    assert explorer.source("marks_over_D")["now_left"][0] < 10
    explorer.moved(lambda: explorer.page.get_by_role("button", name="Undo").click())
    assert explorer.typed("D").input_value() == "50"


def test_a_move_takes_the_curves_away_and_brings_its_own(kept):
    explorer = searched(kept(OPENING))
    before = explorer.source("left_over_K")["left"]
    explorer.type("D", "20")
    wait_until(lambda: not explorer.source("left_over_K")["x"] or explorer.source("left_over_K")["left"] != before)
    searched(explorer)
    wait_until(lambda: explorer.source("marks_over_D")["now"] == [20], what="the curves of D = 20")
    explorer.type("steps", "8")  # it blows up: there is nothing to search for
    explorer.page.get_by_role("heading", name="Change one number alone").wait_for(state="hidden")


def test_a_phone_has_the_curves_below_each_other(kept):
    explorer = searched(kept.anew(OPENING, 390, 844))
    wait_until(lambda: seen(explorer, "alone_K")["width"] >= 350, what="a curve as wide as the phone")
    assert explorer.page.evaluate("document.documentElement.scrollWidth") <= 390
