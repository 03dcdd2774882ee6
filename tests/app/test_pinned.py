"""Pinned settings are computed once, one after the other, drawn like the present one; errors are shown; a table."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.explanation import explain
from vibroscope.app.explorer.link import MOST_PINS, print_address, read_pins
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Series
from vibroscope.app.export.tables import table_in_units
from vibroscope.app.page.explore import comparison
from vibroscope.app.page.explore.comparison import PinComparison, PinnedResults
from vibroscope.app.page.explore.result import prepare
from vibroscope.app.page.shared.figure import PINS
from vibroscope.engine import percent

from tests.app.fakes import FakeHost

SETTING = Setting()
PINNED = SETTING._replace(K=3000.0)
OTHER = SETTING._replace(K=100.0, D=50.0)


class Jobs(list):
    """Stands for the worker threads: keeps what is asked, and a test delivers."""

    def __call__(self, setting, deliver):
        job = SimpleNamespace(question=setting, cancelled=False, deliver=deliver)
        job.cancel = lambda: setattr(job, "cancelled", True)
        self.append(job)
        return job

    @property
    def asked(self):
        return [job.question for job in self]

    def answer(self, found, number=-1):
        self[number].deliver(self[number], found)


class Case:
    """Pinned results, their jobs, and how often they have been drawn."""

    put = None  # replaces a function of the module

    def __init__(self, *pinned, cached=lambda _: None):
        self.host, self.drawn, self.jobs, self.explained = FakeHost(pinned), 0, Jobs(), Jobs()
        for name, stands in (("begin_runs", self.jobs), ("begin_explanation", self.explained), ("cached_runs", cached)):
            self.put(comparison, name, stands)
        self.pinned = PinnedResults(self.host, self.draw)

    def draw(self):
        self.drawn += 1

    @property
    def there(self):
        return [result is not None for _, result in self.pinned.results]


@pytest.fixture(autouse=True)
def patched(monkeypatch):
    """A case stands in for the computations."""
    monkeypatch.setattr(Case, "put", staticmethod(monkeypatch.setattr))


def test_pinned_settings_are_computed_once_and_one_after_the_other():
    case = Case(PINNED, OTHER)
    for eta in (1.1, 1.2, 1.3):
        case.pinned.follow(SETTING._replace(eta=eta))
    assert case.jobs.asked == [PINNED]
    case.jobs.answer(prepare(compute_runs(PINNED)))
    assert case.there == [True, False]
    assert case.jobs.asked == [PINNED, OTHER]
    case.jobs.answer(prepare(compute_runs(OTHER)))
    case.pinned.follow(SETTING)
    assert case.there == [True, True]
    assert len(case.jobs.asked) == 2
    case.pinned.follow(SETTING._replace(frame="absolute"))
    assert case.jobs.asked[2:] == [PINNED._replace(frame="absolute")]


def test_a_result_that_comes_after_it_was_unpinned_is_dropped_and_the_next_is_computed():
    case = Case(PINNED, OTHER)
    case.pinned.follow(SETTING)
    case.host.pinned = (OTHER,)
    case.pinned.follow(SETTING)
    case.jobs.answer(prepare(compute_runs(PINNED)), 0)
    assert case.there == [False]
    assert case.jobs.asked == [PINNED, OTHER]
    case.host.pinned = ()
    case.pinned.follow(SETTING)
    case.jobs.answer(ValueError("late"))
    assert case.host.errors == []
    assert case.pinned.results == []


def test_a_failure_is_shown_and_not_tried_again():
    case = Case(PINNED)
    case.pinned.follow(SETTING)
    case.jobs.answer(ValueError("out of memory"))
    case.pinned.follow(SETTING._replace(eta=2.0))
    assert case.there == [False]
    assert len(case.jobs.asked) == 1
    assert "out of memory" in case.host.errors[0]


def test_computations_end_with_the_page():
    case = Case(PINNED)
    case.pinned.follow(SETTING)
    case.jobs.answer(prepare(compute_runs(PINNED)))
    case.host.pinned = (PINNED, OTHER)
    case.pinned.follow(SETTING)
    case.pinned.drop()
    assert [job.cancelled for job in (case.jobs[-1], case.explained[-1])] == [True, True]


def test_a_cached_result_is_drawn_at_once():
    case = Case(PINNED, cached=compute_runs)
    case.pinned.follow(SETTING)
    assert case.jobs.asked == []
    assert case.there == [True]
    assert case.drawn == 1


def test_without_a_pin_nothing_is_drawn():
    case = Case()
    case.pinned.follow(SETTING)
    assert case.drawn == 0


def test_a_reference_that_is_the_live_one_is_not_drawn_again():
    case = Case(PINNED, cached=compute_runs)
    case.pinned.follow(SETTING)
    (same,), (other,) = (case.pinned.columns(live) for live in (SETTING, SETTING._replace(eta=2.0)))
    for columns, drawn in ((same, False), (other, True)):
        assert math.isfinite(columns["phase_reference"]["x1"][0]) == drawn
        assert math.isfinite(columns["displacements"]["reference1"][0]) == drawn
        assert math.isfinite(columns["displacements"]["penalty1"][0])


def test_the_table_has_the_numbers_of_the_explanation():
    runs, pinned = compute_runs(SETTING), OTHER._replace(restitution=0.6)
    found = explain(runs)
    table = PinComparison()
    assert not table.visible
    table.show(prepare(runs), found, [(pinned, None)])
    live, pin = table.rows
    assert (live["errors"], live["headline"]) == (found.parts, found.headline)
    assert live["shown"]["total"] == percent(found.parts["total"])
    assert live["motion"] == prepare(runs).description.lines(found)["penalty"]
    assert (pin["explained"], pin["texts"]["K"], pin["other"]) == (False, "100", "e = 0.6")
    assert table.table["error total"][0] == found.parts["total"]
    assert math.isnan(table.table["error total"][1])
    assert list(table.parts) == list(found.parts)
    derived = compute_runs(SETTING._replace(joint_damping="derived"))
    table.show(prepare(derived), explain(derived), [(pinned, None)])
    assert "joint_damping" not in table.parts  # no row has this part: no empty column
    assert "error joint_damping" not in table.table
    table.show(prepare(runs), found, [(pinned, None)])
    physical = compute_runs(SETTING._replace(units="si", omega1=10.0, m1=2.0))
    table.show(prepare(physical), found, [(pinned.drawn_like(physical.setting), None)])
    assert table.rows[1]["numbers"][1] == ["K", "penalty stiffness, N/m", "20000"]
    assert table.rows[0]["numbers"][0][:2] == ["f", "excitation frequency, Hz"]
    (series,) = table_in_units([Series("compared", table.table)], physical.setting.scale)
    np.testing.assert_allclose(series.columns["K [N/m]"], [200 * float(row["texts"]["K"]) for row in table.rows])
    table.show(prepare(runs), found, [])
    assert not table.visible


def test_a_link_holds_the_pins_and_their_number_is_bounded():
    pins = tuple(SETTING._replace(K=100.0 * k) for k in range(1, MOST_PINS + 1))
    assert len(PINS) == MOST_PINS  # each has a colour
    assert read_pins(";".join(map(print_address, pins))) == pins
    assert read_pins(print_address(PINNED)) == (PINNED,)  # a link from when there was one pin
    for text, word in ((";".join(["K=99"] * (MOST_PINS + 1)), "At most 4"), ("K=99;", "empty"), ("K=99;K=²", "K must")):
        with pytest.raises(Refused, match=word):
            read_pins(text)
