"""What the commands print in the same way: notes, progress, and numbers for JSON."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # each command imports this module, and importing the compilation imports every kernel
    from vibroscope.engine import CompileProgress

_BAR = 20  # characters


def note(text: str) -> None:
    """Print a remark on stderr, so that it is no part of the output."""
    print(f"vibroscope: {text}", file=sys.stderr)


def finite_or_none(value: float) -> float | None:
    """The number, or None where it is infinite or not a number, which JSON cannot hold."""
    return value if math.isfinite(value) else None


def progress_line(text: Callable[[float], str], end: float) -> Callable[[float], None] | None:
    """A function that prints ``text(done)`` on one line of the terminal until ``end``; None if there is no terminal."""
    if not sys.stderr.isatty():
        return None

    def show(done: float) -> None:
        print(f"\r{text(done)}", end="\n" if done >= end else "", file=sys.stderr, flush=True)

    return show


def show_compilation(progress: CompileProgress | None) -> None:
    """Print how far the compilation is as a bar on one line of the terminal, which the next line overwrites.

    None: it is over.
    """
    if sys.stderr.isatty():
        text = "" if progress is None else compilation_text(progress)
        print(f"\x1b[K{text}", end="\r", file=sys.stderr, flush=True)


def compilation_text(progress: CompileProgress) -> str:
    """How far the compilation is, short enough for a terminal."""
    done = round(_BAR * progress.share)
    return f"Compiling, once: [{'#' * done}{'.' * (_BAR - done)}] {100 * progress.share:3.0f} % {progress.what}"
