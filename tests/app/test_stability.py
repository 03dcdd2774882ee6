"""``vibroscope stability``: what it prints and how it ends; the cases themselves are tested with the engine."""

import json
from dataclasses import replace

import pytest
from vibroscope.app.commands import cli, stability
from vibroscope.engine import Status
from vibroscope.engine.hardcases.cases import hard_cases
from vibroscope.engine.hardcases.judgement import outcome


@pytest.fixture
def three_cases(monkeypatch):
    """A solved case, one that blows up, and one that fails."""
    cases = {case.name: case for case in hard_cases()}
    chosen = [cases["start: start|separated|reference"], cases["K Δτ² ≫ 1: blows up"]]
    outcomes = [outcome(case) for case in [*chosen, replace(chosen[0], statuses=(Status.PILED_UP,))]]

    monkeypatch.setattr(stability, "hard_cases", lambda: outcomes)
    monkeypatch.setattr(stability, "outcome", lambda case: case)
    return outcomes


def test_the_table_says_what_failed_and_exits_with_1(three_cases, capsys):
    assert cli.main(["stability"]) == 1
    printed = capsys.readouterr().out
    assert "start: start|separated|reference" in printed
    assert "✗ ended as ok, not piled-up" in printed
    assert "3 cases, 1 NOT as expected" in printed


def test_json_has_no_number_that_json_does_not_know(three_cases, capsys):
    assert cli.main(["stability", "--json"]) == 1
    solved, blown, failed = json.loads(capsys.readouterr().out)
    assert solved["passed"]
    assert 0 < solved["error"] < solved["allowed"]
    assert 0 < solved["residual"] < solved["balanced"]
    assert blown["status"] == "diverged"
    assert "step" in blown["message"]
    assert blown["error"] is None
    assert not failed["passed"]


def test_without_failures_it_exits_with_0(three_cases, capsys):
    three_cases.pop()
    assert cli.main(["stability"]) == 0
    assert "2 cases, all as expected" in capsys.readouterr().out
