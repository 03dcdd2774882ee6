"""``vibroscope system``: a system file to start from."""

import argparse

from vibroscope.app.commands.options import add_system_option, system_of, units_of
from vibroscope.engine import system_text


def add(commands) -> None:
    """Describe ``vibroscope system``."""
    command = commands.add_parser(
        "system",
        allow_abbrev=False,
        help="print a system file with comments, to change and hand to --system",
        description="Print the paper's system (or that of --system, completed) as a commented TOML file.",
    )
    add_system_option(command)
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the file."""
    print(system_text(system_of(options), units_of(options)), end="")
