"""``vibroscope peaks``: the largest values of both solutions, their spectra and the transmissibility as files."""

import csv
import json

import numpy as np
import pytest
from vibroscope.app.commands.cli import main
from vibroscope.engine import PEAKS

from tests.served import ROOT

OWN = ["peaks", "--system", str(ROOT / "docs/my.toml"), "--K", "584", "--D", "2", "--steps", "400"]


def rows_of(path):
    with path.open(newline="") as file:
        head, *rows = csv.reader(file)
    return dict(zip(head, np.array(rows, float).T, strict=True))


def test_it_prints_both_solutions_in_the_units_that_are_asked_for(capsys):
    assert main([*OWN, "--units"]) == 0
    text = capsys.readouterr().out
    force = next(line for line in text.splitlines() if line.startswith("contact force"))
    assert force.split()[2] == "-"  # of an impact
    assert force.endswith("N")
    assert main([*OWN, "--units", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["penalty"].keys() == {"status", *PEAKS}
    assert found["reference"]["contact_force"] is None
    newtons = found["physical"]["penalty"]["contact_force"]
    assert float(force.split()[3]) == pytest.approx(newtons, rel=1e-3)
    assert 900 < newtons < 1200
    assert found["penalty"]["closing_speed"] == pytest.approx(found["reference"]["closing_speed"], rel=0.2)


def test_spectra_and_transmissibility_are_files(tmp_path, capsys):
    spectra, ratios = tmp_path / "s.csv", tmp_path / "t.csv"
    assert main([*OWN, "--spectrum", str(spectra), "--transmissibility", str(ratios), "--eta-range", "0.5:2:4"]) == 0
    capsys.readouterr()
    found = rows_of(spectra)
    first = np.argmin(np.abs(found["order"] - 1))
    assert found["reference_displacement1"][first] > 10 * found["reference_displacement1"][first + 1]
    ratio = rows_of(ratios)
    assert ratio["eta"].tolist() == [0.5, 1.0, 1.5, 2.0]
    assert np.allclose(ratio["reference_body1"], ratio["penalty_body1"], rtol=0.2)
    assert np.allclose(ratio["reference_body2"], 1)  # the wall moves as the base does


def test_a_run_that_blows_up_is_a_result(capsys):
    diverged = ["peaks", "--eta", "2.76", "--K", "1e9", "--D", "1e3", "--steps", "20"]
    assert main(diverged) == 0
    assert "blew up" in capsys.readouterr().out
    assert main([*diverged, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["penalty"]["status"], found["penalty"]["contact_force"]) == ("diverged", None)
    assert found["reference"]["displacement1"] > 1


def test_a_free_vibration_is_looked_at_from_its_start(tmp_path, capsys):
    file = tmp_path / "thrown.toml"
    file.write_text("[system]\nwall = true\nclearance = 0.5\n[excitation]\nbase = 0\n")
    call = ["peaks", "--eta", "1", "--K", "1000", "--D", "5", "--steps", "2000", "--initial=-2,0,0,0"]
    assert main([*call, "--system", str(file), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["penalty"]["displacement1"] == pytest.approx(2, rel=0.01)


def test_a_spectrum_of_a_run_that_blows_up_is_refused_with_its_reason(capsys, tmp_path):
    asked = ["peaks", "--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "20"]
    assert main([*asked, "--spectrum", str(tmp_path / "s.csv")]) == 2
    assert "--spectrum needs both solutions: penalty: the run ended as diverged" in capsys.readouterr().err


@pytest.mark.parametrize(
    "command",
    [
        ["recommend", "--eta-range", "2:1:3"],
        ["peaks", "--eta", "2", "--K", "100", "--D", "5", "--steps", "50", "--eta-range", "2:1:3"],
    ],
)
def test_a_range_of_frequencies_begins_with_the_smaller_one(capsys, tmp_path, command):
    more = ["--transmissibility", str(tmp_path / "t.csv")] if command[0] == "peaks" else []
    assert main([*command, *more]) == 2
    assert "eta from 2 to 1 is an empty range: give the smaller number first" in capsys.readouterr().err
