"""Sessions take turns in a pool: one that computes much delays no other."""

import threading
import time
from concurrent.futures import CancelledError
from types import SimpleNamespace

import pytest
from vibroscope.app.explorer.compute import JobQueue
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime import logs, workers
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.workers import Workers, give_way, own_time
from vibroscope.app.studies import study_job

from tests.waiting import PATIENCE

SETTING = Setting()


@pytest.fixture
def pool():
    """One thread, which waits until ``go`` is called."""
    go = threading.Event()
    with Workers("test", 1) as pool:
        pool.submit(go.wait, 5)
        pool.go = go.set
        yield pool
        go.set()


@pytest.fixture
def spend(monkeypatch):
    """Jobs take no time but what they spend."""
    now = 0.0

    def spend(seconds):
        nonlocal now
        now += seconds

    monkeypatch.setattr(workers.time, "monotonic", lambda: now)
    return spend


def test_the_next_job_is_that_of_the_session_that_had_least(spend, pool):
    order = []
    for session in "aaabb":
        pool.submit(lambda session=session: (order.append(session), spend(1)), session=session)
    pool.go()
    pool.shutdown()
    assert "".join(order) == "ababa"


def test_an_expensive_session_waits_for_a_cheap_one_that_asks_more_often(spend, pool):
    order = []
    pool.submit(spend, 100, session="dear")
    pool.submit(order.append, "dear", session="dear")
    for _ in range(20):
        pool.submit(lambda: (order.append("cheap"), spend(1)), session="cheap")
    pool.go()
    pool.shutdown()
    assert order == ["cheap"] * 20 + ["dear"]


def test_a_long_job_lets_others_run_in_its_place(pool):
    begun, ended = threading.Event(), threading.Event()

    def long():
        begun.set()
        end = time.monotonic() + PATIENCE
        while not ended.is_set() and time.monotonic() < end:
            give_way()
        return ended.is_set()

    pool.go()
    found = pool.submit(long, session="long")
    assert begun.wait(PATIENCE)
    short = pool.submit(ended.set, session="short")
    assert found.result(PATIENCE)
    assert short.done()


def test_a_job_that_has_had_little_gives_no_way(spend, pool):
    ran = []

    def short():
        give_way()
        ran.append("short")

    pool.submit(short, session="a")
    pool.submit(ran.append, "other", session="b")
    pool.go()
    pool.shutdown()
    assert ran == ["short", "other"]


def test_a_job_gives_way_once_its_session_has_had_the_margin_more(spend):
    ran = []

    def long():
        pool.submit(ran.append, "other", session="b")
        for seconds in (1.0, 0.5, 0.6):
            spend(seconds)
            give_way()
            ran.append(seconds)

    with Workers("test", 1, margin=2.0) as pool:
        pool.submit(long, session="a").result(PATIENCE)
    assert ran == [1.0, 0.5, "other", 0.6]


def test_a_job_rests_while_one_of_a_session_that_has_had_less_runs_in_another_thread(spend):
    order, begun, end = [], threading.Event(), threading.Event()

    def light():
        begun.set()
        end.wait(PATIENCE)
        order.append("light")

    def heavy():
        spend(1.0)
        pool.submit(light, session="light")
        begun.wait(PATIENCE)
        threading.Timer(0.1, end.set).start()
        give_way()
        order.append("heavy")

    with Workers("test", 2) as pool:
        pool.submit(heavy, session="heavy").result(PATIENCE)
    assert order == ["light", "heavy"]


def test_a_job_rests_no_longer_than_until_the_other_session_has_had_as_much(spend):
    begun, end = threading.Event(), threading.Event()

    def light():
        begun.set()
        for _ in range(200):
            if end.wait(0.02):
                return True
            spend(0.1)
        return False

    def heavy():
        spend(1.0)
        running = pool.submit(light, session="light")
        begun.wait(PATIENCE)
        give_way()
        end.set()
        return running.result(PATIENCE)

    with Workers("test", 2) as pool:
        assert pool.submit(heavy, session="heavy").result(PATIENCE)


def test_giving_way_outside_a_pool_does_nothing(spend):
    before = own_time()
    give_way()
    assert own_time() == before


def test_the_own_time_of_a_job_stands_still_while_others_run_in_its_place(spend, pool):
    took = {}

    def job(name, *, seconds, then=None):
        begin = own_time()
        spend(seconds)
        if then:
            then()
            give_way()
        spend(seconds)
        took[name] = own_time() - begin

    def second():
        pool.submit(job, "c", seconds=100, session="c")

    def first():
        pool.submit(job, "b", seconds=10, then=second, session="b")

    pool.go()
    pool.submit(job, "a", seconds=1, then=first, session="a").result(PATIENCE)
    assert list(took.items()) == [("c", 200), ("b", 20), ("a", 2)]


def test_what_waits_or_comes_later_is_cancelled_with_the_pool_and_counted_no_more(pool):
    waiting = pool.submit(lambda: None)
    assert pool.jobs == 2
    pool.shutdown(wait=False, cancel_futures=True)
    pool.go()
    with pytest.raises(CancelledError):
        waiting.result(PATIENCE)
    assert pool.submit(lambda: None).cancelled()  # by a page that is still being built
    assert pool.jobs <= 1


def test_a_failure_reaches_who_asked_and_the_thread_goes_on(pool):
    pool.go()
    with pytest.raises(ZeroDivisionError):
        pool.submit(lambda: 1 / 0).result(PATIENCE)
    assert pool.submit(lambda: 1).result(PATIENCE) == 1


def queue_of(session, pool, solve, deliver=lambda move, result: None):
    with logs.in_session(session):
        return JobQueue(deliver, solve=solve, pool=pool, grace=60)


def test_a_session_that_always_has_a_job_waiting_does_not_keep_the_thread(pool):
    count, served = 0, threading.Event()

    def busy(setting, cancelled):
        nonlocal count
        count += 1
        if not served.is_set() and count < 10_000:
            abuser.submit(count, SETTING)

    abuser = queue_of("abuser", pool, busy)
    visitor = queue_of("visitor", pool, lambda setting, cancelled: served.set())
    abuser.submit(0, SETTING)
    visitor.submit(0, SETTING)
    pool.go()
    assert served.wait(PATIENCE)
    assert count < 10_000


def test_studies_of_two_sessions_grow_side_by_side(spend, monkeypatch):
    with Workers("test", 1) as pool:
        monkeypatch.setattr(study_job, "study_threads", lambda: pool)
        order, begin, ended = [], threading.Event(), threading.Semaphore(0)

        def grow(question, last, cancelled):
            for _ in range(5):
                spend(1)
                yield SimpleNamespace(share=0.5)
            ended.release()

        pool.submit(begin.wait, PATIENCE)
        for session in "ab":
            with logs.in_session(session):
                study_job.StudyJob(session, grow, lambda job, _: order.append(job.question), Cache(4))
        begin.set()
        for _ in range(2):
            assert ended.acquire(timeout=PATIENCE)
    assert {"".join(order[k : k + 2]) for k in (0, 2, 4)} <= {"ab", "ba"}
