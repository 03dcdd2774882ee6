"""The report: what a colleague needs to know, in this order, and no number that the system does not have."""

import re
from html import unescape

from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.suggestion import make_question
from vibroscope.app.export.report import Findings, as_report
from vibroscope.app.page.explore.suggest import Suggester

from tests.app.fakes import QueueingHost
from tests.app.fakes import send as click
from tests.app.searches import SETTING, found_for
from tests.app.test_contact_of_own_system import own, send
from tests.waiting import PATIENCE

SOURCE = {"program": "vibroscope", "made": "today", "address": "?eta=1"}


def report_of(setting, *suggestion):
    findings = Findings({"Do they agree?": "They differ by 41 %."}, suggestion)
    return as_report("Explore", findings, setting, [("<svg></svg>", "Displacements.")], ["cmd"], SOURCE)


def rows(report):
    return {
        unescape(label): unescape(text)
        for label, text in re.findall(r"<tr><th>(.*?)</th><td>(.*?)</td>", report.partition("<h2>Verdict")[0])
    }


def test_its_parts_stand_in_the_order_in_which_they_are_read():
    report = report_of(own(), "An error of 5 % is met.", "K = 4.9e7 N/m.")
    heads = re.findall(r"<h2>(.*?)</h2>", report)
    parts = ["System", "Question", "Verdict", "Figures", "Suggestion", "Limits", "How to reproduce these numbers"]
    assert heads == parts
    assert "<li>An error of 5 % is met.</li><li>K = 4.9e7 N/m.</li>" in report
    assert "no friction" in report
    assert "None was searched for" in report_of(own())


def test_the_numbers_are_those_that_were_entered():
    found = rows(report_of(send(own(), {"eta": {"typed": "18 Hz"}})))
    assert (found["m₁"], found["f₁"], found["AΩ²"], found["g₀"]) == ("0.8 kg", "22 Hz", "4 m/s²", "0.3 mm")
    assert (found["e"], found["f"], found["System"]) == ("0.6", "18 Hz", "a body and a wall")
    assert found["K"].endswith("N/m")
    assert found["2D"].endswith("N·s/m")
    assert found["Contact law"] == "Kelvin–Voigt"


def test_a_wall_has_no_numbers_of_a_second_body_and_newmark_none_of_others():
    found = rows(report_of(own()))
    assert not {"κ", "κ₃", "μ", "d₂", "d₃", "m₂", "F₁", "F₂", "P₂", "φ", "ρ∞", "α", "n", "δ_d", "s"} & found.keys()
    plain = rows(report_of(Setting()))
    assert {"κ", "κ₃", "d₂", "d₃"} <= plain.keys()
    assert not {"μ", "F₁", "ρ∞", "α", "s", "ω₁", "m₁", "A"} & plain.keys()


def test_masses_are_in_tonnes_beside_millimetres():
    setting = send(own(), {"units": "mm-t-s"})
    found = rows(report_of(setting))
    assert (found["m₁"], found["f₁"]) == ("0.0008 t", "22 Hz")
    typed = send(setting, {"mass1_kg": {"typed": "0.0016"}})
    assert typed.m1 == 1.6
    assert send(setting, {"mass1_kg": {"typed": "1600 g"}}).m1 == 1.6


def test_the_suggestion_is_that_of_the_page(searches):
    host = QueueingHost()
    suggester = Suggester(host)
    suggester.follow(SETTING)
    assert suggester.sentences == []
    click(suggester.view, {"suggest": {"tolerance": "5"}})
    answer = searches.get(timeout=PATIENCE)[3]
    answer.put(found_for(make_question(SETTING, {"tolerance": "5"})))
    host.catch_up_until(lambda: suggester.view.content["phase"] == "done")
    head, *lines = suggester.sentences
    assert head == "An error of 5 % is met."
    assert lines == suggester.view.content["lines"]
