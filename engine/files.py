"""Files from outside: read no further than they may be long, and named in whatever is wrong with them."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")


def read_file(path: str | Path, size_limit: int, parse: Callable[[bytes], T]) -> T:
    """What ``parse`` makes of the bytes of a file; of one that is too large it is given one byte more than the limit.

    Raises
    ------
    ValueError
        If the file cannot be read, or what ``parse`` raised: one line that begins with the path.
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
