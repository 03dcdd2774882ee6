"""Why a run ended: the only vocabulary of statuses, as words for people and as numbers for compiled code."""

from enum import StrEnum


class Status(StrEnum):
    """Why a run ended."""

    OK = "ok"
    DIVERGED = "diverged"
    PILED_UP = "piled-up"
    UNRESOLVED = "unresolved"
    WITHOUT_SOLUTION = "without-solution"


STATUSES = tuple(Status)  # a status is stored as its index in here

# the same in compiled code, which knows no strings …
OK, DIVERGED, PILED_UP, UNRESOLVED, WITHOUT_SOLUTION = range(len(STATUSES))
# … and what a kernel returns that is not at an end yet: FULL: empty the buffers and call again; PAUSED: call again;
# WITHDRAWN: the caller has asked it to stop.
# Between two stops, CROSSED: go on as seen from the other one
FULL, PAUSED, WITHDRAWN, CROSSED = range(len(STATUSES), len(STATUSES) + 4)
