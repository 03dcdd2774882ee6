"""Axes in units: a second range that follows the first one, and files with their units in the names of the columns."""

import numpy as np
import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Series
from vibroscope.app.export.tables import table_in_units
from vibroscope.app.page.bifurcation.figure import BifurcationView
from vibroscope.app.page.shared.figure import make_figure
from vibroscope.app.page.shared.ranges import OwnedRange, UnitAxis
from vibroscope.app.page.study.plane import PlaneView
from vibroscope.app.page.study.time_step import TimeStepView
from vibroscope.engine import Units

UNITS = {"units": "mm-t-s", "omega1": 20.0, "m1": 3.0, "amplitude": 2.5}
PLAIN, PHYSICAL = Setting(), Setting(**UNITS)


def ends(axis):
    return axis.range.start, axis.range.end, axis.range.reset_start, axis.range.reset_end


def test_the_second_range_follows_what_the_page_does():
    owned = OwnedRange(1, 2)
    plot = make_figure("", "", "", name="one", x_range=owned.range)
    axis = UnitAxis(owned, "x", plot)
    axis.show("f / Hz", 10.0)
    assert ends(axis) == (10, 20, 10, 20)
    owned.put(3, 5)
    assert ends(axis) == (30, 50, 30, 50)
    owned.range.update(start=3.5, end=4)  # by the user: the browser zooms both
    owned.put(0, 8)
    assert ends(axis) == (35, 40, 0, 80)
    assert (plot.xaxis[0].x_range_name, plot.xgrid[0].x_range_name) == ("units", "units")
    owned.unzoom()
    axis.show("η", 1.0)
    assert ends(axis) == (0, 8, 0, 8)
    assert plot.xaxis[0].x_range_name == "default"


@pytest.mark.parametrize(
    ("make", "draw", "expected"),
    [
        (
            BifurcationView,
            lambda view, setting: view.update(setting, None, "xi2", None),
            ["frequency f / Hz, base displacement 2.5 mm held", "displacement x₂ once a period / mm"],
        ),
        (
            PlaneView,
            lambda view, setting: view.update(setting, None, "period", None, float("nan")),
            ["contact stiffness K / (N/mm)", "contact damper 2D / (N·s/mm)"],
        ),
        (
            TimeStepView,
            lambda view, setting: view.update(setting, None),
            ["displacement x₂ / mm", "velocity x₂′ / (mm/s)"],
        ),
    ],
)
def test_the_axes_of_studies_are_in_the_units_that_are_shown(make, draw, expected):
    view = make()
    plot = next(iter(view.figures.values()))
    for setting, labels in ((PLAIN, None), (PHYSICAL, expected), (PLAIN, None)):
        draw(view, setting)
        found = [plot.xaxis[0].axis_label, plot.yaxis[0].axis_label]
        assert found == expected if labels else not set(found) & set(expected)
        names = {plot.xaxis[0].x_range_name, plot.yaxis[0].y_range_name}
        assert names == {"units" if labels else "default"}


def test_tables_of_studies_name_their_units():
    columns = {
        "eta": np.array([2.0]),
        "xi2": np.array([3.0]),
        "K": np.array([10.0]),
        "D": np.array([1.0]),
        "period": [1],
    }
    (found,) = table_in_units([Series("a", columns)], Units(20.0, 3.0, 2.5, "mm-t-s"))
    assert {name: column[0] for name, column in found.columns.items()} == pytest.approx(
        {"f [Hz]": 40 / 2 / np.pi, "x2 [mm]": 7.5, "K [N/mm]": 12.0, "2D [N·s/mm]": 0.12, "period": 1}
    )
    assert table_in_units([Series("a", columns)], None)[0].columns is columns
