"""The parameters of the explorer, declared once: `Explorer`, and which of them belong together. No panel import."""

from __future__ import annotations

import math
from collections.abc import Iterable

import param
from vibroscope.engine import (
    CONTACT_LAWS,
    INITIAL_ACCELERATIONS,
    INTEGRATORS,
    WITHOUT_SOLUTION,
    Excitation,
    NewmarkBeta,
    System,
    Units,
    end_text,
)
from vibroscope.engine.contact import STEP_SCALE_RANGE
from vibroscope.engine.excitation import AMPLITUDE_RANGE, HELD, PHASE_RANGE
from vibroscope.engine.integrators import ALPHA_RANGE, BETA_RANGE, GAMMA_RANGE, RHO_RANGE
from vibroscope.engine.law_table import HERTZ
from vibroscope.engine.methods import (
    DAMPING_RANGE,
    EXPONENT_RANGE,
    PENETRATION_RANGE,
    STEPS_RANGE,
    STIFFNESS_RANGE,
    THRESHOLD_RANGE,
)
from vibroscope.engine.model import CLEARANCE_RANGE, ETA_RANGE, MASS_RATIO_RANGE, RATIO_RANGE
from vibroscope.engine.simulate import FARTHEST
from vibroscope.engine.units import BASE_AMPLITUDE_RANGE, M1_RANGE, OMEGA1_RANGE, UNIT_SYSTEMS

_PAPER, _UNITS, _DRIVE = System(), Units(), Excitation()
_START = {"bounds": (-FARTHEST, FARTHEST)}
_BELOW_ONE = {"bounds": (0.0, 1.0), "inclusive_bounds": (True, False)}  # damping ratios: underdamped bodies


def _choice(names: Iterable[str], label: str, doc: str, default: str | None = None) -> param.Selector:
    """One of these names; by default the first."""
    objects = list(names)
    return param.Selector(default=default or objects[0], objects=objects, label=label, doc=doc)


def _form(label: str, names: Iterable[str]) -> param.Selector:
    """The form in which a number of the system is typed and shown in units."""
    return _choice(names, label, "Form in which it is typed, shown and kept in units")


class Explorer(param.Parameterized):
    """Default, bounds, label and hint of every slider, field and switch.

    ``bounds`` are what the engine takes, on the command line too. ``softbounds`` are the part of them that sliders and
    axes cover.
    """

    eta = param.Number(1.08, bounds=ETA_RANGE, softbounds=(0.5, 4.0), label="η", doc="excitation frequency Ω/ω₁")
    K = param.Number(2500.0, bounds=STIFFNESS_RANGE, softbounds=(10.0, 1e5), label="K", doc="penalty stiffness")
    D = param.Number(8.0, bounds=DAMPING_RANGE, softbounds=(0.1, 100.0), label="D", doc="penalty damping")
    steps = param.Integer(2000, bounds=STEPS_RANGE, softbounds=(8, 32_000), label="T/Δτ", doc="time steps per period")
    located = _choice(
        ("no", "yes"),
        label="Contact changes",
        doc="Where Newmark's step meets a contact change: at the start of the next step, or located within the step",
    )
    integrator = _choice(
        INTEGRATORS,
        label="Integrator",
        doc="One-step method of the penalty solution, as FE and physics codes have it",
    )
    beta = param.Number(NewmarkBeta().beta, bounds=BETA_RANGE, label="β", doc="of Newmark's method, ¼: average")
    gamma = param.Number(NewmarkBeta().gamma, bounds=GAMMA_RANGE, label="γ", doc="of Newmark's method, above ½: damps")
    alpha = param.Number(-0.05, bounds=ALPHA_RANGE, label="α", doc="of HHT, as Hilber writes it; 0: no damping")
    rho = param.Number(0.8, bounds=RHO_RANGE, label="ρ∞", doc="spectral radius at high frequencies; 1: no damping")
    status = _choice(
        ("start", "end"),
        label="Contact status",
        doc="Contact status of a step: from the gap at its start, or iterated until it agrees with the gap at its end",
    )
    without_solution = _choice(
        WITHOUT_SOLUTION,
        label="Step without a solution",
        doc="What a step does in which neither contact status agrees with its end: stop the run, keep the former "
        "status, or be halved",
    )
    law = _choice(CONTACT_LAWS, label="Contact law", doc="Force of the penalty contact")
    exponent = param.Number(HERTZ, bounds=EXPONENT_RANGE, label="n", doc="of the penetration in the law; 1.5: Hertz")
    penetration = param.Number(
        0.01,
        bounds=PENETRATION_RANGE,
        inclusive_bounds=(False, True),
        label="δ_d",
        doc="penetration from which on the damper of IMPACT acts in full",
    )
    stiffness = _choice(
        ("typed", "system", "step"),
        label="Stiffness",
        doc="K as typed; K with which a contact lasts 1 % of the shorter natural period; or K = s m/Δτ² from the time "
        "step and the reduced mass m, as the soft constraint contact of explicit codes has it (LS-DYNA: SOFT = 1)",
    )
    step_scale = param.Number(
        0.1,
        bounds=STEP_SCALE_RANGE,
        inclusive_bounds=(False, True),
        label="s",
        doc="of K = s m/Δτ², SOFSCL of LS-DYNA; a smaller step makes K larger",
    )
    damper = _choice(
        ("typed", "restitution"),
        label="Damper",
        doc="D as typed, or not known: then it follows from the restitution e, by the formula of the law's authors "
        "where it has one",
    )
    initial_acceleration = _choice(
        INITIAL_ACCELERATIONS,
        label="First acceleration",
        doc="At τ = 0 by the equations of motion, or zero, as some codes have it",
    )
    joint_damping = _choice(
        ("table", "derived"),
        label="Joint damping d₃",
        doc="d₃ of the reference in permanent contact: as measured, or the sum of the two dampers",
    )
    threshold = param.Number(
        0.002,
        bounds=THRESHOLD_RANGE,
        label="ε",
        doc="separation speed below which contact stays, in the unit of length times ω₁ (0: limit)",
    )
    bodies = _choice(
        ("pendulums", "two", "wall"),
        label="System",
        doc="Pendulums whose frequencies are known apart and joined, as the paper's; two bodies; or a body and a wall",
    )
    restitution = param.Number(_PAPER.restitution, bounds=(0.0, 1.0), label="e", doc="coefficient of restitution")
    kappa = param.Number(_PAPER.kappa, bounds=RATIO_RANGE, label="κ", doc="frequency ratio ω₂/ω₁ of body 2")
    d1 = param.Number(_PAPER.d1, **_BELOW_ONE, label="d₁", doc="damping ratio of body 1")
    d2 = param.Number(_PAPER.d2, **_BELOW_ONE, label="d₂", doc="damping ratio of body 2")
    kappa3 = param.Number(_PAPER.kappa3, bounds=RATIO_RANGE, label="κ₃", doc="frequency ratio of both, joined")
    d3 = param.Number(_PAPER.d3, **_BELOW_ONE, label="d₃", doc="damping ratio of both, joined, as measured")
    mass_ratio = param.Number(1.0, bounds=MASS_RATIO_RANGE, label="μ", doc="mass ratio m₂/m₁")
    clearance = param.Number(
        _PAPER.clearance, bounds=CLEARANCE_RANGE, label="g₀", doc="clearance with relaxed springs; below 0: preload"
    )
    base = param.Number(_DRIVE.base, bounds=AMPLITUDE_RANGE, label="a", doc="amplitude of the base motion")
    held = _choice(
        HELD,
        label="Held of the base",
        doc="What of the base keeps its amplitude when the frequency changes: displacement, velocity or acceleration",
    )
    base_phase = param.Number(_DRIVE.base_phase, bounds=PHASE_RANGE, label="φ", doc="phase of the base motion, rad")
    force1 = param.Number(_DRIVE.force1, bounds=AMPLITUDE_RANGE, label="F₁", doc="harmonic force on body 1")
    force1_phase = param.Number(_DRIVE.force1_phase, bounds=PHASE_RANGE, label="φ₁", doc="phase of F₁, rad")
    force2 = param.Number(_DRIVE.force2, bounds=AMPLITUDE_RANGE, label="F₂", doc="harmonic force on body 2")
    force2_phase = param.Number(_DRIVE.force2_phase, bounds=PHASE_RANGE, label="φ₂", doc="phase of F₂, rad")
    constant1 = param.Number(
        _DRIVE.constant1, bounds=AMPLITUDE_RANGE, label="P₁", doc="constant force on body 1; positive: towards body 2"
    )
    constant2 = param.Number(
        _DRIVE.constant2, bounds=AMPLITUDE_RANGE, label="P₂", doc="constant force on body 2; positive: away from body 1"
    )
    zero_start = _choice(
        ("rest", "zero"),
        label="Start of zeros",
        doc="Where all numbers of the start are 0: rest, the static equilibrium, or an own start of zeros",
    )
    start_xi1 = param.Number(0.0, **_START, label="ξ₁(0)", doc="displacement of body 1 at τ = 0")
    start_v1 = param.Number(0.0, **_START, label="ξ₁′(0)", doc="velocity of body 1 at τ = 0")
    start_xi2 = param.Number(0.0, **_START, label="ξ₂(0)", doc="displacement of body 2 at τ = 0")
    start_v2 = param.Number(0.0, **_START, label="ξ₂′(0)", doc="velocity of body 2 at τ = 0")
    frame = _choice(
        ("relative", "absolute", "difference"),
        label="Displacements",
        doc="Relative to the base, relative to a fixed sensor, or the difference between both solutions, in parts",
    )
    coordinate = _choice(
        ("xi1", "xi2"),
        label="Map and difference show",
        doc="Coordinate in the small map over η and in the difference",
        default="xi2",
    )
    units = _choice(
        ("none", *UNIT_SYSTEMS),
        label="Units",
        doc="Without dimension as in the paper, or in a consistent system of units, as an FE input file has them; "
        "the system is then given by masses in kg, springs in N/m and so on",
    )
    spring1_form, spring2_form = (_form(f"Spring {body}", ("stiffness", "frequency")) for body in (1, 2))
    damper1_form, damper2_form = (_form(f"Damper {body}", ("ratio", "damper")) for body in (1, 2))
    acceleration_form = _form("Acceleration of the base", ("metres", "g"))
    omega1 = param.Number(_UNITS.omega1, bounds=OMEGA1_RANGE, label="ω₁", doc="angular frequency of body 1")
    m1 = param.Number(_UNITS.m1, bounds=M1_RANGE, label="m₁", doc="mass of body 1")
    amplitude = param.Number(
        _UNITS.base_amplitude, bounds=BASE_AMPLITUDE_RANGE, label="A", doc="unit of length: amplitude of the base"
    )


FIELDS = tuple(name for name in Explorer.param if name != "name")
MAIN_FIELDS = ("eta", "K", "D", "steps")
EXCITATION_FIELDS = tuple(_DRIVE.as_dict())
# What each kind of system is described by, beside what drives it.
_OF_ALL = ("d1", "restitution", "clearance")
OF_BODY_2 = ("kappa", "d2", "d3")
DESCRIBED_BY = {
    "pendulums": (*_OF_ALL, *OF_BODY_2, "kappa3"),
    "two": (*_OF_ALL, *OF_BODY_2, "mass_ratio"),
    "wall": _OF_ALL,
}
SYSTEM_FIELDS = ("bodies", *_OF_ALL, *OF_BODY_2, "kappa3", "mass_ratio", *EXCITATION_FIELDS)
START_FIELDS = ("start_xi1", "start_v1", "start_xi2", "start_v2")
SHARES = ("d1", "d2", "d3", "restitution")  # may be given in per cent
# What the penalty solution is computed with, beside K, D and the step.
STEPPING_FIELDS = ("integrator", "beta", "gamma", "alpha", "rho", "status", "without_solution", "law")
STEPPING_FIELDS += ("exponent", "penetration", "stiffness", "step_scale", "damper", "initial_acceleration")
# A scene of the paper sets them to their defaults.
PAPER_FIELDS = (*SYSTEM_FIELDS, "zero_start", *START_FIELDS, "threshold", "located", *STEPPING_FIELDS)
FORM_FIELDS = ("spring1_form", "spring2_form", "damper1_form", "damper2_form", "acceleration_form")
DRAWING_FIELDS = ("frame", "coordinate", "units", *FORM_FIELDS, "omega1", "m1", "amplitude")  # of no result


def bounds_of(name: str) -> tuple[float, float]:
    """Smallest and largest value that a number may have; where its range is open, the last number before its end."""
    (low, high), (has_low, has_high) = Explorer.param[name].bounds, Explorer.param[name].inclusive_bounds
    return low if has_low else math.nextafter(low, high), high if has_high else math.nextafter(high, low)


def range_text(bounds: tuple[float, float], factor: float = 1.0) -> str:
    """A range times a factor, as "0 to 1000", or "above 0 to below 1" where the last number before an end is given."""
    (low, high), (before, after) = bounds, (math.nextafter(bounds[0], -math.inf), math.nextafter(bounds[1], math.inf))
    first = f"above {end_text(factor * before)}" if len(repr(before)) < len(repr(low)) else end_text(factor * low)
    last = f"below {end_text(factor * after)}" if len(repr(after)) < len(repr(high)) else end_text(factor * high)
    return f"{first} to {last}"
