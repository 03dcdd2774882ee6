"""``vibroscope warm``: compile every kernel ahead of the first start."""

import argparse
from dataclasses import replace

from vibroscope.engine import Cells, ExactPenalty, Newmark, Reference, System, run_cells, simulate, steady


def add(commands) -> None:
    """Describe ``vibroscope warm``."""
    command = commands.add_parser("warm", help="compile every kernel now, so that the first start is quick")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Compile every kernel, or load it from the cache."""
    newmark = Newmark(2500.0, 8.0, 2000)
    for method in (
        Reference(),
        ExactPenalty(2500.0, 8.0),
        newmark,
        replace(newmark, every_step=True),
        replace(newmark, located=True),
    ):
        simulate(System(), 1.08, method, periods=2, keep=1)
    steady(System(), 1.08, Reference())
    for method in (Reference(), ExactPenalty(2500.0, 8.0), newmark):
        run_cells(Cells(System(), [1.08], method), transient=1, sample=2)
