"""``vibroscope branch --from-basin``: motions that a study of basins found, where the search finds none."""

import json

import numpy as np
import pytest
from vibroscope.app.commands import branch
from vibroscope.app.commands.branch import passes, read_basin
from vibroscope.engine import BasinStudy, BranchQuestion, Reference, System, continue_branch, sweep

from tests.app.command_line import run_command

ETA = 3.2  # two motions of the reference coexist
WORDS = ("branch", "--solver", "reference", "--from", "3.195", "--to", "3.205", "--max-period", "8", "--json")


@pytest.fixture(scope="module")
def basin(tmp_path_factory):
    path = str(tmp_path_factory.mktemp("basin") / "found.zarr")
    axis = np.linspace(-8, 8, 6)
    sweep(BasinStudy.over(System(), Reference(), ETA, {"xi2": axis, "v2": axis}), out=path)
    return path


def test_motions_on_no_branch_are_followed_and_those_on_one_are_not(basin, capsys, monkeypatch):
    seeds = read_basin(basin)
    assert len(seeds.sections) == 2
    first = continue_branch(
        BranchQuestion(System(), ETA, Reference(), low=3.195, high=3.205, initial=seeds.sections[0][0])
    )
    counts = []
    for found in ([], [first]):
        monkeypatch.setattr(branch, "search_branches", lambda *_, found=found, **__: iter(found))
        code, text, _ = run_command(capsys, *WORDS, "--from-basin", basin)
        branches = json.loads(text)["branches"]
        counts.append((code, len(branches), len(found)))
        for rows in seeds.sections:
            assert any(each["period"] == len(rows) for each in branches)
    assert counts == [(0, 2, 0), (0, 2, 1)]


def test_a_motion_lies_on_its_branch_from_whichever_period_it_is_seen(basin):
    for rows in read_basin(basin).sections:
        found = continue_branch(BranchQuestion(System(), ETA, Reference(), low=3.195, high=3.205, initial=rows[0]))
        assert passes(found, ETA, rows)
        assert passes(found, ETA, np.roll(rows, 1, axis=0))
        assert not passes(found, ETA, rows + 0.1)
        assert not passes(found, 3.3, rows)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--eta", "3.21"), "is of eta = 3.2"),
        (("--restitution", "0.6"), "is of restitution = 0.5"),
        (("--from", "3.202"), "lies outside"),
    ],
)
def test_basins_of_another_problem_are_refused(basin, capsys, more, said):
    code, _, error = run_command(capsys, *WORDS, "--from-basin", basin, *more)
    assert (code, said in error) == (2, True)
