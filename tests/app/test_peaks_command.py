"""``vibroscope peaks``: the largest values of both solutions, their spectra and the transmissibility as files."""

import csv
import json

import numpy as np
import pytest
from vibroscope.app.commands.cli import main
from vibroscope.app.commands.peaks import table_of_peaks
from vibroscope.engine import PEAKS, System

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


RELAY = """\
[physical]
mass1_kg = 0.0008
frequency1_Hz = 120.0
damping1_ratio = 0.02
wall = true
clearance_mm = 0.6
constant1_N = 0.9
restitution = 0.55
"""


def test_a_lasting_contact_is_compared_with_the_permanent_contact_of_the_reference(tmp_path, capsys):
    (tmp_path / "relay.toml").write_text(RELAY)
    contact = ["--K", "1e5 N/m", "--D", "3.4 N s/m", "--steps", "10 us"]
    assert main(["peaks", "--system", str(tmp_path / "relay.toml"), "--initial", "-0.6 mm,0,0,0", *contact]) == 0
    text = capsys.readouterr().out
    rows = {line[:16].strip(): line[16:].split() for line in text.splitlines()}
    reference, penalty = map(float, rows["impulse"][:2])
    assert penalty == pytest.approx(reference, rel=0.03)
    force, lasts = float(rows["contact force"][0]), float(rows["contact time"][0])
    assert force == pytest.approx(0.627, rel=1e-3)
    speed = float(rows["closing speed"][0])
    bounces = 0.0008 * speed * 1.55 / (1 - 0.55)  # each 0.55 times as fast, where the force between them is small
    assert reference == pytest.approx(force * lasts + bounces, rel=0.1)
    assert rows["contact force"][2] == "-"  # one of impacts beside one of permanent contact
    assert "its contact force is that of permanent contact" in text


def test_where_nothing_strikes_no_impact_is_explained(tmp_path, capsys):
    (tmp_path / "pressed.toml").write_text(
        "[physical]\nmass1_kg = 0.12\nfrequency1_Hz = 55.0\nwall = true\nclearance_mm = -2.0\n"
        "base_acceleration_g = 3\nfrequency_Hz = 40.0\n"
    )
    call = ["peaks", "--system", str(tmp_path / "pressed.toml"), "--K", "1e5 N/m", "--D", "3.4 N s/m"]
    assert main([*call, "--steps", "10 us"]) == 0
    text = capsys.readouterr().out
    assert "Over the last 16 periods" in text
    assert next(line for line in text.splitlines() if line.startswith("contact time")).split()[2:4] == ["0.4", "0.4"]
    assert "has no duration" not in text
    assert main([*OWN, "--units"]) == 0
    assert "An impact of the reference has no duration" in capsys.readouterr().out


def test_a_large_difference_stands_apart_from_the_number_beside_it():
    found = {"reference": dict.fromkeys(PEAKS, 0.01767), "penalty": dict.fromkeys(PEAKS, 1.0)}
    assert all(line.endswith(" 1 +more than 1000 %") for line in [*table_of_peaks(found, None, System())][1:])
