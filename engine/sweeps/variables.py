"""The arrays of a result and their descriptions: one place for the words, which the digest of the code leaves out."""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.sweeps.codes import MISSING, STATUS_FLAGS

SWEPT = {  # parameters that can be swept
    "eta": "excitation frequency Ω/ω₁",
    "K": "contact stiffness",
    "D": "contact damping",
    "steps": "steps per excitation period",
    "kappa": "frequency ratio of body 2",
    "kappa3": "frequency ratio of the joined bodies",
    "d1": "damping ratio of body 1",
    "d2": "damping ratio of body 2",
    "d3": "damping ratio of the joined bodies",
    "restitution": "coefficient of restitution",
    "clearance": "gap at rest with relaxed springs",
    "clearance2": "clearance of the second stop",
    "restitution2": "coefficient of restitution of the second stop",
    "stiffness_factor2": "K of the second stop over that of the first",
    "damping_factor2": "D of the second stop over that of the first",
    "base": "amplitude of the base motion",
    "force1": "amplitude of the harmonic force on body 1",
    "force2": "amplitude of the harmonic force on body 2",
    "constant1": "constant force on body 1",
    "constant2": "constant force on body 2",
}
# Of each cell, by any method: dtype and description.
MOTION = {
    "period": ("i4", "excitation periods until the motion repeats itself; 0: aperiodic"),
    "near_period": ("i4", "the same of the section alone, scatter within 3 % of its size forgiven; 0: aperiodic"),
    "impacts_per_period": ("f8", "impacts per excitation period"),
    "contacts_per_period": ("f8", "contacts that begin per excitation period (reference: permanent contacts)"),
    "contact_share": ("f8", "share of the time in contact"),
    "longest_contact": ("f8", "longest contact, in units of tau"),
    "longest_contact_steps": ("f8", "longest contact in time steps"),
    "spread": ("f8", "standard deviation of xi2 over the section, of xi1 at a wall"),
}
# The same of a penalty method, which has no impacts but the beginnings of its contacts.
PENALTY_MOTION = {name: described for name, described in MOTION.items() if name != "contacts_per_period"}
PENALTY_MOTION["impacts_per_period"] = ("f8", "contacts that begin per excitation period")
IMPACT_PHASE = {"impact_phase": ("f8", "instant of the first impact in the last cycle, as a share of T")}
PHASE_ERROR = {"impact_phase_error": ("f8", "the same less the reference's, between -1/2 and 1/2")}
# Of a scheme whose contact status is that of the end of the step.
SOLUTION_COUNTS = {
    "steps_without_solution": ("i4", "steps of the run in which neither contact status agreed with its own end"),
    "steps_with_two": ("i4", "steps of the run in which both did"),
}
SOLUTIONS = {
    **SOLUTION_COUNTS,
    "periods_until_stopped": ("f8", "excitation periods until the run stopped for want of a solution; nan: it did not"),
    "period": MOTION["period"],
}
# Of a run with constant steps beside one with located steps.
SCATTER = {
    "scatter": (
        "f8",
        "the same about the points of the cycle of the located run, or of exact penalty where that run repeats none",
    )
}
# Of a plane of starts.
STARTS = {
    "xi1": "xi1 at tau = 0",
    "v1": "v1 at tau = 0",
    "xi2": "xi2 at tau = 0",
    "v2": "v2 at tau = 0",
    "phase": "share of the excitation period at which the run begins",
}
REACHED = {
    "reached": (
        "i4",
        "motion that the start leads to, of those found beforehand; -2: another one, -3: the run ended early, "
        "-4: the bodies would penetrate",
    ),
    "reached_period": ("i4", "excitation periods after which that motion repeats itself; 0: aperiodic"),
    "periods": ("i4", "excitation periods that were run"),
}
POINT = "xi1, v1, xi2, v2 of another motion at tau = 0 mod T: the first point of its cycle, or the mean"
MOTIONS_REACHED = {
    "motion": "motion that the start leads to, as the rows of motion_...; -1: not known, -3: ended early, -4: no start",
    "motion_kind": "kind of each motion; 0 aperiodic, 1 periodic, 2 quasi-periodic, 3 chaotic",
    "motion_period": "excitation periods after which it repeats itself; 0: aperiodic",
    "motion_share": "share of the starts that lead to it",
    "motion_share_error": "standard error of that",
    "motion_start": "xi1, v1, xi2, v2, phase of a start that leads to it",
    "motion_section": "xi1, v1, xi2, v2 at tau = 0 mod T over a cycle; nan after its end",
    "uncertainty_exponent": "alpha in f ~ eps^alpha; f: share of pairs of starts eps apart that lead to other motions",
    "uncertainty_exponent_error": "standard error of that",
    "boundary_dimension": "of the boundary between the basins in the plane, 2 - alpha",
    "boundary_dimension_error": "standard error of that",
}
EXPONENT = {
    "lyapunov": ("f8", "largest Lyapunov exponent per excitation period"),
    "lyapunov_error": ("f8", "standard error of that"),
}
ERRORS = {
    "error": ("f8", "penalty less reference: rms of both displacements over that of the reference"),
    "error_time_step": ("f8", "its part by the time step, Newmark less exact penalty"),
    "error_regularisation": ("f8", "its part by K and D, exact penalty less reference with derived joint damping"),
}
EXACT = "exact penalty: {}"
SECTION = "{} at tau = 0 mod T, oldest first"
PHASE_PLOT = "{} of the phase plot"
TIME = "time of the phase plot from a section on; nan after its end"
END = "xi1, v1, xi2, v2 at the end, where a neighbour goes on"
KIND = "kind of motion, by the section and the Lyapunov exponent where there is one"
STATUS = "how the run ended"
# Of the study as a whole.
SAMPLE = "period of the sample"
SCHEME = "0: fixed step, 1: located step"
JOINT_DAMPING = "reference with derived less with table damping"
EQUAL_RESTITUTION = "D at which a single contact returns the share e"
REFERENCE = {
    "reference_period": "period of the reference; 0: aperiodic",
    "reference_impacts_per_period": "impacts per excitation period",
    "reference_impact_phase": IMPACT_PHASE["impact_phase"][1],
}
ORDERED = {"spread": "the spread", "scatter": "the scatter", "error_time_step": "the error by the time step"}
ORDER = "p in n^-p for {}, by least squares"
ORDER_ERROR = "standard error of that slope"


class Variable(NamedTuple):
    """An array with an entry for each cell: dimensions, dtype, description, and the names of numbers that are flags."""

    dims: tuple[str, ...]
    dtype: str
    description: str
    flags: dict[str, int] | None = None

    @property
    def fill(self) -> float | int:
        """The value of cells that were not computed (yet)."""
        return np.nan if self.dtype.startswith("f") else MISSING

    @property
    def attributes(self) -> dict[str, object]:
        """Units and description, by the CF conventions."""
        named = {"units": "1", "long_name": self.description}
        if self.flags:
            named |= {"flag_values": list(self.flags.values()), "flag_meanings": " ".join(self.flags)}
        return named


class StudyArray(NamedTuple):
    """An array of the study as a whole, not of its cells: a coordinate, a curve, the reference, an observed order."""

    dims: tuple[str, ...]
    values: np.ndarray
    description: str

    @property
    def attributes(self) -> dict[str, object]:
        """Units and description, by the CF conventions."""
        return {"units": "1", "long_name": self.description}


def status_variable(dims: tuple[str, ...], description: str = STATUS) -> Variable:
    """How the run of each cell ended."""
    return Variable(dims, "i1", description, STATUS_FLAGS)


def variables_of(table: dict[str, tuple[str, str]], dims: tuple[str, ...]) -> dict[str, Variable]:
    """A variable for each row of one of the tables above."""
    return {name: Variable(dims, dtype, description) for name, (dtype, description) in table.items()}
