"""``vibroscope transient``: both solutions under a pulse or a record, their difference, files, and refusals."""

import csv
import json
import math
import re
import shlex

import numpy as np
import pytest
from vibroscope.app.commands.cli import main
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.scripts import load_command
from vibroscope.app.studies.load import LoadQuestion, RecordFile

BOX = """\
[physical]
wall = true
mass1_kg = 2.0
frequency1_Hz = 20.0
damping1_ratio = 0.05
clearance_mm = 2.0
restitution = 0.5
"""
CONTACT = ["--K", "1e6 N/m", "--D", "200 N s/m"]


@pytest.fixture
def box(tmp_path):
    path = tmp_path / "box.toml"
    path.write_text(BOX)
    return ["transient", "--system", str(path)]


def test_it_prints_both_solutions_in_the_units_of_the_system(box, capsys):
    assert main([*box, "--base-half-sine", "30 g,11 ms", *CONTACT, "--steps", "0.1 ms", "--energy"]) == 0
    text = capsys.readouterr().out
    assert "peak 294.2 m/s²; it ends at 11 ms, the run at 211 ms" in text
    assert next(line for line in text.splitlines() if line.startswith("closing speed")).endswith("m/s")
    assert "time step" in text
    assert text.count("work of the load") == 2
    said = " ".join(text.split())
    assert "contact alone it has a restitution of " in said
    assert "e = 0.5 is asked for" in said
    assert "joint damping" not in said  # of a wall
    assert "body 2" not in said
    assert main([*box, "--base-half-sine", "30 g,11 ms", *CONTACT, "--json", "--units", "--energy"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["reference"]["impacts"] == 3
    assert found["physical"]["penalty"]["contact_force"] == pytest.approx(2000, rel=0.05)
    assert abs(found["penalty"]["energy"]["residual"]) <= 1e-10 * found["penalty"]["energy"]["work"]
    assert set(found["difference"]["parts"]) == {"time_step", "regularisation"}  # a wall: no joint damping


def test_a_contact_without_a_damper_is_refused_with_or_without_a_step(box, capsys):
    for step in ((), ("--steps", "0.1 ms")):
        assert main([*box, "--base-half-sine", "5 g,11 ms", "--K", "1e5 N/m", *step]) == 2
        said = capsys.readouterr().err
        assert "needs --D; " in said
        assert "in place of --D a --law" in said


def test_a_record_and_the_pulse_that_it_samples_give_the_same(box, tmp_path, capsys):
    record = tmp_path / "a.csv"
    record.write_text("time [ms], a [g]\n0, 0\n6, 50\n6, 0\n")
    found = []
    for load in (["--base-record", str(record)], ["--base-sawtooth", "50 g,6 ms"]):
        assert main([*box, *load, "--json"]) == 0
        found.append(json.loads(capsys.readouterr().out)["reference"]["peaks"])
    finite = {name for name, value in found[1].items() if value is not None}
    assert len(finite) == 9
    assert [found[0][name] for name in finite] == pytest.approx([found[1][name] for name in finite], rel=1e-12)


def test_a_record_ends_when_its_file_says_and_says_if_that_has_no_units(box, tmp_path, capsys):
    unitless = "record, in a file without units, of the"
    for head, words in ("time [s], a [g]", "it ends at 20 ms,"), ("time [-], a [-]", unitless):
        (tmp_path / "a.csv").write_text(f"{head}\n0, 0\n0.01, 1\n0.02, 0\n")
        assert main([*box, "--base-record", str(tmp_path / "a.csv"), "--units"]) == 0
        assert words in capsys.readouterr().out


@pytest.mark.parametrize("head", ["time,a", "time [-],a [-]", "time [ms],a [g]"])
def test_the_command_of_the_page_takes_the_record_that_the_page_takes(tmp_path, monkeypatch, capsys, head):
    """Own ω₁ convert columns with units, and do not ask for any."""
    setting = Setting(omega1=50.0)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csv").write_text(text := f"{head}\n0, 0\n1, 1\n2, 0\n")
    record = RecordFile("a.csv", text.encode(), "base", setting.own_units, physical=False)
    asked = LoadQuestion(setting.system, record, setting.reference, setting.penalty, 1.0, None)
    *written, command = load_command(setting, asked).splitlines()
    if "--system system.toml" in command:
        (tmp_path / "system.toml").write_text("\n".join(written[1 : written.index("END")]))
    assert main([*shlex.split(command)[1:], "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["load"]["peak"] == pytest.approx(record.load().peak)


def test_a_file_without_units_beside_a_physical_system_is_refused_with_what_to_write(box, tmp_path, capsys):
    record, measured = tmp_path / "a.csv", tmp_path / "m.csv"
    record.write_text("time,acceleration\n0, 0\n0.01, 1\n0.02, 0\n")
    measured.write_text("\n".join(["time,xi1,force [N]", *(f"{0.01 * i},{i % 3},0" for i in range(20))]))
    said = "line 1: no column has a unit, and the system is in physical units; give each its unit, as time [s], "
    assert main([*box, "--base-record", str(record)]) == 2
    assert f"{record}: {said}a [m/s2], or [-] for a number of the model" in capsys.readouterr().err
    step = ("--steps", "0.1 ms")
    assert main([*box, "--base-half-sine", "5 g,11 ms", *CONTACT, *step, "--measured", str(measured)]) == 2
    assert f"{measured}: {said}x1 [mm], or [-] for a number of the model" in capsys.readouterr().err
    plain = ["transient", "--base-record", str(record)]  # of a system without dimension they are its numbers
    assert main(plain) == 0
    assert (
        "record, in a file without units, of the acceleration of the base, peak 1; it ends at 0.02,"
        in capsys.readouterr().out
    )


@pytest.mark.parametrize(
    ("step", "share"), [(0.1, (math.pi / 110) ** 2 / 12), (1, (math.pi / 11) ** 2 / 12), (12.5, 1.0)]
)
def test_steps_that_miss_the_load_say_so(box, capsys, step, share):
    """A chord of half a sine lies below it by a twelfth of the square of its angle, on average."""
    asked = [*box, "--base-half-sine", "30 g,11 ms", *CONTACT, "--steps", f"{step} ms"]
    assert main([*asked, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["reference"]["load_missed"] == 0.0
    assert found["penalty"]["load_missed"] == pytest.approx(share, rel=0.1)
    assert main(asked) == 0
    assert ("its steps miss 100 % of the load: take shorter ones" in capsys.readouterr().out) == (share == 1.0)


def test_history_and_shock_response_are_files(box, tmp_path):
    history, response = tmp_path / "h.csv", tmp_path / "s.csv"
    more = ["--shock-response", "10 Hz:40 Hz:3", "--write", str(response)]
    assert main([*box, "--force-trapezoid", "500 N,20 ms", "--history", str(history), "--units"]) == 0
    with history.open(newline="") as file:
        head, *rows = csv.reader(file)
    assert head[:3] == ["solution", "time [s]", "displacement1 [m]"]
    assert max(float(row[2]) for row in rows) == pytest.approx(2e-3, rel=1e-9)  # it meets the wall
    assert main([*box, "--base-sawtooth", "50 g,6 ms", *more, "--units"]) == 0
    with response.open(newline="") as file:
        head, *rows = csv.reader(file)
    assert head[:3] == ["frequency [Hz]", "displacement [m]", "acceleration [m/s²]"]
    assert np.array([float(row[0]) for row in rows]) == pytest.approx([10, 20, 40])
    assert all(float(row[1]) <= float(row[3]) + 1e-12 for row in rows)  # the stop holds the body back


TWO = """\
[physical]
mass1_kg = 2.4
frequency1_Hz = 12.5
damping1_ratio = 0.02
mass2_kg = 0.9
frequency2_Hz = 30.0
damping2_ratio = 0.02
clearance_mm = 0.2
restitution = 0.6
base_amplitude_mm = 0.5
"""


@pytest.mark.parametrize("sheet", [BOX + "base_amplitude_mm = 1.0\n", TWO], ids=["wall", "pair"])
def test_a_line_of_the_shock_response_is_what_is_printed_of_a_file_with_that_frequency(sheet, tmp_path, capsys):
    """The spring of body 1 alone is another one: K, D and the step have the same units as on the command line."""
    path, written = tmp_path / "sheet.toml", tmp_path / "srs.csv"
    path.write_text(sheet)
    load = ["--base-half-sine=-30 g,11 ms", *CONTACT, "--steps", "0.05 ms", "--units"]
    command = ["transient", "--system", str(path), *load]
    assert main([*command, "--shock-response", "10 Hz:40 Hz:3", "--write", str(written)]) == 0
    with written.open(newline="") as file:
        rows = [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(file)]
    own = next(line for line in sheet.splitlines() if line.startswith("frequency1_Hz"))
    for row, frequency in zip(rows, (10.0, 20.0, 40.0), strict=True):
        path.write_text(sheet.replace(own, f"frequency1_Hz = {frequency}"))
        capsys.readouterr()
        assert main([*command, "--json"]) == 0
        peaks = json.loads(capsys.readouterr().out)["physical"]["penalty"]
        seen = [row[name] for name in ("displacement [m]", "acceleration [m/s²]", "impulse [N·s]")]
        assert seen == pytest.approx([peaks[name] for name in ("displacement1", "acceleration1", "impulse")], rel=1e-6)
        assert row["frequency [Hz]"] == pytest.approx(frequency)


def test_a_shock_response_that_is_out_of_range_names_the_frequency(box, tmp_path, capsys):
    asked = [*box, "--base-half-sine=-30 g,11 ms", *CONTACT, "--steps", "1 ms", "--write", str(tmp_path / "s.csv")]
    assert main([*asked, "--shock-response", "20 Hz:500 Hz:2"]) == 2
    assert "natural frequency 500 Hz of body 1: its natural period has 2 time steps" in capsys.readouterr().err


def test_a_measured_response_to_a_pulse_is_compared_and_fitted(box, tmp_path, capsys):
    pulse = ["--base-half-sine=-30 g,11 ms"]
    history, record = tmp_path / "history.csv", tmp_path / "record.csv"
    assert main([*box, *pulse, "--history", str(history), "--units"]) == 0
    with history.open() as lines:
        rows = list(csv.DictReader(lines))
    lines = [f"{row['time [s]']},{row['displacement1 [m]']}" for row in rows[::10]]
    record.write_text("\n".join(["time [s],xi1 [m]", *lines]))
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(BOX.replace("restitution = 0.5", "restitution = 0.7"))
    asked = ["transient", "--system", str(wrong), *pulse, *CONTACT, "--steps", "0.1 ms", "--measured", str(record)]
    capsys.readouterr()
    assert main([*asked, "--units", "--fit", "restitution,zero1"]) == 0
    text = capsys.readouterr().out
    assert text.startswith("half-sine of the acceleration of the base, peak 294.2 m/s²; it ends at 11 ms")
    assert f"{len(lines)} samples, relative displacement of body 1, from the start" in text
    assert next(line for line in text.splitlines() if line.startswith("restitution")).split()[1].startswith("0.5")
    assert main([*box, *pulse, "--fit"]) == 2
    assert "--fit needs a measurement: give --measured FILE.csv" in capsys.readouterr().err


def test_only_where_something_strikes_an_impact_is_explained(box, capsys):
    for peak, explained in (("30 g", True), ("0.01 g", False)):
        assert main([*box, "--base-half-sine", f"{peak},11 ms", *CONTACT, "--steps", "0.1 ms"]) == 0
        assert ("An impact of the reference has no duration" in capsys.readouterr().out) == explained


def test_a_shock_response_counts_in_omega1_only_where_nothing_has_a_unit(box, tmp_path, capsys):
    """5:500 in multiples of ω₁ = 20 Hz would have been 100 Hz to 10 kHz."""
    written = tmp_path / "s.csv"
    more = ["--shock-response", "0.5:2:3", "--write", str(written)]
    assert main([*box, "--base-half-sine", "30 g,11 ms", *more]) == 2
    assert "multiples of omega1" in capsys.readouterr().err
    assert not written.exists()
    assert main(["transient", "--base-half-sine=-3,2", *more]) == 0
    with written.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["ratio"]) for row in rows] == pytest.approx([0.5, 1.0, 2.0])


@pytest.mark.parametrize(
    ("load", "option", "words"),
    [
        (["--base-half-sine", "30 g,11 ms"], ["--body", "2"], "--body has no effect on a motion of the base"),
        (["--force-half-sine", "30 N,11 ms"], ["--logarithmic"], "--logarithmic has no effect on a load that is no sw"),
        (["--force-sweep", "3 N,9 Hz,30 Hz,1 s"], ["--logarithmic", "--body", "1"], ""),
    ],
)
def test_an_option_that_the_load_has_no_use_for_is_named(box, capsys, load, option, words):
    assert main([*box, *load, *option]) == 0
    said = capsys.readouterr().err
    assert words in said
    assert ("has no effect" in said) == bool(words)


@pytest.mark.parametrize("more", [[], [*CONTACT, "--steps", "0.1 ms", "--measured", "m.csv"]], ids=["runs", "measured"])
def test_a_force_on_a_wall_is_refused(box, tmp_path, monkeypatch, capsys, more):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.csv").write_text("\n".join(["time [s],xi1 [mm]", *(f"{0.01 * i},{i % 3}" for i in range(20))]))
    assert main([*box, "--force-sawtooth", "30 N,11 ms", "--body", "2", *more]) == 2
    assert "a force on body 2, which is a wall" in capsys.readouterr().err


def test_peaks_with_a_coarse_step_stand_beside_those_without_one(box, capsys):
    """The time step makes a part of the largest contact force; without it K and D give what they give exactly."""
    asked = [*box, "--base-half-sine=-30 g,11 ms", *CONTACT, "--units"]
    assert main([*asked, "--json"]) == 0
    exact = json.loads(capsys.readouterr().out)
    assert exact["without_step"] is None
    assert main([*asked, "--steps", "0.6 ms", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["without_step"] == pytest.approx(exact["penalty"]["peaks"], rel=1e-12)
    with_step, true = (each["physical"]["penalty"] for each in (found, exact))
    assert abs(with_step["contact_force"] / true["contact_force"] - 1) > 0.1
    assert main([*asked, "--steps", "0.6 ms"]) == 0
    lines = capsys.readouterr().out.splitlines()
    head = next(line for line in lines if line.startswith("largest"))
    assert head.split(maxsplit=3)[3].split("  ")[0] == "without a step"
    for name in ("contact_force", "acceleration1"):
        label = name.replace("_", " ").replace("1", " 1")
        cells = next(line for line in lines if line.startswith(label)).removeprefix(label).split()
        assert [float(cell) for cell in cells[1:3]] == pytest.approx([with_step[name], true[name]], rel=1e-3)


@pytest.mark.parametrize("step", [[], ["--steps", "0.3 ms"]], ids=["exact", "steps"])
def test_the_energies_that_are_printed_add_up(tmp_path, capsys, step):
    """Without a damper of the body its gain is that of its free vibration, ½m(ωA)²."""
    path = tmp_path / "box.toml"
    path.write_text(BOX.replace("damping1_ratio = 0.05", "damping1_ratio = 0.0"))
    load = ["--base-half-sine=-30 g,11 ms", *CONTACT, *step]
    assert main(["transient", "--system", str(path), *load, "--energy", "--units"]) == 0
    text = capsys.readouterr().out
    lines = re.findall(r"energy: work of the load (\S+) J \+ not balanced (\S+) J = (.*)", text)
    amplitudes = re.findall(r"\(amplitude\) body 1 (\S+) m", text)
    assert len(lines) == len(amplitudes) == 2
    for (work, created, spent), amplitude in zip(lines, amplitudes, strict=True):
        dampers, contact, gain = (
            float(re.search(rf"{name} (\S+) J", spent)[1]) for name in ("dampers", "contact", "gain of the bodies")
        )
        assert dampers == 0.0
        assert dampers + contact + gain == pytest.approx(float(work) + float(created), rel=2e-3)
        assert gain == pytest.approx(0.5 * 2.0 * (2 * math.pi * 20 * float(amplitude)) ** 2, rel=2e-3)
    assert float(lines[0][1]) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("head", ["time_s, acceleration_mm/s2", "t_s, a_mm/s²", "time_ms, acceleration_g", "t_s, f_kN"])
def test_units_behind_an_underscore_are_those_in_brackets(box, tmp_path, capsys, head):
    record, said = tmp_path / "a.csv", []
    kind = "--force-record" if "f_" in head else "--base-record"
    bracketed = ", ".join("{} [{}]".format(*cell.split("_")) for cell in head.split(", "))
    for header in (head, bracketed):
        record.write_text(f"{header}\n0, 0\n5, 3\n9, 0\n")
        assert main([*box, kind, str(record), "--units"]) == 0
        said.append(capsys.readouterr().out)
    assert said[0] == said[1]
    assert "without units" not in said[0]


def test_separate_contacts_of_a_decay_have_an_impulse_each(tmp_path, capsys):
    """Seven contacts, the last soft and long; an integration by others has 0.3062 N s for the second, the largest."""
    path = tmp_path / "parts.toml"
    path.write_text(
        "[physical]\nmass1_kg = 2.4\nfrequency1_Hz = 12\ndamping1_ratio = 0.02\nmass2_kg = 0.9\nfrequency2_Hz = 30\n"
        "damping2_ratio = 0.02\nclearance_mm = 0.2\nrestitution = 0.6\nbase_amplitude_mm = 0.5\nfrequency_Hz = 25\n"
    )
    load = ("--force-trapezoid", "30 N,20 ms", "--body", "2", "--K", "1e5 N/m", "--D", "20 N s/m", "--units")
    assert main(["transient", "--system", str(path), *load, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["physical"]["penalty"]
    assert found["impulse"] == pytest.approx(0.3062, rel=1e-3)


def test_a_run_that_blows_up_says_when_in_seconds(box, capsys):
    far = ("--K", "1e9 N/m", "--D", "2e5 N s/m", "--steps", "3 ms")
    assert main([*box, "--base-half-sine", "30 g,11 ms", *far, "--free", "3 s", "--units"]) == 0
    said = next(line for line in capsys.readouterr().out.splitlines() if "blew up" in line)
    assert re.search(r"at step \d+ \([\d.]+ m?s\); take shorter steps, or a smaller K or D", said)
    assert "period" not in said
