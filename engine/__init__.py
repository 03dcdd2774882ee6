"""Vibroscope's engine: solves one vibro-impact problem with an impact law and with penalty contact, and compares.

What one run needs is imported with the package; everything else when its name is first asked for, since a command that
solves one problem would otherwise spend a third of its time with importing studies, searches and measurements. The
names of the package are those of the classes and constants that are imported here, and those of `_LATER`.

What is wrong with an argument is a ValueError in one line, its kind included (:mod:`.arguments`).
"""

from importlib import import_module
from inspect import isfunction

from vibroscope.engine.arguments import checked
from vibroscope.engine.excitation import Excitation
from vibroscope.engine.integrators import (
    HHT,
    INTEGRATORS,
    TRBDF2,
    BackwardEuler,
    Bathe,
    CentralDifference,
    EulerImplicitDamper,
    GeneralisedAlpha,
    HHTInterpolated,
    Integrator,
    NewmarkBeta,
    SemiImplicitEuler,
)
from vibroscope.engine.load import Load
from vibroscope.engine.methods import (
    CONTACT_LAWS,
    CONTACT_STATUSES,
    INITIAL_ACCELERATIONS,
    LAWS_BY_RESTITUTION,
    METHOD_NUMBERS,
    NEWMARK_LAWS,
    WITHOUT_SOLUTION,
    ExactPenalty,
    Method,
    Reference,
    TimeStepping,
)
from vibroscope.engine.model import System
from vibroscope.engine.result import (
    STATUSES,
    Cancelled,
    Checkpoint,
    Cost,
    Impacts,
    Record,
    Response,
    Status,
    Trajectory,
)

# The module has the name of the function: imported later, it would take the function's place here.
from vibroscope.engine.simulate import simulate as _simulate

simulate = checked(_simulate)

# By module: the names that are imported when they are first asked for.
_LATER = {
    "cells": "CellResults Cells run_cells",
    "compilation": "CompileProgress Compiled compile_kernels is_compiled",
    "contact": (
        "damping_of_restitution effective_restitution equal_restitution_damping restitution_of_damping "
        "stiffness_of_duration stiffness_of_step"
    ),
    "continuation.branch": "Branch Point branches_dataset",
    "continuation.family": "PARAMETERS BranchQuestion",
    "continuation.kinds": "POINT_KINDS PointKind",
    "continuation.point_curve": "PointCurve PointCurves continue_point",
    "continuation.points": "FOLLOWED_KINDS",
    "continuation.search": "continue_branch find_branches search_branches",
    "divergence.compare": "PARTS Comparison ComparisonQuestion compare",
    "divergence.parts": "PART_NAMES Difference Regularisation TimeStepParts",
    "divergence.verdict": "Verdict verdict",
    "drivers.code_cache": "cache_root is_cache_private",
    "measurement.comparison": "MeasuredComparison Solved compare_measured measured_verdict",
    "measurement.fit": "FITTED Fit fit fitted_names",
    "measurement.measurement": "Measurement",
    "measurement.measurement_columns": "UnknownColumns",
    "measurement.measurement_file": "measurement_text parse_measurement read_measurement",
    "measurement.synthetic": "synthetic_measurement",
    "methods": "Newmark with_located_steps",
    "motions.search": "Attractor attractors search_attractors",
    "motions.description": "Kind",
    "motions.lyapunov": "Lyapunov lyapunov",
    "motions.motion": "Motion motion",
    "motions.steady": "Steady steady",
    "motions.words": "difference_in_kind repetition touching",
    "physical": "PhysicalSystem physical_entry system_of_physical",
    "one_impact.choose": (
        "Bounds LargestStep Material damping_bounds hertz_stiffness largest_step over_speeds over_steps "
        "stiffness_bounds stiffness_for"
    ),
    "one_impact.forward": "ForceCourse MoreauJean Span WithStep force_courses impact",
    "one_impact.question": "Impact",
    "one_impact.of_system": "OverMotion over_motion",
    "outputs": "PEAKS Spectrum absolute_accelerations peaks spectrum transmissibility",
    "recommendation.contacts": "Tolerances",
    "recommendation.question": "Limits Recommendation Served SettingQuestion",
    "recommendation.trials": "steps_at",
    "recommendation.search": "design_curve recommend recommend_schemes",
    "facts": "Statement print_statement",
    "simulate": "FREE_PERIODS free_length",
    "sweeps": (
        "COORDINATES DIRECTIONS OVER BasinDifference BasinStudy EtaStudy NoSolutionStudy PlaneStudy Progress "
        "StepStudy basin_difference sweep"
    ),
    "sweeps.study": "spaced",
    "sweeps.cache": "Diagram diagram ship_diagrams shipped_diagram",
    "system_file": (
        "SystemFile brief_system_text parse_system physical_text read_system system_of_tables system_text toml_tables"
    ),
    "transients.difference": "TransientDifference transient_difference",
    "transients.record_file": "parse_record read_record",
    "transients.response_spectrum": "ShockResponse shock_response",
    "transients.run": "Transient transient",
    "units": "QUANTITIES UNIT_SYSTEMS Units written",
    "wording": "counted end_text finite_or_none many percent rounded",
}
_HOME = {name: module for module, names in _LATER.items() for name in names.split()}

__all__ = sorted([name for name in globals() if name[0].isupper()] + ["simulate", *_HOME])


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOME[name]}", __name__), name)
    globals()[name] = value = checked(value) if isfunction(value) else value
    return value


def __dir__() -> list[str]:
    return __all__
