"""``vibroscope rules``: what rules of thumb give for a system, what motion follows, and whether they hold."""

import argparse
from textwrap import wrap

from vibroscope.app.codes.rules import RuleOutcome, RuleQuestion, judge, rules
from vibroscope.app.commands.codes import code_alone
from vibroscope.app.commands.numbers import count, measured
from vibroscope.app.commands.options import (
    PENALTY_OPTIONS,
    SCHEME_OPTIONS,
    add_fields,
    add_system_option,
    default_of,
    eta_of,
    refuse_missing,
    stepping_of,
    stiffness_of,
)
from vibroscope.app.commands.parser import Command, OneLineParser, entries
from vibroscope.app.commands.report import Report, progress_line
from vibroscope.app.explorer.method_words import full_words
from vibroscope.app.explorer.state import Setting
from vibroscope.engine import METHOD_NUMBERS, ComparisonQuestion, TimeStepping, counted, percent, written

_SET = Setting()  # what a rule does not give, unless it is given
_KEEP = default_of(ComparisonQuestion, "keep")
_COLUMNS = "{:<50} {:>9} {:>8} {:>7}  {:>7}  {:<6} {}"
_HOLDS = {True: "holds", False: "fails", None: "-"}


def add(command: OneLineParser) -> None:
    """Add the options."""
    command.add_argument("rules", nargs="*", metavar="RULE", help="only these, such as ansys-contact lsdyna-noise")
    add_fields(command, "eta", *PENALTY_OPTIONS, *SCHEME_OPTIONS)
    command.add_argument("--code", metavar="CODE", help="a code of `vibroscope codes`: its integrator, status and law")
    command.add_argument(
        "--element-stiffness",
        type=measured("stiffness"),
        metavar="F",
        help="E A/h of the elements in contact, of modulus E, area A and height h, in units of k1 or as '2e9 N/m': "
        "rules that are about it are judged only where it is given",
    )
    command.add_argument("--periods", type=count, metavar="N", help="excitation periods to run (default %(default)s)")
    add_system_option(command)


def run(options: argparse.Namespace) -> Report:
    """Judge the rules."""
    chosen = entries("rule", options.rules, rules())
    method = _method_of(options)
    asked = RuleQuestion(options.file.system, eta_of(options), method, options.element_stiffness)
    if not asked.system.excitation.drives:
        raise ValueError(
            "no rule can be judged, since nothing drives the bodies and a free vibration does not last: give what "
            "drives them in --system, or look at the free vibration with vibroscope compare --initial"
        )
    how = {"periods": options.periods, "keep": min(_KEEP, options.periods)}
    progress = progress_line(lambda done: f"{done:g} of {len(chosen)} rules", len(chosen))
    found = []
    for rule in chosen:
        found.append(judge(rule, asked, **how))
        if progress:
            progress(len(found))
    outcomes = [each.as_dict() for each in found]
    return Report(_lines(asked, found), {"eta": asked.eta, "method": str(asked.method), "rules": outcomes})


def _method_of(options: argparse.Namespace) -> TimeStepping:
    options.every_step = False
    if options.code is None:
        refuse_missing(options, "newmark")
        return stepping_of(options)
    return code_alone(options).method(stiffness_of(options), options.D, options.steps)


def _lines(asked: RuleQuestion, found: list[RuleOutcome]) -> list[str]:
    lines = [full_words(asked.method), f"eta = {asked.eta:g}", ""]
    lines.append(_COLUMNS.format("rule", "K", "D", "T/dt", "off by", "", "motion"))
    for each in found:
        lines += _row(each)
    lines += ["", "* given by the rule; the other numbers are those that are set"]
    return lines


def _row(found: RuleOutcome) -> list[str]:
    values = dict.fromkeys(METHOD_NUMBERS)
    if found.method is not None:
        values = found.method.numbers
    numbers = [
        "-" if value is None else f"{written(value)}{'*' if name in found.rule.gives else ' '}"
        for name, value in values.items()
    ]
    total = percent(found.total) if found.total == found.total else "-"
    head = _COLUMNS.format(found.rule.title, *numbers, total, _HOLDS[found.holds], found.motion)
    steps = f" {counted(found.without_solution, 'step')} without a solution." if found.without_solution else ""
    said = " ".join(filter(None, (found.rule.claim, f"{found.why}{steps}", found.contact)))
    why = f"{said} [{found.rule.key}: {found.rule.source}]"
    return [head.rstrip(), *wrap(why, 110, initial_indent="    ", subsequent_indent="    ")]


COMMAND = Command(
    "rules of thumb for K, D and the time step: what each gives here, and whether it holds",
    "Apply each rule of thumb to a system at one eta, run what it gives from rest, and compare with the reference. A "
    "rule holds if the part of the difference that its numbers cause is at most 10 %; one that claims a stable step "
    "holds if a run with central differences stays bounded.",
    f"What a rule does not give is --K, --D and --steps (default {_SET.K:g}, {_SET.D:g}, {_SET.steps}).",
    add,
    run,
    "one JSON object",
    {"K": _SET.K, "D": _SET.D, "steps": _SET.steps, "periods": default_of(ComparisonQuestion, "periods")},
)
