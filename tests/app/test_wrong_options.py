"""Options that a command does not have, that have no effect, or that name a file which cannot be written."""

from pathlib import Path

import pytest
from vibroscope.app.commands import branch

from tests.app.command_line import run_command

MEASURED = Path(__file__).parents[2] / "assets" / "example-measurement.csv"
BRANCH = ("branch", "--from", "100", "--to", "200")


@pytest.fixture
def no_search(monkeypatch):
    """No branch is found, and none sought."""
    monkeypatch.setattr(branch, "search_branches", lambda question, **how: iter(()))


def test_eta_has_no_effect_on_branches_over_eta(capsys, no_search):
    status, _, err = run_command(capsys, *BRANCH, "--eta", "2.76")
    unless = "unless --initial or --from-basin begins there"
    assert (status, err) == (0, f"vibroscope: --eta has no effect where eta varies, {unless}\n")
    assert run_command(capsys, *BRANCH, "--eta", "150", "--initial", "0,0,0,0")[2] == ""


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("--series", "--series has no effect without --json"),
        (f"--series --json --measured {MEASURED}", "--series has no effect with --measured"),
        (f"--keep 5 --measured {MEASURED}", "--keep has no effect with --measured"),
    ],
)
def test_what_has_no_effect_on_a_comparison_is_said(capsys, more, words):
    comparison = "compare --eta 2.76 --K 12000 --D 18 --steps 2000 --periods 60"
    status, _, err = run_command(capsys, *comparison.split(), *more.split())
    assert (status, err) == (0, f"vibroscope: {words}\n")


def test_the_largest_k_has_no_effect_where_k_is_held(capsys):
    search = "recommend --eta 2.76 --K 12000 --K-max 100 --steps-max 16"
    status, _, err = run_command(capsys, *search.split())
    assert (status, err) == (0, "vibroscope: --K-max has no effect where --K is held\n")


def test_steps_have_no_effect_on_a_plane_without_a_time_step(capsys, tmp_path):
    words = "sweep plane --solver exact --eta 2.76 --K 100:200:2 --D 5:8:2 --transient 3 --sample 2 --no-error"
    status, _, err = run_command(capsys, *words.split(), "--steps", "100", "--out", str(tmp_path / "plane"))
    assert (status, err) == (0, "vibroscope: --steps has no effect on the exact solver\n")


def test_a_file_that_cannot_be_written_is_named(capsys, tmp_path):
    deck = tmp_path / "nowhere" / "deck.py"
    words = "export --to opensees --eta 2.76 --K 12000 --D 18 --steps 2000 --out"
    status, out, err = run_command(capsys, *words.split(), str(deck))
    assert (status, out, err) == (1, "", f"vibroscope export: {deck}: No such file or directory\n")
