"""What a command returns, and how it is printed: as text, or as JSON for scripts.

Output that the commands share: notes, progress, and numbers for JSON.
"""

import codecs
import contextlib
import os
import signal
import sys
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, NamedTuple, TypeVar

if TYPE_CHECKING:
    from vibroscope.engine import CompileProgress, Statement, Units


_BAR = 20  # characters
# What stands for a character that is neither a Greek letter nor made of ASCII characters.
_PAIRS = (
    "′ '  − -  – -  × x  · .  ± +-  √ sqrt  ≈ ~  ≤ <=  ≥ >=  → ->  ∞ inf  ≡ ==  ∫ int  ∮ oint  ’ '  “ \"  ” \"  ≫ >>"
    "  ∝ ~  ∓ -+  ∂ d  ○ o  □ []  △ ^  ▲ ^  ◆ <>  ★ *  ⊠ [x]  ⊞ [+]  ⊗ (x)  ⬢ (.)  ━ -  ╌ -  ✚ +  µ u  ✗ x  ⁻ -"
    "  ₋ -  ⋅ .  ″ ''  ‴ '''  ⁗ ''''  ø o"
)
_ASCII = {"°": " deg"} | dict(pair.split() for pair in _PAIRS.split("  "))


def open_streams() -> bool:
    """Make both output streams usable by any text; returns whether the standard output was open.

    A terminal or pipe whose encoding lacks Greek letters gets their names. A closed stream gets nothing.
    """
    was_open = sys.stdout is not None
    codecs.register_error("vibroscope", _as_ascii)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 - for the rest of the process
        elif hasattr(getattr(sys, name), "reconfigure"):
            getattr(sys, name).reconfigure(errors="vibroscope")
    return was_open


def _as_ascii(problem: UnicodeError) -> tuple[str, int]:
    """Handler of `codecs`: names in place of characters that cannot be written."""
    found = problem.object[problem.start : problem.end]
    return "".join(map(ascii_name, found)), problem.end


def ascii_name(character: str) -> str:
    """A character in ASCII: "eta" for η, "Omega" for Ω, "1" for ₁."""
    if character in _ASCII:
        return _ASCII[character]
    if unicodedata.combining(character):
        return ""
    words = unicodedata.name(character, "").split()
    if words[:1] == ["GREEK"] and "LETTER" in words:
        return words[-1].capitalize() if "CAPITAL" in words else words[-1].lower()
    plain = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    return plain or "?"


def write_csv(path: str, heads: Sequence[str], rows: Iterable[Iterable[object]]) -> None:
    """Write a table."""
    import csv  # few commands write a file

    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([heads, *rows])


def note(text: str) -> None:
    """Print a remark on stderr, so that it is no part of the output."""
    print(f"vibroscope: {text}", file=sys.stderr)


def progress_line(text: Callable[[float], str], end: float) -> Callable[[float], None] | None:
    """A function that prints ``text(done)`` on one line of the terminal until ``end``; None if there is no terminal."""
    if not sys.stderr.isatty():
        return None

    def show(done: float) -> None:
        print(f"\r{text(done)}", end="\n" if done >= end else "", file=sys.stderr, flush=True)

    return show


def show_compilation(progress: "CompileProgress | None") -> None:
    """Print how far the compilation is as a bar on one line of the terminal, which the next line overwrites.

    None: it is over.
    """
    if sys.stderr.isatty():
        text = "" if progress is None else compilation_text(progress)
        print(f"\x1b[K{text}", end="\r", file=sys.stderr, flush=True)


def compilation_text(progress: "CompileProgress") -> str:
    """How far the compilation is, short enough for a terminal."""
    done = round(_BAR * progress.share)
    return f"Compiling, once: [{'#' * done}{'.' * (_BAR - done)}] {100 * progress.share:3.0f} % {progress.what}"


@contextlib.contextmanager
def watch_interrupt() -> Iterator[Callable[[], bool]]:
    """Gives whether Ctrl-C was pressed: the first one ends the computation, the second ends the process as usual."""
    pressed = []

    def note(*_) -> None:
        pressed.append(True)
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, note)
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, before)


WIDTH = 18  # of the labels of rows
Line = "str | Statement | Row"  # what stands on a line of its own, or more
Check = TypeVar("Check")


class Row(NamedTuple):
    """A label and what it stands for; more lines stand below the first.

    Attributes
    ----------
    label : str
    text : str or Statement
    width : int
        Of a line, if it is wrapped; 0: it is not.
    indent : int
        Where the text begins.
    """

    label: str
    text: "str | Statement"
    width: int = 0
    indent: int = WIDTH


class Report(NamedTuple):
    """What a command found.

    Attributes
    ----------
    lines : iterable of str, Statement or Row
        The text. It is read only where it is printed, line by line.
    data : dict or list, or callable
        The JSON, as `app.runtime.json_text` writes it; a function of no arguments where it takes time, or follows from
        what was run for it.
    units : Units, optional
        Those of the statements.
    status : int, or callable
        The exit status; a function where the lines or the data decide it.
    """

    lines: "Iterable[str | Statement | Row]" = ()
    data: object = None
    units: "Units | None" = None
    status: int | Callable[[], int] = 0

    def show(self, as_json: bool) -> int:
        """Print it and return the exit status."""
        if as_json:
            from vibroscope.app.runtime.json_text import json_text  # with NumPy, which the command has imported by now

            print(json_text(self.data() if callable(self.data) else self.data, ascii_only=True))
        else:
            for line in self.lines:
                print("\n".join(printed(line, self.units)), flush=True)
        return self.status() if callable(self.status) else self.status


def printed(line: "str | Statement | Row", units: "Units | None") -> list[str]:
    """The lines that one part of a report takes."""
    from vibroscope.engine import print_statement  # when the engine is there: each command imports this module

    if isinstance(line, str):
        return [print_statement(line, units)]
    text, head = print_statement(line.text, units), f"{line.label:{line.indent}}"
    if not line.width:
        return [head + text]
    return wrap(text, line.width, initial_indent=head, subsequent_indent=" " * line.indent)


def rows(texts: dict[str, str], **how) -> list[Row]:
    """A row for each label whose text is not empty."""
    return [Row(label, text, **how) for label, text in texts.items() if text]


def record(of: object, *names: str, **others: str) -> dict[str, object]:
    """Attributes of an object for JSON: under their own ``names``, and ``others`` under new ones.

    An attribute of a part has a name with dots, as ``K="method.stiffness"``. Where the object or a part is None, so
    is what is found.
    """
    found = {}
    for key, path in (dict(zip(names, names, strict=True)) | others).items():
        value = of
        for name in path.split("."):
            value = None if value is None else getattr(value, name)
        found[key] = value
    return found


def checks(
    found: Iterable[Check],
    lines_of: Callable[[Check], Iterable[str]],
    as_dict: Callable[[Check], dict],
    passed: Callable[[Check], bool],
    right: str,
    summary: Callable[[Sequence[Check], str], str],
    head: str | None = None,
) -> Report:
    """A report of checks, each printed when it is done; the exit status is 1 if any is not ``passed``.

    ``summary`` gets them, and in words whether all are as they are to be: ``right``, such as "as expected".
    """
    done: list[Check] = []

    def run() -> Iterator[Check]:
        for each in found:
            done.append(each)
            yield each

    def lines() -> Iterator[str]:
        if head is not None:
            yield head
        for each in run():
            yield "\n".join(lines_of(each))
        wrong = sum(not passed(each) for each in done)
        yield summary(done, f"{wrong} NOT {right}" if wrong else f"all {right}")

    return Report(lines(), lambda: [as_dict(each) for each in run()], status=lambda: int(not all(map(passed, done))))
