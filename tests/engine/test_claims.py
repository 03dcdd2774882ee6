"""A share of the check of `make release`: what a verdict says of settings drawn at random is so."""

from dataclasses import replace

import pytest
from vibroscope.engine import Newmark, System

from tests.answers import compared, verdict_of
from tests.claims.__main__ import judged
from tests.claims.judge import FALSE, judge_words
from tests.claims.sentences import changes_in
from tests.claims.settings import Setting
from tests.share import every

SETTINGS = (0, 3, 5, 8, 9, 11, 13)  # quick ones: a wall, a located step, another integrator and law


@pytest.mark.parametrize("number", every(SETTINGS))
def test_what_a_verdict_says_is_so(number):
    assert [each for each in judged(number) if each.outcome != "true"] == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("K is to blame: K = 23000 leaves 2.5 %.", [("K", 0.025)]),
        ("K, D and the time step have to be changed together: K = 1e+05, D = 26.5, 4,000 steps a period leave 3.3 %; "
         "alone at best no time step leaves 43 %.", [("several", 0.033), ("limit", 0.43)]),
        ("The contact status at the start of the step is to blame: steps cut where contact changes would leave 2 % "
         "(8,000 steps a period 2.5 %).", [("status", 0.02), ("steps", 0.025)]),
        ("The joint damping is to blame: without it 4.3 % would be left; neither K nor D nor the step mends it.",
         [("joint damping", 0.043)]),
        ("The time step is to blame: without it 1 % would be left, or 900 steps a period leave 3 %.",
         [("limit", 0.01), ("steps", 0.03)]),
        ("if one number alone is changed: K = 3600 7.8 %; status located 12 %; integrator newmark 9 %; "
         "law limited 10 %; no joint damping of its own 68 %.",
         [("K", 0.078), ("status", 0.12), ("integrator", 0.09), ("law", 0.1), ("joint damping", 0.68)]),
    ],
)  # fmt: skip
def test_the_sentences_are_read(text, found):
    assert [(each.name, pytest.approx(each.left)) for each in changes_in(text)] == found


WRONG = [  # what was said of these settings once, and the row that finds it out
    (3.69, Newmark(66, 21, 1000), "No number alone halves it: at best D = 1.2 leaves 55 %.", (), "a3"),
    (2.3, Newmark(70000, 6, 1000), "D is to blame: D = 38.9 leaves 71 %.", ("D",), "a2"),
    (2.48, Newmark(90, 40, 1000), "D is to blame: D = 1.4 leaves 9 %.", ("D",), "a1"),
    (3.69, Newmark(66, 21, 1000), "No K, D or time step that was tried leaves less together", (), "a8"),
    (1.08, Newmark(100, 50, 2000), "They disagree: with 3 contacts a period for 10 impacts.", (), "d2"),
    (2.76, Newmark(12000, 18, 2000), "The time step blurs each point of the section (ξ₂ by ±0.01).", (), "b"),
]


@pytest.mark.parametrize(("eta", "method", "headline", "blame", "row"), every(WRONG))
def test_what_is_not_so_is_found_out(eta, method, headline, blame, row):
    found = compared(System(), eta, method)
    words = replace(verdict_of(System(), eta, method), headline=headline, blame=blame, together=False, details=())
    wrong = [each.row for each in judge_words(Setting(System(), eta, method), found, words) if each.outcome == FALSE]
    assert row in wrong
