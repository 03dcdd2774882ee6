"""Studies in physical units: the hover of the bifurcation diagram and the data to take away."""

import numpy as np
import pytest
from vibroscope.app.page.tab import Move

from tests.app.filled_tabs import SETTING, filled  # noqa: F401 - a fixture


def test_hover_and_data_of_a_diagram_follow_the_units(filled):  # noqa: F811
    tab = filled("bifurcation")
    physical = SETTING._replace(units="mm-t-s", omega1=20.0, amplitude=2.0)
    plain, source = tab.data(), tab.view.points["penalty"]
    source = source if len(source.data["eta"]) else tab.view.points["reference"]
    assert "shown_eta" not in source.data
    assert tab.view.hover.tooltips[0][1] == "@eta"
    tab.show(Move(2, physical))
    assert tab.view.hover.tooltips[:2] == [
        ("frequency f / Hz, base displacement 2 mm held", "@shown_eta{%.4g}"),
        ("displacement x₂ once a period / mm", "@shown_value{%.4g}"),
    ]
    np.testing.assert_allclose(source.data["shown_eta"], source.data["eta"] * 20 / (2 * np.pi), rtol=1e-6)
    np.testing.assert_allclose(source.data["shown_value"], 2 * source.data["value"], rtol=1e-6)
    data = tab.data()
    assert data["f [Hz]"] == pytest.approx(plain["eta"] * 20 / (2 * np.pi))
    assert data["x2 [mm]"] == pytest.approx(2 * plain["xi2"], nan_ok=True)
    tab.show(Move(3, SETTING))
    assert "shown_eta" not in source.data
    assert tab.data().keys() == plain.keys()
    tab.hide()
