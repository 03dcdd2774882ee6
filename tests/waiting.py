"""How long tests wait for what comes within moments, but not on a machine that does much else."""

import time

PATIENCE = 120.0  # s


def wait_until(holds, seconds=PATIENCE, what=""):
    """Poll ``holds`` until it is true, less often the longer that takes: in a browser a look costs a small update."""
    end, pause = time.monotonic() + seconds, 0.03
    while not holds():
        if time.monotonic() > end:
            raise AssertionError(f"not within {seconds} s: {what or holds}")
        time.sleep(pause)
        pause = min(1.2 * pause, 0.2)
