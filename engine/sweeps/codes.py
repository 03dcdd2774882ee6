"""Numbers that stand for words in a result."""

from enum import IntEnum

from ..cells import STATUSES
from ..motions.description import Kind

MISSING = -1  # status and other flags of a cell that was not computed yet
STATUS_FLAGS = {str(status): i for i, status in enumerate(STATUSES)} | {"missing": MISSING}
# The number of each kind of motion; "unknown" is the one of a cell that was not computed.
CellKind = IntEnum("CellKind", {kind.name: number for number, kind in enumerate(Kind, MISSING)}, module=__name__)
KIND_FLAGS = {str(kind): int(CellKind[kind.name]) for kind in Kind}
