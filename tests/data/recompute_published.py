"""Recompute the figures of assets/validation/cases.toml, from closed formulas or by high_precision.

    .venv/bin/python tests/data/recompute_published.py            compare with the file; status 1 if figures differ
    .venv/bin/python tests/data/recompute_published.py --write    put them into the file
    .venv/bin/python tests/data/recompute_published.py B1 B4      only the cases with these keys

Nothing here uses the engine. The numbers of the problems are written down again, as their sources give them, and not
read from the file, so that a slip in the file shows as a difference.
"""

import re
import sys
import tomllib
from pathlib import Path

from mpmath import mp, mpf
from published import CASES

FILE = Path(__file__).resolve().parents[2] / "assets" / "validation" / "cases.toml"
WORKING, DIGITS = 50, 17  # digits that are computed with, and written
SAME = 1e-14


def recomputed(key):
    """The figures of a case by what they are."""
    with mp.workdps(WORKING):
        return dict(CASES[key]())


def compare(keys):
    """Print the figures beside those of the file; returns whether all are the same."""
    same = True
    for case in tomllib.loads(FILE.read_text(encoding="utf-8"))["case"]:
        if keys and case["key"] not in keys:
            continue
        found = recomputed(case["key"])
        for quantity in case["quantity"]:
            value = found.pop(quantity["what"])
            agrees = abs(value / mpf(quantity["recomputed"]) - 1) < SAME
            same &= agrees
            print(f"{case['key']:14} {quantity['what']:40} {mp.nstr(value, DIGITS):>24} {'' if agrees else 'DIFFERS'}")
        if found:
            raise ValueError(f"{case['key']}: the file lacks {', '.join(found)}")
    return same


def write(keys):
    """Put the figures into the file, after the line of the figure that they belong to."""
    lines, key, what = FILE.read_text(encoding="utf-8").split("\n"), "", ""
    found = {}
    for i, line in enumerate(lines):
        given = re.match(r'(key|what) = "(.*)"', line)
        if given and given[1] == "key":
            key = given[2]
            found = recomputed(key) if not keys or key in keys else {}
        elif given:
            what = given[2]
        elif line.startswith("recomputed = ") and found:
            lines[i] = f"recomputed = {mp.nstr(found[what], DIGITS, strip_zeros=False)}"
    FILE.write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    chosen = [word for word in sys.argv[1:] if not word.startswith("--")]
    if "--write" in sys.argv:
        write(chosen)
    sys.exit(not compare(chosen))
