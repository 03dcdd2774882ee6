"""The tabs of studies without a browser: which studies they start, when, and what they refuse."""

import json

import pytest
from bokeh.events import Tap
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page import asker
from vibroscope.app.page.bifurcation.tab import Bifurcation
from vibroscope.app.page.study import tab as study
from vibroscope.app.page.study.basin import Basins
from vibroscope.app.page.study.plane import Plane
from vibroscope.app.page.study.speed import Speed
from vibroscope.app.page.study.time_step import TimeStep
from vibroscope.app.page.tab import Move
from vibroscope.app.page.take_away import file_writer
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.studies import speed

from tests.app.fakes import Asked, FakeHost

SETTING = Setting()


@pytest.fixture
def opened(monkeypatch):
    """A function from a class of tabs to one that is open, and its host."""
    Asked.all = ()
    monkeypatch.setattr(asker, "StudyJob", Asked)
    for module in (asker, study):
        monkeypatch.setattr(module, "RESULTS", Cache(8))  # without what other tests have computed

    def open_tab(kind):
        tab = kind(host := FakeHost())
        tab.build()
        tab.show(Move(1, SETTING))
        return tab, host

    return open_tab


CASES = {  # what asks anew, and what only moves a mark
    Bifurcation: ({"kappa": 2.4}, {"eta": 2.0}),
    Plane: ({"eta": 2.0}, {"K": 100.0, "D": 1.0}),
    Basins: ({"eta": 2.0}, {"start_xi2": 3.0}),
    TimeStep: ({"K": 100.0}, {"steps": 4000}),
    Speed: ({"steps": 4000}, {"located": "yes"}),
}


@pytest.mark.parametrize("kind", CASES)
def test_a_study_is_asked_anew_only_where_its_question_changes_and_the_last_is_cancelled(opened, kind):
    anew, mark = CASES[kind]
    tab, host = opened(kind)
    tab.show(Move(2, SETTING._replace(**mark)))
    assert len(Asked.all) == 1
    tab.show(Move(3, SETTING._replace(**anew)))
    assert [asked.cancelled for asked in Asked.all] == [True, False]
    assert host.moves == [1, 2, 3]  # every move is answered at once


@pytest.mark.parametrize("kind", CASES)
def test_a_hidden_study_is_cancelled_and_asks_for_nothing(opened, kind):
    tab, host = opened(kind)
    tab.hide()
    assert Asked.all[0].cancelled
    tab.panel.receive({"choose": dict(tab.panel.chosen)})
    tab.panel.receive({"stop": False})
    tab.refresh()  # as after a zoom
    Asked.all[0].deliver(Asked.all[0], ValueError("late"))
    assert len(Asked.all) == 1
    assert host.moves == [1]
    tab.show(Move(2, SETTING))
    assert len(Asked.all) == 2


@pytest.mark.parametrize("kind", CASES)
def test_a_failure_is_shown_in_words_and_can_be_tried_again(opened, kind):
    tab, host = opened(kind)
    Asked.all[0].deliver(Asked.all[0], ValueError("out of memory"))
    assert "out of memory" in host.errors[0]
    assert "the last picture stays" in tab.panel.status["text"]
    assert not tab.panel.status["running"]
    tab.panel.receive({"stop": False})
    assert len(Asked.all) == 2
    assert tab.panel.status["running"]


def test_what_comes_late_from_another_question_is_not_shown(opened):
    tab, _ = opened(Plane)
    tab.show(Move(2, SETTING._replace(eta=2.0)))
    first = Asked.all[0]
    result = next(first.grow(first.question._replace(K=(1e3, 1e4)), None, lambda: False))
    first.deliver(first, result)
    assert tab.result is not result
    assert tab.figures() == []


def test_a_study_says_what_it_shows_of_a_setting_once_all_is_known_and_that_it_computes_before(opened, monkeypatch):
    monkeypatch.setattr(speed, "ROUNDS", (1,))
    tab, host = opened(Speed)
    assert tab.summary(SETTING) == "Computing."
    asked = Asked.all[0]
    for result in asked.grow(asked.question, None, lambda: False):
        asked.deliver(asked, result)
    assert host.summary == tab.summary(SETTING)
    assert "Without a time step: " in host.summary
    assert tab.summary(SETTING._replace(K=100.0)) == "Computing."


def test_the_data_of_a_study_are_taken_away(opened, monkeypatch, tmp_path):
    monkeypatch.setenv("VIBROSCOPE_CACHE_DIR", str(tmp_path))  # where no other test has kept the whole plane
    tab, _ = opened(Plane)
    asked = Asked.all[0]
    asked.deliver(asked, next(asked.grow(asked.question, None, lambda: False)))
    taken = json.loads(file_writer(tab, "json", SETTING, "?")()["text"])["data"]
    assert len(taken["K"]) == len(taken["penalty"]["period"][0]) == 64
    assert None in taken["exact"]["period"][1]  # not computed yet
    assert taken["exact"]["period"][0][0] is not None


@pytest.mark.parametrize(
    "asked",
    [{"quantity": "__class__"}, {"quantity": 1}, {"limit": float("nan")}, {"limit": 1e9}, {"limit": True}, {"x": 1}],
)
def test_a_forged_choice_changes_nothing(opened, asked):
    tab, _ = opened(Plane)
    assert tab.panel.allowed(asked) == {"quantity": "error", "limit": 30, "curves": "off"}
    changed = {"quantity": "period", "limit": "12", "curves": "on"}
    assert tab.panel.allowed(changed) == {"quantity": "period", "limit": 12, "curves": "on"}


def test_a_click_sets_what_can_be_set(opened):
    tab, host = opened(Plane)
    tab.on_tap(Tap(None, x=1e9, y=5.432))
    assert host.settings == [{"K": "100000", "D": "5.43"}]
    tab.on_tap(Tap(None, x=float("nan"), y=5.432))
    assert len(host.settings) == 1
