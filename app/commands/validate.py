"""``vibroscope validate``: published figures of other people beside ours."""

import argparse
import json
from textwrap import wrap

from vibroscope.app.validation import ComparedFigure, PublishedCase, as_dict, cases, validate

_COLUMNS = "  {:<46} {:>15} {:>15} {:>15} {:>10} {:>8}"
_HEAD = _COLUMNS.format("what", "published", "recomputed", "ours", "difference", "seconds")
_ROUNDING = 1e-14
_OF_FORMULA = "*"
_LEGEND = """\
*            the source prints a formula and no figure: its value, from a formula that was derived again
recomputed   with 50 digits, independently of the engine
difference   of our figure from the published one, relative to that
seconds      of the first figure of a case with its solution, and with what had to be compiled"""


def add(commands) -> None:
    """Describe ``vibroscope validate``."""
    command = commands.add_parser(
        "validate",
        allow_abbrev=False,
        help="compare with published figures; exit status 1 if ours is not the recomputed one",
        description="Solve published problems and print the published figure, the same recomputed with many digits, "
        "and ours. Where the published figure is itself off, the reason stands below it.",
    )
    command.add_argument("cases", nargs="*", metavar="CASE", help="only the cases with these keys, such as B2")
    command.add_argument("--json", action="store_true", help="print one JSON list")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Compare all figures and print; returns the exit status, 1 if any is not as recomputed."""
    found = []
    for case in _chosen(options.cases):
        compared = list(validate([case]))
        found += compared
        if not options.json:
            print("\n".join(_lines(case, compared)), flush=True)
    if options.json:
        print(json.dumps([as_dict(each) for each in found], ensure_ascii=False, allow_nan=False))
    else:
        print(_summary(found))
    return int(not all(each.agrees for each in found))


def _chosen(keys: list[str]) -> list[PublishedCase]:
    known = {case.key: case for case in cases()}
    for key in keys:
        if key not in known:
            raise ValueError(f"unknown case {key[:60]!r}; known: {', '.join(known)}")
    return [known[key] for key in keys] if keys else list(known.values())


def _lines(case: PublishedCase, compared: list[ComparedFigure]) -> list[str]:
    lines = ["", f"{case.key}  {case.title}", *wrap(case.source, 116, initial_indent="  ", subsequent_indent="  ")]
    lines.append(_HEAD)
    for each in compared:
        quantity = each.quantity
        published = _number(quantity.published) + (_OF_FORMULA if case.formula else "")
        numbers = (_number(quantity.recomputed), _number(each.ours))
        what = f"{quantity.what} [{quantity.unit}]" if quantity.unit else quantity.what
        lines.append(_COLUMNS.format(what, published, *numbers, _share(each.difference), f"{each.seconds:.2f}"))
        if not each.agrees:
            lines.append(f"    ✗ {each.error:.1e} from the recomputed figure, allowed {quantity.within:.0e}")
        if quantity.note:
            lines += wrap(quantity.note, 116, initial_indent="    ", subsequent_indent="    ")
    return lines


def _number(x: float | None) -> str:
    return "" if x is None else f"{x:.9g}"


def _share(difference: float | None) -> str:
    """A relative difference; 0 if it is only rounding."""
    if difference is None:
        return ""
    return f"{difference:.1e}" if abs(difference) > _ROUNDING else "0"


def _summary(found: list[ComparedFigure]) -> str:
    off = sum(not each.agrees for each in found)
    verdict = "all as recomputed" if not off else f"{off} NOT as recomputed"
    return f"\n{_LEGEND}\n\n{len(found)} figures of {len({each.case.key for each in found})} cases, {verdict}"
