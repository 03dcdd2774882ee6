"""The setting of the explorer: one value for each of its parameters, and what the engine makes of them.

Every value from outside passes through `reading.read_setting`. No panel import.

The ranges that sliders and axes cover for a system; this rule stands nowhere else.

For the paper's bodies they are the `slider` of `FIELDS`. For any other, with the springs k₁ = 1 and k₂ = μκ²:

- K from 1 to 10⁵ times the stiffer spring k;
- D from a damping ratio of the contact of 0.05 at the softest K to 0.5 at the stiffest: D = ζ·√(Kμ/(1+μ))
  (docs/theory/model.md);
- η from a quarter of the lower natural frequency to 5/3 of the upper one, at least to six times the lower one: against
  a wall without clearance a body swings at twice its frequency, and may do so in every third period of the excitation.
"""

import math
from collections import namedtuple
from collections.abc import Mapping
from dataclasses import fields, replace

from vibroscope.app.explorer.parameters import (
    DESCRIBED_BY,
    DRAWING_FIELDS,
    EXCITATION_FIELDS,
    FIELDS,
    SECOND_STOP_FIELDS,
    START_FIELDS,
)
from vibroscope.app.runtime.number_text import print_value
from vibroscope.engine import (
    CONTACT_STATUSES,
    INTEGRATORS,
    Excitation,
    Integrator,
    Newmark,
    Reference,
    System,
    TimeStepping,
    Units,
    damping_of_restitution,
    stiffness_of_duration,
    stiffness_of_step,
    with_located_steps,
)
from vibroscope.engine.contact import damping_for
from vibroscope.engine.law_table import LAWS, damper_of, numbers_of
from vibroscope.engine.methods import DAMPING_RANGE, LAWS_BY_RESTITUTION

Range = tuple[float, float]
RunKey = tuple[System, float, Reference | TimeStepping, tuple[float, float, float, float]]  # the last is the start
SOLVERS = ("reference", "penalty")

_STIFFNESS = (1.0, 1e5)  # times the stiffer spring
_DAMPING_RATIOS = (0.05, 0.5)  # at the softest and at the stiffest contact
_ETA_BELOW, _ETA_ABOVE, _ETA_LEAST = 0.25, 5 / 3, 6.0
_DIGITS = 3  # of an end
_LEAST = 1e-6  # of a range: a logarithmic axis has no 0
_PAPER = System()


def slider_range(name: str, system: System) -> Range:
    """First and last value that the slider of a number covers, within what the number may be."""
    field = FIELDS[name]
    if _has_papers_bodies(system) or name not in _RULES:
        return field.slider or field.bounds
    low, high = field.bounds
    first, last = (float(f"{end:.{_DIGITS}g}") for end in _RULES[name](system))
    return max(low, first), min(high, last)


def widened(usual: Range, value: float) -> Range:
    """A range, as far as the decade of a value outside it: of K or D, whose axes are logarithmic and have no 0."""
    low, high = usual
    if value == 0 or low <= value <= high:
        return usual
    decade = math.log10(max(value, _LEAST))
    return min(low, 10.0 ** math.floor(decade)), max(high, 10.0 ** math.ceil(decade))


def _has_papers_bodies(system: System) -> bool:
    return (system.kappa, system.mass_ratio) == (_PAPER.kappa, _PAPER.mass_ratio)


def _eta_range(system: System) -> Range:
    lower, upper = min(system.frequencies), max(system.frequencies)
    return _ETA_BELOW * lower, max(_ETA_ABOVE * upper, _ETA_LEAST * lower)


def _stiffness_range(system: System) -> Range:
    spring = system.stiffer_spring
    return tuple(times * spring for times in _STIFFNESS)


def _damping_range(system: System) -> Range:
    ends = zip(_DAMPING_RATIOS, _stiffness_range(system), strict=True)
    return tuple(damping_for(system, stiffness, ratio) for ratio, stiffness in ends)


_RULES = {"eta": _eta_range, "K": _stiffness_range, "D": _damping_range}


# Whose restitution follows from the damping ratio alone, though no formula of an author gives its damper.
LAWS_OF_RATIO = tuple(name for name, law in LAWS.items() if law.restitution and not law.damper)


class Setting(namedtuple("Setting", FIELDS, defaults=[field.default for field in FIELDS.values()])):
    """One value for each of `FIELDS`; immutable and hashable, so it can be the key of a cache."""

    __slots__ = ()

    @property
    def described_by(self) -> tuple[str, ...]:
        """The fields that describe the system, beside what drives it."""
        return DESCRIBED_BY[self.bodies] + (SECOND_STOP_FIELDS if self.stops == "two" else ())

    @property
    def system(self) -> System:
        """The bodies and what drives them; raises ValueError where the numbers give none together."""
        values = {name: getattr(self, name) for name in self.described_by}
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
    def methods(self) -> "dict[str, Reference | TimeStepping]":
        """Both solvers, by the names in `SOLVERS`."""
        return {name: getattr(self, name) for name in SOLVERS}

    @property
    def run_keys(self) -> dict[str, RunKey]:
        """What the run of each solver depends on."""
        start = self.initial
        return {name: (self.system, self.eta, method, start) for name, method in self.methods.items()}

    @property
    def own_integrator(self) -> Integrator:
        """The integrator with its numbers."""
        return INTEGRATORS[self.integrator](**{name: getattr(self, name) for name in integrator_numbers(self)})

    @property
    def penalty(self) -> TimeStepping:
        """The solver that an FE code would use: Newmark's method, unless more is set than its numbers.

        Raises ValueError where integrator, contact status and law do not go together.
        """
        default, located = Setting(), self.located == "yes"
        plain = all(getattr(self, name) == getattr(default, name) for name in (*_CHOSEN, *integrator_numbers(self)))
        if plain:
            return Newmark(self.K, self.D, self.steps, located=located)
        method = TimeStepping(
            self.K,
            None if self.follows_restitution else self.D,
            self.steps,
            self.own_integrator,
            CONTACT_STATUSES[0] if located else self.status,
            without_solution=self.without_solution,
            law=self.law,
            **{name: getattr(self, name) for name in law_numbers(self)},
            initial_acceleration=self.initial_acceleration,
        )
        return with_located_steps(method) if located else method

    @property
    def follows_restitution(self) -> bool:
        """Whether the law takes its damper from the restitution, whatever D is."""
        return self.damper == "restitution" and self.law in LAWS_BY_RESTITUTION

    @property
    def finds_damping(self) -> bool:
        """Whether D is not known, and `reading.read_setting` makes it from the restitution."""
        return self.damper == "restitution" and self.law in LAWS_OF_RATIO

    @property
    def damping_of_restitution(self) -> float:
        """D with which a contact has the restitution of the system, to six digits.

        Raises ValueError where no damper gives so small a restitution, or one beyond the range of D.
        """
        system = self.system
        D = damping_of_restitution(self.law, system.restitution, self.K, mass=system.mass_share)
        if not DAMPING_RANGE[1] >= D:
            raise ValueError(f"restitution = {system.restitution:g} takes D = {D:.3g} with this K: take a larger one")
        return float(f"{D:.6g}")

    @property
    def follows_system(self) -> bool:
        """Whether K is that of the natural periods: `reading.read_setting` then makes it from them."""
        return self.stiffness == "system"

    @property
    def stiffness_of_system(self) -> float:
        """K with which a contact lasts 1 % of the shorter natural period, to six digits."""
        return float(f"{stiffness_of_duration(self.system):.6g}")

    def with_contact(self, texts: Mapping[str, str]) -> dict[str, str]:
        """``texts`` with the present K where they set the step that it follows, and the present D that would follow K.

        For what was computed with the present numbers beside the one that is set: they are no longer to follow.
        """
        kept = {"K": self.follows_step and "steps" in texts, "D": self.finds_damping and "K" in texts}
        return {name: print_value(getattr(self, name)) for name in kept if kept[name]} | dict(texts)

    @property
    def follows_step(self) -> bool:
        """Whether K is that of the time step: `reading.read_setting` then makes it from `step_scale`."""
        return self.stiffness == "step"

    @property
    def stiffness_of_step(self) -> float:
        """K = s m/Δτ² of these steps, to six digits, so that it can be read and typed."""
        return float(f"{stiffness_of_step(self.system, self.eta, self.steps, self.step_scale):.6g}")

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
    def constant_step(self) -> TimeStepping:
        """The setting with steps that are not cut where contact changes."""
        return self._replace(located="no").penalty

    @property
    def is_driven(self) -> bool:
        """Whether anything moves with the frequency η; otherwise it only counts the time."""
        return self.system.excitation.drives

    @property
    def start_numbers(self) -> tuple[float, float, float, float]:
        """ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0 as they are set; zeros for rest, too."""
        return tuple(getattr(self, name) for name in START_FIELDS)

    @property
    def from_rest(self) -> bool:
        """Whether both runs start from rest, the static equilibrium."""
        return self.zero_start == "rest" and not any(self.start_numbers)

    @property
    def own_start(self) -> tuple[float, float, float, float] | None:
        """``initial`` where it is not rest, as a study takes it; None from rest."""
        return None if self.from_rest else self.initial

    @property
    def initial(self) -> tuple[float, float, float, float]:
        """The state from which both runs start: ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0."""
        return self.system.rest if self.from_rest else self.start_numbers

    def drawn_like(self, other: "Setting") -> "Setting":
        """The same results, drawn like ``other``: with its `DRAWING_FIELDS`."""
        return self._replace(**{name: getattr(other, name) for name in DRAWING_FIELDS})

    @property
    def scale(self) -> Units | None:
        """The units in which numbers are shown; None where they are shown without dimension."""
        return None if self.units == "none" else replace(self.own_units, system=self.units)

    @property
    def own_units(self) -> Units:
        """The SI units that numbers are counted in, K and D by the contact law."""
        return Units(self.omega1, self.m1, self.amplitude, law=self.law, exponent=self.exponent)

    @property
    def period(self) -> float:
        """Length of an excitation period on the time axes: 1 where time is counted in periods, else in seconds."""
        return 1.0 if self.scale is None else self.scale.physical("time", 2 * math.pi / self.eta)

    def texts(self) -> dict[str, str]:
        """Every value as a text from which `reading.read_setting` reads exactly the same value."""
        return {name: print_value(value) for name, value in self._asdict().items()}


_CHOSEN = ("integrator", "status", "law", "initial_acceleration")  # of `STEPPING_FIELDS`, beside numbers


def integrator_numbers(setting: Setting) -> tuple[str, ...]:
    """Names of the numbers that the integrator of a setting has."""
    return tuple(each.name for each in fields(INTEGRATORS[setting.integrator]))


def law_numbers(setting: Setting) -> tuple[str, ...]:
    """Names of the numbers that the contact law of a setting has, beside K and D."""
    return tuple(numbers_of(setting.law))
