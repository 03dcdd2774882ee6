"""What a search has found so far is no result, and a result sets back nothing that was moved meanwhile."""

import pytest
from vibroscope.app.explorer.suggestion import make_question
from vibroscope.app.page.explore.suggest import Suggester

from tests.app.fakes import QueueingHost, send
from tests.app.searches import SETTING, TRIAL, WORSE, found_for
from tests.waiting import PATIENCE


def test_what_is_found_so_far_is_shown_in_the_units_of_the_page(searches):
    host = QueueingHost()
    suggester = Suggester(host)
    suggester.follow(SETTING._replace(units="mm-t-s", omega1=20.0, m1=3.0))  # K counts 1.2 N/mm
    send(suggester.view, {"suggest": {"tolerance": "5"}})
    _, asked, progress, answer, _ = searches.get(timeout=PATIENCE)
    asked["partial"]([WORSE], SETTING.eta)
    progress(0.4)
    host.catch_up()
    content = suggester.view.content
    assert content["lines"] == ["So far: K = 2400 N/mm, 2D = 0.84 N·s/mm, T/Δτ = 500 steps a period: error 30 %."]
    asked["partial"]([WORSE, TRIAL], SETTING.eta)
    progress(0.6)
    host.catch_up()
    content = suggester.view.content
    assert (content["phase"], content["share"]) == ("running", 0.6)
    assert content["lines"][0].startswith("So far: K = 12600 N/mm, 2D = 1.896 N·s/mm, T/Δτ = 5,793 ")
    assert content["lines"][0].endswith("error 4.9 %; fewer steps may do.")
    assert [steps for steps, *_ in content["front"]] == [500, 5793]
    assert suggester.front == {}  # nothing to take away yet
    assert host.settings == []
    answer.put(found_for(make_question(SETTING, {"tolerance": "5"}), front=(WORSE, TRIAL)))
    host.catch_up()
    assert suggester.view.content["phase"] == "done"
    assert "So far" not in suggester.view.content["lines"][0]


def test_a_range_shows_what_is_found_so_far_with_the_steps_at_the_present_frequency(searches):
    host = QueueingHost()
    suggester = Suggester(host)
    suggester.follow(SETTING._replace(eta=1.5))
    send(suggester.view, {"suggest": {"tolerance": "5", "from": "1.5", "to": "3.1"}})
    _, asked, progress, _, _ = searches.get(timeout=PATIENCE)
    asked["partial"]([WORSE, TRIAL], 3.0)  # at 3.1 there is no error
    progress(0.4)
    host.catch_up()
    content = suggester.view.content
    assert content["phase"] == "running"
    assert "T/Δτ = 5,793 steps a period at η = 3 and more below: error 4.9 %; fewer" in content["lines"][0]
    assert [texts["steps"] for _, _, texts, *_ in content["front"]] == ["1000", "11586"]


@pytest.mark.parametrize("moved", [{"K": 77.0}, {"D": 7.0}, {"steps": 700}])
def test_a_result_is_offered_and_not_set_where_the_sliders_were_moved_meanwhile(searches, moved):
    host = QueueingHost()
    suggester = Suggester(host)
    suggester.follow(SETTING)
    send(suggester.view, {"suggest": {"tolerance": "5"}})
    answer = searches.get(timeout=PATIENCE)[3]
    suggester.follow(SETTING._replace(**moved))
    answer.put(found_for(make_question(SETTING, {"tolerance": "5"})))
    host.catch_up()
    content = suggester.view.content
    assert (content["met"], content["moved"], host.settings) == (True, True, [])
    assert content["use"] == {"K": "10500", "D": "15.8", "steps": "5793"}
    suggester.follow(SETTING._replace(units="si", **moved))
    assert suggester.view.content["moved"]
    send(suggester.view, {"suggest": {"tolerance": "6"}})  # from where they are now
    searches.get(timeout=PATIENCE)[3].put(found_for(make_question(SETTING, {"tolerance": "6"})))
    host.catch_up()
    assert (suggester.view.content["moved"], len(host.settings)) == (False, 1)
