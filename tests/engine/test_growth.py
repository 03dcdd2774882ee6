"""A study that grows: partial results, their order, resuming, and the same numbers in memory and in a store."""

import numpy as np
import pytest
import xarray
from vibroscope.engine import Cancelled, ExactPenalty, Newmark, Reference, StepStudy, System, simulate, sweep
from vibroscope.engine.sweeps import MISSING, EtaStudy, PlaneStudy, RunOptions, grow
from vibroscope.engine.sweeps.errors import reference_motion

from tests.share import every
from tests.studies import sweep_of

ETAS = np.linspace(2.6, 3.3, 40)
PERIODS = {"transient": 60, "sample": 10}
DIRECTIONS = pytest.mark.parametrize("direction", ["rest", "up", "down"])


def diagram(direction="rest"):
    return EtaStudy(System(), Reference(), None, transient=60, sample=10, values=ETAS, direction=direction)


def plane(**more):
    K, D = np.geomspace(100, 60_000, 9), np.geomspace(1, 100, 5)
    return PlaneStudy(System(), Newmark(K[0], D[0], 500), 2.76, transient=60, sample=10, K=K, D=D, **more)


def known(values):
    return values["status"] != MISSING


def grown(study, options=None, **more):
    """The values of each partial result."""
    return [partial.values() for partial in grow(study, options, **more)]


@DIRECTIONS
def test_a_picture_refines_to_the_numbers_of_the_sweep(direction):
    stages = grown(diagram(direction), picture=True)
    whole = sweep(EtaStudy(System(), Reference(), values=ETAS, direction=direction, **PERIODS))
    assert known(stages[-1]).all()
    for stage in stages:
        cells = known(stage)
        np.testing.assert_array_equal(stage["xi2"][cells], whole["xi2"].values[cells])
        assert np.isnan(stage["xi2"][~cells]).all()


def test_coarse_cells_come_first_and_a_continued_diagram_goes_from_end_to_end():
    first = known(grown(diagram(), picture=True)[0])
    assert first[::8].all()
    for direction, order in (("up", 1), ("down", -1)):
        first = known(grown(diagram(direction), picture=True)[0])[::order]
        assert first[: first.sum()].all()
        assert 0 < first.sum() < len(ETAS)


@DIRECTIONS
def test_a_picture_goes_on_from_an_earlier_one(direction):
    first, *_, whole = grown(diagram(direction), picture=True)
    *_, partial = grow(diagram(direction), picture=True, known=first)
    assert partial.progress.reused == known(first).sum()
    assert partial.progress.computed == len(ETAS) - known(first).sum()
    for name, column in partial.values().items():
        np.testing.assert_array_equal(column, whole[name])


def test_a_complete_picture_comes_once_more_and_computes_nothing():
    whole = grown(plane(), picture=True)[-1]
    (partial,) = grow(plane(), picture=True, known=whole)
    assert (partial.progress.computed, partial.share) == (0, 1.0)


def test_what_was_yielded_before_the_cancellation_is_complete():
    wanted = [True]
    growth = grow(plane(), RunOptions(cancelled=lambda: not wanted), picture=True)
    stage = next(growth).values()
    wanted.clear()
    with pytest.raises(Cancelled):
        next(growth)
    whole = grown(plane())[-1]
    cells = known(stage)
    np.testing.assert_array_equal(stage["exact_period"][cells], whole["exact_period"][cells])


def test_in_chunks_a_store_is_readable_while_it_grows(tmp_path):
    shares = []
    for partial in grow(diagram(), RunOptions(tmp_path / "a.zarr", cells_per_chunk=10)):
        found = partial.dataset()
        assert int((found["status"] != MISSING).sum()) == partial.progress.done
        assert found.attrs["complete"] == (partial.share == 1)
        shares.append(partial.share)
    assert shares == [0.25, 0.5, 0.75, 1.0]


def test_of_a_refined_diagram_the_rounds_come_first_and_then_the_whole():
    study = EtaStudy(System(), Reference(), None, transient=60, sample=10, values=ETAS[::4], refine=2)
    *rounds, last = grow(study, RunOptions(cells_per_chunk=4))
    assert all(partial.progress.done < partial.progress.total for partial in rounds)
    assert last.study is study
    assert len(last.dataset()["eta"]) == last.progress.total > 10


@pytest.mark.parametrize(("direction", "neighbour"), [("up", -1), ("down", 1)])
def test_what_refinement_puts_into_a_continued_diagram_goes_on_from_its_neighbour(direction, neighbour):
    study = EtaStudy(System(), Reference(), values=ETAS[::4], direction=direction, refine=1, **PERIODS)
    *_, last = grow(study)
    eta, whole = last.dataset()["eta"].values, last.values()
    put_in = np.flatnonzero(~np.isin(eta, study.values))
    assert 0 < len(put_in) < len(study.values) - 1  # where the motion changes
    for k in put_in:
        run = simulate(System(), eta[k], Reference(), periods=70, keep=10, initial=whole["end"][k + neighbour])
        np.testing.assert_allclose(whole["xi2"][k], run.section[:, 2], rtol=1e-6)


SWEEPS = {
    "rest": lambda **how: sweep_of(EtaStudy, System(), Reference(), values=ETAS, **PERIODS, **how),
    "down": lambda **how: sweep_of(EtaStudy, System(), Reference(), values=ETAS, direction="down", **PERIODS, **how),
    "refined": lambda **how: sweep_of(EtaStudy, System(), Reference(), values=ETAS[::4], refine=2, **PERIODS, **how),
    "plane": lambda **how: sweep_of(
        PlaneStudy, System(), Newmark(1, 1, 500), 2.76, K=[100, 1e3, 5e3], D=[5, 20], **PERIODS, **how
    ),
    "step": lambda **how: sweep_of(
        StepStudy, System(), Newmark(12_000, 18, 2000), 2.76, steps=[500, 1000], **PERIODS, **how
    ),
}


@pytest.mark.parametrize("name", every(SWEEPS))
def test_results_in_memory_and_in_a_store_are_identical(tmp_path, name):
    memory = SWEEPS[name](cells_per_chunk=3)
    store = SWEEPS[name](out=tmp_path / "a.zarr", cells_per_chunk=2).load()
    for found in (memory, store):
        del found.attrs["seconds"], found.attrs["date"]
    xarray.testing.assert_identical(memory, store)


def test_a_plane_computes_the_variables_that_are_wanted_and_runs_nothing_else():
    reference_motion.cache_clear()
    values = grown(plane(only=("period", "exact_period")))[-1]
    assert set(values) == {"period", "exact_period", "status"}
    assert reference_motion.cache_info().misses == 0
    whole = grown(plane())[-1]
    for name, column in values.items():
        np.testing.assert_array_equal(column, whole[name])


def test_the_error_alone_is_that_of_the_error_in_parts():
    only = grown(plane(only=("error", "exact_status", "exact_error")))[-1]
    np.testing.assert_array_equal(only["error"], grown(plane())[-1]["error"])
    K, D = plane().K, plane().D
    exact = sweep(PlaneStudy(System(), ExactPenalty(1, 1), 2.76, K=K, D=D, **PERIODS))
    np.testing.assert_array_equal(only["exact_error"], exact["error"])


def test_a_picture_is_held_in_memory(tmp_path):
    with pytest.raises(ValueError, match="in memory"):
        next(grow(diagram(), RunOptions(tmp_path / "a.zarr"), picture=True))
