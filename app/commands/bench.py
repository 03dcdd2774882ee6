"""``vibroscope bench``: cost and error of every solver."""

import argparse
import json


def add(commands) -> None:
    """``vibroscope bench``."""
    command = commands.add_parser(
        "bench", allow_abbrev=False, help="measure cost and error of every solver (half a minute)"
    )
    command.add_argument("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Measure and print."""
    from vibroscope.app.performance import bench

    found = bench.report()
    print(json.dumps(found, allow_nan=False) if options.json else bench.as_text(found))
