"""``vibroscope sweep basin`` and ``basin-difference``: the contract for scripts, and what a person sees."""

import json

import numpy as np
import pytest
import xarray
from vibroscope.app.commands.cli import main

PLANE = ["--eta", "3.2", "--x", "xi2:-8:8:8", "--y", "v2:-8:8:6"]
SOLVERS = {"reference": ["--solver", "reference"], "exact": ["--solver", "exact", "--K", "12000", "--D", "18"]}


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    paths = {name: str(tmp_path_factory.mktemp("basins") / name) for name in SOLVERS}
    for name, path in paths.items():
        assert main(["sweep", "basin", *PLANE, *SOLVERS[name], "--out", path]) == 0
    return paths


def test_a_basin_as_the_contract_says(stores, capsys):
    assert main(["sweep", "basin", *PLANE, *SOLVERS["reference"], "--out", stores["reference"], "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert (answer["cells"], answer["reused"]) == (48, 48)
    assert [motion["period"] for motion in answer["motions"]] == [6, 2]
    assert sum(motion["share"] for motion in answer["motions"]) == pytest.approx(1)
    assert {"kind", "share_error", "start"} <= set(answer["motions"][0])
    assert answer["boundary_dimension"] is None  # of so few cells
    found = xarray.open_zarr(stores["reference"])
    assert found["motion"].sizes == {"xi2": 8, "v2": 6}
    np.testing.assert_array_equal(found["xi2"], np.linspace(-8, 8, 8))


def test_a_person_reads_the_shares(stores, capsys):
    main(["sweep", "basin", *PLANE, *SOLVERS["reference"], "--out", stores["reference"]])
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("period 6: ")
    assert lines[1].startswith("period 2: ")
    assert all("% of the starts" in line for line in lines[:2])


def test_the_share_in_which_two_solvers_differ(stores, capsys):
    reference = xarray.open_zarr(stores["reference"])
    assert main(["sweep", "basin-difference", *stores.values(), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["share"] == pytest.approx(float(reference["motion_share"][0]))
    assert answer["same"] == [[False], [True]]
    assert main(["sweep", "basin-difference", *stores.values()]) == 0
    said = capsys.readouterr().out
    assert f"{100 * answer['share']:.2f} ± {100 * answer['error']:.2f} % of the starts lead to different" in said
    assert said.count("not in the other") == 1
