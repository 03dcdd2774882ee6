"""Cache and cancellation; the newest request wins."""

import threading
from unittest.mock import Mock

import numpy as np
import pytest
from vibroscope.app.explorer.compute import ORBIT_PERIODS, JobQueue, RunPair, compute_runs
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime import logs, metrics
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.workers import Workers
from vibroscope.engine import Cancelled

from tests.waiting import wait_until

SETTING = Setting()


@pytest.fixture
def pool():
    with Workers("test", 2) as pool:
        yield pool


class Solver:
    """Stands for the engine: ends on `go`, or when cancelled."""

    def __init__(self):
        self.started = []
        self.cancelled = []
        self.asked = 0
        self.go = threading.Event()

    def __call__(self, setting, cancelled):
        self.started.append(setting.eta)
        while not self.go.wait(0.002):
            self.asked += 1
            if cancelled():
                self.cancelled.append(setting.eta)
                raise Cancelled
        return setting.eta


def at(eta):
    return SETTING._replace(eta=eta)


def test_of_many_moves_the_running_and_the_last_are_delivered(pool):
    solver, delivered = Solver(), []
    queue = JobQueue(lambda move, result: delivered.append((move, result)), solve=solver, pool=pool, grace=60)
    for move, eta in enumerate((1.0, 1.1, 1.2, 1.3)):
        queue.submit(move, at(eta))
        wait_until(lambda: solver.started)
    solver.go.set()
    wait_until(lambda: len(delivered) == 2)
    assert delivered == [(0, 1.0), (3, 1.3)]
    assert solver.started == [1.0, 1.3]


def test_a_delivery_that_fails_does_not_stop_the_next(pool):
    delivered = []

    def deliver(move, result):
        delivered.append(move)
        if move == 1:
            raise RuntimeError("no page")

    queue = JobQueue(deliver, solve=lambda setting, cancelled: setting.eta, pool=pool)
    queue.submit(1, at(1.0))
    wait_until(lambda: delivered == [1])
    queue.submit(2, at(1.1))
    wait_until(lambda: delivered == [1, 2])


def test_a_long_job_that_is_overtaken_is_cancelled(pool):
    solver, delivered = Solver(), []
    queue = JobQueue(lambda move, result: delivered.append(move), solve=solver, pool=pool, grace=0.02)
    queue.submit(1, at(1.0))
    wait_until(lambda: solver.started)
    queue.submit(2, at(2.0))
    wait_until(lambda: solver.cancelled == [1.0])
    solver.go.set()
    wait_until(lambda: delivered == [2])


def test_a_job_that_nobody_overtakes_may_take_its_time(pool):
    solver, delivered = Solver(), []
    queue = JobQueue(lambda move, result: delivered.append(move), solve=solver, pool=pool, grace=0.0)
    queue.submit(1, at(1.0))
    wait_until(lambda: solver.asked > 5)  # whether it is cancelled
    solver.go.set()
    wait_until(lambda: delivered == [1])
    assert solver.cancelled == []


def test_after_close_nothing_is_delivered(pool):
    solver, delivered = Solver(), []
    queue = JobQueue(lambda move, result: delivered.append(move), solve=solver, pool=pool, grace=60)
    queue.submit(1, at(1.0))
    wait_until(lambda: solver.started)
    queue.close()
    wait_until(lambda: solver.cancelled)
    queue.submit(2, at(2.0))
    pool.shutdown()  # waits for all that was submitted
    assert delivered == []
    assert solver.started == [1.0]


def test_a_failure_is_delivered_and_the_next_move_still_served(pool):
    delivered = []

    def solve(setting, cancelled):
        if setting.eta == 1.0:
            raise RuntimeError("broken")
        return setting.eta

    queue = JobQueue(lambda move, result: delivered.append((move, result)), solve=solve, pool=pool)
    queue.submit(1, at(1.0))
    wait_until(lambda: delivered)
    queue.submit(2, at(2.0))
    wait_until(lambda: len(delivered) == 2)
    assert isinstance(delivered[0][1], RuntimeError)
    assert delivered[1] == (2, 2.0)


def test_each_move_is_logged_once_with_its_session_and_measured_where_it_succeeds(pool, caplog, monkeypatch):
    caplog.set_level("INFO", logger="vibroscope")
    monkeypatch.setattr(metrics, "SOLVED", measure := Mock())
    delivered = []

    def solve(setting, cancelled):
        if setting.eta == 1.0:
            raise RuntimeError("broken")

    def deliver(move, result):
        delivered.append(move)
        if move == 3:
            raise RuntimeError("no page")

    with logs.in_session("3f2a91cc"):
        queue = JobQueue(deliver, solve=solve, pool=pool)
    for move, eta in ((1, 1.0), (2, 2.0), (3, 3.0)):
        queue.submit(move, at(eta))
        wait_until(lambda move=move: move in delivered)
    wait_until(lambda: len(caplog.records) == 4)
    logged = [(record.message, record.details["move"]) for record in caplog.records]
    assert logged == [("not computed", 1), ("computed", 2), ("computed", 3), ("not delivered", 3)]
    assert {record.details["session"] for record in caplog.records} == {"3f2a91cc"}
    assert measure.add.call_count == 2


def test_the_cache_is_bounded_and_forgets_the_least_recently_used():
    cache = Cache(size=2)
    cache.put("a", 1)
    cache.put("b", 2)
    assert cache.get("a") == 1
    cache.put("c", 3)
    assert (cache.get("a"), cache.get("b"), cache.get("c"), len(cache)) == (1, None, 3, 2)


def test_moving_the_penalty_numbers_does_not_run_the_reference_again():
    cache = Cache(48)
    first = compute_runs(SETTING, cache=cache)
    second = compute_runs(SETTING._replace(K=3000.0, frame="absolute"), cache=cache)
    assert second.reference is first.reference
    assert second.penalty is not first.penalty
    assert len(cache) == 3


def test_a_cancelled_computation_leaves_nothing_in_the_cache():
    cache = Cache(48)
    with pytest.raises(Cancelled):
        compute_runs(SETTING._replace(eta=1.234), cancelled=lambda: True, cache=cache)
    assert len(cache) == 0


def test_traces_continue_the_run_they_belong_to():
    runs = compute_runs(SETTING, cache=Cache(48))
    assert isinstance(runs, RunPair)
    for run in (runs.reference, runs.penalty):
        last = run.response.section[-1]
        for trajectory in (run.trace, run.orbit):
            end = [
                trajectory.displacement[0, -1],
                trajectory.velocity[0, -1],
                trajectory.displacement[1, -1],
                trajectory.velocity[1, -1],
            ]
            np.testing.assert_allclose(end, last, atol=1e-9)


def test_a_diverged_run_is_a_result():
    runs = compute_runs(SETTING._replace(eta=2.76, K=1e5, D=100.0, steps=100), cache=Cache(48))
    assert runs.penalty.response.status == "diverged"
    assert runs.penalty.trace is None
    assert runs.reference.response.ok


@pytest.mark.parametrize("solver", ["reference", "penalty"])
def test_a_motion_that_does_not_repeat_is_drawn_over_twelve_periods_that_end_in_the_trace(solver):
    run = getattr(compute_runs(SETTING._replace(eta=1.7), cache=Cache(0)), solver)
    assert run.motion.period == 0
    first, last = run.orbit.time[[0, -1]]
    assert last - first == pytest.approx(ORBIT_PERIODS * run.response.period)
    assert last == run.trace.time[-1]
    _, mine, theirs = np.intersect1d(run.orbit.time, run.trace.time, return_indices=True)
    assert len(mine) > 1000
    assert (run.orbit.displacement[:, mine] == run.trace.displacement[:, theirs]).all()
