"""Many cells in one call are the single runs, whatever the order, the threads and the cells around them."""

import dataclasses
import threading
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vibroscope.engine import (
    STATUSES,
    Cancelled,
    Cells,
    ExactPenalty,
    Newmark,
    Reference,
    Status,
    System,
    run_cells,
    simulate,
)
from vibroscope.engine.kernels import status

from tests import naive_description
from tests.share import share

NUMBERS = (
    "impacts_per_period",
    "contacts_per_period",
    "contact_share",
    "spread",
    "scatter",
    "longest_contact",
    "impact_phase",
)


def plane(side, method, eta=2.76):
    """The K–D plane of the paper's Figures 11 and 12."""
    k, d = (a.ravel() for a in np.meshgrid(np.geomspace(1e2, 6e4, side), np.geomspace(1, 100, side)))
    return Cells(System(), np.full(side * side, eta), method, stiffness=k, damping=d)


SWEEPS = {
    "reference": Cells(System(), np.linspace(0.5, 4, 30), Reference()),
    "reference, ε = 0": Cells(System(), np.linspace(0.5, 4, 12), Reference("derived", 0.0)),
    "reference, e": Cells([System(restitution=e) for e in np.linspace(0, 0.9, 10)], np.full(10, 1.08), Reference()),
    "wall": Cells(System(wall=True, clearance=0.5), np.linspace(0.5, 4, 12), Newmark(300, 1, 200)),
    "exact": plane(5, ExactPenalty(1, 1)),
    "Newmark": plane(5, Newmark(1, 1, 2000)),
    "Newmark, n": Cells(System(), np.full(4, 2.76), Newmark(12000, 18, 100), steps=[1000, 2000, 4000, 3001]),
    "located": Cells(System(), [1.08, 2.76, 1.7], Newmark(2500, 8, 60, located=True), steps=[60, 101, 60]),
}


def one_by_one(cells, transient, sample):
    """The responses of single runs, and their descriptions by numpy."""
    options = {"periods": transient + sample, "keep": sample}
    n = range(len(cells))
    responses = [simulate(cells.system_of(i), cells.eta[i], cells.method_of(i), **options) for i in n]
    return responses, [naive_description.describe(response) for response in responses]


@pytest.mark.parametrize("name", SWEEPS)
def test_cells_are_single_runs(name):
    cells = SWEEPS[name]
    ours = run_cells(cells, transient=30, sample=25, recurrence=0)
    responses, described = one_by_one(cells, 30, 25)
    assert [STATUSES[code] for code in ours.status] == [response.status for response in responses]
    for i, (response, single) in enumerate(zip(responses, described, strict=True)):
        np.testing.assert_allclose(ours.section[i], response.section, rtol=0, atol=1e-9)
        for name in ("period", "near_period"):
            assert getattr(ours, name)[i] == single[name]
        for name in NUMBERS:
            np.testing.assert_allclose(getattr(ours, name)[i], single[name], atol=1e-9, err_msg=name)


@pytest.mark.parametrize("name", SWEEPS)
def test_early_stop_changes_nothing(name):
    """Periods, too: a motion is only taken for periodic when it has come back to rounding."""
    cells = SWEEPS[name]
    full = run_cells(cells, transient=400, sample=30, recurrence=0)
    early = run_cells(cells, transient=400, sample=30)
    assert early.periods.min() < 300
    for whole in ("status", "period", "near_period"):
        np.testing.assert_array_equal(getattr(early, whole), getattr(full, whole), err_msg=whole)
    scale = np.abs(full.section).max()
    np.testing.assert_allclose(early.section, full.section, rtol=0, atol=1e-10 * scale)
    for number in NUMBERS:
        np.testing.assert_allclose(getattr(early, number), getattr(full, number), rtol=0, atol=1e-9, err_msg=number)
    stopped = early.periods < 430
    np.testing.assert_array_equal(early.section[~stopped], full.section[~stopped])


@pytest.mark.parametrize("name", ["reference", "exact"])
def test_cells_may_stop_where_what_follows_is_nearly_the_same(name):
    cells = SWEEPS[name]
    full, early = (run_cells(cells, transient=400, sample=30, recurrence=share) for share in (1e-13, 1e-9))
    assert (early.periods <= full.periods).all()
    assert early.periods.sum() < full.periods.sum()
    np.testing.assert_array_equal(early.period, full.period)
    np.testing.assert_allclose(early.section, full.section, rtol=0, atol=1e-7 * np.abs(full.section).max())
    with pytest.raises(ValueError, match="recurrence"):
        run_cells(cells, transient=400, sample=30, recurrence=0.1)


@pytest.mark.parametrize("sample", [1, 7])
def test_early_stop_with_a_sample_shorter_than_a_cycle(sample):
    cells = SWEEPS["reference"]
    full = run_cells(cells, transient=401, sample=sample, recurrence=0)
    early = run_cells(cells, transient=401, sample=sample)
    np.testing.assert_array_equal(early.period, full.period)
    np.testing.assert_allclose(early.section, full.section, rtol=0, atol=1e-10)
    for number in NUMBERS:
        np.testing.assert_allclose(getattr(early, number), getattr(full, number), rtol=0, atol=1e-9, err_msg=number)


def test_a_motion_that_a_step_locks_into_a_long_cycle_stops_early():
    cells = plane(14, Newmark(1, 1, 2000))
    full, early = (run_cells(cells, transient=900, sample=60, **how) for how in ({"recurrence": 0}, {}))
    assert (full.cycle == 0).all()
    assert (full.periods == 960).all()
    stopped = early.cycle > 0
    np.testing.assert_array_equal(early.periods < 960, stopped)
    assert (early.cycle[stopped] % 12 == 0).all()
    within, beyond = (stopped & chosen for chosen in ((early.cycle > 12) & (early.cycle <= 60), early.cycle > 60))
    assert within.any()
    assert beyond.any()
    scale = np.abs(full.section).max()
    np.testing.assert_allclose(early.section, full.section, rtol=0, atol=1e-10 * scale)
    for number in NUMBERS:
        np.testing.assert_allclose(getattr(early, number), getattr(full, number), rtol=0, atol=1e-9, err_msg=number)
    np.testing.assert_array_equal(early.section[~stopped], full.section[~stopped])


def test_some_of_the_cells_with_other_numbers():
    systems = [System(d1=d1) for d1 in (0.01, 0.02, 0.03)]
    cells = Cells(systems, [1.0, 2.0, 3.0], Newmark(1, 1, 50), stiffness=[10, 20, 30], chain=[0, 0, 0])
    some = cells.at(np.array([2, 0]), steps=np.array([60, 70]))
    assert (some.eta.tolist(), some.stiffness.tolist(), some.steps.tolist()) == ([3.0, 1.0], [30, 10], [60, 70])
    assert [some.system_of(i).d1 for i in range(2)] == [0.03, 0.01]
    assert some.chain is None
    assert some.initial is some.damping is None


@settings(max_examples=share(15))
@given(st.permutations(range(12)), st.integers(1, 5), st.integers(0, 12), st.sampled_from(sorted(SWEEPS)))
def test_neither_order_nor_threads_nor_chunks_matter(permutation, threads, cut, name):
    cells = SWEEPS[name]
    n = min(12, len(cells))
    places = np.array([i for i in permutation if i < n])

    def part(chosen):
        own = {key: getattr(cells, key) for key in ("stiffness", "damping", "steps")}
        own = {key: value[chosen] for key, value in own.items() if value is not None}
        system = cells.system if isinstance(cells.system, System) else [cells.system[i] for i in chosen]
        return Cells(system, cells.eta[chosen], cells.method, **own)

    whole = run_cells(part(np.arange(n)), transient=40, sample=8, threads=1)
    for chosen in (places[:cut], places[cut:]):
        found = run_cells(part(chosen), transient=40, sample=8, threads=threads)
        for field in dataclasses.fields(found):
            np.testing.assert_array_equal(getattr(found, field.name), getattr(whole, field.name)[chosen])


@pytest.mark.parametrize("method", [Reference(), Newmark(2500, 8, 2000), Newmark(2500, 8, 100, located=True)])
def test_a_chain_goes_on_from_cell_to_cell(method):
    eta = np.array([1.0, 3.2, 1.05, 3.25, 1.1])
    chained = run_cells(Cells(System(), eta, method, chain=[7, 3, 7, 3, 7]), transient=20, sample=4, threads=2)
    before = None
    for i in (0, 2, 4):
        start = None if before is None else before.end
        before = run_cells(Cells(System(), eta[[i]], method, initial=start), transient=20, sample=4)
        np.testing.assert_array_equal(before.section[0], chained.section[i])


def test_cells_that_diverge_are_marked_and_stop_no_other():
    cells = plane(6, Newmark(1, 1, 200))
    found = run_cells(cells, transient=100, sample=10)
    assert 0 < found.ok.sum() < 36
    assert {STATUSES[code] for code in found.status} == {Status.OK, Status.DIVERGED}
    assert np.isnan(found.section[~found.ok]).all()
    assert np.isfinite(found.section[found.ok]).all()
    for i in (np.flatnonzero(found.ok)[0], np.flatnonzero(~found.ok)[0]):
        assert simulate(System(), 2.76, cells.method_of(i), periods=110, keep=10).ok == found.ok[i]


def test_after_a_cell_that_diverges_a_chain_starts_anew():
    cells = Cells(System(), [2.76] * 2, Newmark(1, 1, 1000), stiffness=[1e7, 100], damping=[1, 50], chain=[0, 0])
    found = run_cells(cells, transient=40, sample=5)
    assert found.ok.tolist() == [False, True]
    alone = run_cells(Cells(System(), [2.76], Newmark(100, 50, 1000)), transient=40, sample=5)
    np.testing.assert_array_equal(found.section[1], alone.section[0])


def test_statuses_of_the_compiled_code():
    codes = {name: getattr(status, name) for name in Status.__members__}
    assert {name: STATUSES[code].name for name, code in codes.items()} == {name: name for name in codes}


def test_the_events_of_a_cell_that_diverges_are_not_those_of_the_next():
    cells = Cells(System(), [2.76] * 2, Newmark(1, 1, 1000), stiffness=[1e7, 12000], damping=[1, 18])
    found = run_cells(cells, transient=0, sample=60, threads=1)
    assert found.ok.tolist() == [False, True]
    alone = run_cells(cells.at(np.array([1])), transient=0, sample=60)
    for field in dataclasses.fields(alone):
        np.testing.assert_array_equal(getattr(alone, field.name)[0], getattr(found, field.name)[1], err_msg=field.name)


MIXED = {
    "coarse steps beside fine ones": ([2.76] * 3, {"steps": [4000, 20, 2000]}),
    "one that diverges": (
        [2.76] * 3,
        {"stiffness": [12000, 1e7, 100], "damping": [18, 1, 50], "steps": [2000, 1000, 2000]},
    ),
}


@pytest.mark.parametrize("name", MIXED)
def test_a_cell_is_the_same_alone_and_in_company(name):
    """Also how long it ran, and with a neighbour that is solved in another way or diverges."""
    eta, own = MIXED[name]
    how = {"transient": 100, "sample": 12}
    together = run_cells(Cells(System(), eta, Newmark(12000, 18, 2000), **own), **how)
    for i in range(len(eta)):
        numbers = {key: [values[i]] for key, values in own.items()}
        alone = run_cells(Cells(System(), [eta[i]], Newmark(12000, 18, 2000), **numbers), **how)
        for field in dataclasses.fields(alone):
            np.testing.assert_array_equal(
                getattr(alone, field.name)[0], getattr(together, field.name)[i], err_msg=field.name
            )


def test_a_chain_goes_on_between_cells_that_are_solved_in_different_ways():
    steps = [2000, 20, 2000]
    chained = run_cells(
        Cells(System(), [2.76] * 3, Newmark(100, 50, 20), steps=steps, chain=[0] * 3), transient=20, sample=4
    )
    start = None
    for i, n in enumerate(steps):
        alone = run_cells(Cells(System(), [2.76], Newmark(100, 50, n), initial=start), transient=20, sample=4)
        np.testing.assert_array_equal(alone.section[0], chained.section[i])
        start = alone.end


def test_impacts_that_fill_the_record_are_all_counted():
    """A chatter at e = 0.7 down to a small threshold: more impacts in the sample than a record holds."""
    cells = Cells([System(restitution=0.7)], [1.08], Reference("derived", 1e-12))
    ours, (_, (single,)) = run_cells(cells, transient=5, sample=200), one_by_one(cells, 5, 200)
    assert single["impacts_per_period"] * 200 > 4096
    assert ours.impacts_per_period[0] == single["impacts_per_period"]


def test_chosen_coordinates():
    cells = SWEEPS["reference"]
    every = run_cells(cells, transient=10, sample=5)
    np.testing.assert_array_equal(
        run_cells(cells, transient=10, sample=5, coordinates=(2,)).section, every.section[:, :, [2]]
    )


def test_progress_ends_with_all_cells_and_is_heard_in_the_calling_thread():
    heard = []
    run_cells(SWEEPS["exact"], transient=200, sample=5, progress=lambda n: heard.append((n, threading.get_ident())))
    assert [n for n, _ in heard] == sorted(n for n, _ in heard)
    assert heard[-1] == (25, threading.get_ident())


@pytest.mark.parametrize("method", [Reference(), Newmark(2500, 8, 2000), Newmark(2500, 8, 2000, every_step=True)])
def test_a_call_is_cancelled_at_once(method):
    cells = Cells(System(), [1.7] * 8, method)
    begin = time.perf_counter()
    with pytest.raises(Cancelled):
        run_cells(cells, transient=50_000_000, sample=1, cancelled=lambda: time.perf_counter() > begin + 0.1)
    assert time.perf_counter() < begin + 20


def test_no_cells():
    found = run_cells(Cells(System(), [], Reference()), transient=1, sample=2)
    assert found.section.shape == (0, 2, 4)
