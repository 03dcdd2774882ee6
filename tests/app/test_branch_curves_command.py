"""``vibroscope branch --along``: curves in two numbers on the command line."""

import json

from vibroscope.app.commands import branch
from vibroscope.engine import search_branches

from tests.app.command_line import run_command
from tests.few_seeds import few_seeds

WORDS = ("branch", "--solver", "exact", "--D", "18", "--K", "12000", "--eta", "2.76")
WORDS = (*WORDS, "--from", "2.7", "--to", "2.8", "--max-period", "1", "--along", "K")
RANGE = ("--along-from", "4000", "--along-to", "40000")


def test_curves_stand_beside_the_branches_and_a_lost_point_with_its_reason(capsys, monkeypatch):
    branches = []

    def search(question, **how):
        for found in search_branches(question, **how):
            branches.append(found)
            yield found

    monkeypatch.setattr(branch, "search_branches", search)
    with few_seeds():
        code, text, _ = run_command(capsys, *WORDS, *RANGE, "--json")
    found = json.loads(text)
    (curve,) = found["curves"]
    assert (code, curve["kind"], found["not_followed"]) == (0, "period doubling", [])
    assert max(curve["eta"]) == 2.8

    def lost(self, point):
        raise ValueError("the orbit is not found again")

    monkeypatch.setattr(branch, "search_branches", lambda *_, **__: branches)
    monkeypatch.setattr(branch.PointCurves, "follow", lost)
    code, text, _ = run_command(capsys, *WORDS, *RANGE, "--json")
    found = json.loads(text)
    assert (code, found["curves"]) == (0, [])
    assert found["not_followed"][0]["reason"] == "the orbit is not found again"
    assert found["branches"]
