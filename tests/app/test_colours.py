"""Figures can be read: curves and cells, also by colour-blind readers; what stands on their background."""

import itertools

import numpy as np
import pytest
from bokeh.colors import named
from bokeh.document import Document
from bokeh.models import Plot
from vibroscope.app.page.bifurcation.figure import legend as strip_key
from vibroscope.app.page.paper.figures import KINDS, draw
from vibroscope.app.page.shared.figure import DARK, PINS, THEME
from vibroscope.app.page.tabs import VIEWS
from vibroscope.app.studies import basin, cell_classes

from tests.app.fakes import FakeHost
from tests.app.test_paper_figures import PICTURES

LEAST_DISTANCE = 20  # in CIELAB between two curves that differ in colour alone; about 2 is just noticeable side by side
LEAST_OF_CELLS = 7  # between two classes of cells, whose areas touch
LEAST_WIDTH = 2  # pixels by which curves differ that differ by their width alone
TEXT, GRAPHICS = 4.5, 3.0  # contrasts that WCAG 2.1 asks for (1.4.3, 1.4.11)

# Machado, Oliveira and Fernandes (2009), severity 1, on linear RGB; sRGB to XYZ (IEC 61966-2-1).
SEEN = {
    "everyone": np.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def linear(colour):
    values = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    ratio = XYZ @ rgb / XYZ.sum(axis=1)
    x, y, z = np.where(ratio > 216 / 24389, np.cbrt(ratio), (24389 / 27 * ratio + 16) / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def distance(one, other, seen):
    return np.linalg.norm(np.subtract(*(lab(np.clip(SEEN[seen] @ linear(each), 0, 1)) for each in (one, other))))


def contrast(one, other):
    low, high = sorted((XYZ @ linear(each))[1] for each in (one, other))
    return (high + 0.05) / (low + 0.05)


def over(colour, alpha, background):
    """A colour with an opacity over a background, as the browser mixes them."""
    pairs = zip(*map(parts, (colour, background)), strict=True)
    return "#" + "".join(f"{round(alpha * int(c, 16) + (1 - alpha) * int(b, 16)):02X}" for c, b in pairs)


def parts(colour):
    return [colour[i : i + 2] for i in (1, 3, 5)]


def in_theme(colour, theme):
    return DARK.get(colour.upper(), colour) if theme == "dark" else colour


@pytest.fixture(scope="module")
def figures():
    """Every figure of every tab, with all pins; the Paper's with curves: cells have a test of their own."""
    found = {f"paper: {name}": draw(make(), name) for name, make in PICTURES.items() if name != "cells"}
    for key, kind in VIEWS.items():
        tab = kind(FakeHost())
        page = tab.build()
        if key == "explore":
            tab.motion.add(tab.motion.pins)
            tab.motion.draw_beside([{}] * len(PINS), {}, {})
        found |= {f"{key}: {plot.name}": plot for plot in plots(page)}
    doc = Document(theme=THEME)
    for plot in found.values():
        doc.add_root(plot)
    assert {name.partition(":")[0] for name in found} == VIEWS.keys() - {"help"}
    return found


def plots(view):
    """The Bokeh figures in a view of Panel."""
    if isinstance(getattr(view, "object", None), Plot):
        yield view.object
    for part in getattr(view, "objects", []):
        yield from plots(part)


def plain(value):
    """A property's value, also where it is a specification that holds one."""
    return getattr(value, "value", value)


def looks(item):
    """Colour, opacity, dash, marker and width of each curve that an entry of a legend names."""
    for renderer in item.renderers:
        glyph = {name: plain(value) for name, value in renderer.glyph.properties_with_values().items()}
        colour = glyph.get("line_color") or glyph.get("fill_color")
        colour = colour if colour.startswith("#") else getattr(named, colour).to_hex().upper()
        shape = str(glyph.get("line_dash")), str(glyph.get("marker"))
        yield colour, glyph.get("line_alpha") or 1.0, shape, glyph.get("line_width") or 0


def entries(plot):
    """Label and looks of each entry of the legends of a figure, and whether it is shown at first."""
    return [(item.label.value, list(looks(item)), item.visible) for legend in plot.legend for item in legend.items]


def differ_in_shape(one, other):
    shapes = [[look[2] for look in each] for each in (one, other)]
    widths = [max(look[3] for look in each) for each in (one, other)]
    return shapes[0] != shapes[1] or abs(widths[0] - widths[1]) >= LEAST_WIDTH


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_curves_of_a_figure_are_told_apart_by_colour_blind_readers_too(figures, theme):
    for name, plot in figures.items():
        shown = {visible: [entry for entry in entries(plot) if entry[2] == visible] for visible in (True, False)}
        for together in shown.values():  # the parts of the difference take the place of the displacements
            for (one, a, _), (other, b, _) in itertools.combinations(together, 2):
                for seen in () if differ_in_shape(a, b) else SEEN:
                    found = distance(*(in_theme(each[0][0], theme) for each in (a, b)), seen)
                    assert found >= LEAST_DISTANCE, (name, one, other, seen, found)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_text_axes_and_curves_stand_out_from_their_background(figures, theme):
    for name, plot in figures.items():
        background = in_theme(plot.background_fill_color, theme)
        for label, curves, _ in entries(plot):
            seen = [over(in_theme(colour, theme), alpha, background) for colour, alpha, *_ in curves]
            assert max(contrast(each, background) for each in seen) >= GRAPHICS, (name, label)
        for axis in plot.axis:
            assert contrast(in_theme(axis.axis_line_color, theme), background) >= GRAPHICS, name
            around = in_theme(plot.border_fill_color, theme)
            for text in (axis.major_label_text_color, axis.axis_label_text_color, plot.title.text_color):
                assert contrast(in_theme(text, theme), around) >= TEXT, name
        for legend in plot.legend:
            assert contrast(in_theme(legend.label_text_color, theme), background) >= TEXT, name


def test_every_colour_of_the_figures_has_a_counterpart_in_the_dark():
    assert len(set(DARK.values())) == len(DARK)  # so that the way back is known
    assert {"#FFFFFF", "#22303C"} <= DARK.keys()


PERIODS = [colour for _, colour in cell_classes.PERIODS]
CELLS = {
    "periods": [*cell_classes.SPECIAL[1:], *PERIODS],
    "graded": [*cell_classes.SPECIAL[1:], *(colour for _, colour in cell_classes.COLOURINGS["contact"].classes)],
    "basins": [*cell_classes.SPECIAL[1:], *basin.COLOURS, basin.FURTHER],
    "paper": KINDS,
}


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("cells", CELLS)
def test_classes_of_cells_are_told_apart_by_colour_blind_readers_too(cells, theme):
    for pair in itertools.combinations(CELLS[cells], 2):
        for seen in SEEN:
            found = distance(*(in_theme(each, theme) for each in pair), seen)
            assert found >= LEAST_OF_CELLS, (*pair, seen, found)


def test_stretches_of_the_strip_differ_in_colour_or_pattern_for_colour_blind_readers_too():
    for (one, a, pattern), (other, b, hatch) in itertools.combinations(strip_key(), 2):
        for seen in SEEN if pattern == hatch else ():  # these colours are the same in both themes
            assert distance(one, other, seen) >= LEAST_OF_CELLS, (a, b, seen)


def test_a_picture_without_a_class_of_its_key_says_what_its_colours_show():
    blown_up = np.full((8, 8), cell_classes.DIVERGED, np.uint8)
    assert cell_classes.most_frequent(blown_up, "period") == "period"
    blown_up[0, :4] = cell_classes.PALETTE.index(cell_classes.COLOURINGS["period"].classes[1][1])
    second = cell_classes.COLOURINGS["period"].classes[1][0]
    blown_up[1] = cell_classes.UNKNOWN
    assert cell_classes.most_frequent(blown_up, "period") == f"period {second} in 7.1 % of the cells"
