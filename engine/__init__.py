"""Vibroscope's engine: two solvers of one vibro-impact problem, compared."""

from .alignment import MeasuredComparison, Solved, compare_measured
from .attractors import Attractor, attractors
from .batch import STATUSES, CellResults, Cells, run_cells
from .compare import Comparison, compare
from .fit import FITTED, Fit, fit
from .lyapunov import Lyapunov, lyapunov
from .measured import Measurement, measurement_text, read_measurement
from .measured_verdict import measured_verdict
from .methods import ExactPenalty, Method, Newmark, Reference
from .model import System
from .motion import Motion, motion
from .recommend import Recommendation, design_curve, recommend
from .result import Cancelled, Checkpoint, Cost, Impacts, Record, Response, Status, Trajectory
from .simulate import simulate
from .steady import Steady, steady
from .store import diagram, ship_diagrams
from .sweep import Diagram, bifurcation
from .synthetic import synthetic_measurement
from .systemfile import SystemFile, read_system, system_text
from .units import QUANTITIES, Units

__all__ = [
    "FITTED",
    "QUANTITIES",
    "STATUSES",
    "Attractor",
    "Cancelled",
    "CellResults",
    "Cells",
    "Checkpoint",
    "Comparison",
    "Cost",
    "Diagram",
    "ExactPenalty",
    "Fit",
    "Impacts",
    "Lyapunov",
    "MeasuredComparison",
    "Measurement",
    "Method",
    "Motion",
    "Newmark",
    "Recommendation",
    "Record",
    "Reference",
    "Response",
    "Solved",
    "Status",
    "Steady",
    "System",
    "SystemFile",
    "Trajectory",
    "Units",
    "attractors",
    "bifurcation",
    "compare",
    "compare_measured",
    "design_curve",
    "diagram",
    "fit",
    "lyapunov",
    "measured_verdict",
    "measurement_text",
    "motion",
    "read_measurement",
    "read_system",
    "recommend",
    "run_cells",
    "ship_diagrams",
    "simulate",
    "steady",
    "synthetic_measurement",
    "system_text",
]
