"""``vibroscope paper``: the claims of the paper, each checked now."""

import argparse
from collections.abc import Sequence
from textwrap import wrap

from vibroscope.app.commands.parser import Command
from vibroscope.app.commands.report import Report, checks
from vibroscope.app.paper import CLAIMS, VERDICTS, Claim, Finding, as_dict, count_verdicts

Checked = tuple[Claim, Finding]


def run(options: argparse.Namespace) -> Report:
    """Check all claims."""
    found = ((claim, claim.find()) for claim in CLAIMS.values())
    return checks(found, _lines, lambda checked: as_dict(*checked), _is_known, "as known", _summary)


def _is_known(checked: Checked) -> bool:
    claim, finding = checked
    return finding.agrees == claim.holds


def _lines(checked: Checked) -> list[str]:
    claim, finding = checked
    verdict = f"{claim.verdict(finding):<{max(map(len, VERDICTS))}}"
    surprise = "" if _is_known(checked) else "   ✗ NOT as known"
    lines = [f"{claim.name:<14} {verdict}  {claim.text}{surprise}"]
    for text in filter(None, (finding.result, finding.reason)):
        lines += wrap(text, 118, initial_indent=24 * " ", subsequent_indent=24 * " ")
    return lines


def _summary(checked: Sequence[Checked], outcome: str) -> str:
    return f"\n{len(checked)} claims: {count_verdicts(claim.verdict(finding) for claim, finding in checked)}; {outcome}"


COMMAND = Command(
    "check every claim of the paper; exit status 1 if any is not as known",
    "Compute the paper's figures 3, 4, 6 and 9 to 14 anew and say of each claim whether it holds, with the numbers "
    "that were found, and the reason where it does not.",
    run=run,
    json="one JSON list",
)
