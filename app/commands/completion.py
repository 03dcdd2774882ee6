"""``vibroscope completion``: the script by which a shell completes commands, options, their values and files."""

import argparse
from importlib import import_module

from vibroscope.app.commands.parser import COMPLETED_AS_FILES, Command
from vibroscope.app.commands.report import Report

SHELLS = {
    "bash": "vibroscope completion bash > ~/.local/share/bash-completion/completions/vibroscope",
    "zsh": "vibroscope completion zsh > ~/.zfunc/_vibroscope   # a folder of fpath",
    "fish": "vibroscope completion fish > ~/.config/fish/completions/vibroscope.fish",
}


def run(options: argparse.Namespace) -> Report:
    """Make the script; it holds what the commands are now, so that it is made again after an upgrade."""
    import shtab  # no other command needs it

    COMPLETED_AS_FILES.update(shtab.FILE)
    # all commands import this one when they are described
    parser = import_module("vibroscope.app.commands.cli").build_parser()
    return Report([shtab.complete(parser, options.shell)])


COMMAND = Command(
    "print the script by which bash, zsh or fish completes this command line",
    "Print the script by which a shell completes commands, options, their values and files.",
    "\n".join(["to install it, for new shells:", *(f"  {line}" for line in SHELLS.values())]),
    add=lambda parser: parser.add_argument("shell", choices=tuple(SHELLS), help="which shell"),
    run=run,
)
