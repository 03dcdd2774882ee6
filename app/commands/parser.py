"""The parser of the command line and of each command."""

import argparse


class OneLineParser(argparse.ArgumentParser):
    """A parser that reports an error in one line and exits with status 2."""

    def error(self, message: str):
        """Print the line and point to --help."""
        line = " ".join(message.splitlines())  # it may quote what holds line breaks
        self.exit(2, f"{self.prog}: {line} (see {self.prog} --help)\n")
