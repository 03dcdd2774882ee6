"""``vibroscope warm``: compile every kernel ahead of the first start."""

import argparse

from vibroscope.app.commands.parser import Command
from vibroscope.app.commands.report import show_compilation
from vibroscope.engine import compile_kernels


def run(options: argparse.Namespace) -> None:
    """Compile every kernel, or load it from the cache."""
    compile_kernels(show_compilation, processes=None)
    show_compilation(None)


COMMAND = Command(
    "compile every kernel now, so that the first start is quick",
    "Compile every kernel that the cache folder does not have: two to three minutes on two cores the first time, and "
    "again after an upgrade or a change of the engine.",
    run=run,
)
