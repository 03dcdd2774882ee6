"""``vibroscope stability``: the hard cases, as a table or as JSON."""

import argparse
import json
import math

from vibroscope.engine import finite_or_none
from vibroscope.engine.hardcases.judgement import HardCaseOutcome, stability

_COLUMNS = "{:<55} {:<18} {:<10} {:>8} {:>8} {:>8} {:>8} {:>8} {:>10}"
_HEAD = _COLUMNS.format("case", "expected", "got", "error", "allowed", "energy", "allowed", "pierced", "us/period")
_LEGEND = """\
error     largest difference of a state from the truth (from a finer solution for time steps, from the steady motion
          2 % into a million periods; for chaos, of a statistic, in standard errors), and what is allowed
energy    residual of the energy balance of a period, in units of the energy, and what is allowed
pierced   deepest penetration of the reference, in units of the largest displacement"""


def add(commands) -> None:
    """Describe ``vibroscope stability``."""
    command = commands.add_parser(
        "stability",
        allow_abbrev=False,
        help="run the hard cases; exit status 1 if any is not as expected",
        description="Run every solver on the hard cases (grazing, chatter, stiff contacts, coarse steps, a million "
        "periods) and print its error beside the one that is allowed.",
    )
    command.add_argument("--json", action="store_true", help="print one JSON list")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the hard cases and print their outcomes; returns the exit status, 1 if any is not as expected."""
    if options.json:
        outcomes = stability()
        print(json.dumps([as_dict(outcome) for outcome in outcomes], allow_nan=False))
    else:
        print(_HEAD)
        outcomes = stability(progress=lambda outcome: print(_row(outcome), flush=True))
        print(_summary(outcomes))
    return int(not all(outcome.passed for outcome in outcomes))


def _row(outcome: HardCaseOutcome) -> str:
    """Format a case: one line, and one more for each result that is not as expected."""
    line = _COLUMNS.format(
        outcome.case.name,
        outcome.case.expected,
        outcome.status,
        *(_number(value) for value in (outcome.error, outcome.allowed)),
        *(_number(value) for value in (outcome.residual, outcome.balanced)),
        _number(outcome.penetration) if outcome.case.setup.method.name == "reference" else "",
        f"{outcome.microseconds:.1f}",
    )
    return "\n".join([line.rstrip(), *(f"    ✗ {failure}" for failure in outcome.failures)])


def _number(value: float) -> str:
    """One digit and the power of ten; empty where there is no number."""
    return f"{value:.0e}".replace("0e+00", "0") if math.isfinite(value) else ""


def _summary(outcomes: list[HardCaseOutcome]) -> str:
    """The meaning of the columns, and the number of cases that are as expected."""
    failed = sum(not outcome.passed for outcome in outcomes)
    verdict = "all as expected" if not failed else f"{failed} NOT as expected"
    return f"\n{_LEGEND}\n\n{len(outcomes)} cases, {verdict}"


def as_dict(outcome: HardCaseOutcome) -> dict:
    """The JSON of one case; None where there is no number."""
    numbers = ("error", "allowed", "residual", "balanced", "penetration", "microseconds")
    return {
        "case": outcome.case.name,
        "expected": [str(status) for status in outcome.case.statuses],
        "status": str(outcome.status),
        "message": outcome.message,
        **{name: finite_or_none(getattr(outcome, name)) for name in numbers},
        "failures": list(outcome.failures),
        "passed": outcome.passed,
    }
