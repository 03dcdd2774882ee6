"""The last question alone is asked, after its rest; what was asked before is cancelled, or never begun."""

import queue
import threading
import time
from unittest.mock import Mock

import pytest
from vibroscope.app.page.asker import Asker
from vibroscope.app.page.tab import on_loop
from vibroscope.app.runtime import logs
from vibroscope.app.runtime.job import Answer
from vibroscope.app.runtime.workers import Workers
from vibroscope.engine import Cancelled

from tests.app.fakes import Document, FakeHost, QueueingHost
from tests.waiting import PATIENCE


class Timers(Document):
    """Keeps what should be called after a rest."""

    def __init__(self):
        super().__init__()
        self.waiting = []

    def add_timeout_callback(self, callback, _):
        self.waiting.append(callback)


class Job:
    def __init__(self, name, begun):
        self.cancelled = False
        begun.append(name)

    def cancel(self):
        self.cancelled = True


@pytest.mark.parametrize("rest", [0, 100])
def test_the_last_question_alone_is_asked(rest):
    doc, begun = Timers(), []
    asker = Asker(FakeHost(doc=doc), rest)

    def pass_time():
        waiting, doc.waiting = doc.waiting, []
        for callback in waiting:
            callback()

    asker.ask(lambda: Job("first", begun))
    pass_time()
    first = asker.job
    asker.ask(lambda: Job("second", begun))
    assert first.cancelled
    asker.ask(lambda: Job("third", begun))
    pass_time()
    assert begun == (["first", "third"] if rest else ["first", "second", "third"])
    assert not asker.job.cancelled
    asker.ask(lambda: Job("fourth", begun))
    asker.drop()
    pass_time()
    assert asker.job is None
    assert begun[-1] == ("third" if rest else "fourth")


@pytest.fixture
def pool():
    with Workers("test", 1) as pool:
        yield pool


def test_what_is_dropped_stops_and_the_next_answer_comes_part_by_part(pool):
    host, taken, started, stopped = QueueingHost(), [], threading.Event(), threading.Event()
    asker = Asker(host)

    def solve(question, cancelled, report):
        report(f"part of {question}")
        started.set()
        while question == "slow":
            if cancelled():
                stopped.set()
                raise Cancelled
            time.sleep(0.002)
        return f"all of {question}"

    def ask(question):
        take = on_loop(host, lambda _, found: taken.append(found))
        asker.ask(lambda: Answer(question, solve, take, pool, "test"))

    ask("slow")
    assert started.wait(PATIENCE)
    ask("next")
    assert stopped.wait(PATIENCE)
    for _ in range(3):  # a part of the first was on its way
        host.catch_up()
    assert taken == ["part of next", "all of next"]


def test_an_answer_is_logged_with_its_session_and_measured_where_it_succeeds(pool, caplog):
    caplog.set_level("INFO", logger="vibroscope")
    delivered, measure = queue.Queue(), Mock()

    def solve(question, cancelled, report):
        if question == "broken":
            raise RuntimeError(question)
        return question

    with logs.in_session("3f2a91cc"):
        for question in ("broken", "right"):
            Answer(question, solve, lambda _, found: delivered.put(str(found)), pool, "test", measure=measure)
    assert [delivered.get(timeout=PATIENCE) for _ in range(2)] == ["broken", "right"]
    logged = [(record.message, record.details["job"], record.details["session"]) for record in caplog.records]
    assert logged == [("failed", "test", "3f2a91cc"), ("done", "test", "3f2a91cc")]
    assert measure.add.call_count == 1
