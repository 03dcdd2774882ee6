"""``vibroscope paper``: one entry a claim, and an exit status that reports a surprise."""

import json
from dataclasses import replace

import pytest
from vibroscope.app.commands import cli, paper
from vibroscope.app.paper import CLAIMS


@pytest.fixture
def check_only(monkeypatch):
    """Check only these claims, some of them changed."""

    def choose(*keys, **changes):
        monkeypatch.setattr(
            paper, "CLAIMS", {key: replace(CLAIMS[key], **changes.get(f"of_{key}", {})) for key in keys}
        )

    return choose


def test_json_has_one_object_a_claim(check_only, capsys):
    check_only("4C", "14D")
    assert cli.main(["paper", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [(row["figure"], row["agrees"]) for row in rows] == [("Figure 4 [C]", True), ("Figure 14 [D]", False)]
    assert rows[0]["found"] == CLAIMS["4C"].find().result


def test_a_claim_that_is_not_as_known_gives_status_1(check_only, capsys):
    check_only("4C", "14D", of_14D={"holds": True})
    assert cli.main(["paper"]) == 1
    assert "1 NOT as known" in capsys.readouterr().out


def test_the_summary_counts_examples_apart(check_only, capsys):
    check_only("4C", "10B")
    assert cli.main(["paper"]) == 0
    out = capsys.readouterr().out
    assert "Figure 10 [B]  shown by example" in out
    assert "2 claims: 1 agree, 0 differ, 1 shown by example; all as known" in out
