"""``vibroscope diagram``: the results that are shipped: bifurcation diagrams, and what the page opens with."""

import argparse
from itertools import chain

from vibroscope.app.commands.parser import Command
from vibroscope.app.commands.report import Report
from vibroscope.engine import ship_diagrams


def run(options: argparse.Namespace) -> Report:
    """Compute what is shipped again and write it."""
    from vibroscope.app.explorer.shipped import ship_opening

    return Report(str(path) for path in chain(ship_diagrams(), [ship_opening()]))


COMMAND = Command(
    "recompute the results that the page opens with and that are shipped (some ten seconds)",
    "Recompute the bifurcation diagrams and the result of the opening scene that are shipped, and print the paths of "
    "the files. Needed after a change of the numerical code.",
    add=lambda parser: parser.add_argument(
        "--write", action="store_true", required=True, help="write them into assets"
    ),
    run=run,
)
