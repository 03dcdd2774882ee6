"""``vibroscope validate``: published figures of other people beside ours."""

import argparse
from collections.abc import Sequence
from textwrap import wrap

from vibroscope.app.commands.parser import Command, entries
from vibroscope.app.commands.report import Report, checks
from vibroscope.app.validation import ComparedFigure, as_dict, cases, validate

_COLUMNS = "  {:<46} {:>15} {:>15} {:>15} {:>10} {:>8}"
_HEAD = _COLUMNS.format("what", "published", "recomputed", "ours", "difference", "seconds")
_ROUNDING = 1e-14
_OF_FORMULA = "*"
_LEGEND = """\
*            the source prints a formula and no figure: its value, from a formula that was derived again
recomputed   with 50 digits, independently of the engine
difference   of our figure from the published one, relative to that
seconds      of the first figure of a case with its solution, and with what had to be compiled"""


def run(options: argparse.Namespace) -> Report:
    """Compare all figures."""
    return checks(
        validate(entries("case", options.cases, {case.key: case for case in cases()})),
        _lines,
        as_dict,
        lambda each: each.agrees,
        "as recomputed",
        _summary,
    )


def _lines(found: ComparedFigure) -> list[str]:
    """A figure; before the first one of a case, what the case is."""
    case, quantity, lines = found.case, found.quantity, []
    if quantity is case.quantities[0]:
        source = wrap(case.source, 116, initial_indent="  ", subsequent_indent="  ")
        lines += ["", f"{case.key}  {case.title}", *source, _HEAD]
    published = _number(quantity.published) + (_OF_FORMULA if case.formula else "")
    numbers = (published, _number(quantity.recomputed), _number(found.ours))
    what = f"{quantity.what} [{quantity.unit}]" if quantity.unit else quantity.what
    lines.append(_COLUMNS.format(what, *numbers, _share(found.difference), f"{found.seconds:.2f}"))
    if not found.agrees:
        lines.append(f"    ✗ {found.error:.1e} from the recomputed figure, allowed {quantity.within:.0e}")
    return lines + wrap(quantity.note or "", 116, initial_indent="    ", subsequent_indent="    ")


def _number(x: float | None) -> str:
    return "" if x is None else f"{x:.9g}"


def _share(difference: float | None) -> str:
    """A relative difference; 0 if it is only rounding."""
    if difference is None:
        return ""
    return f"{difference:.1e}" if abs(difference) > _ROUNDING else "0"


def _summary(found: Sequence[ComparedFigure], verdict: str) -> str:
    return f"\n{_LEGEND}\n\n{len(found)} figures of {len({each.case.key for each in found})} cases, {verdict}"


COMMAND = Command(
    "compare with published figures; exit status 1 if ours is not the recomputed one",
    "Solve published problems and print the published figure, the same recomputed with many digits, and ours. Where "
    "the published figure is itself off, the reason stands below it.",
    add=lambda parser: parser.add_argument(
        "cases", nargs="*", metavar="CASE", help="only the cases with these keys, such as B2"
    ),
    run=run,
    json="one JSON list",
)
