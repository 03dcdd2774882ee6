"""What a command returns, and how it is printed: as text, or as JSON for scripts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, NamedTuple, TypeVar

if TYPE_CHECKING:  # each command imports this module
    from vibroscope.engine import Statement, Units

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
    text: str | Statement
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

    lines: Iterable[str | Statement | Row] = ()
    data: object = None
    units: Units | None = None
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


def printed(line: str | Statement | Row, units: Units | None) -> list[str]:
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


def checks(
    found: Iterable[Check],
    lines_of: Callable[[Check], Iterable[str]],
    as_dict: Callable[[Check], dict],
    passed: Callable[[Check], bool],
    summary: Callable[[Sequence[Check]], str],
    head: str | None = None,
) -> Report:
    """A report of checks, each printed when it is done; the exit status is 1 if any is not ``passed``."""
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
        yield summary(done)

    return Report(lines(), lambda: [as_dict(each) for each in run()], status=lambda: int(not all(map(passed, done))))
