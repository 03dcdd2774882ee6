"""``vibroscope simulate`` and the command line as a whole: JSON, text, notes, bad input, the installed command."""

import json
import re
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from vibroscope.app.commands.cli import EXAMPLES, main
from vibroscope.engine import Newmark, Reference, System, simulate, steady

from tests.app.command_line import run_command

COMMAND = Path(sys.executable).parent / "vibroscope"
NEWMARK = ["--solver", "newmark", "--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "500"]


def run(capsys, *arguments):
    return run_command(capsys, "simulate", *arguments)


def test_the_examples_of_the_help_run(capsys):
    examples = [line.split()[1:] for line in EXAMPLES.splitlines() if line.startswith("  vibroscope simulate")]
    assert len(examples) == 3
    for words in examples:
        assert main(words) in (None, 0)
        assert capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "method"),
    [
        (["--solver", "reference", "--eta", "2.76"], Reference()),
        (["--solver", "reference", "--eta", "2.76", "--joint-damping", "derived"], Reference("derived")),
        (NEWMARK, Newmark(12000, 18, 500)),
        ([*NEWMARK, "--located"], Newmark(12000, 18, 500, located=True)),
    ],
)
def test_json_is_the_contract(capsys, arguments, method):
    status, out, _ = run(capsys, *arguments, "--periods", "60", "--keep", "7", "--json")
    expected = simulate(System(), 2.76, method, periods=60, keep=7)
    found = json.loads(out)
    assert status == 0
    assert list(found) == [
        "solver", "eta", "periods", "keep", "status", "message", "section", "impacts", "contacts", "seconds",
        "steps_without_solution", "steps_with_two",
    ]  # fmt: skip
    assert (found["solver"], found["eta"], found["periods"], found["keep"]) == (method.name, 2.76, 60, 7)
    assert (found["status"], found["message"]) == ("ok", "")
    assert found["section"] == expected.section.tolist()
    impacts = zip(expected.impacts.time, expected.impacts.closing_speed, strict=True)
    assert found["impacts"] == [list(pair) for pair in impacts]
    assert all(speed > 0 for _, speed in found["impacts"])
    assert found["contacts"] == expected.contacts.tolist()
    assert 0 < found["seconds"] < 1


def test_steady_motion_adds_to_the_contract(capsys):
    arguments = ["--solver", "reference", "--eta", "3.25", "--steady"]
    status, out, _ = run(capsys, *arguments, "--json")
    expected, found = steady(System(), 3.25, Reference()), json.loads(out)
    assert status == 0
    assert list(found)[-5:] == ["periodic", "period", "multipliers", "residual", "periods_run"]
    assert (found["periodic"], found["period"], found["message"]) == (True, 2, "")
    assert found["section"] == expected.response.section.tolist()
    assert [complex(*pair) for pair in found["multipliers"]] == expected.multipliers.tolist()
    assert (found["residual"], found["periods_run"]) == (expected.residual, expected.periods)
    _, out, _ = run(capsys, *arguments)
    assert f"found by running {expected.periods} periods" in out
    assert "repeats every 2 periods" in out
    assert "0.5 per period" in out
    _, out, _ = run(capsys, "--solver", "exact", "--K", "12000", "--D", "18", *arguments[2:])
    assert "contacts          0.5 per period" in out


def test_where_no_motion_is_steady_the_long_run_is_shown(capsys):
    arguments = ["--solver", "reference", "--eta", "1.70", "--steady"]
    status, out, _ = run(capsys, *arguments, "--json")
    found = json.loads(out)
    assert (status, found["status"], found["periodic"], found["period"], found["residual"]) == (0, "ok", False, 0, None)
    assert found["section"] == simulate(System(), 1.70, Reference()).section.tolist()
    assert found["message"].startswith("no periodic motion found")
    _, out, _ = run(capsys, *arguments)
    assert out.splitlines()[-1] == found["message"]


def test_a_run_that_blows_up_is_a_result(capsys):
    arguments = ["--solver", "newmark", "--eta", "2.76", "--K", "60000", "--D", "1", "--steps", "100"]
    status, out, _ = run(capsys, *arguments, "--json")
    found = json.loads(out)
    assert (status, found["status"], found["section"]) == (0, "diverged", [])
    assert "step" in found["message"]
    status, out, _ = run(capsys, *arguments)
    assert "diverged: Newmark's solution blew up" in out


def test_all_options_reach_the_solver(capsys):
    arguments = ["--solver", "reference", "--eta", "1.08", "--periods", "5", "--json"]
    _, out, _ = run(capsys, *arguments, "--restitution", "0.3", "--threshold", "0.01", "--initial", "-0.5,0,0.5,1e-1")
    expected = simulate(
        System(restitution=0.3), 1.08, Reference(threshold=0.01), periods=5, keep=5, initial=(-0.5, 0, 0.5, 0.1)
    )
    assert json.loads(out)["section"] == expected.section.tolist()


def test_a_port_in_use_gives_one_line():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        done = subprocess.run([COMMAND, "serve", "--port", port], capture_output=True, text=True, timeout=120)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].endswith(f"127.0.0.1:{port}: Address already in use")


def test_a_motion_has_one_description_and_one_width(capsys):
    """Its name has ± over 256 periods; no other width of the kept periods stands beside it."""
    question = ("--solver", "newmark", "--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "2000")
    hht = (*question, "--integrator", "hht", "--alpha", "-0.1", "--status", "end", "--without-solution", "halve")
    for asked in (question, hht):
        _, text, _ = run_command(capsys, "simulate", *asked)
        words = re.search(r"motion +(repeats every period, blurred by the time step \(±[\d.]+ in ξ₂\))", text)[1]
        assert words in run_command(capsys, "motion", *asked)[1]
        assert "spread" not in text
        assert text.count("±") == 1


def test_the_installed_command():
    done = subprocess.run([COMMAND], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert "usage" in done.stderr
