"""``vibroscope completion``: the script by which a shell completes commands, options, their values and files."""

import argparse
from importlib import import_module

from vibroscope.app.commands.parser import COMPLETED_AS_FILES

SHELLS = {
    "bash": "vibroscope completion bash > ~/.local/share/bash-completion/completions/vibroscope",
    "zsh": "vibroscope completion zsh > ~/.zfunc/_vibroscope   # a folder of fpath",
    "fish": "vibroscope completion fish > ~/.config/fish/completions/vibroscope.fish",
}


def add(commands) -> None:
    """Describe ``vibroscope completion``."""
    command = commands.add_parser(
        "completion",
        allow_abbrev=False,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        help="print the script by which bash, zsh or fish completes this command line",
        description="Print the script by which a shell completes commands, options, their values and files.",
        epilog="\n".join(["to install it, for new shells:", *(f"  {line}" for line in SHELLS.values())]),
    )
    command.add_argument("shell", choices=tuple(SHELLS), help="which shell")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the script; it holds what the commands are now, so that it is made again after an upgrade."""
    import shtab  # no other command needs it

    COMPLETED_AS_FILES.update(shtab.FILE)
    # all commands import this one when they are described
    print(shtab.complete(import_module("vibroscope.app.commands.cli").build_parser(), options.shell))
