"""The command line in this process."""

import contextlib
import os
import subprocess

from vibroscope.app.commands.cli import main

# A machine on springs before a wall, in the keys of a data sheet.
PHYSICAL = """[physical]
mass1_kg = 25.0
stiffness1_N_per_m = 98696.0
wall = true
clearance_mm = 0.5
restitution = 0.5
base_acceleration_m_per_s2 = 1.0
frequency_Hz = 10.0
"""


def run_command(capsys, *words):
    """Exit status, output and errors of a command."""
    try:
        status = main(list(words))
    except SystemExit as exit_:
        status = exit_.code
    return status, *capsys.readouterr()


SAY_WORDS = """#!/bin/sh
printf '%s\\0' "$@"
echo
"""


def run_shell(capsys, text, folder):
    """What the commands of a shell print in a folder; each ``vibroscope``, whose start takes a second, runs here.

    So a shell must read them, none may fail or complain, and none may need what another one prints.
    """
    program = folder / "vibroscope"
    program.write_text(SAY_WORDS)
    program.chmod(0o755)
    path = {"PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(["sh", "-e"], input=text, cwd=folder, env=os.environ | path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    with contextlib.chdir(folder):
        found = [run_command(capsys, *words.split("\0")[:-1]) for words in done.stdout.splitlines()]
    assert {(status, error) for status, _, error in found} == {(0, "")}
    return "".join(out for _, out, _ in found)
