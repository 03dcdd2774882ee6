"""The table of fields: every number and choice of the setting, declared once. No panel import.

Page, command line, links, units, help, refusals and files read it. A new number is an entry here, and its use.
"""

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from vibroscope.engine import (
    CONTACT_LAWS,
    CONTACT_STATUSES,
    INITIAL_ACCELERATIONS,
    INTEGRATORS,
    WITHOUT_SOLUTION,
    Excitation,
    NewmarkBeta,
    Reference,
    System,
    Units,
    end_text,
)
from vibroscope.engine.contact import STEP_SCALE_RANGE
from vibroscope.engine.excitation import HELD
from vibroscope.engine.fields import described_fields
from vibroscope.engine.integrators import ALPHA_RANGE, BETA_RANGE, GAMMA_RANGE, RHO_RANGE
from vibroscope.engine.law_table import HERTZ, LAWS, laws_with
from vibroscope.engine.methods import (
    DAMPING_RANGE,
    EXPONENT_RANGE,
    PENETRATION_RANGE,
    STEPS_RANGE,
    STIFFENING_RANGE,
    STIFFNESS_RANGE,
    THRESHOLD_RANGE,
)
from vibroscope.engine.model import ETA_RANGE, MASS_RATIO_RANGE
from vibroscope.engine.simulate import FARTHEST

Span = tuple[float, float] | tuple[()]
Bodies = tuple[str, ...]
_TWO = ("pendulums", "two")  # kinds of system with two bodies
_ALL_KINDS = (*_TWO, "wall")
LAW_NAMES = {  # of a law without one its key
    "kelvin-voigt": "Kelvin–Voigt",
    "cut": "Kelvin–Voigt, cut at zero",
    "limited": "limited damper",
    "compression": "damper in compression alone",
    "hunt-crossley": "Hunt–Crossley",
    "lankarani-nikravesh": "Lankarani–Nikravesh",
    "flores": "Flores",
    "jankowski": "Jankowski",
    "constant-restitution": "constant restitution",
    "impact": "IMPACT",
    "bilinear": "bilinear spring",
}


class Field(NamedTuple):
    """A number or a choice: what it is called, what it may be, and where it has a meaning.

    Attributes
    ----------
    name : str
        In a setting, in a link and in a script; the option of the command line is ``--name``.
    label, hint : str
        Symbol, or the title of a choice; and what it is.
    default : float, int or str
        A whole number is an int.
    bounds : tuple of float
        Smallest and largest number that the engine takes, on the command line too; where its range is open, the last
        number before its end.
    slider : tuple of float
        The part of them that sliders and axes cover; empty where that is all.
    quantity : str
        Of `engine.QUANTITIES`, if the number has a dimension.
    choices : mapping of str to str
        What can be chosen, and its words; empty for a number.
    in_units : tuple of str
        Label and hint where numbers have units, if they are others.
    also : str
        A unit in which a number without dimension may be typed: "%", or "Hz" for a ratio of frequencies.
    defines : str
        The quantity of a number that defines the units, and has a unit always.
    bodies : tuple of str
        Kinds of system that have it.
    words : str
        What the command line says of the option; empty where there is none.
    solvers : tuple of str
        Solvers of the command line that have it.
    """

    name: str
    label: str
    hint: str
    default: float | int | str
    bounds: Span = ()
    slider: Span = ()
    quantity: str = ""
    choices: Mapping[str, str] = {}
    in_units: tuple[str, str] | tuple[()] = ()
    also: str = ""
    defines: str = ""
    bodies: Bodies = _ALL_KINDS
    words: str = ""
    solvers: tuple[str, ...] = ()

    @property
    def whole(self) -> bool:
        """Whether it is a whole number."""
        return isinstance(self.default, int)

    def option(self, words: str, *solvers: str) -> "Field":
        """The field with an option on the command line."""
        return self._replace(words=words, solvers=solvers)

    def read_as(self, label: str, hint: str) -> "Field":
        """The field with another label and hint where numbers have units."""
        return self._replace(in_units=(label, hint))


def _choice(name: str, label: str, hint: str, choices: Iterable[str], default: str = "") -> Field:
    """A choice; by default the first. One without words of its own is called by its name."""
    words = dict(choices) if isinstance(choices, Mapping) else {each: each for each in choices}
    return Field(name, label, hint, default or next(iter(words)), choices=words)


def _above(low: float, high: float) -> Span:
    """A range without its lower end: from the next number on."""
    return math.nextafter(low, high), high


def _form(name: str, label: str, *choices: str) -> Field:
    """The form in which a number of the system is typed and shown in units."""
    return _choice(name, label, "Form in which it is typed, shown and kept in units", choices)


def _start(name: str, label: str, hint: str, quantity: str, in_units: str, bodies: Bodies = _ALL_KINDS) -> Field:
    """A number of the state at τ = 0."""
    field = Field(name, label, hint, 0.0, (-FARTHEST, FARTHEST), quantity=quantity, bodies=bodies)
    return field.read_as(in_units, hint.replace("τ", "t"))


def _of(kind: type, name: str, label: str, hint: str, quantity: str = "", **more) -> Field:
    """A number that a class of the engine declares, with its default, its range, and whether a wall has it."""
    each = described_fields(kind)[name]
    low, high = map(float, each.allowed[:2])
    first = math.nextafter(low, high) if each.allowed.open_low else low
    last = math.nextafter(high, low) if each.allowed.open_high else high
    own = {"default": getattr(kind, name), "bodies": _TWO if each.of_body_2 else _ALL_KINDS}
    return Field(name, label, hint, bounds=(first, last), quantity=quantity, **own | more)


LAW_WORDS = (
    "contact law (default: a spring and a damper, which may pull)",
    "None is hysteretic, as ImpactMaterial is: constant-restitution rebounds alike",
)
_PENALTY, _NEWMARK = ("exact", "newmark"), ("newmark",)

_MAIN = (
    Field("eta", "η", "excitation frequency Ω/ω₁", 1.08, ETA_RANGE, (0.5, 4.0), "frequency")
    .read_as("f", "excitation frequency")
    .option("excitation frequency Omega/omega1; paper: 1.08 to 3.25 (default: what frequency_Hz of --system gives)"),
    Field("K", "K", "penalty stiffness", 2500.0, STIFFNESS_RANGE, (10.0, 1e5), "contact_stiffness").option(
        "contact stiffness; the paper uses 100 to 12000", *_PENALTY
    ),
    Field("D", "D", "penalty damping", 8.0, DAMPING_RANGE, (0.1, 100.0), "contact_damping")
    .read_as("2D", "penalty damper")
    .option("contact damping; the paper uses 8 to 50", *_PENALTY),
    Field("steps", "T/Δτ", "time steps per period", 2000, STEPS_RANGE, (8, 32_000)).option(
        "steps per excitation period, the time step is T/N; or the longest time step, as '10 us'", *_NEWMARK
    ),
)
_STEPPING = (
    _choice(
        "integrator",
        "Integrator",
        "One-step method of the penalty solution, as FE and physics codes have it",
        {name: kind.title for name, kind in INTEGRATORS.items()},
    ).option(
        "the one-step method (default newmark); hht averages the forces at both ends of a step, hht-interpolated takes "
        "them at the displacement between, as OpenSees does",
        *_NEWMARK,
    ),
    Field("beta", "β", "of Newmark's method, ¼: average", NewmarkBeta().beta, BETA_RANGE).option(
        "integrator newmark (default 1/4)", *_NEWMARK
    ),
    Field("gamma", "γ", "of Newmark's method, above ½: damps", NewmarkBeta().gamma, GAMMA_RANGE).option(
        "integrator newmark; more than 1/2 damps (default 1/2)", *_NEWMARK
    ),
    Field("alpha", "α", "of HHT, as Hilber writes it; 0: no damping", -0.05, ALPHA_RANGE).option(
        "integrator hht (default -0.05), hht-interpolated (-0.1): -1/3 to 0 as Hilber writes it; OpenSees' 0.9 is -0.1",
        *_NEWMARK,
    ),
    Field("rho", "ρ∞", "spectral radius at high frequencies; 1: no damping", 0.8, RHO_RANGE).option(
        "integrator generalised-alpha (default 0.8), bathe (0): spectral radius at high frequencies, 0 to 1", *_NEWMARK
    ),
    _choice(
        "status",
        "Contact status",
        "Contact status of a step: from the gap at its start, or iterated until it agrees with the gap at its end",
        {"start": "start of the step", "end": "end, iterated"},
    ).option(
        "contact status of a step from the gap at its start, iterated until it agrees with the gap at its end, or "
        f"located within the step, as --located (default {CONTACT_STATUSES[0]})",
        *_NEWMARK,
    ),
    _choice(
        "without_solution",
        "Step without a solution",
        "What a step does in which neither contact status agrees with its end: stop the run, keep the former status, "
        "or be halved",
        dict(zip(WITHOUT_SOLUTION, ("stop", "keep status", "halve step"), strict=True)),
    ).option(
        "status end: a step in which neither status agrees with its end stops the run, keeps the former status, or is "
        f"halved until all its parts have a solution (default {WITHOUT_SOLUTION[0]})",
        *_NEWMARK,
    ),
    _choice(
        "law", "Contact law", "Force of the penalty contact", {name: LAW_NAMES.get(name, name) for name in CONTACT_LAWS}
    ).option(
        f"{LAW_WORDS[0]}. Without --D those from hunt-crossley to constant-restitution take their damper from the "
        f"restitution of the system and the closing speed, by the formula of their authors. {LAW_WORDS[1]}",
        *_PENALTY,
    ),
    Field("exponent", "n", "of the penetration in the law; 1.5: Hertz", HERTZ, EXPONENT_RANGE).option(
        f"power of the penetration in the law, at least 1 (default {HERTZ:g})", *_PENALTY
    ),
    Field(
        "penetration",
        "δ_d",
        "penetration from which on the damper of IMPACT acts in full, or the bilinear spring is stiffer",
        0.01,
        _above(*PENETRATION_RANGE),
        quantity="displacement",
    ).option(
        f"law {' or '.join(laws_with('penetration'))}: penetration beyond which "
        f"{', or '.join(LAWS[law].penetration for law in laws_with('penetration'))}",
        *_PENALTY,
    ),
    Field(
        "stiffening",
        "r",
        "stiffness of the bilinear spring beyond that penetration, over K",
        4.0,
        _above(*STIFFENING_RANGE),
    ).option(
        f"law {' or '.join(laws_with('stiffening'))}: stiffness beyond the penetration over K, more than 1", *_PENALTY
    ),
    _choice(
        "stiffness",
        "Stiffness",
        "K as typed; K with which a contact lasts 1 % of the shorter natural period; or K = s m/Δτ² from the time "
        "step and the mass m of the lighter body, as the soft constraint contact of explicit codes has it (LS-DYNA: "
        "SOFT = 1)",
        {"typed": "K as typed", "system": "from the natural period", "step": "follows the step"},
    ),
    Field(
        "step_scale",
        "s",
        "of K = s m/Δτ², SOFSCL of LS-DYNA; a smaller step makes K larger",
        0.1,
        _above(*STEP_SCALE_RANGE),
    ).option(
        "K = S m/(time step)^2 instead of --K, m that of the lighter body; half the step has four times K", *_NEWMARK
    ),
    _choice(
        "damper",
        "Damper",
        "D as typed, or not known: then it follows from the restitution e, by the formula of the law's authors where "
        "it has one",
        {"typed": "D as typed", "restitution": "from the restitution"},
    ),
    _choice(
        "initial_acceleration",
        "First acceleration",
        "At τ = 0 by the equations of motion, or zero, as some codes have it",
        dict(zip(INITIAL_ACCELERATIONS, ("from the equations", "zero"), strict=True)),
    ).option(
        "accelerations at tau = 0 by the equations of motion, or zero, as OpenSees has them "
        f"(default {INITIAL_ACCELERATIONS[0]})",
        *_NEWMARK,
    ),
)
_LOCATED = _choice(
    "located",
    "Contact changes",
    "Where Newmark's step meets a contact change: at the start of the next step, or located within the step",
    {"no": "at the next step", "yes": "cut at contact"},
).option("cut each step at a contact change, located within the step", *_NEWMARK)
_REFERENCE_FIELDS = (
    _choice(
        "joint_damping",
        "Joint damping d₃",
        "d₃ of the reference in permanent contact: as measured, or the sum of the two dampers",
        {"table": "as measured", "derived": "of both dampers"},
    ).option(
        "reference: damping of the joined pendulums; derived: only what their own dampers give "
        f"(default {Reference.joint_damping})",
        "reference",
    ),
    Field(
        "threshold",
        "ε",
        "separation speed below which contact stays, in the unit of length times ω₁ (0: limit)",
        Reference.threshold,
        THRESHOLD_RANGE,
        quantity="velocity",
    ).option(
        "reference: parting speed that begins permanent contact, in the unit of length times omega1, so that it "
        f"scales with the system (default {Reference.threshold:g}); 0: the limit of the threshold",
        "reference",
    ),
)
_SYSTEM = (
    _choice(
        "bodies",
        "System",
        "Pendulums whose frequencies are known apart and joined, as the paper's; two bodies; or a body and a wall",
        {"pendulums": "the paper’s pendulums", "two": "two bodies", "wall": "a body and a wall"},
    ),
    _of(System, "restitution", "e", "coefficient of restitution", also="%").option(
        f"reference: coefficient of restitution (default: the system's; the paper's is {System.restitution:g})",
        "reference",
    ),
    _of(
        System, "spring1", "k₁", "spring of body 1 in m₁ω₁²; 0: none, and ω₁ is a unit of time", bodies=("two", "wall")
    ),
    _of(System, "kappa", "κ", "frequency ratio ω₂/ω₁ of body 2; 0: no spring", also="Hz"),
    _of(System, "d1", "d₁", "damping ratio of body 1", also="%"),
    _of(System, "d2", "d₂", "damping ratio of body 2", also="%"),
    _of(System, "kappa3", "κ₃", "frequency ratio of both, joined", also="Hz", bodies=("pendulums",)),
    _of(System, "d3", "d₃", "damping ratio of both, joined, as measured", also="%"),
    Field("mass_ratio", "μ", "mass ratio m₂/m₁", 1.0, MASS_RATIO_RANGE, bodies=("two",)),
    _of(System, "clearance", "g₀", "clearance with relaxed springs; below 0: preload", "displacement"),
)
_STOPS = _choice("stops", "Stops", "One stop, or a second one on the other side of the same gap", ("one", "two"))
_SECOND_STOP = (
    _of(System, "clearance2", "g₂", "clearance of the second stop", "displacement", default=1.0),
    _of(
        *(System, "restitution2", "e₂", "coefficient of restitution of the second stop"),
        default=System.restitution,
        also="%",
    ),
    _of(System, "stiffness_factor2", "K₂/K", "stiffness of the second stop over K"),
    _of(System, "damping_factor2", "D₂/D", "damping of the second stop over D"),
)
# What moves the bodies; the phases are those of the amplitudes before them.
_EXCITATION = (
    _of(Excitation, "base", "a", "amplitude of the base motion", "displacement"),
    _choice(
        "held",
        "Held of the base",
        "What of the base keeps its amplitude when the frequency changes: displacement, velocity or acceleration",
        HELD,
    ),
    _of(Excitation, "base_phase", "φ", "phase of the base motion, rad"),
    _of(Excitation, "force1", "F₁", "harmonic force on body 1", "force"),
    _of(Excitation, "force1_phase", "φ₁", "phase of F₁, rad"),
    _of(Excitation, "force2", "F₂", "harmonic force on body 2", "force"),
    _of(Excitation, "force2_phase", "φ₂", "phase of F₂, rad"),
    _of(Excitation, "constant1", "P₁", "constant force on body 1; positive: towards body 2", "force"),
    _of(Excitation, "constant2", "P₂", "constant force on body 2; positive: away from body 1", "force"),
)
_START = (
    _start("start_xi1", "ξ₁(0)", "displacement of body 1 at τ = 0", "displacement", "x₁(0)"),
    _start("start_v1", "ξ₁′(0)", "velocity of body 1 at τ = 0", "velocity", "x₁′(0)"),
    _start("start_xi2", "ξ₂(0)", "displacement of body 2 at τ = 0", "displacement", "x₂(0)", _TWO),
    _start("start_v2", "ξ₂′(0)", "velocity of body 2 at τ = 0", "velocity", "x₂′(0)", _TWO),
)
_ZERO_START = _choice(
    "zero_start",
    "Start of zeros",
    "Where all numbers of the start are 0: rest, the static equilibrium, or an own start of zeros",
    ("rest", "zero"),
)
_FORMS = (
    _form("spring1_form", "Spring 1", "stiffness", "frequency"),
    _form("spring2_form", "Spring 2", "stiffness", "frequency"),
    _form("damper1_form", "Damper 1", "ratio", "damper"),
    _form("damper2_form", "Damper 2", "ratio", "damper"),
    _form("acceleration_form", "Acceleration of the base", "metres", "g"),
)
_DRAWING = (
    _choice(
        "frame",
        "Displacements",
        "Relative to the base, relative to a fixed sensor, or the difference between both solutions, in parts",
        ("relative", "absolute", "difference"),
    ),
    _choice(
        "coordinate",
        "Map and difference show",
        "Coordinate in the small map over η and in the difference",
        {"xi1": "body 1", "xi2": "body 2"},
        "xi2",
    ),
    _choice(
        "units",
        "Units",
        "Without dimension as in the paper, or in a consistent system of units, as an FE input file has them; the "
        "system is then given by masses in kg, springs in N/m and so on",
        {"none": "non-dimensional", "si": "SI", "mm-t-s": "mm-t-s"},
    ),
    *_FORMS,
    _of(
        *(Units, "omega1", "ω₁", "angular frequency of body 1; without a spring 1 over the unit of time"),
        defines="angular_frequency",
    ),
    _of(Units, "m1", "m₁", "mass of body 1", defines="mass"),
    _of(Units, "base_amplitude", "A", "unit of length: amplitude of the base", defines="displacement")._replace(
        name="amplitude"
    ),
)
_ALL = (
    *(*_MAIN, _LOCATED, *_STEPPING, *_REFERENCE_FIELDS),
    *(*_SYSTEM, _STOPS, *_SECOND_STOP, *_EXCITATION, _ZERO_START, *_START, *_DRAWING),
)


def _names(fields: Iterable[Field]) -> tuple[str, ...]:
    return tuple(field.name for field in fields)


FIELDS = {field.name: field for field in _ALL}  # in this order a link has them
MAIN_FIELDS = _names(_MAIN)
EXCITATION_FIELDS = _names(_EXCITATION)
# What each kind of system is described by, beside what drives it.
DESCRIBED_BY = {kind: _names(f for f in _SYSTEM[1:] if kind in f.bodies) for kind in FIELDS["bodies"].choices}
SECOND_STOP_FIELDS = _names(_SECOND_STOP)  # of two stops
SYSTEM_FIELDS = _names((*_SYSTEM, _STOPS, *_SECOND_STOP, *_EXCITATION))
START_FIELDS = _names(_START)
STEPPING_FIELDS = _names(_STEPPING)  # what the penalty solution is computed with, beside K, D and the step
# A scene of the paper sets them to their defaults.
PAPER_FIELDS = (*SYSTEM_FIELDS, "zero_start", *START_FIELDS, "threshold", "located", *STEPPING_FIELDS)
FORM_FIELDS = _names(_FORMS)
DRAWING_FIELDS = _names(_DRAWING)  # of no result
FIELD_QUANTITIES = {name: field.quantity for name, field in FIELDS.items() if field.quantity}


def range_text(bounds: tuple[float, float], factor: float = 1.0) -> str:
    """A range times a factor, as "0 to 1000", or "above 0 to below 1" where the last number before an end is given."""
    (low, high), (before, after) = bounds, (math.nextafter(bounds[0], -math.inf), math.nextafter(bounds[1], math.inf))
    first = f"above {end_text(factor * before)}" if len(repr(before)) < len(repr(low)) else end_text(factor * low)
    last = f"below {end_text(factor * after)}" if len(repr(after)) < len(repr(high)) else end_text(factor * high)
    return f"{first} to {last}"
