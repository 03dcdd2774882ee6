"""The table of the claims, and its page."""

from collections import Counter
from datetime import date
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "validation" / "verdict.md"
LIMIT = 0.02  # of the claims of a row that may be false or misleading
ROWS = {
    "a1": "“X leaves p %” of the headline, repeated as printed, from rest",
    "a2": "“X is to blame”: is another single number better? (false: by 1.5; misleading: by 1.2)",
    "a3": "“together”, “no number”: does one number alone remove three quarters of what can be removed?",
    "a4": "“at best X leaves p %”: below the total, and no single number leaves less",
    "a5": "“if one number alone is changed”: K, D, law, integrator, no step, repeated as printed",
    "a6": "the same: contact status, number of steps",
    "a7": "what is blamed leaves the motions something in common (not over 85 %, and half the total)",
    "a8": "“no K, D or time step”, “neither K nor D nor the step”: 44 pairs of K and D without a step",
    "a9": "“by errors that cancel”: the contact does not rebound as asked, or is not resolved",
    "b": "“the time step blurs”: size, and less with 4 or 16 times the steps",
    "c1": "kind and period of the reference, after 40,000 periods",
    "c2": "kind and period of the penalty solution, five times later or after 40,000 periods",
    "c3": "“the penalty solution …, the reference …”: they do differ",
    "c4": "“nothing touches”, “stay in contact all the time”, of both",
    "c5": "“nothing is to blame”: the difference is one by chance",
    "c6": "“a different but valid motion”, six times later",
    "d1": "impacts, contacts, contact time, against all events",
    "d2": "“with n contacts a period for m impacts”",
    "d3": "peak force, against every step",
    "d4": "energy lost, against an integral of the work",
    "d5": "“which D = … or K = … alone gives”: rebound of a contact alone, and in the motion",
    "d6": "“the bodies part with …”, “rebounds with …”",
    "d7": "“a contact lasts …”, “takes only n steps” (within 1.5 times of the median contact)",
    "e1": "the difference, by an error measure of its own",
    "e2": "parts add up",
    "e3": "word of the agreement against its number",
    "h": "“still changes”: later sections differ from it by more than from each other",
}


def counts(claims):
    """{row: Counter of outcomes}, in the order of ROWS."""
    found = {row: Counter() for row in ROWS}
    for each in claims:
        found[each.row][each.outcome] += 1
    return found


def beyond(claims, limit=LIMIT):
    """The rows with a larger share of false or misleading claims."""
    wrong = {row: count["false"] + count["misleading"] for row, count in counts(claims).items()}
    return [row for row, count in counts(claims).items() if wrong[row] > limit * sum(count.values())]


def table(claims):
    """The table, as Markdown."""
    lines = ["| | kind of claim | tested | true | false | misleading |", "|---|---|---|---|---|---|"]
    for row, count in counts(claims).items():
        numbers = (sum(count.values()), count["true"], count["false"], count["misleading"])
        lines.append(f"| {row} | {ROWS[row]} | {' | '.join(map(str, numbers))} |")
    return "\n".join(lines)


def page(claims, settings, seconds):
    """The page of the documentation that holds the table."""
    return f"""# Claims of the verdict, tested

Written by `python -m tests.claims --write` on {date.today():%-d %B %Y}: {settings} settings drawn at random,
{len(claims):,} claims, {seconds / 60:.0f} minutes of one processor.

The settings are of the paper's system and of random ones (two bodies or a wall, apart, touching or pressed together,
with forces and weights), η 0.5 to 4, K 10 to 1e5, D 0.1 to 100, 200 to 20,000 steps a period (2000 where steps cannot
be skipped), all contact statuses, integrators and laws. Each sentence of `compare` is read from its words and tested by
runs of `simulate` alone, with an error measure, an alignment and counts of its own (`tests/claims/`). A value counts by
the median of its neighbours within 10 %, so that luck does not. `make release` runs the check again, and fails if more
than 2 % of a row are false or misleading.

{table(claims)}
"""
