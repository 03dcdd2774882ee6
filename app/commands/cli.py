"""The command line ``vibroscope COMMAND``; each command is a module of this package."""

import argparse
import os
import sys
from collections.abc import Sequence
from importlib.metadata import version

from vibroscope.app import QUESTION
from vibroscope.app.commands import (
    bench,
    compare,
    diagram,
    measurement,
    motion,
    paper,
    recommend,
    serve,
    simulate,
    stability,
    sweep,
    system,
    warm,
)
from vibroscope.app.commands.options import OneLineParser

COMMANDS = (
    simulate,
    motion,
    compare,
    recommend,
    serve,
    bench,
    stability,
    paper,
    diagram,
    sweep,
    system,
    measurement,
    warm,
)

DESCRIPTION = f"""\
{QUESTION}
Two pendulums on a shaken base hit, chatter, stick and part; a semi-analytical reference
and the penalty model (Newmark, constant step) are solved and compared."""

EXAMPLES = """\
examples:
  vibroscope serve                                  open the explorer on this machine
  vibroscope simulate --solver reference --eta 1.08
  vibroscope simulate --solver newmark --eta 2.76 --K 12000 --D 18 --steps 8000 --json
  vibroscope simulate --solver exact --eta 2.76 --K 12000 --D 18
"""


def build_parser() -> argparse.ArgumentParser:
    """The parser of the whole command line."""
    parser = OneLineParser(
        prog="vibroscope",
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"vibroscope {version('vibroscope')}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=OneLineParser)
    for command in COMMANDS:
        command.add(commands)
    return parser


def join_initial(arguments: Sequence[str]) -> list[str]:
    """The arguments with ``--initial -1,0,0,0`` joined into one word, since argparse takes -1,0,0,0 for an option."""
    words: list[str] = []
    for word in arguments:
        if words and words[-1] == "--initial":
            words[-1] = f"--initial={word}"
        else:
            words.append(word)
    return words


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit status."""
    options = build_parser().parse_args(join_initial(sys.argv[1:] if arguments is None else arguments))
    try:
        status = options.run(options)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader of the output has closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as problem:
        print(f"vibroscope {options.command}: {problem.strerror or problem}", file=sys.stderr)
        return 1
    except ValueError as problem:
        print(f"vibroscope {options.command}: {problem}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return status or 0
