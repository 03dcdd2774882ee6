"""The command line ``vibroscope COMMAND``; each command is a module of this package."""

import argparse
import atexit
import contextlib
import gc
import os
import re
import sys
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from pathlib import Path

from vibroscope.app import QUESTION
from vibroscope.app.commands.parser import OneLineParser, option
from vibroscope.app.commands.report import Report, open_streams

# In the order of `vibroscope --help`; each is a module of this package with its `Command`.
COMMANDS = (
    "simulate",
    "motion",
    "compare",
    "peaks",
    "transient",
    "impact",
    "recommend",
    "codes",
    "rules",
    "serve",
    "bench",
    "stability",
    "paper",
    "validate",
    "diagram",
    "sweep",
    "branch",
    "system",
    "measurement",
    "export",
    "warm",
    "completion",
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

WRITTEN = "out", "history", "write", "spectrum", "transmissibility"  # options that name a file to write

_NEGATIVE = re.compile(r"-\.?\d.*", re.DOTALL)  # no option begins so


class _Version(argparse.Action):
    """Prints the version, which is looked up only then."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"vibroscope {version('vibroscope')}")
        parser.exit()


def build_parser(names: Sequence[str] = COMMANDS) -> argparse.ArgumentParser:
    """The parser of the whole command line, or of the commands of these names alone."""
    parser = OneLineParser(
        prog="vibroscope",
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show program's version number and exit")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=OneLineParser)
    for name in names:
        import_module(f"vibroscope.app.commands.{name}").COMMAND.describe(commands, name)
    return parser


def join_negative(arguments: Sequence[str]) -> list[str]:
    """The arguments with values that begin with a negative number joined to their options.

    As ``--initial -1,0,0,0`` and ``--mass -1kg``, whose values argparse takes for options.
    """
    words: list[str] = []
    for word in arguments:
        if words and words[-1].startswith("--") and "=" not in words[-1] and _NEGATIVE.fullmatch(word):
            words[-1] += f"={word}"
        else:
            words.append(word)
    return words


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit status. Without arguments it is a program: it takes those of the process."""
    if arguments is not None:
        return _run_until_stopped(join_negative(arguments))
    status: list[int] = []
    atexit.register(_end_process, status)
    gc.disable()  # nothing that is imported becomes garbage
    try:
        status.append(_run_until_stopped(join_negative(sys.argv[1:])))
    except SystemExit as end:  # help, or bad arguments
        status.append(_status_of(end))
        raise
    return status[0]


def _status_of(end: SystemExit) -> int:
    """The exit status that Python gives such an end: without a code success, with a text, which it prints, failure."""
    if end.code is None:
        return 0
    return end.code & 0xFF if isinstance(end.code, int) else 1


def _end_process(status: list[int]) -> None:
    """End the process without clearing its memory, which takes a seventh of the time of a short run.

    Registered first, this runs when all threads have ended and all else has been done that was left for the end.
    """
    if status:  # else an exception is to be shown
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError):  # its reader has closed it
                stream.flush()
        os._exit(status[0])


@cache
def _leave_out_imports() -> None:
    """Import Numba without SciPy and YAML, which stay usable: no kernel needs them, and a short run starts sooner.

    Numba checks the version of SciPy, and looks for its BLAS when the module below is imported. It reads a file of
    settings by YAML, if there is one.
    """
    names = ["scipy"] if Path(".numba_config.yaml").exists() else ["scipy", "yaml"]
    hidden = [name for name in names if name not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # whose import then fails, as where they are not installed
    try:
        import_module("numba.np.arraymath")
    finally:
        for name in hidden:
            del sys.modules[name]


def _refuse_overwriting(words: Sequence[str], options: argparse.Namespace) -> None:
    """Raise ValueError where a file that is there and is to be written is named twice: it may be read as well."""
    named = [Path(word.rpartition("=")[2]).resolve() for word in words]
    for name in WRITTEN:
        path = getattr(options, name, None)
        if isinstance(path, str | Path) and Path(path).is_file() and named.count(Path(path).resolve()) > 1:
            raise ValueError(f"{option(name)} {path}: this command has the same file twice; give another name")


def _run_until_stopped(words: Sequence[str]) -> int:
    """Run a command, or say that it was stopped, be it while it is still imported."""
    try:
        return _run(words)
    except KeyboardInterrupt:
        print(f"\nvibroscope {words[0] if words else ''}: stopped by Ctrl-C before its end", file=sys.stderr)
        return 130


def _run(words: Sequence[str]) -> int:
    was_open = open_streams()
    _leave_out_imports()
    # Only the command that is run is imported: all of them together take as long as a short run.
    parser = build_parser(words[:1] if words and words[0] in COMMANDS else COMMANDS)
    if not words:
        parser.print_help(sys.stderr)
        return 2
    options = parser.parse_args(words)
    name = " ".join(filter(None, ("vibroscope", options.command, getattr(options, "study", None))))
    if not gc.isenabled():  # this is a program
        gc.freeze()
        gc.enable()
    numbers, typed = import_module("vibroscope.app.commands.numbers"), {}
    try:
        _refuse_overwriting(words, options)
        typed.update(numbers.resolve_units(options))
        found = options.run(options)
        status = found.show(options.json) if isinstance(found, Report) else found
        sys.stdout.flush()
    except BrokenPipeError:  # the reader of the output has closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as problem:
        where = f"{problem.filename}: " if problem.filename else ""
        print(f"{name}: {where}{problem.strerror or problem}", file=sys.stderr)
        return 1
    except ValueError as problem:
        print(f"{name}: {numbers.as_typed(str(problem), typed, getattr(options, 'file', None))}", file=sys.stderr)
        return 2
    if not was_open and options.command != "serve":  # whose output nobody needs
        print(f"{name}: the standard output is closed, so that nothing was printed", file=sys.stderr)
        return status or 1
    return status or 0
