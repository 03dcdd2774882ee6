"""``vibroscope system`` and ``--system``."""

import json

import pytest
from vibroscope.engine import Reference, System, simulate, system_text

from tests.app.command_line import PHYSICAL, run_command

SIMULATE = ["simulate", "--solver", "reference", "--eta", "2.76", "--periods", "20", "--json"]


def test_what_it_prints_is_taken_by_every_command(capsys, tmp_path):
    path = tmp_path / "own.toml"
    status, out, _ = run_command(capsys, "system")
    assert (status, out) == (0, system_text())
    path.write_text(out.replace("kappa = 2.41", "kappa = 2.6").replace("restitution = 0.5", "restitution = 0.4"))
    own = System(kappa=2.6, restitution=0.4)
    status, out, _ = run_command(capsys, *SIMULATE, "--system", str(path))
    assert status == 0
    assert json.loads(out)["section"] == simulate(own, 2.76, Reference(), periods=20, keep=20).section.tolist()
    _, out, _ = run_command(capsys, *SIMULATE, "--system", str(path), "--restitution", "0.7")
    again = simulate(System(kappa=2.6, restitution=0.7), 2.76, Reference(), periods=20, keep=20)
    assert json.loads(out)["section"] == again.section.tolist()
    _, out, _ = run_command(capsys, "system", "--system", str(path))
    assert out == system_text(own)


def test_a_physical_file_is_converted_and_gives_the_frequency(capsys, tmp_path):
    path, plain = tmp_path / "own.toml", tmp_path / "plain.toml"
    path.write_text(PHYSICAL)
    status, out, note = run_command(capsys, "system", "--from", "physical", str(path))
    assert status == 0
    assert "wall = true" in out
    eta = note.split("eta = ")[1].split(":")[0]
    plain.write_text(out)
    command = ["simulate", "--solver", "reference", "--periods", "20", "--json"]
    _, one, _ = run_command(capsys, *command, "--system", str(path))
    _, two, _ = run_command(capsys, *command, "--system", str(plain), "--eta", eta)
    assert json.loads(one)["section"] == json.loads(two)["section"]
    status, _, err = run_command(capsys, *command, "--system", str(plain))
    assert (status, err.count("\n")) == (2, 1)
    assert "needs --eta" in err
    status, out, _ = run_command(capsys, "system", "--system", str(path), "--to", "physical")
    assert status == 0
    assert "clearance_mm = 0.5" in out


@pytest.mark.parametrize("way", [["--from", "physical"], ["--to", "physical", "--system"], ["--system"]])
def test_a_restitution_that_is_not_given_is_said_where_the_system_is_shown(capsys, tmp_path, way):
    path, again = tmp_path / "own.toml", tmp_path / "again.toml"
    path.write_text(PHYSICAL.replace("restitution = 0.5\n", ""))
    status, out, err = run_command(capsys, "system", *way, str(path))
    assert (status, err.count("gives no restitution, and 0.5 is taken")) == (0, 1)
    assert out.startswith("# Assumed: [physical] gives no restitution, and 0.5 is taken")
    again.write_text(out)
    _, out, err = run_command(capsys, "system", "--system", str(again))
    assert "restitution = 0.5" in out
    assert "Assumed" not in out + err


def test_a_restitution_that_is_not_given_is_noted_by_every_run(capsys, tmp_path):
    path = tmp_path / "own.toml"
    run_it = ["simulate", "--solver", "reference", "--periods", "5", "--keep", "2", "--json", "--system", str(path)]
    for text, noted in ((PHYSICAL, 0), (PHYSICAL.replace("restitution = 0.5\n", ""), 1)):
        path.write_text(text)
        status, out, err = run_command(capsys, *run_it)
        assert (status, err.count("gives no restitution")) == (0, noted)
        assert json.loads(out)["section"]
    path.write_text("[excitation]\nbase = 1.0\n")  # the paper's system, whose numbers are all known
    assert "restitution" not in run_command(capsys, "system", "--system", str(path))[2]


WITH_FREQUENCY = (
    ["recommend", "--located", "--tolerance", "0.5", "--steps-max", "16", "--json"],
    ["measurement", "--periods", "2"],
    ["compare", "--K", "700", "--D", "6", "--steps", "100", "--periods", "20", "--json"],
    ["sweep", "plane", "--K", "500:700:2", "--D", "3:6:2", "--steps", "100", "--transient", "9", "--sample", "3"],
    ["sweep", "step", "--K", "700", "--D", "6", "--steps", "100,200", "--transient", "9", "--sample", "3"],
    ["sweep", "eta", "--over", "K", "--from", "500", "--to", "700", "--count", "2", "--solver", "exact", "--D", "6",
     "--transient", "9", "--sample", "3"],
)  # fmt: skip


@pytest.mark.parametrize("command", WITH_FREQUENCY, ids=lambda words: " ".join(words[:2]))
def test_every_command_takes_the_frequency_of_the_file(capsys, tmp_path, command):
    path, plain = tmp_path / "own.toml", tmp_path / "plain.toml"
    path.write_text(PHYSICAL)
    out = ["--out", str(tmp_path / "store.zarr")] if command[0] == "sweep" else []
    status, text, err = run_command(capsys, *command, *out, "--system", str(path))
    assert (status, err) == (0, "")
    if command[0] in ("recommend", "compare"):
        assert json.loads(text)["eta"] == pytest.approx(1.0, abs=1e-3)
    if command[0] != "measurement":  # which has a frequency of its own
        _, text, _ = run_command(capsys, "system", "--from", "physical", str(path))
        plain.write_text(text)
        status, _, err = run_command(capsys, *command, *out, "--system", str(plain))
        assert (status, err.count("\n")) == (2, 1)
        assert "needs --eta" in err
    else:
        assert "# eta = 1, " in text


def test_a_wall_has_no_row_of_joint_damping(capsys, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(PHYSICAL)
    command = ["compare", "--K", "700", "--D", "6", "--steps", "100", "--periods", "100", "--system", str(path)]
    status, text, _ = run_command(capsys, *command)
    assert status == 0
    assert "joint damping" not in text
    _, text, _ = run_command(capsys, *command, "--json")
    assert json.loads(text)["joint_damping"] == 0.0


def test_a_free_vibration_is_said_to_be_one(capsys, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text("[system]\nwall = true\nclearance = 0.2\n[excitation]\nbase = 0.0\n")
    options = ["--eta", "1.3", "--system", str(path), "--initial", "0.1,1,0,0"]
    penalty = ["--K", "700", "--D", "6", "--steps", "500"]
    status, text, _ = run_command(capsys, "compare", *penalty, *options, "--units")
    assert status == 0
    assert text.count("free vibration") == 3
    assert "in the first 2 periods T" in text
    assert "nan" not in text
    status, _, err = run_command(capsys, "simulate", "--solver", "reference", *options)
    assert (status, "nothing drives the bodies" in err) == (0, True)


@pytest.mark.parametrize(("periods", "words"), [("2050", "come to rest"), ("60", "still moving")])
def test_a_free_vibration_repeats_in_no_period(capsys, tmp_path, periods, words):
    path = tmp_path / "own.toml"
    path.write_text("[system]\nwall = true\nclearance = 0.5\nd1 = 0.0033\n[excitation]\nbase = 0.0\n")
    options = ["--eta", "1.2", "--system", str(path), "--initial=-1,0,0,0", "--periods", periods]
    status, text, _ = run_command(capsys, "simulate", "--solver", "reference", *options)
    assert status == 0
    assert f"motion            free vibration, {words}\n" in text


def test_what_never_touches_is_said(capsys, tmp_path):
    path = tmp_path / "own.toml"
    path.write_text("[system]\nclearance = 1000.0\n")
    for command in ("simulate", "motion"):
        status, text, _ = run_command(capsys, command, "--solver", "reference", "--eta", "1.3", "--system", str(path))
        assert (status, "Nothing touches" in text) == (0, True)
