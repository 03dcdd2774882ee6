"""``vibroscope system``: a system file to start from."""

import argparse
from textwrap import wrap

from vibroscope.app.commands.options import add_system_option, system_of, units_of
from vibroscope.app.commands.output import note
from vibroscope.engine import physical_text, read_system, system_text


def add(commands) -> None:
    """Describe ``vibroscope system``."""
    command = commands.add_parser(
        "system",
        allow_abbrev=False,
        help="print a system file with comments, to change and hand to --system",
        description="Print the paper's system (or that of --system, completed) as a commented TOML file. "
        "--from physical FILE converts a table [physical], whose numbers have units; --to physical converts back.",
    )
    add_system_option(command)
    command.add_argument(
        "--from",
        dest="source",
        nargs=2,
        metavar=("physical", "FILE.toml"),
        help="the file with a table [physical] to convert",
    )
    command.add_argument(
        "--to",
        choices=("numbers", "physical"),
        default="numbers",
        help="print numbers without dimension, or one table [physical] (default %(default)s)",
    )
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the file."""
    if options.source is not None:
        kind, path = options.source
        if kind != "physical":
            raise ValueError(f"--from {kind!r} is not known: give --from physical FILE.toml")
        options.system = read_system(path)
        for text in options.system.assumed:
            note(f"{path}: {text}")
    system, units, eta = system_of(options), units_of(options), options.system.eta
    for text in options.system.assumed:  # stays with the numbers where they are written into a file
        print("\n".join(wrap(text, 110, initial_indent="# Assumed: ", subsequent_indent="# ")))
    if options.to == "physical":
        print(physical_text(system, units, eta, options.system.forms), end="")
        return
    print(system_text(system, units), end="")
    if eta is not None:
        note(f"the file's frequency is eta = {eta!r}: give it as --eta")
