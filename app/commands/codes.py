"""``vibroscope codes``: what simulation codes do by default, with the source of each figure."""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import fields
from textwrap import wrap

from vibroscope.app.codes.catalogue import Code, codes
from vibroscope.app.commands.options import LAW_OPTIONS, STEPPING_OPTIONS
from vibroscope.app.commands.parser import Command, entries, option
from vibroscope.app.commands.report import Report
from vibroscope.app.commands.translate import TRANSLATE
from vibroscope.engine import INTEGRATORS

_WIDTH = 100
_COLUMNS = "{:<18} {:<34} {:<9} {:<22} {}"


def run(options: argparse.Namespace) -> Report:
    """Show the table, or entries of it."""
    chosen = entries("code", options.codes, codes())
    lines = ["\n\n".join("\n".join(_entry(code)) for code in chosen)] if options.codes else _table(chosen)
    return Report(lines, [code.as_dict() for code in chosen])


def _table(chosen: Sequence[Code]) -> Iterator[str]:
    yield _COLUMNS.format("code", "integrator", "status", "law", "rules")
    for code in chosen:
        law, rules = code.law or "-", ", ".join(code.rules) or "-"
        yield _COLUMNS.format(code.key, _integrator(code), code.status or "-", law, rules)


def code_alone(options: argparse.Namespace) -> Code:
    """The code of ``--code``; raises ValueError where another option gives what it has."""
    names = ("located", *STEPPING_OPTIONS, *LAW_OPTIONS)
    given = [name for name in names if getattr(options, name, None) not in (None, False)]
    if given:
        raise ValueError(f"--code sets the integrator, status and law itself: leave {option(given[0])} out")
    return entries("code", [options.code], codes())[0]


def _integrator(code: Code) -> str:
    if not code.integrator:
        return "-"
    kind = INTEGRATORS[code.integrator]
    own = [each.name for each in fields(kind) if each.name in code.numbers]
    return " ".join([kind.name, *(f"{name}={code.numbers[name]:g}" for name in own)])


def _column(head: str, texts: Sequence[str]) -> list[str]:
    """Lines of an entry, with a head before the first."""
    return [f"  {head if not i else '':<18}{text}" for i, text in enumerate(texts)]


def _entry(code: Code) -> list[str]:
    """An entry at length."""
    rows = {
        "integrator": _integrator(code),
        "contact status": code.status or "-",
        "without solution": code.without_solution or "-",
        "contact law": " ".join(filter(None, (code.law or "-", code.exponent and f"exponent {code.exponent:g}"))),
        "damper": code.damper and f"from the {code.damper}",
        "start": code.initial_acceleration and f"acceleration {code.initial_acceleration}",
        "rules of thumb": ", ".join(code.rules) or "-",
        "not computed here": code.leaves_out,
    }
    lines = [f"{code.name} ({code.key})"]
    for name, text in rows.items():
        if text:
            lines += wrap(text, _WIDTH, initial_indent=f"  {name:<18}", subsequent_indent=20 * " ")
    own = code.integrators.get(code.integrator, ())
    others = {name: words for name, words in code.integrators.items() if name != code.integrator}
    lines += _column("input", (*own, *code.input))
    lines += _column("contact words", [" ".join(form.words) for form in code.contact])
    lines += _column("in its place", [f"{name}: {line}" for name, words in others.items() for line in words])
    for source in code.sources:
        text = f"{source.figure}: {source.text} {source.url}".strip()
        lines += wrap(text, _WIDTH, initial_indent=f"  {'source':<18}", subsequent_indent=20 * " ")
    return lines


SHOW = Command(
    "what simulation codes do by default; `vibroscope codes` alone does this, too",
    "Print the table of codes: default integrator with its numbers, contact status, contact law, rules of thumb, and "
    "the source of each figure. What no source says is a dash. Named codes are printed at length.",
    add=lambda parser: parser.add_argument(
        "codes", nargs="*", metavar="CODE", help="only these, such as calculix opensees, at length"
    ),
    run=run,
    json="one JSON list",
)
COMMAND = Command(
    "what simulation codes do by default: integrator, contact status, law, keywords of their input; translations",
    "Print what simulation codes do by default, or the contact of one code in the words of another.",
    below={"show": SHOW, "translate": TRANSLATE},
    otherwise="show",
)
