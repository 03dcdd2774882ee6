"""The view Peaks and spectra: its numbers are those of the engine, in any unit; signs, a wall, a run that ends."""

import math

import numpy as np
import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.study.peaks import Peaks
from vibroscope.app.page.tab import Move
from vibroscope.app.studies.peaks import off_text, sampled
from vibroscope.engine import PEAKS, peaks, spectrum, written

from tests.app.fakes import QueueingHost

SETTING = Setting(eta=2.76, K=12000.0, D=18.0)


@pytest.fixture
def shown():
    """A function from a setting to the view with both runs."""
    tabs = []

    def show(setting):
        tab = Peaks(QueueingHost())
        tab.build()
        tab.show(Move(1, setting))
        tab.host.catch_up_until(lambda: tab.result is not None and tab.result.share == 1)
        tabs.append(tab)
        return tab

    yield show
    for tab in tabs:
        tab.close()


def rows(tab):
    return {
        cells[0]["text"]: [cell["text"] for cell in cells[1:]] for cells in (r["cells"] for r in tab.list.near["rows"])
    }


def runs(setting):
    methods = {"reference": setting.reference, "penalty": setting.penalty}
    return {solver: sampled(setting.system, setting.eta, method, setting.initial) for solver, method in methods.items()}


def test_table_and_files_have_the_numbers_of_the_engine(shown):
    tab, found = shown(SETTING), runs(SETTING)
    table = {series.label: series.columns for series in tab.table("peaks")}
    for solver, run in found.items():
        wanted = peaks(run)
        np.testing.assert_equal({name: column[0] for name, column in table[solver].items()}, wanted)
        lines = spectrum(run)
        for name in ("spectrum_motion", "spectrum_force"):
            (series,) = (each for each in tab.table(name) if each.label == solver)
            np.testing.assert_array_equal(series.columns["order"], lines.order)
        np.testing.assert_array_equal(series.columns["contact_force"], lines.force)
    assert len(rows(tab)) == len(PEAKS)
    speed = [peaks(run)["closing_speed"] for run in found.values()]
    assert rows(tab)["closing speed / (Aω₁)"][:2] == [written(value) for value in speed]


def test_units_are_those_that_are_shown_and_the_difference_has_none(shown):
    setting = SETTING._replace(units="mm-t-s", omega1=10.0, m1=2.0)
    plain, units = shown(SETTING), shown(setting)
    factor = setting.scale.factor("velocity")
    first, second = rows(plain)["closing speed / (Aω₁)"], rows(units)["closing speed / (mm/s)"]
    assert float(second[0]) == pytest.approx(factor * float(first[0]), rel=1e-3)
    assert second[2] == first[2]
    assert "contact_force [N]" in units.table("spectrum_force")[0].columns


def test_a_wall_has_no_row_and_no_column(shown):
    tab = shown(SETTING._replace(bodies="wall"))
    assert not [name for name in rows(tab) if "body" in name]
    assert not [name for name in tab.table("spectrum_motion")[0].columns if name.endswith("2")]
    assert tab.away(tab.shown_setting()) == {"quantity": ["displacement2", "acceleration2"]}


def test_a_run_that_ends_early_says_why_and_the_other_keeps_its_numbers(shown):
    tab = shown(SETTING._replace(D=0.0, steps=200, integrator="newmark", beta=0.0))
    reference, penalty, off = rows(tab)["closing speed / (Aω₁)"]
    assert float(reference) > 0
    assert (penalty, off) == ("–", "–")
    assert "diverged" in tab.words()["Penalty solution"]
    assert [series.label for series in tab.table("spectrum_force")] == ["reference"]


@pytest.mark.parametrize(
    ("reference", "penalty", "text"),
    [
        (2.0, 1.9, "-5 %"),
        (2.0, 2.1, "+5 %"),
        (2.0, 2.0, "0 %"),
        (0.0, 1.0, ""),
        (math.nan, 1.0, ""),
        (1.0, math.nan, ""),
    ],
)
def test_a_difference_has_its_sign(reference, penalty, text):
    assert off_text(reference, penalty) == text
