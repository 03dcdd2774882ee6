"""``vibroscope diagram``: the bifurcation diagrams that are shipped."""

import argparse

from vibroscope.engine import ship_diagrams


def add(commands) -> None:
    """``vibroscope diagram``."""
    command = commands.add_parser(
        "diagram", help="recompute the bifurcation diagrams that are shipped (some ten seconds)"
    )
    command.add_argument("--write", action="store_true", required=True, help="write them into assets/diagrams")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Compute the shipped diagrams again and write them."""
    for path in ship_diagrams():
        print(path)
