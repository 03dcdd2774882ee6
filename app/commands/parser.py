"""What a command is, and the parser of the command line and of each command."""

import argparse
import difflib
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, TypeVar

# Whatever takes a file has a metavar that begins so. `vibroscope completion` says how a shell completes one.
NAMES_OF_FILES = ("FILE", "PATH")
COMPLETED_AS_FILES: dict[str, str] = {}
Entry = TypeVar("Entry")


class OneLineParser(argparse.ArgumentParser):
    """A parser that reports an error in one line and exits with status 2."""

    def __init__(self, **how) -> None:
        super().__init__(allow_abbrev=False, **how)
        self.below: tuple[str, ...] = ()  # the commands below this one
        self.otherwise = ""  # that of them which runs where none is named
        self.not_here: dict[str, str] = {}  # options of other commands: why this one does not have them

    def add_argument(self, *names: str, **how) -> argparse.Action:
        """Add an argument, as `argparse` does; a file is marked as one for shells."""
        action = super().add_argument(*names, **how)
        if str(action.metavar).startswith(NAMES_OF_FILES):
            action.complete = COMPLETED_AS_FILES
        return action

    def parse_known_args(self, args=None, namespace=None):
        """Parse, as `argparse` does, but report what a command does not know as an error of that command.

        The parser of the whole command line would report it, and point to its own help, which names no option.
        """
        if self.otherwise and not (args and args[0] in (*self.below, "-h", "--help")):
            args = [self.otherwise, *(args or ())]
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            # A word that follows an unknown option is its value.
            options = [word for word in unknown if word.startswith("-")]
            self.error("; ".join(map(self._unknown, options)) or f"{' '.join(unknown)} belongs to no option")
        return found, unknown

    def _unknown(self, word: str) -> str:
        name = word.partition("=")[0]
        if name in self.not_here:
            return f"{name} is no option: {self.not_here[name]}"
        options = [option for action in self._actions for option in action.option_strings]
        near = difflib.get_close_matches(name, options, n=1, cutoff=0.7)
        return f"{name} is no option" + (f": do you mean {near[0]}?" if near else "")

    def error(self, message: str):
        """Print the line and point to --help."""
        line = " ".join(message.splitlines())  # it may quote what holds line breaks
        self.exit(2, f"{self.prog}: {line} (see {self.prog} --help)\n")


def option(name: str) -> str:
    """The option of a name in the parsed options."""
    return f"--{name.replace('_', '-')}"


def entries(kind: str, names: Sequence[str], known: Mapping[str, Entry]) -> list[Entry]:
    """The entries of a table that are named, all where none is; raises ValueError for one that it does not have."""
    from vibroscope.engine.arguments import near_names  # the command line begins before the engine is imported

    for name in names:
        if name not in known:
            near = near_names(name, known)
            meant = f"did you mean {' or '.join(near)}? " if near else ""
            raise ValueError(f"unknown {kind} {name[:60]!r}; {meant}known: {', '.join(known)}")
    return [known[name] for name in names or known]


class Command(NamedTuple):
    """A command, or one below another, as ``vibroscope sweep eta``.

    Attributes
    ----------
    help, description, epilog : str
        One line for the list of commands; what stands before and behind the options.
    add : callable
        Adds the options to a parser.
    run : callable
        What the command does with the parsed options. It returns a `Report`, which is printed as text or JSON, an exit
        status, or None. `ValueError` is bad input, `OSError` a file that cannot be read or written.
    json : str
        What ``--json`` prints; empty where there is no such option.
    defaults : mapping
        Values of the options where they are not given.
    below : mapping of str to Command
        Commands below this one, by their names.
    otherwise : str
        That of them which runs where none is named; empty where one has to be.
    """

    help: str
    description: str = ""
    epilog: str = ""
    add: Callable[[OneLineParser], None] = lambda parser: None
    run: Callable[[argparse.Namespace], object] | None = None
    json: str = ""
    defaults: Mapping[str, object] = {}
    below: Mapping[str, "Command"] = {}
    otherwise: str = ""

    def describe(self, commands, name: str) -> None:
        """Add a parser with this name."""
        texts = {"help": self.help, "description": self.description or self.help, "epilog": self.epilog}
        if "\n" in self.epilog:
            texts["formatter_class"] = argparse.RawDescriptionHelpFormatter
        parser = commands.add_parser(name, **texts)
        if self.below:
            metavar = "COMMAND" if self.otherwise else "STUDY"
            place = parser.add_subparsers(dest="study", required=True, metavar=metavar)
            for each, command in self.below.items():
                command.describe(place, each)
            parser.below, parser.otherwise = tuple(self.below), self.otherwise
        self.add(parser)
        if self.json:
            parser.add_argument("--json", action="store_true", help=f"print {self.json}")
        parser.set_defaults(**{"run": self.run, "json": False} | self.defaults)
