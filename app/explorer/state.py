"""The parameters of the explorer, declared once, and the validated setting that is generated from them.

Every value from outside (address, typed text, slider, uploaded file, forged message) arrives as text and passes through
`read_setting`: all texts are accepted, or none is. No panel import.
"""

from __future__ import annotations

import math
import re
from collections import namedtuple
from collections.abc import Mapping
from dataclasses import fields
from inspect import signature

import param
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.runtime.limits import CostLimitError, check_cost
from vibroscope.app.runtime.number_text import LONGEST_NUMBER, print_number, quote
from vibroscope.app.runtime.settings import current_settings
from vibroscope.engine import (
    CONTACT_LAWS,
    INITIAL_ACCELERATIONS,
    INTEGRATORS,
    WITHOUT_SOLUTION,
    Excitation,
    Integrator,
    Newmark,
    NewmarkBeta,
    Reference,
    System,
    TimeStepping,
    Units,
    end_text,
    simulate,
)
from vibroscope.engine.integrators import ALPHA_RANGE, BETA_RANGE, GAMMA_RANGE, RHO_RANGE
from vibroscope.engine.law_table import HERTZ, numbers_of
from vibroscope.engine.laws import damper_of
from vibroscope.engine.methods import (
    DAMPING_RANGE,
    EXPONENT_RANGE,
    LAWS_BY_RESTITUTION,
    PENETRATION_RANGE,
    STEPS_RANGE,
    STIFFNESS_RANGE,
    THRESHOLD_RANGE,
)
from vibroscope.engine.model import (
    AMPLITUDE_RANGE,
    CLEARANCE_RANGE,
    ETA_RANGE,
    MASS_RATIO_RANGE,
    PHASE_RANGE,
    RATIO_RANGE,
)
from vibroscope.engine.motions.motion import FARTHEST
from vibroscope.engine.units import BASE_AMPLITUDE_RANGE, M1_RANGE, OMEGA1_RANGE, UNIT_SYSTEMS

_PAPER, _UNITS, _DRIVE = System(), Units(), Excitation()
_PERIODS = signature(simulate).parameters["periods"].default
_START = {"bounds": (-FARTHEST, FARTHEST)}
_BELOW_ONE = {"bounds": (0.0, 1.0), "inclusive_bounds": (True, False)}  # damping ratios: underdamped bodies

# A number as a person writes one. Stricter than float(), which also accepts "nan", "inf", "1_000", the digits of other
# scripts, and text of any length.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,4})?", re.ASCII)


# ---- the parameters -------------------------------------------------------------------------------------------------


class Explorer(param.Parameterized):
    """Default, bounds, label and hint of every slider, field and switch.

    ``bounds`` are what the engine takes, on the command line too. ``softbounds`` are the part of them that sliders and
    axes cover.
    """

    eta = param.Number(1.08, bounds=ETA_RANGE, softbounds=(0.5, 4.0), label="η", doc="excitation frequency Ω/ω₁")
    K = param.Number(2500.0, bounds=STIFFNESS_RANGE, softbounds=(10.0, 1e5), label="K", doc="penalty stiffness")
    D = param.Number(8.0, bounds=DAMPING_RANGE, softbounds=(0.1, 100.0), label="D", doc="penalty damping")
    steps = param.Integer(2000, bounds=STEPS_RANGE, softbounds=(8, 32_000), label="T/Δτ", doc="time steps per period")
    located = param.Selector(
        default="no",
        objects=["no", "yes"],
        label="Contact changes",
        doc="Where Newmark's step meets a contact change: at the start of the next step, or located within the step",
    )
    integrator = param.Selector(
        default=NewmarkBeta.name,
        objects=list(INTEGRATORS),
        label="Integrator",
        doc="One-step method of the penalty solution, as FE and physics codes have it",
    )
    beta = param.Number(NewmarkBeta().beta, bounds=BETA_RANGE, label="β", doc="of Newmark's method, ¼: average")
    gamma = param.Number(NewmarkBeta().gamma, bounds=GAMMA_RANGE, label="γ", doc="of Newmark's method, above ½: damps")
    alpha = param.Number(-0.05, bounds=ALPHA_RANGE, label="α", doc="of HHT, as Hilber writes it; 0: no damping")
    rho = param.Number(0.8, bounds=RHO_RANGE, label="ρ∞", doc="spectral radius at high frequencies; 1: no damping")
    status = param.Selector(
        default="start",
        objects=["start", "end"],
        label="Contact status",
        doc="Contact status of a step: from the gap at its start, or iterated until it agrees with the gap at its end",
    )
    without_solution = param.Selector(
        default=WITHOUT_SOLUTION[0],
        objects=list(WITHOUT_SOLUTION),
        label="Step without a solution",
        doc="What a step does in which neither contact status agrees with its end: stop the run, keep the former "
        "status, or be halved",
    )
    law = param.Selector(
        default=CONTACT_LAWS[0], objects=list(CONTACT_LAWS), label="Contact law", doc="Force of the penalty contact"
    )
    exponent = param.Number(HERTZ, bounds=EXPONENT_RANGE, label="n", doc="of the penetration in the law; 1.5: Hertz")
    penetration = param.Number(
        0.01,
        bounds=PENETRATION_RANGE,
        inclusive_bounds=(False, True),
        label="δ_d",
        doc="penetration from which on the damper of IMPACT acts in full",
    )
    damper = param.Selector(
        default="typed",
        objects=["typed", "restitution"],
        label="Damper",
        doc="Damper of a law that has a formula for it: D as typed, or from the restitution e by the formula of its "
        "authors",
    )
    initial_acceleration = param.Selector(
        default=INITIAL_ACCELERATIONS[0],
        objects=list(INITIAL_ACCELERATIONS),
        label="First acceleration",
        doc="At τ = 0 by the equations of motion, or zero, as some codes have it",
    )
    joint_damping = param.Selector(
        default="table",
        objects=["table", "derived"],
        label="Joint damping d₃",
        doc="d₃ of the reference in permanent contact: as measured, or the sum of the two dampers",
    )
    threshold = param.Number(
        0.002,
        bounds=THRESHOLD_RANGE,
        label="ε",
        doc="separation speed below which contact stays, in the unit of length times ω₁ (0: limit)",
    )
    bodies = param.Selector(
        default="pendulums",
        objects=["pendulums", "two", "wall"],
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
    base = param.Number(_DRIVE.base, bounds=AMPLITUDE_RANGE, label="a", doc="amplitude of the base motion a·cos ητ")
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
    zero_start = param.Selector(
        default="rest",
        objects=["rest", "zero"],
        label="Start of zeros",
        doc="Where all numbers of the start are 0: rest, the static equilibrium, or an own start of zeros",
    )
    start_xi1 = param.Number(0.0, **_START, label="ξ₁(0)", doc="displacement of body 1 at τ = 0")
    start_v1 = param.Number(0.0, **_START, label="ξ₁′(0)", doc="velocity of body 1 at τ = 0")
    start_xi2 = param.Number(0.0, **_START, label="ξ₂(0)", doc="displacement of body 2 at τ = 0")
    start_v2 = param.Number(0.0, **_START, label="ξ₂′(0)", doc="velocity of body 2 at τ = 0")
    frame = param.Selector(
        default="relative",
        objects=["relative", "absolute", "difference"],
        label="Displacements",
        doc="Relative to the base, relative to a fixed sensor, or the difference between both solutions, in parts",
    )
    coordinate = param.Selector(
        default="xi2",
        objects=["xi1", "xi2"],
        label="Map and difference show",
        doc="Coordinate in the small map over η and in the difference",
    )
    units = param.Selector(
        default="none",
        objects=["none", *UNIT_SYSTEMS],
        label="Units",
        doc="Without dimension as in the paper, or in a consistent system of units, as an FE input file has them; "
        "the system is then given by masses in kg, springs in N/m and so on",
    )
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
_OF_BODY_2 = ("kappa", "d2", "d3")
_DESCRIBED_BY = {
    "pendulums": (*_OF_ALL, *_OF_BODY_2, "kappa3"),
    "two": (*_OF_ALL, *_OF_BODY_2, "mass_ratio"),
    "wall": _OF_ALL,
}
SYSTEM_FIELDS = ("bodies", *_OF_ALL, *_OF_BODY_2, "kappa3", "mass_ratio", *EXCITATION_FIELDS)
START_FIELDS = ("start_xi1", "start_v1", "start_xi2", "start_v2")
SHARES = ("d1", "d2", "d3", "restitution")  # may be given in per cent
_FORMER_CHOICES = {("units", "physical"): "si"}  # in older links and files
# What the penalty solution is computed with, beside K, D and the step.
STEPPING_FIELDS = ("integrator", "beta", "gamma", "alpha", "rho", "status", "without_solution", "law")
STEPPING_FIELDS += ("exponent", "penetration", "damper", "initial_acceleration")
# A scene of the paper sets them to their defaults.
PAPER_FIELDS = (*SYSTEM_FIELDS, "zero_start", *START_FIELDS, "threshold", "located", *STEPPING_FIELDS)
DRAWING_FIELDS = ("frame", "coordinate", "units", "omega1", "m1", "amplitude")  # results do not depend on them


class Setting(namedtuple("Setting", FIELDS, defaults=[Explorer.param[name].default for name in FIELDS])):
    """One value for each parameter of `Explorer`; immutable and hashable, so it can be the key of a cache."""

    __slots__ = ()

    @property
    def system(self) -> System:
        """The bodies and what drives them; raises ValueError where the numbers give none together."""
        values = {name: getattr(self, name) for name in _DESCRIBED_BY[self.bodies]}
        if self.bodies == "two":
            values["mu"] = values.pop("mass_ratio")
            values["d3"] = self.d3 if self.joint_damping == "table" else None  # None: it was never measured
        drive = Excitation(**{name: getattr(self, name) for name in EXCITATION_FIELDS})
        return System(**values, wall=self.bodies == "wall", excitation=drive)

    @property
    def reference(self) -> Reference:
        """The solver with the impact law."""
        return Reference(joint_damping=self.joint_damping, threshold=self.threshold)

    @property
    def own_integrator(self) -> Integrator:
        """The integrator with its numbers."""
        return INTEGRATORS[self.integrator](**{name: getattr(self, name) for name in integrator_numbers(self)})

    @property
    def penalty(self) -> Newmark | TimeStepping:
        """The solver that an FE code would use: Newmark's method, unless more is set than its numbers.

        Raises ValueError where integrator, contact status and law do not go together.
        """
        default, located = Setting(), self.located == "yes"
        plain = all(getattr(self, name) == getattr(default, name) for name in (*_CHOSEN, *integrator_numbers(self)))
        if plain:
            return Newmark(self.K, self.D, self.steps, located=located)
        return TimeStepping(
            self.K,
            None if self.follows_restitution else self.D,
            self.steps,
            self.own_integrator,
            "located" if located else self.status,
            without_solution=self.without_solution,
            law=self.law,
            **{name: getattr(self, name) for name in law_numbers(self)},
            initial_acceleration=self.initial_acceleration,
        )

    @property
    def follows_restitution(self) -> bool:
        """Whether the law takes its damper from the restitution, whatever D is."""
        return self.damper == "restitution" and self.law in LAWS_BY_RESTITUTION

    @property
    def damping(self) -> tuple[float, bool]:
        """D, and whether it is still to be divided by the closing speed of a touch, in Aω₁.

        Raises ValueError where it follows from the restitution, and the formula has none for that.
        """
        if not self.follows_restitution:
            return self.D, False
        gain, by_speed = damper_of(self.system, self.penalty)
        return 0.5 * gain * (self.K if by_speed else 1.0), by_speed  # of h = 2D/K, or of c = 2D

    @property
    def place_in_plane(self) -> tuple[float, float]:
        """K and D; D is nan where it depends on the closing speed."""
        D, by_speed = self.damping
        return self.K, math.nan if by_speed else D

    @property
    def constant_step(self) -> Newmark | TimeStepping:
        """The same with steps that are not cut where contact changes."""
        return self._replace(located="no").penalty

    @property
    def is_driven(self) -> bool:
        """Whether anything moves with the frequency η; otherwise it only counts the time."""
        return is_driven(self.system)

    @property
    def from_rest(self) -> bool:
        """Whether both runs start from rest, the static equilibrium."""
        return self.zero_start == "rest" and not any(_start_numbers(self))

    @property
    def own_start(self) -> tuple[float, float, float, float] | None:
        """``initial`` where it is not rest, as a study takes it; None from rest."""
        return None if self.from_rest else self.initial

    @property
    def initial(self) -> tuple[float, float, float, float]:
        """Where both runs start: ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0."""
        return self.system.rest if self.from_rest else _start_numbers(self)

    def drawn_like(self, other: Setting) -> Setting:
        """The same results, drawn like ``other``: with its `DRAWING_FIELDS`."""
        return self._replace(**{name: getattr(other, name) for name in DRAWING_FIELDS})

    @property
    def scale(self) -> Units | None:
        """The units in which numbers are shown; None where they are shown without dimension."""
        return None if self.units == "none" else Units(self.omega1, self.m1, self.amplitude, self.units)

    @property
    def period(self) -> float:
        """Length of an excitation period on the time axes: 1 where time is counted in periods, else in seconds."""
        return 1.0 if self.scale is None else self.scale.physical("time", 2 * math.pi / self.eta)

    def texts(self) -> dict[str, str]:
        """Every value as a text from which `read_setting` reads exactly the same value."""
        return {name: print_value(value) for name, value in self._asdict().items()}


_CHOSEN = ("integrator", "status", "law", "initial_acceleration")  # of `STEPPING_FIELDS`, beside numbers


def integrator_numbers(setting: Setting) -> tuple[str, ...]:
    """Names of the numbers that the integrator of a setting has."""
    return tuple(each.name for each in fields(INTEGRATORS[setting.integrator]))


def law_numbers(setting: Setting) -> tuple[str, ...]:
    """Names of the numbers that the contact law of a setting has, beside K and D."""
    return tuple(numbers_of(setting.law))


def is_driven(system: System) -> bool:
    """Whether anything moves with the frequency η; otherwise a motion is a free vibration from its start."""
    return system.excitation.drives


# ---- from text to a setting -----------------------------------------------------------------------------------------


def read_setting(texts: Mapping[str, object], base: Setting | None = None) -> Setting:
    """The setting ``base`` (the default one if None) with the values of ``texts``; raises `Refused` at the first fault.

    Names that are no parameter are ignored.
    """
    setting = read_setting_at_any_cost(texts, base)
    _check_cost(setting)
    return setting


def read_setting_at_any_cost(texts: Mapping[str, object], base: Setting | None = None) -> Setting:
    """As `read_setting`, even if this server would not run it: what is offered is the same on every server."""
    setting = (base or Setting())._replace(**read_values(texts))
    if "D" in texts and "damper" not in texts:  # what is given stays
        setting = setting._replace(damper="typed")
    if setting.bodies == "wall":  # it does not move
        setting = setting._replace(coordinate="xi1", start_xi2=0.0, start_v2=0.0)
    if any(_start_numbers(setting)):
        setting = setting._replace(zero_start="rest")
    setting = _with_one_status(setting, texts)
    _check_combination(setting)
    _check_damper(setting, texts)
    given = (name for name in texts if name in ("start_xi1", "start_xi2"))
    _check_gap(setting, "start_xi1" if setting.bodies == "wall" else next(given, "start_xi2"))
    return setting


def _with_one_status(setting: Setting, given: Mapping[str, object]) -> Setting:
    """The setting with a contact status that goes with what was chosen last.

    Located steps have no other status, and an explicit integrator only that from the start. What is given stays; two
    statuses that are given and do not go together raise `Refused`.
    """
    if setting.located == "yes" and setting.status != "start":
        if {"located", "status"} <= given.keys():
            raise Refused("status", "status must be start where contact changes are located within the step, not end.")
        setting = setting._replace(**({"located": "no"} if "status" in given else {"status": "start"}))
    try:
        _ = setting.penalty
    except ValueError as error:
        free = {"located": "no", "status": "start"}
        setting = setting._replace(**{name: value for name, value in free.items() if name not in given})
        try:
            _ = setting.penalty
        except ValueError:
            raise Refused("status" if setting.located == "no" else "located", f"{error}.") from None
    return setting


def _start_numbers(setting: Setting) -> tuple[float, ...]:
    return tuple(getattr(setting, name) for name in START_FIELDS)


def read_values(texts: Mapping[str, object]) -> dict[str, float | int | str]:
    """The value of each parameter in ``texts``, checked one by one; raises `Refused` at the first bad one."""
    return {name: _read_value(name, text) for name, text in texts.items() if name in FIELDS}


def _read_value(name: str, text: object) -> float | int | str:
    rule = Explorer.param[name]
    if isinstance(rule, param.Selector):
        text = _FORMER_CHOICES.get((name, text), text) if isinstance(text, str) else text
        return read_choice(name, text, rule.objects)
    return read_number(name, text, bounds_of(name), isinstance(rule, param.Integer))


def bounds_of(name: str) -> tuple[float, float]:
    """Smallest and largest value that a number may have; where its range is open, the last number before its end."""
    (low, high), (has_low, has_high) = Explorer.param[name].bounds, Explorer.param[name].inclusive_bounds
    return low if has_low else math.nextafter(low, high), high if has_high else math.nextafter(high, low)


def _check_cost(setting: Setting) -> None:
    try:
        check_cost(setting.steps, _PERIODS)
    except CostLimitError as error:
        raise Refused("steps", str(error)) from None


def _check_combination(setting: Setting) -> None:
    """Raise `Refused` where values that are valid one by one give no system together."""
    try:
        _ = setting.system
    except ValueError as error:
        raise _refused_system(setting, error) from None


def _check_damper(setting: Setting, given: Mapping[str, object]) -> None:
    """Raise `Refused` for what was given last where the damper's formula has no value for the restitution."""
    try:
        _ = setting.damping
    except ValueError as error:
        raise Refused("restitution" if "restitution" in given else "damper", f"{error}.") from None


def _refused_system(setting: Setting, error: ValueError) -> Refused:
    if setting.bodies != "pendulums":
        name = str(error).partition(" ")[0]
        return Refused(name if name in FIELDS else "bodies", f"{error}.")
    return Refused(
        "kappa3",
        f"kappa3 must lie between 1 and kappa = {setting.kappa:g}, not {setting.kappa3:g}: the natural frequency "
        "of the joined pendulums lies between those of the separate ones, and the mass ratio follows from it.",
    )


def _check_gap(setting: Setting, name: str) -> None:
    """Raise `Refused` for the parameter ``name`` where the bodies would overlap at the start."""
    system = setting.system
    if setting.from_rest or not system.overlap_of(setting.initial):
        return
    symbol, number = "ξ", print_number
    if setting.scale is not None:
        symbol, number = "x", lambda value: setting.scale.text("displacement", value, 6)
    first, second, clearance = map(number, (setting.start_xi1, setting.start_xi2, setting.clearance))
    may = "the bodies may touch, but not overlap"
    if setting.bodies == "wall":
        raise Refused(
            name, f"{symbol}₁(0) must be at most the clearance, {clearance}, not {first}: at the start {may}."
        )
    most = f"{symbol}₂(0)" + (f" plus the clearance, {clearance}" if setting.clearance else "")
    raise Refused(
        name,
        f"{symbol}₁(0) must be at most {most}, not {first} with {second}: at the start {may}. "
        f"Set {symbol}{'₂' if name == 'start_xi1' else '₁'}(0) first.",
    )


def most_steps() -> int:
    """The largest number of steps per period that this server computes (`check_cost`)."""
    return min(STEPS_RANGE[1], current_settings().steps // _PERIODS)


def read_choice(name: str, text: object, choices: list[str]) -> str:
    """``text`` if it is one of the ``choices`` for ``name``; raises `Refused` otherwise."""
    if not isinstance(text, str) or text not in choices:
        raise Refused(name, f"{name} must be {' or '.join(choices)}, not {quote(text)}.")
    return text


def read_number(name: str, text: object, bounds: tuple[float, float], whole: bool) -> float | int:
    """The number that ``text`` gives for ``name``; raises `Refused` if it gives none within ``bounds``."""
    low, high = bounds
    kind = "a whole number" if whole else "a number"
    refusal = Refused(name, f"{name} must be {kind} from {end_text(low)} to {end_text(high)}, not {quote(text)}.")
    if not isinstance(text, str) or len(text) > LONGEST_NUMBER or not _NUMBER.fullmatch(text.strip()):
        raise refusal
    value = float(text)
    if not (math.isfinite(value) and low <= value <= high) or (whole and value != int(value)):
        raise refusal
    return int(value) if whole else value


def print_value(value: float | int | str) -> str:
    """The text of a choice, or of a number, from which `read_setting` reads exactly the same value."""
    return value if isinstance(value, str) else print_number(value)
