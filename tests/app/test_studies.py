"""The three studies of the page against single runs, and what their figures are made of."""

import math

import numpy as np
import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.plane.tab import told as told_of_plane
from vibroscope.app.studies import bifurcation, plane
from vibroscope.app.studies import cell_classes as classes
from vibroscope.app.studies import time_step as timestep
from vibroscope.app.studies.bifurcation import Diagram, refine_diagram
from vibroscope.app.studies.plane import Plane, refine_plane
from vibroscope.app.studies.time_step import TimeStep, refine_step
from vibroscope.engine import Cancelled, ExactPenalty, Newmark, Reference, System, motion, simulate

SYSTEM = System()


def never():
    return False


def last(stages):
    return list(stages)[-1]


# -- the plane ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def small_plane():
    """The whole plane in few cells."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plane, "COUNT", 12)
        patch.setattr(plane, "TRANSIENT", 150)
        yield list(refine_plane(Plane(SYSTEM, 2.76, 300, False, True, (10.0, 1e5), (0.1, 100.0)), None, never))


def test_both_planes_are_what_single_runs_give(small_plane):
    stage = small_plane[-1]
    assert stage.share == 1
    for row, column in ((0, 0), (11, 11), (9, 8), (5, 2)):
        K, D = stage.question.axis("K")[column], stage.question.axis("D")[row]
        for side, method in (("penalty", Newmark(K, D, 300)), ("exact", ExactPenalty(K, D))):
            run = simulate(SYSTEM, 2.76, method, periods=200, keep=50)
            if not run.ok:
                assert stage.diverged(side)[row, column]
                continue
            found = motion(run)
            assert stage.shown(side, "period")[row, column] == found.period
            assert stage.shown(side, "impacts_per_period")[row, column] == pytest.approx(found.impacts_per_period)


def test_a_plane_that_was_stopped_goes_on_to_the_very_same(small_plane, monkeypatch):
    monkeypatch.setattr(plane, "COUNT", 12)
    monkeypatch.setattr(plane, "TRANSIENT", 150)
    first = small_plane[0]
    assert 0 < first.share < 1
    resumed = last(refine_plane(first.question, first, never))
    for side in plane.SIDES:
        for name, table in small_plane[-1].tables[side].items():
            np.testing.assert_array_equal(resumed.tables[side][name], table)


def test_what_is_not_known_yet_is_shown_coarsely(small_plane):
    stage = small_plane[0]
    assert stage.known[0, 0]
    assert stage.known[8, 8]
    assert not stage.known[1, 1]
    shown = stage.shown("exact", "period")
    assert shown[1, 1] == shown[0, 0] == stage.tables["exact"]["period"][0, 0]


def test_the_cell_of_a_setting_holds_it(small_plane):
    stage = small_plane[-1]
    row, column = stage.cell(12000, 18)
    for value, middle, span in (
        (12000, stage.question.axis("K")[column], 1e4),
        (18, stage.question.axis("D")[row], 1e3),
    ):
        assert abs(math.log(middle / value)) <= 0.5 * math.log(span) / 12 * 1.001
    assert stage.question.axis("K")[0] * stage.question.axis("K")[-1] == pytest.approx(10 * 1e5)  # edge to edge
    assert stage.cell(10, 0.1) == (0, 0)
    assert stage.cell(1e5, 100) == (11, 11)
    assert stage.cell(9.9, 18) is None


def test_a_plane_says_which_cell_its_numbers_are_of_and_that_shares_are_so_far(small_plane, monkeypatch):
    monkeypatch.setattr(plane, "COUNT", 12)
    setting = Setting(K=12000.0, D=18.0)
    first, whole = small_plane[0], small_plane[-1]
    for stage, place in ((first, (8, 8)), (whole, whole.cell(12000, 18))):
        centre = stage.question.axis("K")[place[1]], stage.question.axis("D")[place[0]]
        assert stage.centre(whole.cell(12000, 18)) == centre
        heads = [head for head, _ in told_of_plane(setting, stage)]
        assert heads[0].startswith("Newmark, cell at K ≈ ")
        for number, value in zip(heads[0].split(" ≈ ")[1:], centre, strict=True):
            assert float(number.split(",")[0]) == pytest.approx(value, rel=5e-3)
    assert told_of_plane(setting, first)[-1][0] == "The whole plane so far"
    assert told_of_plane(setting, whole)[-1][0] == "The whole plane"


@pytest.mark.parametrize("name", classes.QUANTITIES)
def test_every_cell_has_the_colour_of_its_number(small_plane, name):
    stage, quantity = small_plane[-1], classes.QUANTITIES[name]
    for side in plane.SIDES:
        picture = classes.picture(stage, side, name)
        assert picture.dtype == np.uint8
        assert picture.max() < len(classes.PALETTE)
        assert ((picture == classes.DIVERGED) == stage.diverged(side)).all()
        values = quantity.read(stage, side)
        for i in np.flatnonzero(np.isfinite(values) & ~stage.diverged(side))[::7]:
            index = sum(values.ravel()[i] >= edge for edge in quantity.edges)
            assert classes.PALETTE[picture.ravel()[i]] == quantity.classes[index][1]


def test_the_planes_of_the_paper_differ_by_the_time_step(small_plane):
    stage = small_plane[-1]
    once = {side: (stage.shown(side, "period") == 1).mean() for side in plane.SIDES}
    assert once["exact"] > 2 * once["penalty"]


def test_a_movable_limit_of_steps_marks_the_sudden_impacts(small_plane):
    stage = small_plane[-1]
    steps = stage.contact_steps("penalty")
    few, many = (classes.sudden(stage, "penalty", limit) for limit in (2, 30))
    assert few.sum() < many.sum()
    assert (many == ((steps > 0) & (steps < 30) & ~stage.diverged("penalty"))).all()


def test_cells_that_blow_up_are_marked(monkeypatch):
    monkeypatch.setattr(plane, "COUNT", 8)
    monkeypatch.setattr(plane, "TRANSIENT", 50)
    stage = last(refine_plane(Plane(SYSTEM, 2.76, 100, False, False, (1e4, 1e5), (0.1, 100.0)), None, never))
    row, column = np.argwhere(classes.picture(stage, "exact", "period") != classes.DIVERGED)[0]
    assert np.isfinite(stage.shown("exact", "period")[row, column])
    stage.tables["exact"]["status"][row, column] = plane._DIVERGED
    assert classes.picture(stage, "exact", "period")[row, column] == classes.DIVERGED


def test_a_plane_that_is_cancelled_stops():
    question = Plane(SYSTEM, 2.76, 2000, False, False, (10.0, 1e5), (0.1, 100.0))
    with pytest.raises(Cancelled):
        last(refine_plane(question, None, lambda: True))


# -- the diagram -------------------------------------------------------------------------------------------------------


@pytest.fixture
def small_diagram(monkeypatch):
    """A function from a direction to the last stage of a short diagram, over where motions change."""
    monkeypatch.setattr(bifurcation, "COUNT", 17)
    monkeypatch.setattr(bifurcation, "TRANSIENT", 60)
    monkeypatch.setattr(bifurcation, "SAMPLE", 12)
    return lambda direction: last(refine_diagram(Diagram(SYSTEM, Reference(), direction, (2.7, 2.9)), None, never))


def test_from_rest_each_value_is_a_run_of_its_own(small_diagram):
    stage = small_diagram("rest")
    for i in (0, 7, 16):
        run = simulate(SYSTEM, stage.question.axis[i], Reference(), periods=72, keep=12)
        np.testing.assert_allclose(stage.section[i], run.section, atol=1e-8)


@pytest.mark.parametrize("direction", ["up", "down"])
def test_continued_each_value_starts_where_its_neighbour_ended(small_diagram, direction):
    stage = small_diagram(direction)
    start = (0.0, 0.0, 0.0, 0.0)
    for i in np.arange(17)[:: 1 if direction == "up" else -1]:
        run = simulate(SYSTEM, stage.question.axis[i], Reference(), periods=72, keep=12, initial=start)
        np.testing.assert_allclose(stage.section[i, :3], run.section[:3], atol=1e-6)
        start = stage.section[i, -1]


def test_points_of_one_motion_are_sent_once_and_never_too_many(small_diagram):
    stage = small_diagram("rest")
    eta, values = stage.points("xi2")
    once = np.flatnonzero(stage.period == 1)
    assert len(once) > 3
    for i in once[:3]:
        assert (eta == stage.question.axis[i]).sum() == 1
    assert set(values) <= set(stage.section[:, :, 2].ravel())
    fewer, _ = stage.points("xi2", 40)
    assert len(fewer) <= 40
    assert set(fewer) == set(eta)  # none is left out


def test_stretches_of_one_period_cover_the_range_without_gaps(small_diagram):
    stage = small_diagram("rest")
    left, right, period = stage.stretches()
    assert left[0] == 2.7
    assert right[-1] == 2.9
    assert (left[1:] == right[:-1]).all()
    assert (period[1:] != period[:-1]).all()
    assert set(period) == set(stage.period)


# -- the time step -----------------------------------------------------------------------------------------------------


def test_the_located_step_is_of_second_order_and_the_fixed_one_is_not(monkeypatch):
    monkeypatch.setattr(timestep, "STEPS", (100, 200, 400, 800))
    monkeypatch.setattr(timestep, "_STAGES", (2, 4))
    monkeypatch.setattr(timestep, "TRANSIENT", 200)
    stages = list(refine_step(TimeStep(SYSTEM, 2.76, 12000.0, 18.0), None, never))
    assert [len(stage.steps) for stage in stages] == [2, 4]
    order, error = stages[-1].order("error_time_step", "located")
    assert order == pytest.approx(2.0, abs=max(0.1, 3 * error))
    assert stages[-1].order("error_time_step", "fixed")[0] < 1.5
    assert stages[-1].nearest(390) == 2
