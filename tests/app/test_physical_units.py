"""--units: the numbers printed, in the units of an FE input file."""

import json
import re

import numpy as np
import pytest
from vibroscope.app.commands.cli import main
from vibroscope.engine import Units

SETTING = ["--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "2000"]
FILE = "[units]\nomega1 = 3.0\nm1 = 2.0\nbase_amplitude = 0.5\n"
UNITS = Units(3.0, 2.0, 0.5)


@pytest.fixture
def printed(capsys, tmp_path):
    path = tmp_path / "system.toml"
    path.write_text(FILE)

    def run(*arguments, system="si"):
        assert main([*arguments, "--system", str(path), "--units", system, "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    return run


def test_a_run_in_physical_units(printed):
    found = printed("simulate", "--solver", "newmark", *SETTING, "--keep", "3")
    physical = found["physical"]
    metres, per_second = 0.5e-3, 0.5e-3 * 3.0
    scale = [metres, per_second, metres, per_second]
    assert np.allclose(physical["section"], np.array(found["section"]) * scale, rtol=1e-13)
    assert np.allclose(physical["contacts"], np.array(found["contacts"]) / 3.0, rtol=1e-13)
    assert physical["settings"]["stiffness"] == pytest.approx(12000 * 2 * 9)  # K m₁ω₁²
    assert physical["settings"]["damping"] == pytest.approx(2 * 18 * 2 * 3)  # 2D m₁ω₁
    assert physical["settings"]["time_step"] == pytest.approx(2 * np.pi / 2.76 / 3 / 2000)


@pytest.mark.parametrize("command", [["motion", "--solver", "reference", "--eta", "2.76"], ["compare", *SETTING]])
def test_a_motion_in_physical_units(printed, command):
    found = printed(*command)
    plain, physical = found, found["physical"]
    if command[0] == "compare":
        plain, physical = found["reference"], found["physical"]["reference"]
    assert physical["impulse"] == pytest.approx(plain["impulse"] * 2.0 * 0.5e-3 * 3.0)  # m₁Aω₁
    assert physical["energy_lost"] == pytest.approx(plain["energy_lost"] * 2.0 * (0.5e-3 * 3.0) ** 2)
    assert physical["closing_speeds"] == pytest.approx([speed * 1.5e-3 for speed in plain["closing_speeds"]])


@pytest.mark.parametrize("command", ["simulate", "motion", "compare"])
def test_the_text_has_them_too(capsys, command):
    solver = [] if command == "compare" else ["--solver", "newmark"]
    assert main([command, *solver, *SETTING, "--units"]) == 0
    assert "stiffness 12000 N/m, damper 36 N.s/m, time step 0.001138 s, period 2.277 s" in capsys.readouterr().out


def test_no_number_of_a_search_is_written_as_a_power_of_ten(capsys, tmp_path):
    path = tmp_path / "system.toml"
    path.write_text("[units]\nomega1 = 94.0\nm1 = 2.0\n")  # 1 of K is 17,672 N/m
    arguments = ["--eta", "2.76", "--tolerance", "0.5", "--steps-max", "64", "--units", "mm-t-s", "--system", str(path)]
    assert main(["recommend", *arguments]) == 0
    printed = capsys.readouterr().out
    assert "physical          stiffness " in printed
    assert not re.search(r"\de\+\d", printed)
