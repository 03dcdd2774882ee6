"""The data of the page, to be compared with a baseline, and its faults."""

import itertools
import math
import re
from pathlib import Path

READ = Path(__file__).with_name("snapshots.js").read_text(encoding="utf-8")
# Bokeh clears a canvas half a pixel off, so that parts of earlier paintings remain at its edge.
AFRESH = """() => {
  for (const model of [...Bokeh.documents[0].all_models].filter((one) => one.type === "Figure")) {
    const view = Bokeh.index.find_one_by_id(model.id);
    if (!view?.canvas_view) continue;
    const clear = (node) => {
      if (node instanceof HTMLCanvasElement) {
        const context = node.getContext("2d");
        context.save();
        context.resetTransform();
        context.clearRect(0, 0, node.width, node.height);
        context.restore();
      }
      for (const child of [...(node.shadowRoot?.children ?? []), ...node.children]) clear(child);
    };
    clear(view.el);
    view.invalidate_painters();
    view.paint();
  }
}"""
KEPT_VALUES = 60  # of a column; a curve that changes does so at more than one point
LEAST_INK = 40  # pixels; a single mark has more
# Boxes of letters are taller than the letters.
BESIDE, BELOW = 1.0, 3.5

# In mm, s and N a label ends in its unit; these are ratios all the same.
UNIT = re.compile(r" / (%|µs|mm|m|s|N|Hz|\(mm/s\)|\(m/s\)|\(N·s\)|\(N/m\)|\(N·s/m\)|\(N/mm\)|\(N·s/mm\))(?=[ ,]|$)")
RATIO = re.compile(r"η = Ω/ω₁|/Δτ|relative|non-dimensional|restitution e\b")
# Otherwise it names a number of the model or its divisor.
NUMBER = re.compile(r"[ηξτλωKD]|/ base amplitude|error after")


def read(page):
    """Figures as they are drawn, texts and their positions, boxes of the parts of the page."""
    return page.evaluate(READ)


# -- for the baseline ----------------------------------------------------------


def data(found, irregular="", measured=False, stacked=False):
    """The data that must be the same on any machine.

    Parameters
    ----------
    irregular
        A pattern of "figure/source.column" for columns of chaotic motions, of which only the presence is compared.
    measured
        The page shows measured times.
    stacked
        Parts are below each other, so that their heights depend on the letters above; only their order is compared.
    """
    texts = ["measured" if text["measured"] else text["text"] for text in words(found)]
    if irregular or measured:
        texts = [hidden(text) for text in texts]
    return {
        "figures": {
            figure["name"]: of_figure(figure, "." if measured else irregular, stacked) for figure in found["figures"]
        },
        "texts": texts,
        "boxes": [[name, *placed(box, stacked or measured)] for name, *box in found["boxes"]],
    }


def words(found):
    """The texts of the page outside figures, whose texts follow from their data."""
    return [text for text in found["texts"] if "figure" not in text]


def hidden(text):
    """A text without its numbers."""
    return re.sub(r"[\d.,]+(e[−-]?\d+)?", "#", text)


def placed(box, stacked):
    """Left, top, width and height; if stacked, only left and width."""
    return {"x": box[0], "width": box[2]}.values() if stacked else box


def of_figure(figure, irregular, stacked):

    def shown(source, name, values):
        place = f"{figure['name']}/{source}.{name}"
        return structure(values) if irregular and re.search(irregular, place) else thinned(values)

    columns = {
        source: {name: shown(source, name, values) for name, values in columns.items()}
        for source, columns in figure["sources"].items()
    }
    return {
        "title": hidden(figure["title"]) if irregular else figure["title"],
        "axes": figure["axes"],
        "legend": figure["legend"],
        "box": list(placed(figure["box"], stacked)) + ([figure["box"][3]] if stacked else []),
        "sources": columns,
    }


def structure(values):
    return "finite" if any(is_finite(value) for value in values) else "empty"


def thinned(values):
    """Length and some values of a column."""
    return [f"{len(values)} values", *values[:: max(1, math.ceil(len(values) / KEPT_VALUES))]]


def is_finite(value):
    return isinstance(value, str) or (isinstance(value, int | float) and math.isfinite(value))


# -- faults -------------------------------------------------------------------


def faults(found, physical=False):
    """Empty figures, axes without a unit, texts that overlap or are cut off; one line of text each."""
    lines = [fault for figure in found["figures"] for fault in (*emptiness(figure), *unlabelled(figure, physical))]
    if found["wide"] > 0:
        lines.append(f"the page is {found['wide']} pixels wider than the window")
    return [*lines, *misplaced(found["texts"])]


def emptiness(figure):
    """The fault if nothing is drawn."""
    columns = [values for source in figure["sources"].values() for values in source.values()]
    if not any(is_finite(value) for values in columns for value in values):
        yield f"{figure['name']} has no data"
    elif figure["ink"] < LEAST_INK:
        yield f"{figure['name']} is empty: its data add {figure['ink']} pixels"


def unlabelled(figure, physical):
    """Axes without a unit."""
    for axis in figure["axes"]:
        label = " ".join((axis["label"] or "").split())  # a long one is in two lines
        if not label:
            strip = figure["shares_axis"] and len(figure["axes"]) == 1
            if axis["kind"] != "CategoricalAxis" and not strip:
                yield f"{figure['name']} has an axis without a label"
        elif not (UNIT.search(label) or RATIO.search(label) or (not physical and NUMBER.search(label))):
            yield f"{figure['name']} has an axis without a unit: {label!r}"


def misplaced(texts):
    """Texts that lie over each other, or are cut off."""
    placed = []  # text, what it is a part of, box
    for number, text in enumerate(texts):
        for place in text.get("places", [text]):
            placed.append((text["text"], number, place["box"]))
            if place["cut"]:
                yield f"cut off: {text['text'][:80]!r}"
    placed.sort(key=lambda entry: entry[2][1])
    for index, (text, part, box) in enumerate(placed):
        below = itertools.takewhile(lambda entry: entry[2][1] < box[1] + box[3] - BELOW, placed[index + 1 :])  # noqa: B023
        for other, other_part, other_box in below:
            if part != other_part and overlap(box, other_box):
                yield f"{text[:60]!r} and {other[:60]!r} lie over each other"


def overlap(one, two):
    beside, below = (min(one[i] + one[i + 2], two[i] + two[i + 2]) - max(one[i], two[i]) for i in (0, 1))
    return beside > BESIDE and below > BELOW
