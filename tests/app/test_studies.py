"""The studies of the page against single runs, and what their figures are made of."""

import functools
import math

import numpy as np
import pytest
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.study.plane import statements
from vibroscope.app.studies import bifurcation, plane, time_step
from vibroscope.app.studies import cell_classes as classes
from vibroscope.app.studies.bifurcation import DiagramQuestion, grow_diagram
from vibroscope.app.studies.plane import PlaneQuestion, grow_plane
from vibroscope.app.studies.time_step import StepQuestion, grow_step
from vibroscope.engine import (
    STATUSES,
    ExactPenalty,
    Newmark,
    Reference,
    Status,
    System,
    motion,
    simulate,
)

from tests.share import every

SYSTEM = System()


@pytest.fixture(scope="module", autouse=True)
def _own_studies(tmp_path_factory):
    """A cache without studies: one that an earlier run of the tests left there would be whole from the beginning."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibroscope.engine.sweeps.cache.cache_root", lambda: folder)
        yield


def never():
    return False


def last(results):
    return list(results)[-1]


# -- the plane ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def small_plane():
    """The whole plane in few cells."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plane, "COUNT", 12)
        patch.setattr(plane, "TRANSIENT", 150)
        yield list(grow_plane(PlaneQuestion(SYSTEM, 2.76, 300, False, True, (10.0, 1e5), (0.1, 100.0)), None, never))


def test_both_planes_are_what_single_runs_give(small_plane):
    result = small_plane[-1]
    assert result.share == 1
    for row, column in ((0, 0), (11, 11), (9, 8), (5, 2)):
        K, D = result.question.axis("K")[column], result.question.axis("D")[row]
        for side, method in (("penalty", Newmark(K, D, 300)), ("exact", ExactPenalty(K, D))):
            run = simulate(SYSTEM, 2.76, method, periods=200, keep=50)
            if not run.ok:
                assert result.diverged(side)[row, column]
                continue
            found = motion(run)
            assert result.shown(side, "period")[row, column] == found.period
            assert result.shown(side, "impacts_per_period")[row, column] == pytest.approx(found.impacts_per_period)


def test_kinds_stand_in_the_files_of_the_penalty_solution_where_they_are_asked_for(small_plane):
    result = small_plane[-1]
    judged = plane.PartialPlane(result.question._replace(judged=True), result.values)
    kinds = [{side: "kind" in each.data()[side] for side in plane.SIDES} for each in (result, judged)]
    assert kinds == [{"penalty": False, "exact": False}, {"penalty": True, "exact": False}]


def test_a_plane_that_was_stopped_goes_on_to_the_very_same(small_plane, monkeypatch):
    monkeypatch.setattr(plane, "COUNT", 12)
    monkeypatch.setattr(plane, "TRANSIENT", 150)
    first = small_plane[0]
    assert 0 < first.share < 1
    resumed = last(grow_plane(first.question, first, never))
    for side in plane.SIDES:
        for name, table in small_plane[-1].tables[side].items():
            np.testing.assert_array_equal(resumed.tables[side][name], table)


def test_a_plane_has_errors_where_a_cell_has_one(small_plane):
    result = small_plane[-1]
    assert result.has_errors
    nowhere = result.values | {"error": np.full_like(result.values["error"], np.nan)}
    assert not plane.PartialPlane(result.question, nowhere).has_errors


def test_what_is_not_known_yet_is_shown_coarsely(small_plane):
    result = small_plane[0]
    assert result.known[0, 0]
    assert result.known[8, 8]
    assert not result.known[1, 1]
    shown = result.shown("exact", "period")
    assert shown[1, 1] == shown[0, 0] == result.tables["exact"]["period"][0, 0]


def test_the_cell_of_a_setting_holds_it(small_plane):
    result = small_plane[-1]
    row, column = result.cell(12000, 18)
    for value, middle, span in (
        (12000, result.question.axis("K")[column], 1e4),
        (18, result.question.axis("D")[row], 1e3),
    ):
        assert abs(math.log(middle / value)) <= 0.5 * math.log(span) / 12 * 1.001
    assert result.question.axis("K")[0] * result.question.axis("K")[-1] == pytest.approx(10 * 1e5)  # edge to edge
    assert result.cell(10, 0.1) == (0, 0)
    assert result.cell(1e5, 100) == (11, 11)
    assert result.cell(9.9, 18) is None


def test_a_plane_says_which_cell_its_numbers_are_of_and_that_shares_are_so_far(small_plane, monkeypatch):
    monkeypatch.setattr(plane, "COUNT", 12)
    setting = Setting(K=12000.0, D=18.0)
    first, whole = small_plane[0], small_plane[-1]
    for result, place in ((first, (8, 8)), (whole, whole.cell(12000, 18))):
        centre = result.question.axis("K")[place[1]], result.question.axis("D")[place[0]]
        assert result.centre(whole.cell(12000, 18)) == centre
        heads = [head for head, _ in statements(setting, result)]
        assert heads[0].startswith("Newmark, cell at K ≈ ")
        for number, value in zip(heads[0].split(" ≈ ")[1:], centre, strict=True):
            assert float(number.split(",")[0]) == pytest.approx(value, rel=5e-3)
    assert statements(setting, first)[-1][0] == "The whole plane so far"
    assert statements(setting, whole)[-1][0] == "The whole plane"


@pytest.mark.parametrize("name", [name for name in classes.COLOURINGS if name != "without_solution"])
def test_every_cell_has_the_colour_of_its_number(small_plane, name):
    result, quantity = small_plane[-1], classes.COLOURINGS[name]
    for side in plane.SIDES:
        picture = classes.class_image(result, side, name)
        assert picture.dtype == np.uint8
        assert picture.max() < len(classes.PALETTE)
        assert ((picture == classes.DIVERGED) == result.diverged(side)).all()
        values = quantity.read(result, side)
        chosen = np.flatnonzero(np.isfinite(values) & ~result.diverged(side))[::7]
        assert len(chosen)
        for i in chosen:
            index = sum(values.ravel()[i] >= edge for edge in quantity.edges)
            assert classes.PALETTE[picture.ravel()[i]] == quantity.classes[index][1]


def test_a_movable_limit_of_steps_marks_the_sudden_impacts(small_plane):
    result = small_plane[-1]
    steps = result.contact_steps("penalty")
    few, many = (classes.sudden_contacts(result, "penalty", limit) for limit in (2, 30))
    assert few.sum() < many.sum()
    assert (many == ((steps > 0) & (steps < 30) & ~result.diverged("penalty"))).all()


def test_cells_that_blow_up_are_marked(monkeypatch):
    monkeypatch.setattr(plane, "COUNT", 8)
    monkeypatch.setattr(plane, "TRANSIENT", 50)
    result = last(grow_plane(PlaneQuestion(SYSTEM, 2.76, 100, False, False, (1e4, 1e5), (0.1, 100.0)), None, never))
    row, column = np.argwhere(classes.class_image(result, "exact", "period") != classes.DIVERGED)[0]
    assert np.isfinite(result.shown("exact", "period")[row, column])
    result.tables["exact"]["status"][row, column] = STATUSES.index(Status.DIVERGED)
    assert classes.class_image(result, "exact", "period")[row, column] == classes.DIVERGED


def test_the_motions_of_coarse_cells_of_a_plane_are_judged_first():
    question = PlaneQuestion(SYSTEM, 2.76, 300, False, False, (10.0, 1e5), (0.1, 100.0), judged=True)
    shape = (plane.COUNT, plane.COUNT)
    values = {"status": np.zeros(shape, int), "period": np.full(shape, 3), "exact_period": np.zeros(shape, int)}
    rows, columns = np.unravel_index(plane.PartialPlane(question, values).open_cells, shape)
    assert len(set(zip(rows, columns, strict=True))) == plane.COUNT**2
    for stride in (32, 16, 8, 4, 2):
        first = slice((plane.COUNT // stride) ** 2)
        assert not (rows[first] % stride).any()
        assert not (columns[first] % stride).any()


# -- the diagram -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def small_diagram():
    """A function from a direction to the results of a short diagram while it grows, over where motions change."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bifurcation, "SAMPLE", 12)
        yield functools.cache(lambda direction: list(grow_diagram(short_question(direction), None, never)))


def short_question(direction):
    return DiagramQuestion(SYSTEM, Reference(), direction, (2.7, 2.9), count=17, transient=60)


@pytest.mark.parametrize("direction", every(["down", "up"]))
def test_a_continued_diagram_shows_a_coarse_preview_and_goes_on_from_where_it_was(small_diagram, direction):
    question = short_question(direction)
    preview, first, *_, whole = small_diagram(direction)
    assert preview.share == 0
    assert preview.known.sum() == len(question.preview_cells)
    assert 0 < first.share < 1
    assert (first.known & preview.known).sum() == preview.known.sum()
    resumed = last(grow_diagram(question, first, never))
    for name, values in whole.data().items():
        np.testing.assert_array_equal(resumed.data()[name], values)


def test_points_of_one_motion_are_sent_once_and_never_too_many(small_diagram):
    result = small_diagram("rest")[-1]
    eta, values = result.points("xi2")
    once = np.flatnonzero(result.period == 1)
    assert len(once) > 3
    for i in once[:3]:
        assert (eta == result.question.axis[i]).sum() == 1
    assert set(values) <= set(result.section("xi2").ravel())
    fewer, _ = result.points("xi2", 40)
    assert len(fewer) <= 40
    assert set(fewer) == set(eta)  # none is left out


def test_stretches_of_one_period_cover_the_range_without_gaps(small_diagram):
    result = small_diagram("rest")[-1]
    left, right, period, kind = result.stretches()
    assert left[0] == 2.7
    assert right[-1] == 2.9
    assert (left[1:] == right[:-1]).all()
    assert ((period[1:] != period[:-1]) | (kind[1:] != kind[:-1])).all()
    assert set(kind) == set(result.kinds["kind"])


# -- the time step -----------------------------------------------------------------------------------------------------


def test_the_located_step_is_of_second_order_and_the_fixed_one_is_not(monkeypatch, tmp_path):
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))  # nothing is known from an earlier run
    monkeypatch.setattr(time_step, "STEPS", (100, 200, 400, 800))
    monkeypatch.setattr(time_step, "STEPS_AT_ONCE", 2)
    monkeypatch.setattr(time_step, "TRANSIENT", 200)
    results = list(grow_step(StepQuestion(SYSTEM, 2.76, Newmark(12000.0, 18.0, 100)), None, never))
    assert [len(result.steps) for result in results] == [2, 4, 4]  # the last one with the kinds of motion
    order, error = results[-1].order("error_time_step", "located")
    assert order == pytest.approx(2.0, abs=max(0.1, 3 * error))
    assert results[-1].order("error_time_step", "fixed")[0] < 1.5
    assert results[-1].nearest(390) == 2
