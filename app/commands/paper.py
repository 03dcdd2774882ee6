"""``vibroscope paper``: the claims of the paper, each checked now."""

import argparse
import json
from textwrap import wrap

from vibroscope.app.paper import CLAIMS, VERDICTS, Claim, Finding, as_dict, count_verdicts


def add(commands) -> None:
    """Describe ``vibroscope paper``."""
    command = commands.add_parser(
        "paper",
        allow_abbrev=False,
        help="check every claim of the paper; exit status 1 if any is not as known",
        description="Compute the paper's figures 3, 4, 6 and 9 to 14 anew and say of each claim whether it holds, with "
        "the numbers that were found, and the reason where it does not.",
    )
    command.add_argument("--json", action="store_true", help="print one JSON list")
    command.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Check all claims and print; returns the exit status, 1 if any is not as known."""
    checked = []
    for claim in CLAIMS.values():
        finding = claim.find()
        checked.append((claim, finding))
        if not options.json:
            print("\n".join(_lines(claim, finding)), flush=True)
    if options.json:
        print(json.dumps([as_dict(*each) for each in checked], ensure_ascii=False, allow_nan=False))
    else:
        print(_summary(checked))
    return int(not all(finding.agrees == claim.holds for claim, finding in checked))


def _lines(claim: Claim, finding: Finding) -> list[str]:
    verdict = f"{claim.verdict(finding):<{max(map(len, VERDICTS))}}"
    surprise = "" if finding.agrees == claim.holds else "   ✗ NOT as known"
    texts = [text for text in (finding.result, finding.reason) if text]
    return [f"{claim.name:<14} {verdict}  {claim.text}{surprise}", *map(_indented, texts)]


def _indented(text: str) -> str:
    return "\n".join(wrap(text, 118, initial_indent=24 * " ", subsequent_indent=24 * " "))


def _summary(checked: list[tuple[Claim, Finding]]) -> str:
    unknown = sum(finding.agrees != claim.holds for claim, finding in checked)
    outcome = "all as known" if not unknown else f"{unknown} NOT as known"
    return f"\n{len(checked)} claims: {count_verdicts(claim.verdict(finding) for claim, finding in checked)}; {outcome}"
