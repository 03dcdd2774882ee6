"""``python -m tests.claims [--settings N] [--from N] [--write]``: judge settings, print the table, write its page."""

import argparse
import os
import time

from tests.claims.judge import judge
from tests.claims.settings import command, draw
from tests.claims.table import PAGE, page, table


def main():
    """Judge settings drawn at random; what is not true is printed at once."""
    parser = argparse.ArgumentParser(prog="python -m tests.claims", description=main.__doc__)
    parser.add_argument("--settings", type=int, default=200, metavar="N")
    parser.add_argument("--from", type=int, default=0, dest="first", metavar="N", help="the first one's number")
    parser.add_argument("--write", action="store_true", help=f"write {PAGE.name}")
    options = parser.parse_args()
    found, spent = [], time.process_time()
    for number in range(options.first, options.first + options.settings):
        found += judged(number)
        print(f"{number}: {time.process_time() - spent:.0f} s", flush=True)
    print(table(found))
    if options.write:
        PAGE.write_text(page(found, options.settings, time.process_time() - spent))


def judged(number):
    """The claims of a setting; those that are not true are printed."""
    setting = draw(number)
    claims, words = judge(setting)
    wrong = [each for each in claims if each.outcome != "true"]
    if wrong:
        print(f"{number}: {command(setting)}\n    {words.headline}", flush=True)
    for each in wrong:
        print(f"    {each.row} {each.outcome}: {each.text}", flush=True)
    return claims


if __name__ == "__main__":
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    main()
