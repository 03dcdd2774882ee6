"""``vibroscope stability``: the hard cases, as a table or as JSON."""

from __future__ import annotations

import json
import math

from vibroscope.engine.hardcases.judgement import Outcome
from vibroscope.engine.hardcases.stability import stability

COLUMNS = "{:<55} {:<18} {:<10} {:>8} {:>8} {:>8} {:>8} {:>8} {:>10}"
HEAD = COLUMNS.format("case", "expected", "got", "error", "allowed", "energy", "allowed", "pierced", "us/period")
ABOUT = """\
error     largest difference of a state from the truth (from a finer solution for time steps, from the steady motion
          2 % into a million periods; for chaos, of a statistic, in standard errors), and what is allowed
energy    residual of the energy balance of a period, in units of the energy, and what is allowed
pierced   deepest penetration of the reference, in units of the largest displacement"""


def run(*, as_json: bool) -> int:
    """Run all hard cases and print what came out; returns the exit status, 1 if any is not as expected."""
    if as_json:
        outcomes = stability()
        print(json.dumps([as_dict(outcome) for outcome in outcomes], allow_nan=False))
    else:
        print(HEAD)
        outcomes = stability(progress=lambda outcome: print(row(outcome), flush=True))
        print(summary(outcomes))
    return int(not all(outcome.passed for outcome in outcomes))


def row(outcome: Outcome) -> str:
    """One line, and one more for each thing that is not as expected."""
    line = COLUMNS.format(
        outcome.case.name,
        outcome.case.expected,
        outcome.status,
        *(number(value) for value in (outcome.error, outcome.allowed)),
        *(number(value) for value in (outcome.residual, outcome.balanced)),
        number(outcome.penetration) if outcome.case.setup.method.name == "reference" else "",
        f"{outcome.microseconds:.1f}",
    )
    return "\n".join([line.rstrip(), *(f"    ✗ {failure}" for failure in outcome.failures)])


def number(value: float) -> str:
    """Two digits; nothing where there is no number."""
    return f"{value:.0e}".replace("0e+00", "0") if math.isfinite(value) else ""


def summary(outcomes: list[Outcome]) -> str:
    """What the columns mean, and how many cases are as expected."""
    failed = sum(not outcome.passed for outcome in outcomes)
    verdict = "all as expected" if not failed else f"{failed} NOT as expected"
    return f"\n{ABOUT}\n\n{len(outcomes)} cases, {verdict}"


def as_dict(outcome: Outcome) -> dict:
    """The contract for scripts; null where there is no number."""
    numbers = ("error", "allowed", "residual", "balanced", "penetration", "microseconds")
    return {
        "case": outcome.case.name,
        "expected": [str(status) for status in outcome.case.statuses],
        "status": str(outcome.status),
        "message": outcome.message,
        **{name: finite(getattr(outcome, name)) for name in numbers},
        "failures": list(outcome.failures),
        "passed": outcome.passed,
    }


def finite(value: float) -> float | None:
    """The number, or None."""
    return value if math.isfinite(value) else None
