"""Vibroscope's engine: two solvers of one vibro-impact problem, compared."""

from .batch import run_cells
from .cells import STATUSES, CellResults, Cells
from .compare import Comparison, compare
from .methods import ExactPenalty, Method, Newmark, Reference
from .model import System
from .motion import Motion, motion
from .result import Cancelled, Checkpoint, Cost, Impacts, Record, Response, Status, Trajectory
from .simulate import simulate
from .steady import Steady, steady
from .store import diagram, ship_diagrams
from .sweep import Diagram, bifurcation
from .systemfile import SystemFile, read_system, system_text
from .units import QUANTITIES, Units

__all__ = [
    "QUANTITIES",
    "STATUSES",
    "Cancelled",
    "CellResults",
    "Cells",
    "Checkpoint",
    "Comparison",
    "Cost",
    "Diagram",
    "ExactPenalty",
    "Impacts",
    "Method",
    "Motion",
    "Newmark",
    "Record",
    "Reference",
    "Response",
    "Status",
    "Steady",
    "System",
    "SystemFile",
    "Trajectory",
    "Units",
    "bifurcation",
    "compare",
    "diagram",
    "motion",
    "read_system",
    "run_cells",
    "ship_diagrams",
    "simulate",
    "steady",
    "system_text",
]
