"""Nothing of the page is cut, from the smallest phone to a large screen: asserted from the boxes that are rendered."""

import json

import pytest

from tests.share import every
from tests.waiting import wait_until

SIZES = (
    (320, 568),
    (390, 844),
    (1440, 900),
    (3840, 2160),
    (720, 450),  # 1440 × 900 at 200 %
    (768, 1024),
    (1024, 768),
    (1280, 720),
)
# Views by their names in `test_snapshots`, which opens them, and how many figures each shows at least.
TABS = {"scene-a": 6, "bifurcation": 2, "plane": 2, "basin": 2, "step": 4, "code": 2, "load": 0, "peaks": 0}
TABS |= {"impact": 3, "speed": 1, "paper": 0, "help": 0}

# Texts and controls that an ancestor clips or that lie outside the page; boxes that scroll sideways, or scroll without
# a cue; texts and legends of figures that are wider than their canvas. All of what is open, wherever it is scrolled to.
CUT = """() => {
  const cut = [], ARROW = 17; // px, of a list
  const pen = document.createElement("canvas").getContext("2d");
  const parentOf = (node) => node.assignedSlot ?? node.parentElement ?? node.getRootNode().host ?? null;
  const nameOf = (node) => `${node.tagName.toLowerCase()}.${node.className.baseVal ?? node.className}`;
  const seen = new Map(); // what counts of an ancestor, which many texts have in common
  const read = (node) => {
    const style = getComputedStyle(node), { overflowX, overflowY } = style;
    const scrolls = !["visible", "hidden", "clip"].includes(overflowY);
    return {
      unseen: style.clipPath !== "none" || style.visibility === "hidden",
      fixed: style.position === "fixed",
      clipsSideways: overflowX !== "visible",
      clipsUpright: overflowY !== "visible",
      scrolls,
      uncued: scrolls && node.scrollHeight > node.clientHeight + 13
        && !node.hasAttribute("data-more") && node.getAttribute("role") !== "main",
      box: node.getBoundingClientRect(),
      parent: parentOf(node),
    };
  };
  const about = (node) => seen.get(node) ?? seen.set(node, read(node)).get(node);
  const check = (rect, from, what) => {
    if (rect.width < 1 || rect.height < 1) return;
    let [sideways, upright] = [true, true]; // whether it is still to be checked in this direction
    for (let at = from; at && at !== document.documentElement; at = about(at).parent) {
      const { unseen, fixed, clipsSideways, clipsUpright, scrolls, uncued, box } = about(at);
      if (unseen) return;
      if (fixed) break;
      if (sideways && clipsSideways) {
        if (rect.left < box.left - 1.5 || rect.right > box.right + 1.5) cut.push(`${what}: sideways in ${nameOf(at)}`);
        sideways = false;
      }
      if (upright && clipsUpright) {
        if (!scrolls && (rect.top < box.top - 1.5 || rect.bottom > box.bottom + 1.5)) {
          cut.push(`${what}: below in ${nameOf(at)}`);
        }
        if (uncued) cut.push(`${nameOf(at)} scrolls without a cue`);
        if (scrolls) upright = false;
      }
    }
    if (sideways && (rect.left < -1 || rect.right > innerWidth + 1)) cut.push(`${what}: outside the page`);
  };
  const walk = (root) => root.querySelectorAll("*").forEach((node) => {
    if (node.checkVisibility && !node.checkVisibility()) return;
    if (node.closest(".equation, pre, .cue")) return;
    if (["BUTTON", "INPUT", "SELECT", "PROGRESS", "svg"].includes(node.tagName)) {
      check(node.getBoundingClientRect(), parentOf(node), `${nameOf(node)} ${node.textContent.slice(0, 20)}`);
    }
    if (node.type === "text" && node.scrollWidth > node.clientWidth + 1) cut.push(`${node.id} ${node.value}`);
    if (node.tagName === "SELECT") {
      const chosen = node.selectedOptions[0]?.textContent ?? "";
      pen.font = getComputedStyle(node).font;
      if (pen.measureText(chosen).width + ARROW > node.clientWidth) cut.push(`${chosen}: in its list`);
    }
    for (const text of node.childNodes) {
      if (text.nodeType !== 3 || !text.textContent.trim()
        || ["STYLE", "SCRIPT", "OPTION", "TITLE", "title"].includes(node.tagName)) continue;
      const range = document.createRange();
      range.selectNodeContents(text);
      for (const rect of range.getClientRects()) check(rect, node, `“${text.textContent.trim().slice(0, 24)}”`);
    }
    if (node.shadowRoot) walk(node.shadowRoot);
  });
  walk(document.body);
  if (document.scrollingElement.scrollWidth > innerWidth) cut.push("the page scrolls sideways");
  const ruler = document.createElement("canvas").getContext("2d");
  const widest = (model, name, text) => {
    ruler.font = ["font_style", "font_size", "font"].map((part) => model[`${name}_${part}`]).join(" ");
    return Math.max(...text.split("\\n").map((line) => ruler.measureText(line).width));
  };
  let figures = 0;
  for (const model of Bokeh.documents[0].all_models) {
    const view = model.type === "Figure" ? Bokeh.index.find_one_by_id(model.id) : null;
    if (!view?.frame || !view.el.getBoundingClientRect().width) continue;
    figures += 1;
    const { bbox, frame: { bbox: frame } } = view;
    const complain = (what) => cut.push(`${model.name}: ${what}`);
    if (frame.width < 60 || frame.height < 20) complain(`frame of ${frame.width} × ${frame.height}`);
    if (frame.left < 0 || frame.right > bbox.width + 1 || frame.bottom > bbox.height + 1) complain("frame");
    check(view.el.getBoundingClientRect(), parentOf(view.el), model.name);
    const { title } = model;
    if (title?.visible && title.text && frame.left + widest(title, "text", title.text) > bbox.width) complain("title");
    for (const [side, middle, length] of [["below", frame.hcenter, bbox.width], ["left", frame.vcenter, bbox.height],
      ["right", frame.vcenter, bbox.height]]) {
      for (const axis of model[side].filter((part) => part.visible && part.axis_label)) {
        const half = widest(axis, "axis_label_text", axis.axis_label) / 2;
        if (middle - half < -1 || middle + half > length + 1) complain(`axis label “${axis.axis_label}”`);
      }
    }
    for (const legend of [...model.center, ...model.above].filter((part) => part.type === "Legend")) {
      const { left, right } = view.views.find_one(legend).bbox;
      const room = model.center.includes(legend) ? frame : { left: 0, right: bbox.width };
      if (left < room.left - 1 || right > room.right + 1) complain("legend");
    }
  }
  return [[...new Set(cut)], figures];
}"""


# Open states beside the tabs as they are at first: a query, and what has come once the state is complete.
_POINT = "eta=1.42&K=12000&D=18&steps=200"
_LONG = "eta=1.86666666666667&K=1234.56789012345&bodies=two&d1=0.0123456789012345&threshold=1.23456789012345e-05"
_PINS = ";".join(f"eta=2.5%26K={K}%26D=18%26steps=200" for K in (2500, 300, 30))  # quickly explained
_SWEEP = "zoom=eta:1.3,1.5&choice=branches:both;count:60;transient:200"
STATES = {
    "pins": (f"?{_POINT}&pin={_PINS}", ".comparison-table .pin3 .acts"),
    "branches": (f"?view=bifurcation&{_POINT}&{_SWEEP}", ".branches-list[data-running=false] .points [data-kind]"),
    "code": (f"?view=code&{_POINT}&choice=code:calculix", "section.study[data-share='1']"),
    "units": (f"?{_POINT}&units=si&omega1=100", ".lines[data-pending=false]"),
    "long numbers": (f"?{_LONG}", ".lines[data-pending=false]"),
}
OF_STATES = ((390, 844), (720, 450), (768, 1024), (1024, 768), (1440, 900))


def tried(names, sizes):
    """By name the first size and a share of the others."""
    others = every([(name, size) for name in names for size in sizes[1:]])
    return {name: [sizes[0], *(size for other, size in others if other == name)] for name in names}


def test_nothing_of_measured_times_is_cut_at_any_size(visit):
    """Of the other views: `test_snapshots`."""
    check(visit("?view=speed"), tried(TABS, SIZES)["speed"], TABS["speed"])


@pytest.mark.parametrize("state", STATES)
def test_nothing_is_cut_in_an_open_state(kept, state):
    query, complete = STATES[state]
    explorer = kept(query)
    explorer.page.locator(complete).locator("visible=true").first.wait_for()
    check(explorer, tried(STATES, OF_STATES)[state], 1)


def test_no_panel_slides_over_the_branches(kept):
    query, complete = STATES["branches"]
    explorer = kept(query).resized(1000, 768)
    explorer.page.locator(complete).first.wait_for()
    explorer.page.locator(complete).last.scroll_into_view_if_needed()
    panel, listed = (explorer.page.locator(part).bounding_box() for part in ("section.study", ".branches-list"))
    assert panel["y"] + panel["height"] <= listed["y"]


def check(explorer, sizes, figures):
    """Nothing is cut at these sizes, and so many figures are seen."""
    found = {}
    for width, height in sizes:
        explorer.resized(width, height)

        def holds(size=(width, height)):
            cut, seen = explorer.page.evaluate(CUT)
            found[size] = cut or ([] if seen >= figures else [f"{seen} figures"])
            return not found[size]

        try:
            wait_until(holds, 30)  # figures follow their boxes in some steps
        except AssertionError:
            continue
    assert not any(found.values()), json.dumps([(size, cut) for size, cut in found.items() if cut], ensure_ascii=False)
