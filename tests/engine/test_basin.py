"""The study of a plane of starts: the same numbers however it is computed, its conclusions, and its refusals."""

from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import xarray
from vibroscope.engine import (
    Cancelled,
    ExactPenalty,
    Excitation,
    Newmark,
    Reference,
    System,
    TimeStepping,
    basin_difference,
    sweep,
)
from vibroscope.engine.sweeps import BasinStudy, StartPlane, grow
from vibroscope.engine.sweeps.basin_motions import BasinSearch

from tests.studies import sweep_of

SYSTEM, ETA = System(), 3.2
VALUES = np.linspace(-8, 8, 16)
PENALTY = ExactPenalty(12000.0, 18.0)
NAMES = ("reached", "reached_period", "periods", "point", "status", "motion", "motion_share", "motion_start")


def basin(method=None, values=VALUES, axes=("xi2", "v2"), **more):
    return sweep_of(BasinStudy.over, SYSTEM, method or Reference(), ETA, dict.fromkeys(axes, values), **more)


@cache
def whole_basin():
    """The basins of the reference, which most tests compare with."""
    return basin()


def study(method=None):
    plane = StartPlane(("xi2", "v2"), ((-8.0, 8.0),) * 2, SYSTEM.rest)
    return BasinStudy(SYSTEM, method or Reference(), ETA, transient=1800, sample=256, plane=plane, x=VALUES, y=VALUES)


def assert_same(one, other):
    for name in NAMES:
        np.testing.assert_array_equal(one[name], other[name])


def test_a_store_belongs_to_one_plane(tmp_path):
    basin(values=VALUES[8:10], out=str(tmp_path / "basin"))
    for other in ({"start": (0, 1, 0, 0)}, {"phase": 0.5}, {"axes": ("v1", "v2")}):
        with pytest.raises(ValueError, match="another study"):
            basin(values=VALUES[8:10], out=str(tmp_path / "basin"), **other)


def test_a_picture_grows_from_coarse_to_fine():
    partials = [partial.values()["status"] != -1 for partial in grow(study(), picture=True)]
    coarse = np.zeros((VALUES.size,) * 2, bool)
    coarse[::8, ::8] = True
    assert partials[0][coarse].all()
    assert all((before <= after).all() for before, after in pairwise(partials))
    *_, last = grow(study(), picture=True)
    assert_same(whole_basin(), last.dataset())


def test_what_is_complete_is_kept_when_it_is_cancelled(tmp_path):
    how = {"out": str(tmp_path / "basin"), "cells_per_chunk": 16, "threads": 1}
    done = []
    with pytest.raises(Cancelled):
        basin(progress=done.append, cancelled=lambda: bool(done) and done[-1].done > 40, **how)
    again = basin(**how)
    assert again.attrs["reused"] > 0
    assert again.attrs["reused"] + again.attrs["computed"] == VALUES.size**2
    assert_same(whole_basin(), again)


def test_motions_are_numbered_by_their_shares_and_their_starts_lead_there():
    found = whole_basin()
    assert found["motion_period"].values.tolist() == [6, 2]
    assert np.diff(found["motion_share"]).max() < 0
    assert found["motion_share"].sum() == pytest.approx(1)
    for k, start in enumerate(found["motion_start"].values):
        cell = found["motion"].sel(xi2=start[2], v2=start[3])
        assert (int(cell), start[4]) == (k, 0)


def test_a_motion_that_was_not_found_beforehand_is_found_by_its_cells(monkeypatch):
    """A lattice of a single start knows one motion of the two."""
    whole = whole_basin()
    monkeypatch.setattr("vibroscope.engine.sweeps.basin_motions.PROBES", 1)
    found = basin(transient=1799)  # another study, which finds its motions anew
    assert (found["reached"] == -2).any()
    np.testing.assert_array_equal(found["motion"], whole["motion"])
    np.testing.assert_array_equal(found["motion_period"], whole["motion_period"])


def test_a_cycle_that_steps_scatter_in_two_ways_is_one_motion():
    """Two bands of different widths about one cycle were two motions, of which `attractors` lists one."""
    values = np.linspace(-2, 2, 12)
    plane = {"xi2": values, "v2": values}
    found = sweep(BasinStudy.over(SYSTEM, Newmark(2500.0, 8.0, 500), 2.3, plane, transient=300))
    assert found["motion_period"].values.tolist() == [1]


def test_a_short_transient_changes_no_label():
    """What no region has decided by then is decided later."""
    for transient in (0, 20):
        np.testing.assert_array_equal(basin(transient=transient, sample=32)["motion"], whole_basin()["motion"])


def test_the_share_in_which_two_solvers_differ():
    """The reference has a cycle of period 6 that the penalty model does not have."""
    reference, penalty = whole_basin(), basin(PENALTY)
    found = basin_difference(reference, penalty)
    np.testing.assert_array_equal(found.same, [[False], [True]])
    motion = reference["motion"].values
    np.testing.assert_array_equal(found.cells, np.where(motion < 0, -1, np.where(motion == 0, 1, 0)))
    assert found.share == pytest.approx(float(reference["motion_share"][0]))
    assert basin_difference(reference, reference).share == 0


@pytest.mark.parametrize("method", [Newmark(12000.0, 18.0, 1000), TimeStepping(12000.0, 18.0, 500)])
def test_methods_with_a_time_step_have_basins(method):
    found = basin(method, VALUES[::8], transient=300, sample=64)
    assert (found["motion"] == 0).all()
    assert found["motion_period"].values.tolist() == [2]


def test_a_whole_period_later_is_the_same_start():
    found = sweep(
        BasinStudy.over(SYSTEM, Reference(), ETA, {"phase": [0.0, 0.4, 1.0], "v2": VALUES}, start=(0, 0, 2, 0))
    )
    np.testing.assert_array_equal(found["periods"][0], found["periods"][2])
    assert (found["periods"][0] != found["periods"][1]).any()


def test_chaos_is_a_motion():
    found = sweep(BasinStudy.over(SYSTEM, Reference(), 1.7, {"xi2": [1.0, 3.0], "v2": [0.0, 2.0]}))
    assert found["motion_kind"].values.tolist() == [3]
    assert (found["motion"] == 0).all()


@pytest.mark.parametrize(
    ("system", "method", "x", "y", "more", "text"),
    [
        (SYSTEM, Reference(), VALUES, VALUES, {"axes": ("xi2", "eta")}, "'eta' is no axis"),
        (SYSTEM, Reference(), VALUES, VALUES, {"axes": ("xi2",)}, "two axes, not 1"),
        (SYSTEM, Reference(), VALUES, VALUES, {"sample": 31}, "sample = 31 is outside [32"),
        (SYSTEM, Reference(), [], VALUES, {}, "no value of xi2"),
        (SYSTEM, Reference(), [1.0, 1.0], VALUES, {}, "do not ascend strictly"),
        (SYSTEM, Reference(), VALUES, [0.0, 2e6], {}, "v2 = 2000000.0 is outside"),
        (SYSTEM, Reference(), VALUES, VALUES, {"start": (0, 0, 0)}, "initial has 3 numbers"),
        (SYSTEM, Reference(), VALUES, [0.5, 1.5], {"axes": ("xi2", "phase")}, "phase = 1.5 is outside"),
        (SYSTEM, Newmark(1e4, 9.0, 99), [0.0, 0.5], VALUES, {"axes": ("phase", "v2")}, "needs a solver in closed form"),
        (System(wall=True), Reference(), VALUES, VALUES, {"axes": ("xi1", "v2")}, "v2 cannot be an axis: a wall"),
        (System(wall=True), Reference(), VALUES, VALUES, {"axes": ("xi1", "v1"), "start": (0, 0, 1, 0)}, "give 0, 0"),
        (
            System(excitation=Excitation(base=0.0)),
            Reference(),
            [0.0, 0.5],
            VALUES,
            {"axes": ("phase", "v2")},
            "nothing drives the bodies",
        ),
    ],
)
def test_bad_input_is_refused_in_one_line(system, method, x, y, more, text):
    axes = dict(zip(more.pop("axes", ("xi2", "v2")), (x, y), strict=False))
    with pytest.raises(ValueError, match=r"^[^\n]*$") as refused:
        sweep_of(BasinStudy.over, system, method, ETA, axes, **more)
    assert text in str(refused.value)


def test_basins_of_other_cells_are_not_compared():
    with pytest.raises(ValueError, match="not of the same cells"):
        basin_difference(whole_basin(), basin(values=VALUES[::2]))
    with pytest.raises(ValueError, match="no complete basin"):
        basin_difference(whole_basin(), xarray.Dataset())


def test_what_runs_in_the_place_of_a_search_for_motions_can_search_for_the_same():
    """A server lets another job run wherever ``cancelled`` is called, in the same thread."""
    plane = StartPlane(("xi2", "v2"), ((-6.0, 6.0),) * 2, SYSTEM.rest)
    search, inner = BasinSearch(SYSTEM, ETA, Reference(), plane, 600, 64), []

    def other_job():
        if not inner:
            inner.append(None)
            inner[0] = search.motions(1)
        return False

    with ThreadPoolExecutor(1) as pool:
        outer = pool.submit(search.motions, 1, other_job).result(60)
    assert [each.period for each in outer] == [each.period for each in inner[0]]
