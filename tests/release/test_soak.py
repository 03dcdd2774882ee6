"""Memory stays flat while sessions open, move, visit every tab, export files, load one and close, for an hour.

It is measured while nobody is there: at the end of each quarter of the time all visitors leave, and the server frees
what they left. What it has then is code, caches and leaks. The caches of results hold a fixed number of entries and
fill in the first half of an hour, so that growth from the half to the end of an hour is a leak. A shorter soak ends
while they fill: its growth is printed and not judged; `test_leftovers` counts what visits leave. No thread, file
handle or task of theirs is left in either. ``RELEASE_SOAK`` sets the seconds.
"""

import os

from tests.release.odd import run
from tests.release.soak import ASKED, QUARTERS, TAKEN, THINKING, Soak
from tests.served import served

SECONDS = float(os.environ.get("RELEASE_SOAK", "3600"))
LAST_VISITS = 1200  # s that the visits may take that are under way at the end of a quarter
FLAT, HOUR = 0.02, 3600  # growth in the last half, as a share, of a soak that takes an hour
# Pools start their threads when they are needed, so that the first quarter may have met fewer than all of them.
SPARE = {"threads": 2, "handles": 4, "tasks": 2}


def test_soak(tmp_path, report):
    with served(tmp_path / "log.txt", VIBROSCOPE_LOG_LEVEL="warning") as server:
        soak = Soak(server, THINKING)
        run(soak.all_quarters(SECONDS), SECONDS + (1 + QUARTERS) * LAST_VISITS)
    judged = f"at most {FLAT:.0%}" if SECONDS >= HOUR else "not judged: caches fill for half an hour"
    report(f"soak of {SECONDS:.0f} s: {soak.sentence} ({judged})", sessions=soak.visits)
    assert {*TAKEN, *ASKED, "loaded", "measurement"} <= {what for what, count in soak.files.items() if count}
    if SECONDS >= HOUR:
        assert soak.growth < FLAT
    for what, spare in SPARE.items():
        assert soak.idle[-1][what] <= soak.idle[1][what] + spare, what
