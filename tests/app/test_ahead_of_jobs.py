"""Background jobs rest while a page is built, and work on in between if pages never end."""

import threading
import time

import pytest
from vibroscope.app.explorer import compute
from vibroscope.app.explorer.compute import JobQueue
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime import workers
from vibroscope.app.runtime.job import Answer
from vibroscope.app.runtime.workers import Workers, ahead_of_jobs, give_way, own_time, stand_aside

from tests.waiting import PATIENCE


@pytest.fixture
def pool():
    with Workers("test", 1) as pool:
        yield pool


def test_a_job_rests_until_what_is_ahead_of_it_ends_and_its_own_time_stands_still(pool):
    order, asked = [], threading.Event()

    def job():
        begun = own_time()
        asked.set()
        stand_aside()
        order.append("job")
        return own_time() - begun

    with ahead_of_jobs(), ahead_of_jobs():
        running = pool.submit(job)
        asked.wait(PATIENCE)
        time.sleep(0.8)
        order.append("page")
    assert running.result(PATIENCE) < 0.6
    assert order == ["page", "job"]


def test_pages_without_end_leave_a_job_half_of_its_time(pool, monkeypatch):
    monkeypatch.setattr(workers, "LONGEST_REST", 0.1)

    def job():
        rests = []
        begun = time.monotonic()
        while len(rests) < 3 or time.monotonic() < begun + 1.0:
            before = time.monotonic()
            stand_aside()
            if (rest := time.monotonic() - before) > 0.05:
                rests.append(rest)
        return rests, time.monotonic() - begun

    with ahead_of_jobs():
        rests, all_of_it = pool.submit(job).result(PATIENCE)
    assert sum(rests[:-1]) < 0.6 * all_of_it  # it has not worked as long as the last one, yet


def test_where_nothing_is_ahead_no_job_rests(pool):
    with pytest.raises(ZeroDivisionError), ahead_of_jobs():
        raise ZeroDivisionError
    waited = pool.submit(lambda: (time.monotonic(), stand_aside(), time.monotonic())).result(PATIENCE)
    assert waited[2] - waited[0] < 0.5


def test_a_figure_that_is_solved_waits_for_no_page(pool):
    """What a move waits for gives way to lighter sessions alone."""

    def solved():
        begun = time.monotonic()
        give_way()
        return time.monotonic() - begun

    with ahead_of_jobs():
        assert pool.submit(solved).result(PATIENCE) < workers.LONGEST_REST / 2


def test_an_explanation_rests_while_figures_are_solved(pool, monkeypatch):
    order, solving = [], threading.Event()

    def solve(setting, cancelled):
        solving.set()
        time.sleep(0.4)
        order.append("figures")
        return setting

    def explain(setting, cancelled, report):
        solving.wait(PATIENCE)
        cancelled()
        order.append("explanation")
        return setting

    with Workers("figures", 1) as figures:
        monkeypatch.setattr(compute, "workers", lambda: figures)
        ended = threading.Event()
        Answer(Setting(), explain, lambda *_: ended.set(), pool, "explanation")
        JobQueue(lambda *_: None, solve=solve).submit(0, Setting())
        assert ended.wait(PATIENCE)
    assert order == ["figures", "explanation"]
