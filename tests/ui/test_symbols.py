"""Every symbol on the page has its name beside it, and its unit where it has one: read from what is rendered."""

import re

from vibroscope.app.page.tabs import TABS

from tests.waiting import wait_until

# Texts of labels, heads and keys that are seen; and by figure, the labels of its axes and the entries of its legend.
TEXTS = """() => {
  const texts = [], figures = {};
  const walk = (root) => root.querySelectorAll("*").forEach((node) => {
    if (node.shadowRoot) walk(node.shadowRoot);
    const holds = node.matches("label, legend, th, dt, output, summary, h2, .key li, .group > span, .note > span");
    if (!holds || !node.checkVisibility() || node.closest("dialog, article")) return;
    texts.push(node.innerText.replace(/\\s+/g, " ").trim());
  });
  walk(document.body);
  for (const figure of Bokeh.documents[0].all_models) {
    const view = figure.type === "Figure" ? Bokeh.index.find_one_by_id(figure.id) : null;
    if (!view?.frame || !view.el.getBoundingClientRect().width) continue;
    const parts = [...figure.below, ...figure.left, ...figure.right, ...figure.center, ...figure.above];
    figures[figure.name] = [
      parts.filter((part) => part.visible && part.axis_label).map((axis) => axis.axis_label.replaceAll("\\n", " ")),
      parts.filter((part) => part.type === "Legend").flatMap((legend) => legend.items.filter((item) => item.visible)
        .map((item) => item.label.value)),
      figure.toolbar.tools.filter((tool) => tool.type === "HoverTool")
        .flatMap((tool) => tool.tooltips.map(([head]) => head)),
    ];
  }
  return [texts.filter(Boolean), figures];
}"""
OPEN = """() => {
  const walk = (root) => root.querySelectorAll("*").forEach((node) => {
    if (node.shadowRoot) walk(node.shadowRoot);
    if (node.matches("details.more, details.others")) node.open = true;
  });
  walk(document.body);
}"""
SYMBOL = re.compile(r"[ηκξτεωμσζλΩΔ]|(?<![\w.])(?:2?[KDTA]|[efxtd][₁₂₃]?)(?![\w.])")
NAME = re.compile(r"[A-Za-z]{4,}")
NAMES = {"mm-t-s", "K and D"}  # a system of units, and a part of the difference
OF_FIGURES = {"bifurcation": 2, "plane": 2, "basin": 2, "step": 4, "code": 2, "speed": 1, "impact": 3}
OF_FIGURES |= {"load": 4, "peaks": 2}
STARTED = "direction:own;start_v2:0.0467"  # 5 mm/s in Aω₁
FIELDS = {  # a part of each name: unit in mm-t-s, and what a number without dimension is a multiple of
    "penalty stiffness": ("N/mm", "k₁"),
    "penalty damp": ("N·s/mm", "2m₁ω₁"),
    "excitation frequency": ("Hz", ""),
    "displacement of body 1": ("mm", "base amplitude"),
    "velocity of body 2": ("mm/s", "Aω₁"),
    "separation speed": ("mm/s", "Aω₁"),
    "mass of": ("t", "kg"),
}


def nameless(explorer):
    """Texts with a symbol and no name; entries of a legend may have the name on an axis."""
    texts, figures = explorer.page.evaluate(TEXTS)
    found = [text for text in texts if SYMBOL.search(text) and not NAME.search(text) and text not in NAMES]
    for name, (axes, entries, heads) in figures.items():
        found += [f"{name}: {text}" for text in (*axes, *heads) if SYMBOL.search(text) and not NAME.search(text)]
        symbols = {symbol for entry in entries for symbol in re.findall("[ξxλ][₁₂]?", entry) if SYMBOL.search(symbol)}
        found += [f"{name}: {symbol}" for symbol in symbols if not any(symbol in axis for axis in axes)]
    return found


def open_by_key(explorer, number, tab, view):
    """Open a view: a digit opens the first one of a tab, End the last."""
    lists = explorer.page.get_by_role("tablist")
    if view is tab.views[0]:
        explorer.page.keyboard.press(f"Shift+Digit{number}")
        parts = explorer.page.get_by_role("tablist", name="Parts of the page")  # a view may have the title of its tab
        parts.get_by_role("tab", name=tab.title, exact=True, selected=True).wait_for()
        wait_until(lambda: lists.count() == 1 + (len(tab.views) > 1), what="the views of the tab")
    else:
        lists.last.get_by_role("tab", selected=True).focus()
        explorer.page.keyboard.press("End")
        lists.last.locator(f"[aria-selected=true]:text-is('{view.title}')").wait_for()
        explorer.wait_for_address(view=view.key)
    explorer.page.get_by_role("tabpanel", name=view.title).wait_for()


def check_fields(explorer, column):
    texts, _ = explorer.page.evaluate(TEXTS)
    for part, units in FIELDS.items():
        label = next(text for text in texts if part in text)
        assert label.endswith(f", {units[column]}" if units[column] else label), label


def test_every_symbol_of_the_branches_has_its_name(visit):
    explorer = visit(
        "?view=bifurcation&eta=1.42&K=12000&D=18&zoom=eta:1.3,1.5&choice=branches:both;count:60;transient:200"
    )
    for units in ({}, {"units": "mm-t-s", "omega1": "100"}):
        explorer.at(**units)
        rows = explorer.page.locator(".branches-list[data-running=false] .points [data-kind]")
        rows.first.wait_for()
        assert "largest multiplier" in explorer.page.evaluate(TEXTS)[0]
        wait_until(lambda: not nameless(explorer), what=f"a name beside each symbol: {units}")


def test_keys_reach_every_view_and_every_symbol_has_its_name_and_unit_beside_it(visit):
    explorer = visit("?view=help&units=mm-t-s&omega1=100&pin=eta=1.08%26K=2500%26D=8%26steps=2000")
    # Explore comes last: while it is built, another view takes far longer to open.
    for number, tab, view in [(n, each, view) for n, each in enumerate(TABS[1:], 2) for view in each.views]:
        open_by_key(explorer, number, tab, view)
        explorer.page.evaluate(OPEN)
        figures = OF_FIGURES.get(view.key, 0)
        wait_until(lambda figures=figures: len(explorer.page.evaluate(TEXTS)[1]) >= figures, what=view.title)
        # a figure that has no result yet has no words on its axes either
        wait_until(lambda: not nameless(explorer), what=f"a name beside each symbol of {view.title}")
        assert [text for text in explorer.page.evaluate(TEXTS)[0] if "ξ" in text] == [], view.title  # x with units
        if view.key == "bifurcation":
            explorer.page.locator(".study select:has(option[value=own])").select_option("own")
            start = explorer.page.locator(".study label", has_text="velocity of body 2 at t = 0, mm/s")
            start.locator("input").fill("5")
            start.locator("input").press("Enter")
            wait_until(lambda: explorer.address().get("choice", "").startswith(STARTED), what=STARTED)
    explorer.page.get_by_role("tab", selected=True).first.focus()
    explorer.page.keyboard.press("Home")
    explorer.page.locator("[role=tab][aria-selected=true]:text-is('Explore')").wait_for()
    explorer.explained().page.evaluate(OPEN)
    explorer.unfold("More: ")
    explorer.page.get_by_role("button", name="Options of the search").click()
    check_fields(explorer, 0)
    wait_until(lambda: len(explorer.page.evaluate(TEXTS)[1]) >= 6, what="the figures of Explore")
    wait_until(lambda: not nameless(explorer), what="a name beside each symbol of Explore")
    assert [text for text in explorer.page.evaluate(TEXTS)[0] if "ξ" in text] == []
    explorer.open_tab("Help")  # a tab opens the view that was open last in it
    explorer.page.get_by_role("tabpanel", name=TABS[-1].views[-1].title).wait_for()
    open_by_key(explorer, 1, TABS[0], TABS[0].views[0])
    explorer.unfold("System")
    explorer.moved(lambda: explorer.page.get_by_label("non-dimensional").check())
    assert nameless(explorer) == []
    check_fields(explorer, 1)
