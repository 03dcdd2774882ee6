"""One K, D and Δτ for a range of η: the question, and how the page shows the answer."""

import math

import pytest
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.suggestion import default_limits, make_question, suggestion_content
from vibroscope.engine import Recommendation, Served, SettingQuestion, System, Tolerances
from vibroscope.engine.facts import equation, stated
from vibroscope.engine.recommendation.trials import NewmarkSetting as Chosen
from vibroscope.engine.recommendation.trials import Trial

from tests.app.searches import CONTACTS

SETTING = Setting()
RANGE = {"tolerance": "20", "from": "2.7", "to": "2.76", "hold": "K"}


def test_one_setting_is_asked_for_a_range_and_follows_no_single_frequency():
    asked = make_question(SETTING._replace(K=5000.0), RANGE)
    assert asked.search.etas == (2.7, 2.715, 2.73, 2.745, 2.76)
    assert (asked.search.limits.stiffness, asked.search.limits.damping) == (5000.0, None)
    assert asked == asked.follow(SETTING._replace(eta=1.2))
    hertz = make_question(SETTING._replace(units="si", omega1=20.0), RANGE | {"from": "8.6 Hz", "to": "8.8"})
    assert hertz.search.etas[0] == pytest.approx(8.6 * 2 * math.pi / 20, rel=1e-5)


def test_the_limits_that_are_offered_ask_the_same_question_in_all_units():
    physical = SETTING._replace(units="mm-t-s", omega1=94.24777960769379, m1=2.0, amplitude=0.5)
    offered = {name: default_limits(physical)[name] for name in ("K", "steps")}
    assert make_question(physical, {"tolerance": "5"} | offered) == make_question(SETTING, {"tolerance": "5"})


@pytest.mark.parametrize(
    ("typed", "words"),
    [({"from": ""}, "η from must be"), ({"to": "x"}, "η to must be"), ({"to": "2.6"}, "η from must be less than η to")],
)
def test_a_range_has_two_ends_in_order(typed, words):
    with pytest.raises(Refused, match=words):
        make_question(SETTING, RANGE | typed)


def test_a_range_is_shown_with_its_limit_and_sets_the_steps_at_the_present_frequency():
    served = (Served(2.0, 150, 0.04, 0.041, CONTACTS, 0.5), Served(3.0, 100, 0.05, 0.06, CONTACTS, 0.5))
    trial = Trial(Chosen(5000.0, 12.0, 100), 0.05, 0.06, 100.0, CONTACTS)
    limit = stated("the range is limited at {}: an error of 5 % there, the largest part", equation("eta", 3.0))
    found = Recommendation(
        question=SettingQuestion(System(), [2.0, 3.0], Tolerances(0.1)),
        eta=3.0,
        met=True,
        best=trial,
        ranges={"damping": (11.0, 14.0)},
        front=(trial,),
        served=served,
        left_out=(2.5,),
        limit=limit,
    )
    content = suggestion_content(found, SETTING._replace(eta=1.5))
    assert content["head"] == "An error of 10 % over the range is met"
    assert content["use"] == {"K": "5000", "D": "12", "steps": "200"}  # of the same time step
    assert content["lines"][0].startswith("K = 5000, D = 12, Δτ = 0.02094, which is 100 steps a period at η = 3 and")
    assert content["lines"][1] == "The range is limited at η = 3: an error of 5 % there, the largest part."
    assert (
        content["lines"][2]
        == "Left out, since the reference does not repeat itself, or nothing touches there: η = 2.5."
    )
    assert content["lines"][3] == "Error: 4 % at η = 2, 5 % at η = 3."
    assert content["lines"][4] == "Met where one number alone is changed: D = 11 to 14 where K = 5000."
    physical = suggestion_content(found, SETTING._replace(eta=1.5, units="si", omega1=20.0))
    assert "Δt = 1.047 ms, which is 100 steps a period at f = 9.549 Hz" in physical["lines"][0]
    assert physical["lines"][1].startswith("The range is limited at f = 9.549 Hz:")
