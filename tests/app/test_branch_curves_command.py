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


def test_no_two_points_of_mirrored_motions_are_printed_alike(capsys, tmp_path):
    """Both halves of a branch through the symmetric motion double their period at one value."""
    path = tmp_path / "two.toml"
    numbers = "wall = true\nclearance_mm = 0.5\nclearance2_mm = 0.5\nrestitution = 0.8\nfrequency_Hz = 10.0\n"
    own = "mass1_kg = 25.0\nstiffness1_N_per_m = 98696.0\ndamping1_ratio = 0.07\nbase_acceleration_m_per_s2 = 1.0\n"
    path.write_text(f"[physical]\n{own}{numbers}")
    with few_seeds():
        code, text, _ = run_command(capsys, "branch", "--system", str(path), "--from", "0.9", "--to", "0.98")
    lines = text.splitlines()
    points = [line for line in lines if "multiplier" in line]
    assert code == 0
    assert len({point.partition("ξ₁")[0] for point in points}) < len(points)
    assert len(set(points)) == len(points)
    (stable,) = (line.partition("stable: ")[2] for line in lines if "stable: 0.93" in line)
    assert ", " not in stable
