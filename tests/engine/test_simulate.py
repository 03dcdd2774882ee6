"""The way in: what it refuses, what it keeps, how it goes on and stops."""

import math
import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest
from vibroscope.engine import Cancelled, Newmark, Record, Reference, System, simulate
from vibroscope.engine.drivers import base

METHODS = [Reference(), Reference("derived"), Newmark(12000, 18, 500)]


@pytest.mark.parametrize("method", METHODS, ids=str)
def test_samples_meet_the_section(method):
    response = simulate(System(), 1.08, method, periods=30, keep=5, record=Record(3, 250))
    per_period = (len(response.trajectory.time) - 1) // 3
    at_section = slice(per_period, None, per_period)
    np.testing.assert_allclose(
        response.trajectory.displacement[:, at_section].T, response.section[-3:, [0, 2]], atol=1e-13
    )
    np.testing.assert_allclose(response.trajectory.velocity[:, at_section].T, response.section[-3:, [1, 3]], atol=1e-11)
    assert response.trajectory.time[-1] == pytest.approx(30 * response.period)


def test_both_solvers_can_be_sampled_on_one_grid():
    record = Record(2, 300, steps=1999)
    one = simulate(System(), 1.08, Reference(), periods=20, keep=5, record=record)
    two = simulate(System(), 1.08, Newmark(2500, 8, 1999), periods=20, keep=5, record=record)
    np.testing.assert_allclose(one.trajectory.time, two.trajectory.time, rtol=1e-14)


@pytest.mark.parametrize("method", METHODS, ids=str)
def test_the_transient_leaves_nothing_behind(method):
    simulate(System(), 1.08, method, periods=10, keep=2)  # compiled
    peaks = []
    for periods in (200, 5000):
        tracemalloc.start()
        simulate(System(), 1.08, method, periods=periods, keep=2)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < peaks[0] + 20_000


def test_buffers_grow_over_many_events():
    """More impacts than a buffer's 4,096 rows, with nothing lost where the kernel returned for room."""
    whole = simulate(System(), 1.08, Reference(), periods=1200, keep=1200)
    assert len(whole.impacts) > 8192
    assert (np.diff(whole.impacts.time) > 0).all()
    last = simulate(System(), 1.08, Reference(), periods=1200, keep=10)
    np.testing.assert_array_equal(whole.impacts.time[-len(last.impacts) :], last.impacts.time)


@pytest.mark.parametrize("method", METHODS, ids=str)
def test_a_run_can_be_cancelled(method):
    calls = []

    def cancelled():
        calls.append(0)
        return len(calls) > 3

    with pytest.raises(Cancelled):
        simulate(System(), 1.08, method, periods=10_000_000, keep=1, cancelled=cancelled)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"eta": math.nan}, "eta = nan"),
        ({"eta": -1}, r"eta = -1 is outside \[0.001, 1000\]"),
        ({"eta": "fast"}, "eta = 'fast'"),
        ({"periods": 0}, "periods = 0"),
        ({"periods": 2.5}, "periods = 2.5 is not a whole number"),
        ({"keep": 3000}, r"keep = 3000 is outside \[1, 2050\]"),
        ({"initial": (1, 2, 3)}, "four numbers"),
        ({"initial": (0, 0, -1, 0)}, "gap .* is negative"),
        ({"initial": (0, math.inf, 0, 0)}, "initial ξ₁′ = inf"),
        ({"record": Record(60)}, "record.periods = 60"),
        ({"record": Record(2, 0)}, "record.per_period = 0"),
    ],
)
def test_bad_input_is_named(arguments, words):
    given = {"eta": 1.08, **arguments}
    with pytest.raises(ValueError, match=words):
        simulate(System(), given.pop("eta"), Reference(), **given)


@pytest.mark.parametrize(
    ("system", "eta", "method"),
    [
        (System(), 1.08, Newmark(2500, 8, 100)),
        (System(), 1.08, Reference("derived")),
        (System(), 1.09, Reference()),
        (System(restitution=0.4), 1.08, Reference()),
    ],
)
def test_a_checkpoint_is_bound_to_its_run(system, eta, method):
    response = simulate(System(), 1.08, Reference(), periods=5, keep=1)
    with pytest.raises(ValueError, match="cannot start"):
        simulate(system, eta, method, initial=response.checkpoint)


def test_work_is_bounded():
    with pytest.raises(ValueError, match="periods × steps"):
        simulate(System(), 1.08, Newmark(2500, 8, 10_000_000), periods=100_000_000)


def test_a_kernel_is_loaded_once():
    """Its loading does not count as the run's seconds, so a driver must know when a call loads it."""
    calls, kernel = [], object()  # which no run has used
    driver = SimpleNamespace(loop=kernel, call=lambda *given: calls.append(given), _state=np.zeros(1), _no_buffers=None)
    for _ in range(3):
        base.Driver.load_loop(driver, 7)
    assert calls == [(7, None)]
