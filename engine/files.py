"""Read files that users give: bounded in size, and with errors that name the file."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")


def read_file(path: str | Path, size_limit: int, parse: Callable[[bytes], T]) -> T:
    """Read a file and return what ``parse`` makes of its bytes.

    At most ``size_limit + 1`` bytes are read, so ``parse`` recognises a file that is too large by its length.

    Raises
    ------
    ValueError
        If the file cannot be read or ``parse`` refuses its content: one line that begins with the path.
    """
    try:
        with open(path, "rb") as file:
            content = file.read(size_limit + 1)
    except OSError as problem:
        raise ValueError(f"{path}: cannot be read: {problem.strerror or problem}") from None
    try:
        return parse(content)
    except ValueError as problem:
        raise ValueError(f"{path}: {problem}") from None
