"""``vibroscope stability``: the hard cases, as a table or as JSON."""

import argparse
import math
from collections.abc import Iterator, Sequence

from vibroscope.app.commands.parser import Command
from vibroscope.app.commands.report import Report, checks, record
from vibroscope.engine.hardcases.cases import hard_cases
from vibroscope.engine.hardcases.judgement import HardCaseOutcome, outcome

_COLUMNS = "{:<55} {:<18} {:<10} {:>8} {:>8} {:>8} {:>8} {:>8} {:>10}"
_HEAD = _COLUMNS.format("case", "expected", "got", "error", "allowed", "energy", "allowed", "pierced", "us/period")
_LEGEND = """\
error     largest difference of a state from the truth (from a finer solution for time steps, from the steady motion
          2 % into a million periods; for chaos, of a statistic, in standard errors), and what is allowed
energy    residual of the energy balance of a period, in units of the energy, and what is allowed
pierced   deepest penetration of the reference, in units of the largest displacement"""


def run(options: argparse.Namespace) -> Report:
    """Run the hard cases."""
    return checks(map(outcome, hard_cases()), _lines, as_dict, lambda each: each.passed, "as expected", _summary, _HEAD)


def _lines(found: HardCaseOutcome) -> Iterator[str]:
    """A case: one line, and one more for each result that is not as expected."""
    of_reference = found.case.setup.method.name == "reference"
    numbers = (
        found.error,
        found.allowed,
        found.residual,
        found.balanced,
        found.penetration if of_reference else math.nan,
    )
    yield _COLUMNS.format(
        found.case.name, found.case.expected, found.status, *map(_number, numbers), f"{found.microseconds:.1f}"
    ).rstrip()
    yield from (f"    ✗ {failure}" for failure in found.failures)


def _number(value: float) -> str:
    """One digit and the power of ten; empty where there is no number."""
    return f"{value:.0e}".replace("0e+00", "0") if math.isfinite(value) else ""


def _summary(outcomes: Sequence[HardCaseOutcome], verdict: str) -> str:
    """The meaning of the columns, and the number of cases that are as expected."""
    return f"\n{_LEGEND}\n\n{len(outcomes)} cases, {verdict}"


def as_dict(found: HardCaseOutcome) -> dict:
    """The JSON of one case; None where there is no number."""
    numbers = ("error", "allowed", "residual", "balanced", "penetration", "microseconds")
    return {
        "case": found.case.name,
        "expected": [str(status) for status in found.case.statuses],
        "status": str(found.status),
        **record(found, "message", *numbers, "failures", "passed"),
    }


COMMAND = Command(
    "run the hard cases; exit status 1 if any is not as expected",
    "Run every solver on the hard cases (grazing, chatter, stiff contacts, coarse steps, a million periods) and print "
    "its error beside the one that is allowed.",
    run=run,
    json="one JSON list",
)
