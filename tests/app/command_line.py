"""The command line in this process."""

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
