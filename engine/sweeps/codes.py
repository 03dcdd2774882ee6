"""Numbers that stand for words in a result."""

from ..cells import STATUSES

MISSING = -1  # status and other flags of a cell that was not computed yet
STATUS_FLAGS = {str(status): i for i, status in enumerate(STATUSES)} | {"missing": MISSING}
MOTIONS = {"aperiodic": 0, "periodic": 1, "quasi-periodic": 2, "chaotic": 3, "ended-early": 4, "missing": MISSING}
