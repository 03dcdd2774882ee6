"""``vibroscope diagram``: the results that are shipped: bifurcation diagrams, and what the page opens with."""

import argparse

from vibroscope.engine import ship_diagrams


def add(commands) -> None:
    """``vibroscope diagram``."""
    command = commands.add_parser(
        "diagram",
        help="recompute the results that the page opens with and that are shipped (some ten seconds)",
        description="Recompute the bifurcation diagrams and the result of the opening scene that are shipped, and "
        "print the paths of the files. Needed after a change of the numerical code.",
    )
    command.add_argument("--write", action="store_true", required=True, help="write them into assets")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Compute what is shipped again and write it."""
    from vibroscope.app.explorer.shipped import ship_opening

    for path in (*ship_diagrams(), ship_opening()):
        print(path)
