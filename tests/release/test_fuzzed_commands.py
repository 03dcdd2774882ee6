"""Fuzzed command lines: every option of every command with odd values."""

import argparse

import pytest
from vibroscope.app.commands.cli import build_parser, main

from tests.release.odd import NO_NUMBERS, ODD

PENALTY = ["--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "100"]
STUDY = ["--transient", "5", "--sample", "5", "--out", "OUT"]
STARTS = ["--eta", "2.76", "--x", "xi2:1:2:2", "--y", "v2:0:1:2"]
COMMANDS = (
    ["simulate", "--solver", "newmark", *PENALTY, "--periods", "5", "--keep", "2"],
    ["simulate", "--solver", "reference", "--eta", "2.76", "--periods", "5", "--keep", "2"],
    ["motion", "--solver", "newmark", *PENALTY],
    ["compare", *PENALTY, "--periods", "20"],
    ["recommend", "--eta", "2.76", "--tolerance", "0.5", "--steps-max", "16", "--located"],
    ["serve"],
    ["sweep", "eta", "--from", "2", "--to", "3", "--count", "2", "--solver", "newmark", *PENALTY[2:], *STUDY],
    ["sweep", "plane", "--eta", "2.76", "--K", "100:200:2", "--D", "1:2:2", "--steps", "50", *STUDY],
    ["sweep", "basin", *STARTS, "--solver", "exact", *PENALTY[2:6], "--transient", "5", "--sample", "32", *STUDY[-2:]],
    ["sweep", "step", "--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "50,100", *STUDY],
    ["branch", "--solver", "reference", "--from", "2.7", "--to", "2.72", "--max-period", "1", "--most-orbits", "10"],
    ["system"],
    ["measurement", "--eta", "2.76", "--periods", "5"],
    ["rules", "ansys-mode", *PENALTY, "--periods", "20"],
    ["export", "--to", "opensees", *PENALTY, "--periods", "5"],
    ["recommend", "--code", "abaqus-standard", "--eta", "2.76", "--tolerance", "0.5", "--steps-max", "16"],
    ["sweep", "no-solution", "--eta", "2.76", "--K", "100:200:2", "--D", "18", "--steps", "20:50:2", *STUDY],
    ["sweep", "check"],
    ["codes"],
    ["validate"],
)
# Any text may be the name of a file or of a host.
FREE = ("--out", "--address", "--origin")
# Dozens of Dask clients that fail in one process may hang in their clean-up; test_sweep_cluster.py tries one.
ELSEWHERE = ("--scheduler",)


def options_of(command):
    """Return the options of a command that take a value, and "" where it takes one without an option."""
    parser = build_parser()
    for word in command:
        subs = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
        if not subs:
            break
        parser = subs[0].choices[word]
    taking = [action for action in parser._actions if action.nargs != 0]
    names = [action.option_strings[-1] if action.option_strings else "" for action in taking]
    return [name for name in names if name not in ELSEWHERE]


def ended(arguments):
    try:
        return main(arguments)
    except SystemExit as end:
        return end.code


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: "-".join(command[:2]).replace("---", "-"))
def test_command_line(command, tmp_path, monkeypatch, capsys, report):
    """Every option with every odd value: the command ends with one line and a status, or accepts the value."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("vibroscope.app.server.server.serve", lambda *_, **__: None)
    tried, refused, wrong = 0, 0, []
    for option in options_of(command):
        for value in ODD:
            words = [str(tmp_path / f"{tried}.zarr") if word == "OUT" else word for word in command]
            status = ended([*words, f"{option}={value}" if option else value])
            said = capsys.readouterr().err.strip()
            tried += 1
            refused += status != 0
            in_words = status in (1, 2) and said.startswith("vibroscope ") and "Traceback" not in said
            taken = status == 0 and (option in FREE or value not in NO_NUMBERS or "has no effect" in said)
            if not in_words and not taken:
                wrong.append((option, value, status, said))
    assert not wrong
    report(f"vibroscope {' '.join(command[:2])}: {tried} odd values, {refused} refused in a line", inputs=tried)
