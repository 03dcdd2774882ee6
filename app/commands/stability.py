"""``vibroscope stability``: the hard cases."""

import argparse


def add(commands) -> None:
    """``vibroscope stability``."""
    command = commands.add_parser(
        "stability", allow_abbrev=False, help="run the hard cases; exit status 1 if any is not as expected"
    )
    command.add_argument("--json", action="store_true", help="print one JSON list")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the hard cases and print."""
    from vibroscope.app.performance import stability

    return stability.run(as_json=options.json)
