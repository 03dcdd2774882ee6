"""The parser of the command line and of each command."""

import argparse

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

    def error(self, message: str):
        """Print the line and point to --help."""
        line = " ".join(message.splitlines())  # it may quote what holds line breaks
        self.exit(2, f"{self.prog}: {line} (see {self.prog} --help)\n")
