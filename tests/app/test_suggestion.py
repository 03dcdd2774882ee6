"""Suggest K, D, Δτ: what is asked, withdrawn and told; the search itself is tested with the engine."""

import queue
import sys
import threading

import pytest
from vibroscope.app.explorer import suggestion
from vibroscope.app.explorer.state import Explorer, Refused
from vibroscope.app.explorer.suggestion import Search, question_of, told_of
from vibroscope.app.page.explore.suggesting import Suggesting
from vibroscope.engine import Cancelled, Recommendation
from vibroscope.engine.recommendation.trials import NewmarkSetting as Chosen
from vibroscope.engine.recommendation.trials import Trial

SETTING = Explorer().setting()
TRIAL = Trial(Chosen(10500.0, 15.8, 5793), 0.0486, 0.0494, 5793.0)


def found_for(question, *, met=True, best=TRIAL, front=(TRIAL,), joint=0.0, reason=""):
    system, eta, reference, located, tolerance = question
    return Recommendation(system, eta, reference, tolerance, located, met, best, front, joint, reason)


@pytest.fixture
def searches(monkeypatch):
    """`recommend` replaced by one that waits to be let go; what it was called with."""
    calls = queue.Queue()

    def recommend(system, eta, *, cancelled, progress, **asked):
        answer = queue.Queue()
        calls.put((eta, asked, progress, answer, cancelled))
        while answer.empty():
            if cancelled():
                raise Cancelled
        return answer.get()

    monkeypatch.setattr(suggestion, "recommend", recommend)
    monkeypatch.setattr(suggestion, "_KEPT", suggestion.Cache(2))
    return calls


class Desk:
    """A page that does at once what it is asked to do later, and remembers what was set."""

    def __init__(self):
        self.texts = []
        self.waiting = queue.Queue()

    def later(self, callback):
        self.waiting.put(callback)

    def offer(self):
        pass

    def set(self, texts):
        self.texts.append(texts)

    def catch_up(self):
        self.waiting.get(timeout=5)()


@pytest.mark.parametrize("percent", ["", "0", "101", "five", "nan", "1e400", None, 5])
def test_a_tolerance_that_is_none_is_refused(percent):
    with pytest.raises(Refused, match=r"tolerance must be a number from 0\.01 to 100"):
        question_of(SETTING, percent)


def test_a_question_does_not_depend_on_what_is_looked_for():
    asked = question_of(SETTING, "5")
    assert asked == question_of(SETTING._replace(K=10.0, D=1.0, steps=500, frame="absolute"), "5.0")
    assert asked != question_of(SETTING._replace(eta=1.1), "5")
    assert asked != question_of(SETTING._replace(located="yes"), "5")
    assert asked.tolerance == 0.05


def test_what_meets_the_tolerance_moves_the_sliders_once(searches):
    desk = Desk()
    suggesting = Suggesting(desk)
    suggesting.follow(SETTING)
    suggesting._ask("5")
    _, asked, progress, answer, _ = searches.get(timeout=5)
    assert (asked["stiffness_max"], asked["steps_max"]) == (1e5, 32_000)  # what the sliders reach
    progress(0.4)
    desk.catch_up()
    assert suggesting.view.told == {"phase": "running", "share": 0.4}
    answer.put(found_for(question_of(SETTING, "5")))
    desk.catch_up()
    assert desk.texts == [{"K": "10500", "D": "15.8", "steps": "5793"}]
    assert suggesting.view.told["phase"] == "done"
    suggesting.follow(SETTING._replace(K=10500.0, D=15.8, steps=5793))
    assert suggesting.view.told["phase"] == "done"  # the answer stands beside the setting that it gave


def test_the_front_can_be_taken_as_long_as_it_is_drawn(searches):
    desk = Desk()
    suggesting = Suggesting(desk)
    suggesting.follow(SETTING)
    suggesting._ask("5")
    other = Trial(Chosen(2000.0, 7.0, 500), 0.3, 0.31, 500.0)
    searches.get(timeout=5)[3].put(found_for(question_of(SETTING, "5"), front=(other, TRIAL)))
    assert suggesting.front == {}
    desk.catch_up()
    assert suggesting.front == {"steps": [500, 5793], "error": [0.3, 0.0486], "K": [2000, 10500], "D": [7, 15.8]}
    suggesting.follow(SETTING._replace(eta=1.2))
    assert suggesting.front == {}


def test_what_does_not_meet_it_moves_nothing_and_says_why(searches):
    desk = Desk()
    suggesting = Suggesting(desk)
    suggesting.follow(SETTING)
    suggesting._ask("5")
    searches.get(timeout=5)[3].put(
        found_for(question_of(SETTING, "5"), met=False, joint=0.077, reason="the joint damping alone makes 7.7 %")
    )
    desk.catch_up()
    told = suggesting.view.told
    assert desk.texts == []
    assert told["head"] == "An error of 5 % is not met"
    assert told["lines"][1] == "The joint damping alone makes 7.7 %."
    assert "errors cancel here" in told["lines"][2]  # the error found is less than the joint damping makes
    assert told["use"] == {"K": "10500", "D": "15.8", "steps": "5793"}


@pytest.mark.parametrize("change", [{"eta": 1.2}, {"d1": 0.01}, {"joint_damping": "derived"}, {"located": "yes"}])
def test_another_question_withdraws_the_search(searches, change):
    desk = Desk()
    suggesting = Suggesting(desk)
    suggesting.follow(SETTING)
    suggesting._ask("5")
    cancelled = searches.get(timeout=5)[4]
    suggesting.follow(SETTING._replace(K=77.0))
    assert not cancelled()
    suggesting.follow(SETTING._replace(**change))
    assert cancelled()
    assert suggesting.view.told == {"phase": "idle"}


def test_an_answer_on_its_way_when_the_question_changes_is_dropped(searches):
    desk = Desk()
    suggesting = Suggesting(desk)
    suggesting.follow(SETTING)
    suggesting._ask("5")
    searches.get(timeout=5)[3].put(found_for(question_of(SETTING, "5")))
    late = desk.waiting.get(timeout=5)
    suggesting.follow(SETTING._replace(eta=2.0))
    late()
    assert desk.texts == []
    assert suggesting.view.told == {"phase": "idle"}


def test_a_search_that_fails_says_so(monkeypatch):
    def broken(*_, **__):
        raise ValueError("no such luck")

    monkeypatch.setattr(suggestion, "recommend", broken)
    monkeypatch.setattr(suggestion, "_KEPT", suggestion.Cache(2))
    results = queue.Queue()
    Search(question_of(SETTING, "5"), None, lambda _, result: results.put(result))
    assert str(results.get(timeout=5)) == "no such luck"


def test_a_front_is_thinned_to_ten_and_keeps_the_best():
    front = tuple(Trial(Chosen(1000.0, 5.0, n), 1 / n, 1 / n, n) for n in range(100, 140))
    told = told_of(found_for(question_of(SETTING, "5"), front=front, best=front[17]))
    steps = [steps for steps, _, _ in told["front"]]
    assert len(steps) <= 10
    assert {100, 117, 139} <= set(steps)


def test_what_the_sliders_do_not_reach_is_not_offered():
    far = Trial(Chosen(1000.0, 500.0, 200), 0.01, 0.01, 200)
    told = told_of(found_for(question_of(SETTING, "5"), best=far, front=(far,)))
    assert (told["use"], told["front"]) == ({}, [])


@pytest.mark.skipif(sys.platform != "linux", reason="threads have a priority of their own on Linux only")
def test_searches_stand_back_behind_the_sliders():
    import os

    read = suggestion._threads().submit(lambda: os.getpriority(os.PRIO_PROCESS, threading.get_native_id()))
    assert read.result(timeout=5) > os.getpriority(os.PRIO_PROCESS, 0)
