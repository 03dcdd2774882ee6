"""The parser of the command line and of each command."""

import argparse
import difflib

# Whatever takes a file has a metavar that begins so. `vibroscope completion` says how a shell completes one.
NAMES_OF_FILES = ("FILE", "PATH")
COMPLETED_AS_FILES: dict[str, str] = {}


class OneLineParser(argparse.ArgumentParser):
    """A parser that reports an error in one line and exits with status 2."""

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
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            # A word that follows an unknown option is its value.
            options = [word for word in unknown if word.startswith("-")]
            self.error("; ".join(map(self._unknown, options)) or f"{' '.join(unknown)} belongs to no option")
        return found, unknown

    def _unknown(self, word: str) -> str:
        name = word.partition("=")[0]
        options = [option for action in self._actions for option in action.option_strings]
        near = difflib.get_close_matches(name, options, n=1, cutoff=0.7)
        return f"{name} is no option" + (f": do you mean {near[0]}?" if near else "")

    def error(self, message: str):
        """Print the line and point to --help."""
        line = " ".join(message.splitlines())  # it may quote what holds line breaks
        self.exit(2, f"{self.prog}: {line} (see {self.prog} --help)\n")
