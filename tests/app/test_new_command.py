"""A command is one file: its options, what it finds, and how that is printed come from it and from the runner."""

import json
import sys
from types import ModuleType

import pytest
from vibroscope.app.commands import cli

from tests.app.command_line import run_command

HALF = """
from vibroscope.app.commands.numbers import measured
from vibroscope.app.commands.options import add_system_option
from vibroscope.app.commands.parser import Command
from vibroscope.app.commands.physical_units import add_units_option, wanted_units
from vibroscope.app.commands.report import Report, Row
from vibroscope.engine import Statement
from vibroscope.engine.facts import equation


def add(command):
    command.add_argument("K", type=measured("contact_stiffness"))
    add_system_option(command)
    add_units_option(command)


def run(options):
    if options.K > 1e9:
        raise ValueError("K must be at most 1e9")
    text = Statement("half is ", equation("K", options.K / 2))
    return Report([Row("half", text)], {"half": options.K / 2}, wanted_units(options), int(options.K == 0))


COMMAND = Command("halve a stiffness", add=add, run=run, json="one JSON object")
"""


@pytest.fixture(autouse=True)
def command(monkeypatch):
    module = ModuleType("vibroscope.app.commands.half")
    exec(HALF, module.__dict__)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(cli, "COMMANDS", (*cli.COMMANDS, "half"))


def test_it_prints_text_json_and_units_and_ends_with_its_status(capsys, tmp_path):
    assert run_command(capsys, "half", "2500") == (0, "half              half is K = 1250\n", "")
    assert json.loads(run_command(capsys, "half", "2500", "--json")[1]) == {"half": 1250.0}
    system = tmp_path / "my.toml"
    system.write_text("[system]\n[units]\nomega1 = 10.0\nm1 = 2.0\n")
    text = run_command(capsys, "half", "400 N/m", "--system", str(system), "--units")[1]
    assert text == "half              half is K = 200 N/m\n"
    assert run_command(capsys, "half", "0")[0] == 1


def test_its_errors_are_one_line(capsys):
    assert run_command(capsys, "half", "2e9") == (2, "", "vibroscope half: K must be at most 1e9\n")
    status, out, err = run_command(capsys, "half", "2", "--jsn")
    assert (status, out) == (2, "")
    assert "do you mean --json?" in err
