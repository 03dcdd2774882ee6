"""What is seen in each figure stands in its title, in the units that are shown, and in the captions of its files."""

import numpy as np
import panel as pn
import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.shared.figure import make_figure
from vibroscope.app.page.shared.seen import amplitude, apart, of_both, say
from vibroscope.app.page.tabs import VIEWS

from tests.app.filled_tabs import filled  # noqa: F401 - the fixture

TABS = [key for key in VIEWS if key not in ("help", "paper")]  # figures of the paper are drawn one after the other
IN_UNITS = Setting(omega1=10.0, m1=2.0, amplitude=3.0, units="si")


def figures_of(tab):
    """The figures of a tab in which anything is drawn."""
    plots = [pane.object for pane in tab.page.select(pn.pane.Bokeh)]
    return {plot.name: plot for plot in plots if plot.visible and any(map(_is_drawn, plot.renderers))}


def _is_drawn(renderer):
    return any(np.size(column) for column in renderer.data_source.data.values())


@pytest.mark.parametrize("key", TABS)
def test_every_figure_says_what_is_seen_in_it(filled, key):  # noqa: F811
    titles = {name: plot.title.text for name, plot in figures_of(filled(key)).items()}
    assert titles
    assert all(": " in title for title in titles.values()), titles
    assert not any(word in title for title in titles.values() for word in ("nan", "None")), titles


def test_numbers_are_those_that_are_drawn_in_their_unit():
    x = np.array([-0.012, 0.006, np.nan])
    plot = make_figure("", "", "")
    say(plot, "Phase plot", of_both("amplitude", [amplitude(x), amplitude(2 * x)], "displacement", IN_UNITS), IN_UNITS)
    assert plot.title.text == "Phase plot: amplitude 0.009, penalty 0.018 m"
    say(plot, "Phase plot", of_both("amplitude", [amplitude(x), None], "displacement", IN_UNITS), IN_UNITS)
    assert plot.title.text == "Phase plot: amplitude 0.009 m (reference)"
    assert apart([x, 0.5 * x], Setting()) == "up to 0.012 apart"
    say(plot, "Displacements", apart([x * np.nan], Setting()), Setting())
    assert plot.title.text == "Displacements: one solution ended early"
