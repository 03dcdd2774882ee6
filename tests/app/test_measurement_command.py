"""``vibroscope measurement`` and ``vibroscope compare --measured``."""

import argparse
import json

import pytest
from vibroscope.app.commands.cli import main
from vibroscope.app.commands.compare_measured import fit_names
from vibroscope.app.runtime.files import ASSETS
from vibroscope.engine import System, Units, read_measurement, synthetic_measurement

EXAMPLE = ASSETS / "example-measurement.csv"


def compare(capsys, *arguments):
    setting = ["--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "2000", "--periods", "300"]
    assert main(["compare", *setting, *arguments]) == 0
    return capsys.readouterr().out


def test_the_example_is_made_by_the_command_and_says_so(capsys):
    assert main(["measurement"]) == 0
    assert capsys.readouterr().out == EXAMPLE.read_text(encoding="utf-8")
    assert EXAMPLE.read_text(encoding="utf-8").startswith(
        "# NOT MEASURED: the semi-analytical reference plus normal noise"
    )
    made = synthetic_measurement(System(), 2.76, periods=4, per_period=120, noise=0.02, phase=0.7, seed=1)
    assert read_measurement(EXAMPLE, Units()).displacement == pytest.approx(made.displacement, abs=1e-5)


def test_json_holds_the_measurement_beside_both_solvers(capsys):
    found = json.loads(compare(capsys, "--measured", str(EXAMPLE), "--json"))
    assert list(found) == ["eta", "measured", "reference", "penalty", "fit", "verdict"]
    assert found["measured"]["samples"] == 481
    assert found["measured"]["period"] == 1
    assert found["measured"]["noise"] == pytest.approx(0.02, rel=0.1)
    assert found["reference"]["phase"] == pytest.approx(0.7, abs=0.01)
    assert found["reference"]["rms"] < 0.01 < found["penalty"]["rms"]
    assert found["fit"] is None
    assert found["verdict"].startswith("The reference agrees")


def test_a_fit_comes_first_and_its_system_is_compared(capsys):
    found = json.loads(compare(capsys, "--measured", str(EXAMPLE), "--fit", "restitution,d3", "--json"))
    fit = found["fit"]
    assert abs(fit["values"]["restitution"] - 0.5) < 3 * fit["errors"]["restitution"]
    assert fit["errors"]["d3"] is None
    assert fit["correlation"]["names"] == ["restitution"]
    text = compare(capsys, "--measured", str(EXAMPLE), "--fit", "restitution")
    assert "restitution                 0.50" in text
    assert "+- " in text
    assert "contacts per period" in text


def test_units_come_from_the_system_file(capsys, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text("[units]\nbase_amplitude = 2.14\n")
    found = json.loads(compare(capsys, "--measured", str(EXAMPLE), "--system", str(path), "--json"))
    assert found["reference"]["rms"] > 0.3  # all displacements half as large


def test_names_that_cannot_be_fitted_are_refused():
    assert fit_names("d1, d2") == ("d1", "d2")
    for text in ("kappa", "d1,d1", ""):
        with pytest.raises(
            argparse.ArgumentTypeError, match="give some of restitution,d1,d2,d3,K,D,zero1,zero2,scale, each once"
        ):
            fit_names(text)


def test_columns_of_other_names_are_asked_for_and_read(capsys, tmp_path):
    file = tmp_path / "other.csv"
    file.write_text(EXAMPLE.read_text(encoding="utf-8").replace("time [s], x1 [mm], x2 [mm]", "Zeit [s], Weg, w2"))
    setting = ["compare", "--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "400", "--measured", str(file)]
    assert main(setting) == 2
    assert '--columns "time=1 [s], xi1=2 [mm], xi2=3 [mm]"' in capsys.readouterr().err
    text = compare(capsys, "--measured", str(file), "--columns", "time=Zeit, x1=2 [mm], x2=w2 [mm]")
    assert "The reference agrees within the noise of the measurement" in text
