"""A study in the background: results in order, cancelled, resumed, failed, out of time, and behind the sliders."""

import os
import queue
import sys
import threading
from dataclasses import dataclass

import pytest
from vibroscope.app.runtime import logs
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.studies import study_job
from vibroscope.engine import Cancelled

from tests.waiting import PATIENCE


@dataclass(frozen=True)
class Count:
    """A partial result: counted so far."""

    number: int

    @property
    def share(self):
        return self.number / 4


def count(question, last, cancelled):
    for number in range(1 if last is None else last.number + 1, 5):
        if cancelled():
            raise Cancelled
        yield Count(number)


def collect(grow, results=None, question="q"):
    delivered = queue.Queue()
    results = Cache(48) if results is None else results
    return study_job.StudyJob(question, grow, lambda job, result: delivered.put(result), results), delivered


def idle():
    """Wait until all threads of the studies have come to rest."""
    rest = threading.Barrier(study_job.THREADS + 1)
    for _ in range(study_job.THREADS):
        study_job.study_threads().submit(rest.wait, 5)
    rest.wait(PATIENCE)


def test_results_come_in_order_and_the_last_is_remembered():
    results = Cache(48)
    _, delivered = collect(count, results)
    assert [delivered.get(timeout=PATIENCE).number for _ in range(4)] == [1, 2, 3, 4]
    assert results.get("q").number == 4


def test_what_was_cancelled_goes_on_where_it_was():
    results, held, go = Cache(48), threading.Event(), threading.Event()

    def slow(question, last, cancelled):
        for result in count(question, last, cancelled):
            yield result
            held.set()
            assert go.wait(PATIENCE)

    job, delivered = collect(slow, results)
    assert delivered.get(timeout=PATIENCE).number == 1
    assert held.wait(PATIENCE)
    job.cancel()
    go.set()
    idle()
    _, rest = collect(count, results)
    assert [rest.get(timeout=PATIENCE).number for _ in range(3)] == [2, 3, 4]
    assert delivered.empty()


class Held:
    """`count`, which waits for a permit before each number, and keeps what it computed."""

    def __init__(self):
        self.computed, self.begun, self.go = [], queue.Queue(), threading.Semaphore(0)

    def __call__(self, question, last, cancelled):
        for number in range(1 if last is None else last.number + 1, 5):
            self.begun.put(number)
            assert self.go.acquire(timeout=PATIENCE)
            if cancelled():
                raise Cancelled
            self.computed.append(number)
            yield Count(number)


def test_who_asks_what_another_computes_waits_for_the_same_results():
    results, held = Cache(48), Held()
    _, first = collect(held, results)
    assert held.begun.get(timeout=PATIENCE) == 1
    _, second = collect(held, results)
    _, other = collect(count, results, "another question")
    held.go.release(4)
    for delivered in (first, second, other):
        assert [delivered.get(timeout=PATIENCE).number for _ in range(4)] == [1, 2, 3, 4]
    idle()
    assert held.computed == [1, 2, 3, 4]
    assert first.empty()
    assert second.empty()


def test_who_waits_computes_on_where_the_other_was_cancelled():
    results, held = Cache(48), Held()
    job, first = collect(held, results)
    waiting = [collect(held, results) for _ in range(3)]
    held.go.release()
    assert first.get(timeout=PATIENCE).number == 1
    job.cancel()
    waiting[0][0].cancel()
    held.go.release(4)  # one of them for the slice that ends with the cancelled job
    for _, delivered in waiting[1:]:
        assert [delivered.get(timeout=PATIENCE).number for _ in range(4)] == [1, 2, 3, 4]
    idle()
    assert held.computed == [1, 2, 3, 4]
    assert first.empty()
    _, again = collect(held, results)  # nobody computes it any more, and nothing is left to compute
    assert again.get(timeout=PATIENCE).number == 4
    idle()
    assert held.computed == [1, 2, 3, 4]


def test_who_waits_learns_of_a_failure_and_computes_on_where_the_other_has_no_time_left(monkeypatch):
    failing, go = Cache(48), threading.Event()

    def broken(question, last, cancelled):
        assert go.wait(PATIENCE)
        raise ValueError("eta = 9 is too large")
        yield

    both = [collect(broken, failing)[1] for _ in range(2)]
    go.set()
    assert ["too large" in str(delivered.get(timeout=PATIENCE)) for delivered in both] == [True, True]

    monkeypatch.setattr(study_job, "SECONDS", -1.0)
    results, held = Cache(48), Held()
    (first, one), (second, two) = (collect(held, results) for _ in range(2))
    held.go.release(2)
    assert one.get(timeout=PATIENCE).number == 1
    assert [two.get(timeout=PATIENCE).number for _ in range(2)] == [1, 2]
    idle()
    assert (first.out_of_time, second.out_of_time) == (True, True)
    assert one.empty()


def test_a_failure_is_delivered_and_logged_and_the_thread_goes_on(caplog):
    def broken(question, last, cancelled):
        yield Count(1)
        raise ValueError("eta = 9 is too large")

    with logs.in_session("3f2a91cc"):
        _, delivered = collect(broken)
    assert delivered.get(timeout=PATIENCE).number == 1
    assert "too large" in str(delivered.get(timeout=PATIENCE))
    assert [(record.message, record.details) for record in caplog.records] == [
        ("failed", {"session": "3f2a91cc", "job": "study"})
    ]
    assert collect(count)[1].get(timeout=PATIENCE).number == 1


def test_a_study_that_takes_too_long_stops_and_says_so(monkeypatch):
    monkeypatch.setattr(study_job, "SECONDS", -1.0)
    job, delivered = collect(count)
    assert delivered.get(timeout=PATIENCE).number == 1
    idle()
    assert job.out_of_time
    assert delivered.empty()


@pytest.mark.skipif(sys.platform != "linux", reason="priorities of single threads")
def test_studies_and_the_threads_they_start_stand_behind_all_others():
    def priorities():
        found = [os.getpriority(os.PRIO_PROCESS, threading.get_native_id())]
        child = threading.Thread(
            target=lambda: found.append(os.getpriority(os.PRIO_PROCESS, threading.get_native_id()))
        )
        child.start()
        child.join()
        return found

    own = os.getpriority(os.PRIO_PROCESS, threading.get_native_id())
    behind = study_job.study_threads().submit(priorities).result(PATIENCE)
    assert behind[0] == behind[1] > own
