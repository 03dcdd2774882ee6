"""``vibroscope system``: a system file to start from."""

import argparse
from textwrap import wrap

from vibroscope.app.commands.options import add_system_option
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.report import Report, note
from vibroscope.engine import physical_text, read_system, system_text


def add(command: OneLineParser) -> None:
    """Add the options."""
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


def run(options: argparse.Namespace) -> Report:
    """Write the file."""
    if options.source is not None:
        kind, path = options.source
        if kind != "physical":
            raise ValueError(f"--from {kind!r} is not known: give --from physical FILE.toml")
        options.file = read_system(path)
        for text in options.file.assumed:
            note(f"{path}: {text}")
    system, units, eta = options.file.system, options.file.units, options.file.eta
    if options.to == "physical":
        text = physical_text(system, units, eta, options.file.forms)
    else:
        text = system_text(system, units)
        if eta is not None:
            note(f"the file's frequency is eta = {eta!r}: give it as --eta")
    # what was assumed stays with the numbers where they are written into a file
    assumed = (line for each in options.file.assumed for line in wrap(f"Assumed: {each}", 108))
    return Report([*(f"# {line}" for line in assumed), *text.splitlines()])


COMMAND = Command(
    "print a system file with comments, to change and hand to --system",
    "Print the paper's system (or that of --system, completed) as a commented TOML file. --from physical FILE converts "
    "a table [physical], whose numbers have units; --to physical converts back.",
    add=add,
    run=run,
)
