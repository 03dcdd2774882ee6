"""``vibroscope branch --out``: branches are kept as they are found, and read by the next call."""

import json
from itertools import islice

import pytest
import xarray
from vibroscope.app.commands import branch
from vibroscope.engine import search_branches

from tests.app.command_line import run_command
from tests.few_seeds import few_seeds

WORDS = ("branch", "--from", "2.76", "--to", "2.81", "--max-period", "2", "--json")


@pytest.fixture(autouse=True)
def _few_seeds():
    with few_seeds():
        yield


def test_what_a_killed_search_had_found_is_kept_and_the_next_call_adds_the_rest(tmp_path, capsys, monkeypatch):
    out = str(tmp_path / "branches.zarr")

    def killed(question, **how):
        yield from islice(search_branches(question, **how), 1)
        raise RuntimeError("killed")

    monkeypatch.setattr(branch, "search_branches", killed)
    with pytest.raises(RuntimeError, match="killed"):
        run_command(capsys, *WORDS, "--out", out)
    kept = xarray.open_zarr(out, consolidated=False)
    assert (kept.attrs["complete"], kept.branch.values.max()) == (0, 0)
    monkeypatch.undo()
    code, text, error = run_command(capsys, *WORDS, "--out", out)
    report = json.loads(text)
    branches = report["branches"]
    assert (report["over"], report["solver"]) == ("eta", "reference")
    assert (code, len(branches), error) == (0, 2, "")
    whole = xarray.open_zarr(out, consolidated=False)
    assert whole.attrs["complete"] == 1
    assert whole.sizes["orbit"] == sum(each["orbits"] for each in branches)
    assert run_command(capsys, *WORDS, "--out", out)[1] == text


def test_what_is_no_such_search_is_refused(tmp_path, capsys):
    (tmp_path / "notes.txt").write_text("mine")
    code, _, error = run_command(capsys, *WORDS, "--out", str(tmp_path))
    assert (code, (tmp_path / "notes.txt").read_text()) == (2, "mine")
    assert "exists and is no result of such a search" in error


def test_a_search_that_finds_nothing_writes_that(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(branch, "search_branches", lambda question, **how: iter(()))
    out = str(tmp_path / "none.zarr")
    code, text, _ = run_command(capsys, *WORDS, "--out", out)
    assert (code, json.loads(text)["branches"]) == (0, [])
    kept = xarray.open_zarr(out, consolidated=False)
    assert (kept.attrs["complete"], kept.attrs["over"], kept.sizes["orbit"]) == (1, "eta", 0)
