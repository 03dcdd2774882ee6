"""Numbers that stand for words in a result."""

from vibroscope.engine.cells import STATUSES
from vibroscope.engine.motions.description import CellKind, Kind

MISSING = -1  # status and other flags of a cell that was not computed yet
STATUS_FLAGS = {str(status): i for i, status in enumerate(STATUSES)} | {"missing": MISSING}
KIND_FLAGS = {str(kind): int(CellKind[kind.name]) for kind in Kind}
