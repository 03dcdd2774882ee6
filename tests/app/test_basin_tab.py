"""Basins without a browser: colours, shares and words against the engine, what asks anew, what a click does."""

from itertools import pairwise

import numpy as np
import pytest
from bokeh.events import Tap
from vibroscope.app.explorer.state import SOLVERS, Setting
from vibroscope.app.page.bifurcation.tab import Bifurcation
from vibroscope.app.page.study.basin import Basins, statements
from vibroscope.app.page.tab import Move
from vibroscope.app.studies import basin
from vibroscope.app.studies.basin import BasinQuestion, grow_basin
from vibroscope.engine import (
    BasinStudy,
    Cancelled,
    ExactPenalty,
    Reference,
    System,
    basin_difference,
    sweep,
)

from tests.app.fakes import Asked, FakeHost
from tests.app.test_study_tab import opened  # noqa: F401 - a fixture

QUESTION = BasinQuestion(
    System(), 3.2, Reference(), ExactPenalty(12000.0, 18.0), ("xi2", "v2"), (-8.0, 8.0), (-8.0, 8.0), (0.0,) * 4
)
SETTING = Setting(eta=3.2, K=12000.0, D=18.0)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """All partial results of few cells, none of them from an earlier run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
        patch.setattr(basin, "COUNT", 20)
        yield list(grow_basin(QUESTION, None, lambda: False))


def test_both_basins_are_those_of_the_engine(small):
    result = small[-1]
    x, y = QUESTION.axis("x"), QUESTION.axis("y")
    found = {
        side: sweep(BasinStudy.over(System(), QUESTION.method(side), 3.2, {"xi2": x, "v2": y})) for side in SOLVERS
    }
    for side, each in found.items():
        np.testing.assert_array_equal(result.concluded[side]["motion"], each["motion"])
        np.testing.assert_array_equal(result.columns(side)["periods"], each["periods"].values.T.ravel())
    assert result.difference.share == basin_difference(*found.values()).share
    assert [each.name for each in result.motions] == ["motion 1 (period 6)", "motion 2 (period 2)"]
    assert set(result.motions[0].shares) == {"reference"}
    assert result.motions[1].shares["penalty"] == 1


def test_a_motion_has_one_colour_on_both_sides(small):
    images = {side: small[-1].image(side) for side in SOLVERS}
    assert set(np.unique(images["reference"])) == {2, 3, 4}
    assert set(np.unique(images["penalty"])) == {4}
    overlap = np.tile(QUESTION.axis("x") < 0, (20, 1))
    np.testing.assert_array_equal(images["reference"] == 2, overlap)  # the bodies would overlap
    periods = small[-1].periods("reference")
    np.testing.assert_array_equal(periods, np.choose(images["reference"] - 2, (0, 6, 2)))


def test_the_pictures_grow_and_go_on_to_the_very_same(small):
    assert len(small) > 2
    assert all(before.share < after.share for before, after in pairwise(small))
    assert all((each.shown(side) != -1).any() for each in small for side in SOLVERS)
    *_, resumed = grow_basin(QUESTION, small[0], lambda: False)
    for side in SOLVERS:
        np.testing.assert_array_equal(resumed.cells[side], small[-1].cells[side])


def test_it_stops_when_it_is_cancelled():
    with pytest.raises(Cancelled):
        list(grow_basin(QUESTION._replace(eta=3.21), None, lambda: True))


def test_words_say_where_both_differ_and_what_the_start_leads_to(small):
    result = small[-1]
    lines = dict(statements(SETTING._replace(start_xi2=3.0, start_v2=2.0, zero_start="zero"), result))
    share, error = 100 * result.difference.share, 100 * result.difference.error
    assert lines["Different motions"].startswith(f"From {share:.1f} ± {error:.1f} % of the starts")
    assert "motion 2 (period 2) from 100 % of the starts" in lines["Penalty model"]
    (head,) = (head for head in lines if head.startswith("Cell of the start"))
    row, column = result.cell(3.0, 2.0)
    assert lines[head].startswith(
        "The reference leads to period 6" if result.cells["reference"][row, column] == 0 else "Both lead to the same"
    )
    outside = dict(statements(SETTING._replace(start_xi2=30.0), result))
    assert not any(head.startswith("Cell") for head in outside)
    assert "Different motions so far" in dict(statements(SETTING, small[0]))


def test_a_click_starts_explore_there(opened):  # noqa: F811
    tab, host = opened(Basins)
    tab.on_tap(Tap(None, x=1.23456, y=-2.0))
    expected = {"zero_start": "zero", "start_xi1": "0", "start_v1": "0", "start_xi2": "1.235", "start_v2": "-2"}
    assert host.visits == [("explore", expected, None)]


def test_the_start_counts_where_it_is_not_on_an_axis(opened):  # noqa: F811
    tab, _ = opened(Basins)
    tab.show(Move(2, Setting(start_v2=4.0)))
    assert len(Asked.all) == 1
    tab.show(Move(3, Setting(start_v1=4.0)))
    assert Asked.all[-1].question.start == (0, 4, 0, 0)
    tab.panel.receive({"choose": {"plane": "v1-v2"}})
    assert Asked.all[-1].question.axes == ("v1", "v2")
    assert Asked.all[-1].question.start == (0, 0, 0, 0)


def test_at_a_wall_the_starts_are_those_of_body_1(opened):  # noqa: F811
    tab, _ = opened(Basins)
    tab.show(Move(2, Setting(bodies="wall", clearance=1.0)))
    assert tab.panel.chosen["plane"] == "xi1-v1"  # as the list shows
    assert tab.view_texts()["choice"] == "plane:xi1-v1"
    assert Asked.all[-1].question.axes == ("xi1", "v1")
    assert tab.panel.away == {"plane": ["xi2-v2", "v1-v2", "xi1-xi2", "phase-xi2", "phase-v2"]}


@pytest.mark.parametrize(("kind", "switch"), [(Basins, "plane"), (Bifurcation, "coordinate")])
def test_a_wall_that_nothing_drives_is_offered_no_choices_of_body_2(opened, kind, switch):  # noqa: F811
    """There is no study to draw, but the switches stand there."""
    tab, _ = opened(kind)
    free = Setting(bodies="wall", clearance=1.0, base=0.0, start_v1=1.0)
    assert tab.obstacle(free)
    tab.show(Move(2, free))
    assert tab.panel.away[switch]


def test_the_penalty_model_is_without_a_step_or_as_it_is_set(opened):  # noqa: F811
    tab, host = opened(Basins)
    assert Asked.all[-1].question.penalty == Setting().penalty.limit
    tab.panel.receive({"choose": {"model": "set"}})
    assert Asked.all[-1].question.penalty == Setting().penalty
    assert host.errors == []


def test_a_contact_law_stands_in_the_commands(opened):  # noqa: F811
    tab, _ = opened(Basins)
    setting = Setting(K=1000.0, D=5.0, law="cut")
    tab.show(Move(2, setting))
    assert "--solver exact --K 1000 --D 5 --law cut" in tab.command(setting)
    assert Asked.all[-1].question.count == basin.SLOW_COUNT  # whose cells are run one by one


def test_nothing_is_computed_before_the_tab_is_shown(monkeypatch):
    Asked.all = ()
    monkeypatch.setattr("vibroscope.app.page.asker.StudyJob", Asked)
    tab = Basins(FakeHost())
    tab.build()
    assert Asked.all == ()


def test_a_plane_may_be_of_the_start_phase_and_a_number(opened):  # noqa: F811
    tab, host = opened(Basins)
    tab.show(Move(2, Setting(start_v1=4.0, base_phase=6.0)))
    tab.panel.receive({"choose": {"plane": "phase-v2"}})
    asked = Asked.all[-1].question
    assert (asked.axes, asked.x, asked.start) == (("phase", "v2"), (0.0, 1.0), (0, 4, 0, 0))
    assert tab.view.ranges["start_x"].ends == (0.0, 1.0)
    assert asked.y == tab.view.ranges["start_y"].ends != (0.0, 1.0)
    tab.on_tap(Tap(None, x=0.25, y=-2.0))
    _, texts, _ = host.visits.pop()
    assert float(texts["base_phase"]) == pytest.approx(6.0 + np.pi / 2 - 2 * np.pi)
    assert (texts["start_v1"], texts["start_v2"]) == ("4", "-2")
    tab.panel.receive({"choose": {"model": "set"}})
    assert "another phase need a solver in closed form" in tab.obstacle(Setting())
