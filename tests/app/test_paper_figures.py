"""The figures of the tab Paper: an entry of a legend hides all that it names, and nothing else is left."""

import numpy as np
import pytest
from bokeh.models import GlyphRenderer
from vibroscope.app.page.paper.figures import draw
from vibroscope.app.paper.pictures import CellMap, PhasePlots, TimeHistory
from vibroscope.engine import Newmark, Record, Reference, System, simulate

NAMES = ("bifurcated", "in between", "one period")


def run(method):
    return simulate(System(), 2.76, method, periods=20, keep=2, record=Record(2, 50))


PICTURES = {
    "one solution": lambda: PhasePlots({"reference": run(Reference())}),
    "two solutions": lambda: PhasePlots({"reference": run(Reference()), "penalty": run(Newmark(12000, 18, 2000))}),
    "impacts": lambda: TimeHistory(run(Reference())),
    "contacts": lambda: TimeHistory(run(Newmark(12000, 18, 2000))),
    "cells": lambda: CellMap(
        np.geomspace(1, 8, 4), np.geomspace(1, 4, 3), np.arange(12).reshape(3, 4) % 3, NAMES, (2, 2)
    ),
}


@pytest.mark.parametrize("picture", PICTURES)
def test_each_entry_hides_what_it_names_and_all_of_them_hide_the_whole_picture(picture):
    plot = draw(PICTURES[picture](), "paper")
    shown = {each for each in plot.renderers if isinstance(each, GlyphRenderer)}
    for item in plot.legend[0].items:
        named = set(item.renderers)
        assert any(has_data(each) for each in named), item.label.value
        assert named <= shown
        shown -= named
    assert shown == set()


def has_data(renderer):
    glyph, data = renderer.glyph, renderer.data_source.data
    if hasattr(glyph, "image"):
        return bool(np.any(data["image"][0] > 0))
    return bool(np.isfinite(np.asarray(data["x" if "x" in data else "left"], dtype=float)).any())
