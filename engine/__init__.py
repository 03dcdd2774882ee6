"""Vibroscope's engine: solves one vibro-impact problem with an impact law and with penalty contact, and compares."""

from .batch import run_cells
from .cells import STATUSES, CellResults, Cells
from .divergence.compare import PARTS, Comparison, compare
from .divergence.contact import equal_restitution_damping
from .divergence.regularisation import Regularisation
from .divergence.verdict import Verdict, verdict
from .drivers.code_cache import cache_root
from .measurement.comparison import MeasuredComparison, Solved, compare_measured
from .measurement.fit import FITTED, Fit, fit
from .measurement.measurement import Measurement
from .measurement.measurement_file import measurement_text, read_measurement
from .measurement.synthetic import synthetic_measurement
from .measurement.verdict import measured_verdict
from .methods import CONTACT_LAWS, ExactPenalty, Method, Newmark, Reference
from .model import System
from .motions.attractors import Attractor, attractors
from .motions.lyapunov import Lyapunov, lyapunov
from .motions.motion import Motion, motion
from .motions.steady import Steady, steady
from .recommendation.recommend import Recommendation, design_curve, recommend
from .result import Cancelled, Checkpoint, Cost, Impacts, Record, Response, Status, Trajectory
from .simulate import simulate
from .sweeps import COORDINATES, DIRECTIONS, OVER, Progress, sweep_eta, sweep_plane, sweep_step
from .sweeps.axis import spaced
from .sweeps.diagrams import Diagram, diagram, ship_diagrams
from .system_file import SystemFile, parse_system, read_system, system_text, toml_tables
from .units import QUANTITIES, Units

__all__ = [
    "CONTACT_LAWS",
    "COORDINATES",
    "DIRECTIONS",
    "FITTED",
    "OVER",
    "PARTS",
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
    "Progress",
    "Recommendation",
    "Record",
    "Reference",
    "Regularisation",
    "Response",
    "Solved",
    "Status",
    "Steady",
    "System",
    "SystemFile",
    "Trajectory",
    "Units",
    "Verdict",
    "attractors",
    "cache_root",
    "compare",
    "compare_measured",
    "design_curve",
    "diagram",
    "equal_restitution_damping",
    "fit",
    "lyapunov",
    "measured_verdict",
    "measurement_text",
    "motion",
    "parse_system",
    "read_measurement",
    "read_system",
    "recommend",
    "run_cells",
    "ship_diagrams",
    "simulate",
    "spaced",
    "steady",
    "sweep_eta",
    "sweep_plane",
    "sweep_step",
    "synthetic_measurement",
    "system_text",
    "toml_tables",
    "verdict",
]
