"""Coexisting motions on Explore: what is searched, what is listed, and that a click leads to the motion."""

from dataclasses import replace
from itertools import islice

import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page import asker
from vibroscope.app.page.explore import other_motions
from vibroscope.app.page.explore.other_motions import CoexistingMotions
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.studies.coexisting import Coexisting, CoexistingQuestion, coexisting_content, search_coexisting
from vibroscope.engine.motions.search import STARTS

from tests.app.fakes import QueueingHost, send

SETTING = Setting(eta=3.2, K=12000.0, D=18.0, steps=500)
QUESTION = CoexistingQuestion.of(SETTING)
DONE = 12


@pytest.fixture(scope="module")
def result():
    *_, last = islice(search_coexisting(QUESTION, None, lambda: False), DONE)
    return last


def listed(content):
    return dict(content["solvers"])


def test_each_start_leads_the_run_of_the_page_to_its_motion(result):
    reference, penalty = listed(coexisting_content(result, SETTING)).values()
    assert {each["name"] for each in reference} == {"period 6", "period 2"}
    assert penalty
    for each in reference:
        run = compute_runs(read_setting(each["use"], SETTING), cache=Cache(8)).reference
        assert f"period {run.motion.period}" == each["name"]


def test_shares_are_those_of_the_starts_so_far_and_rest_is_the_first_start(result):
    assert (result.done, result.share) == (DONE, DONE / STARTS)
    for motions in result.found.values():
        assert sum(each.share for each in motions) == pytest.approx(1)
    content = coexisting_content(result, SETTING)
    assert content["head"].startswith(f"From {DONE} starts: 2 motions of the reference and ")
    assert [each["name"] for each in listed(content)["Reference"] if each["shown"]] == ["period 2"]


def test_the_list_names_the_integrator_that_is_set(result):
    hht = CoexistingQuestion.of(SETTING._replace(integrator="hht", law="flores"))
    for question, title in ((QUESTION, "Penalty (Newmark)"), (hht, "Penalty (HHT-α, Flores)")):
        assert list(listed(coexisting_content(replace(result, question=question), SETTING))) == ["Reference", title]


def test_the_list_is_in_the_units_of_the_setting(result):
    plain, physical = (
        coexisting_content(result, SETTING._replace(units=units))["solvers"][0][1][0]["text"]
        for units in ("none", "si")
    )
    assert "impulse" in plain
    assert "N·s" not in plain
    assert "N·s per period" in physical


def test_nothing_is_computed_until_asked_for_and_another_setting_closes_the_list(result, monkeypatch):
    asked = []

    def search(question, last, cancelled):
        asked.append(question)
        yield Coexisting(question, 1, result.found)
        yield Coexisting(question, STARTS, result.found)

    monkeypatch.setattr(other_motions, "search_coexisting", search)
    monkeypatch.setattr(asker, "RESULTS", Cache(2))
    host = QueueingHost()
    found = CoexistingMotions(host)
    found.follow(SETTING)
    assert asked == []
    assert found.view.content == {"phase": "idle"}
    send(found.view, {"find": True})
    assert found.view.content["phase"] == "running"
    host.catch_up()
    assert found.view.content["share"] == round(1 / STARTS, 2)
    host.catch_up()
    assert found.view.content["phase"] == "done"
    other = read_setting(listed(found.view.content)["Reference"][0]["use"], SETTING)
    found.follow(other)  # the start is none of what the motions depend on: it marks another row
    assert [each["shown"] for each in listed(found.view.content)["Reference"]] == [True, False]
    found.hide()
    assert found.view.content["phase"] == "done"
    found.follow(other._replace(eta=3.1))
    assert found.view.content == {"phase": "idle", "share": 0.0}
    assert asked == [QUESTION]


def test_a_search_that_is_stopped_keeps_its_list_and_one_that_is_left_ends(result, monkeypatch):
    def search(question, last, cancelled):
        yield Coexisting(question, 1, result.found)
        while not cancelled():
            yield Coexisting(question, 2, result.found)

    monkeypatch.setattr(other_motions, "search_coexisting", search)
    host = QueueingHost()
    found = CoexistingMotions(host)
    found.follow(SETTING._replace(K=13000.0))  # whose motions no other test has kept
    send(found.view, {"find": True})
    host.catch_up()
    send(found.view, {"stop": True})
    assert found.view.content["phase"] == "stopped"
    assert found.view.content["solvers"]
    send(found.view, {"find": True})
    found.hide()
    assert found.view.content["phase"] == "idle"
    found.close()
