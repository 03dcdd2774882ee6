"""The system: two bodies, or one and a wall, that may touch; `excitation` drives them.

The default is the paper's (section 2 and Table 1): two neighbouring pendulums that touch at rest, on a shaken base.
Everything is non-dimensional: τ = ω₁t, ξ′ = dξ/dτ, excitation period T = 2π/η; lengths are counted in base amplitudes
where the base moves, otherwise in a length that the user names, and forces in m₁ω₁² times that length, which is k₁.
Of a body 1 without a spring ω₁ is no frequency but a unit that the user names, and `System.spring1` = 0.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from vibroscope.engine.arguments import flag, require, set_fields, shown
from vibroscope.engine.excitation import Excitation
from vibroscope.engine.fields import Range, check_numbers, described, described_fields

ETA_RANGE = (1e-3, 1e3)
CLEARANCE_RANGE = (-1e6, 1e6)
MASS_RATIO_RANGE = (1e-9, 1e9)
RATIO_RANGE = (1e-3, 1e3)  # of frequencies
KAPPA_RANGE = (0.0, RATIO_RANGE[1])  # with 0, of a body without a spring
FACTOR_RANGE = (1e-6, 1e6)  # of K and D of a second stop
# Units of length from touch to the static equilibrium, beyond which counting from there would cost digits near touch:
# of a body that is pressed to the wall, and of one that may swing about an equilibrium without ever meeting it.
FAR, FAR_OPEN = 32.0, 1e4

_DRIVE = tuple(each.name for each in fields(Excitation))
COORDINATES = ("xi1", "v1", "xi2", "v2")  # ξ₁, ξ₁′, ξ₂, ξ₂′: the columns of a section …
DISPLACEMENTS = slice(0, None, 2)  # … and those of ξ₁ and ξ₂ among them
_RATIO, _MASS_RATIO = Range(*RATIO_RANGE), Range(*MASS_RATIO_RANGE)
_DAMPING = (
    *("-", Range(0, 1, open_high=True)),
    "the bodies must be underdamped, give a ratio of at least 0 and below 1",
)
_FACTOR = "-", Range(*FACTOR_RANGE), "give what the number of the method is multiplied by"
_BODY_2 = {"of_body_2": True}


@dataclass(frozen=True)
class System:
    """Two bodies that can touch, or one body and a wall; by default the paper's pendulums (Table 1).

    All numbers are without dimension. Displacements ξᵢ are relative to the base and counted from where the body's
    spring is relaxed; the gap is g = clearance + ξ₂ − ξ₁. A wall is fixed to the base: ξ₂ = 0.

    Attributes
    ----------
    kappa : float
        κ = ω₂/ω₁, frequency ratio of body 2; 0 where it has no spring.
    d1, d2 : float
        Damping ratios of the separate bodies, 0 ≤ d < 1; of one without a spring its damper in units of 2mω₁.
    kappa3 : float
        κ₃ = ω₃/ω₁, frequency ratio of the joined bodies; strictly between 1 and κ. The mass ratio follows from it,
        unless ``mu`` is given: then κ₃ follows from that, whatever is given here.
    d3 : float or None
        Measured damping ratio of the joined bodies, 0 ≤ d₃ < 1; None if it was never measured: then it is what the two
        dampers give. The default is the paper's measurement: of other bodies give your own, or None. Always None of
        two bodies without springs, which have no such ratio.
    restitution : float
        Coefficient of restitution e, 0 ≤ e ≤ 1.
    clearance : float
        g₀, the gap where both springs are relaxed. Negative: a preload, the bodies press against each other at rest.
    wall : bool
        Whether body 2 is a wall. κ, κ₃, d₂, d₃, μ and the forces on body 2 then do not apply; what is given for them is
        replaced by the defaults.
    excitation : Excitation
    mu : float or None
        μ = m₂/m₁ where it is given, as it must be for equal frequencies (κ = 1); None if it follows from κ₃.
    spring1 : float
        Stiffness of the spring of body 1 in units of m₁ω₁², 0 ≤ k₁ ≤ 1: 1 where ω₁ is its natural frequency. Where it
        is less, ω₁ is a unit of time alone, and d₁ the damper in units of 2m₁ω₁; 0 without a spring. Of two bodies
        either of these two; body 2 has none with κ = 0.
    clearance2 : float or None
        Clearance of a second stop, on the other side: its gap is clearance2 − ξ₂ + ξ₁. Both clearances together are the
        play, which must be positive. None: there is no second stop. The contact force is negative there.
    restitution2 : float or None
        Coefficient of restitution of the second stop; None: that of the first.
    stiffness_factor2, damping_factor2 : float
        K and D of the second stop, as multiples of those of the method.

    Raises
    ------
    ValueError
        If a value is out of range.

    Examples
    --------
    >>> from vibroscope.engine import Excitation, System
    >>> System().kappa  # the paper's
    2.41
    >>> beside_a_wall = System(wall=True, clearance=0.5, d1=0.07, restitution=0.8)
    >>> driven_by_a_force = System(mu=0.5, d3=None, excitation=Excitation(base=0, force1=1.5))
    >>> beside_a_wall.observed_body, driven_by_a_force.mass_ratio
    (1, 0.5)
    >>> ball = System(wall=True, spring1=0.0, excitation=Excitation(constant1=0.7))
    >>> ball.rest  # its weight presses it to the table
    (0.0, 0.0, 0.0, 0.0)
    >>> pair = System(wall=True, spring1=0.0, d1=0.0, clearance=5.0, clearance2=5.0)  # free between two walls
    >>> pair.play
    10.0
    """

    kappa: float = described(
        *(2.41, "frequency ratio of body 2, omega2/omega1; 0: no spring", "-", Range(*KAPPA_RANGE)),
        "give the frequency ratio ω₂/ω₁, 0 where body 2 has no spring",
        words="0, or 0.001 to 1000",
        **_BODY_2,
    )
    d1: float = described(0.0033, "damping ratio of body 1", *_DAMPING)
    d2: float = described(0.0120, "damping ratio of body 2", *_DAMPING, **_BODY_2)
    kappa3: float = described(
        *(1.80, "frequency ratio of the joined bodies, omega3/omega1", "-", _RATIO, "give the frequency ratio ω₃/ω₁"),
        words="between 1 and kappa, neither of them",
        **_BODY_2,
    )
    d3: float | None = described(
        0.0330, "damping ratio of the joined bodies, as measured", *_DAMPING, **_BODY_2, optional=True
    )
    restitution: float = described(
        0.5, "coefficient of restitution e", "-", Range(0, 1), "give a coefficient of restitution"
    )
    clearance: float = described(
        *(0.0, "gap where both springs are relaxed; negative: preload", "length", Range(*CLEARANCE_RANGE)),
        "give the gap at rest in units of length; below 0: preload",
    )
    wall: bool = False
    excitation: Excitation = field(default_factory=Excitation)
    mu: float | None = described(
        *(None, "mass ratio m2/m1, in place of kappa3", "-", _MASS_RATIO, "give the mass ratio m₂/m₁"),
        **_BODY_2,
        optional=True,
    )
    spring1: float = described(
        *(1.0, "stiffness of spring 1 in m1 omega1^2; 0: no spring, and omega1 is a unit of time", "-", Range(0, 1)),
        "give 1 where omega1 is the natural frequency of body 1, 0 where it has no spring",
        words="1 or 0; beside a wall 0 to 1",
    )
    clearance2: float | None = described(
        *(None, "clearance of a second stop, on the other side", "length", Range(*CLEARANCE_RANGE)),
        "give the gap of the second stop at rest in units of length; leave it out where there is none",
        optional=True,
    )
    restitution2: float | None = described(
        *(None, "restitution of the second stop, where it is another one", "-", Range(0, 1)),
        "give a coefficient of restitution",
        optional=True,
    )
    stiffness_factor2: float = described(1.0, "K of the second stop over that of the first", *_FACTOR)
    damping_factor2: float = described(1.0, "D of the second stop over that of the first", *_FACTOR)
    sign: ClassVar[float] = 1.0  # of displacements, as in kernels.equations.coordinates

    def __post_init__(self):
        set_fields(self, wall=flag("wall", self.wall))
        if not isinstance(self.excitation, Excitation):
            raise ValueError(f"excitation = {shown(self.excitation)} is not an Excitation")
        if self.wall:
            self._forget_body_2()
        check_numbers(self, without=("kappa3",))
        self._check_springs()
        set_fields(self, kappa3=self._checked_kappa3())
        if self.kappa3 == 0.0:
            set_fields(self, d3=None)
        if self.two_stops and not self.play > 0.0:
            raise ValueError(
                f"clearance + clearance2 = {self.play:g} leaves no play between the two stops: give clearances whose "
                "sum is above 0"
            )
        if not self.two_stops:
            usual = {each.name: each.default for each in fields(self)}
            for name in (name for name in SECOND_STOP if getattr(self, name) != usual[name]):
                raise ValueError(f"{name} without clearance2: there is no second stop; give its clearance, too")

    def _forget_body_2(self) -> None:
        own = {each.name: each.default for each in fields(self) if each.name in BODY_2}
        idle = {each.name: each.default for each in fields(Excitation) if each.name in FORCES_ON_BODY_2}
        set_fields(self, **own, excitation=replace(self.excitation, **idle))

    def _check_springs(self) -> None:
        """Raise a ValueError if one of two bodies has a spring that it cannot have."""
        if self.wall:
            return
        if self.spring1 not in (0.0, 1.0):
            raise ValueError(
                f"spring1 = {self.spring1:g} without wall = true: of two bodies give 1, and time in units of 1/ω₁, or 0"
            )
        if self.kappa:
            require("kappa", self.kappa, *RATIO_RANGE, "give the frequency ratio ω₂/ω₁, 0 where body 2 has no spring")
        if self.spring1 == 0.0 and self.mu is None:
            raise ValueError(
                "spring1 = 0 leaves the mass ratio open, which kappa3 does not give: give mass_ratio, m₂/m₁"
            )

    def _checked_kappa3(self) -> float:
        """κ₃, which follows from μ where that is given."""
        kappa, mu = self.kappa, self.mu
        if mu is not None:
            return math.sqrt((self.spring1 + mu * kappa**2) / (1 + mu))
        kappa3 = described_fields(System)["kappa3"].check("kappa3", self.kappa3)
        if kappa == 1.0:
            raise ValueError(
                "kappa = 1 leaves the mass ratio open, which otherwise follows from kappa3: give mass_ratio, m₂/m₁"
            )
        why = "joined bodies swing between the frequencies of the separate ones; the mass ratio follows from it"
        return require("kappa3", kappa3, *sorted((1.0, kappa)), why, open_low=True, open_high=True)

    @classmethod
    def from_mass_ratio(cls, mass_ratio: float, *, kappa: float = 2.41, **others) -> "System":
        """The system with μ = m₂/m₁ given instead of κ₃, Eq. (33)."""
        mu = require("mass_ratio", mass_ratio, *MASS_RATIO_RANGE, "give m₂/m₁")
        return cls(kappa=kappa, mu=mu, **others)

    @cached_property
    def mass_ratio(self) -> float:
        """μ = m₂/m₁; inf for a wall.

        Two springs that are joined on one mass give

            κ₃² = (1 + μκ²)/(1 + μ),    μ = (κ₃² − 1)/(κ² − κ₃²),    μ/(1 + μ) = (κ₃² − 1)/(κ² − 1)      (33)
        """
        if self.wall:
            return math.inf
        if self.mu is not None:
            return self.mu
        # products, not squares: they keep their digits where the frequencies lie close together
        k, k3 = self.kappa, self.kappa3
        return (k3 - 1) * (k3 + 1) / ((k - k3) * (k + k3))

    @property
    def two_stops(self) -> bool:
        """Whether there is a second stop."""
        return self.clearance2 is not None

    @property
    def play(self) -> float:
        """The distance between two stops; inf where there is one."""
        return self.clearance + self.clearance2 if self.two_stops else math.inf

    @property
    def second_restitution(self) -> float:
        """Coefficient of restitution of the second stop."""
        return self.restitution if self.restitution2 is None else self.restitution2

    @property
    def contact_factors(self) -> tuple[tuple[float, float], ...]:
        """The multiples of a method's K and D at each of two stops."""
        return (1.0, 1.0), (self.stiffness_factor2, self.damping_factor2)

    @cached_property
    def mirrored(self) -> "System":
        """The system of two stops as seen from the second one: its displacements are the negative of these."""
        own = {name: 1.0 / getattr(self, name) for name in ("stiffness_factor2", "damping_factor2")}
        own |= {"clearance": self.clearance2, "clearance2": self.clearance}
        own |= {"restitution": self.second_restitution, "restitution2": self.restitution}
        return replace(self, excitation=self.excitation.reversed, **own)

    @property
    def with_first_stop(self) -> "System":
        """The system without its second stop."""
        usual = {each.name: each.default for each in fields(self) if each.name in ("clearance2", *SECOND_STOP)}
        return replace(self, **usual) if self.two_stops else self

    @property
    def is_symmetric(self) -> bool:
        """Whether both stops are alike and no constant force acts: then −ξ half a period later is a motion, too."""
        e = self.excitation
        first = self.clearance, self.restitution, 1.0, 1.0
        second = self.clearance2, self.second_restitution, self.stiffness_factor2, self.damping_factor2
        return first == second and e.constant1 == e.constant2 == 0.0

    @property
    def stiffer_spring(self) -> float:
        """The stiffer one of both bodies' springs, in units of m₁ω₁²; 1 where none has one."""
        return 1.0 if self.wall else max(self.spring1, self.mass_ratio * self.kappa**2) or 1.0

    @cached_property
    def mass_share(self) -> float:
        """μ/(1 + μ), the reduced mass of the two bodies in units of m₁; 1 for a wall."""
        if self.wall:
            return 1.0
        if self.mu is not None:
            return self.mu / (1 + self.mu)
        k, k3 = self.kappa, self.kappa3
        return (k3 - 1) * (k3 + 1) / ((k - 1) * (k + 1))

    @property
    def lighter_mass(self) -> float:
        """Mass of the lighter body in units of m₁; 1 for a wall."""
        return min(1.0, self.mass_ratio)

    @cached_property
    def stiffness_share(self) -> float:
        """k₂/(k₁ + k₂) = μκ²/(1 + μκ²), stiffness of both springs in series in units of k₁; k₁ for a wall.

        Of two bodies of which one has no spring 1 or 0, the share of the gap by which body 1 gives way.
        """
        if self.wall or self.kappa3 == 0.0:
            return self.spring1
        return self.mass_share * (self.kappa / self.kappa3) ** 2

    @cached_property
    def derived_joint_damping(self) -> float:
        """d₃ if the joint held the two dampers and nothing else; 0 for a wall, and of two bodies without springs.

        It is

            d₃ = (d₁ + μd₂κ)/((1 + μ)κ₃)                                                    (34)
        """
        if self.wall or self.kappa3 == 0.0:
            return 0.0
        mu = self.mass_ratio
        return (self.d1 + mu * self.damper2) / ((1 + mu) * self.kappa3)

    @property
    def damper2(self) -> float:
        """d₂κ, half the damper of body 2 in units of m₂ω₁; d₂ where it has no spring."""
        return self.d2 * (self.kappa or 1.0)

    def joint_damper(self, kind: str) -> float:
        """d₃κ₃, half the damper of the joined bodies in units of (m₁ + m₂)ω₁."""
        if self.kappa3 == 0.0:
            return (self.d1 + self.mass_ratio * self.damper2) / (1 + self.mass_ratio)
        return self.joint_damping(kind) * self.kappa3

    def joint_damping(self, kind: str) -> float:
        """d₃ as measured (``"table"``), where it was, or as it follows from the dampers (``"derived"``)."""
        return self.derived_joint_damping if kind == "derived" or self.wall or self.d3 is None else self.d3

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Natural frequencies of the separate bodies, or the unit of time, in units of ω₁: 1 and κ; 1 beside a wall."""
        return (1.0,) if self.wall else (1.0, self.kappa or 1.0)

    @property
    def observed_body(self) -> int:
        """The body whose displacement stands for the motion where one has to: 2, or 1 beside a wall, which stands."""
        return 1 if self.wall else 2

    @cached_property
    def separate_rest(self) -> tuple[float, float]:
        """ξ₁ and ξ₂ of the static equilibrium that the bodies have without contact, even if they overlap there.

        Of a body without a spring that a constant force pulls beside a wall ξ₁ is infinite; without one it may rest
        anywhere: at 0, or, of two bodies, where it touches the other one if that is nearer. Of two bodies one that is
        pulled is where it touches the other one, if that has a spring.
        """
        e = self.excitation
        x1 = e.constant1 / self.spring1 if self.spring1 else 0.0
        if self.wall and not self.spring1 and e.constant1:
            x1 = math.copysign(math.inf, e.constant1)
        x2 = 0.0 if self.wall or not self.kappa else e.constant2 / (self.mass_ratio * self.kappa**2)
        overlap = max(0.0, -self.gap(x1, x2)) if self.has_free_body else 0.0
        if self.held_pull:
            overlap = -self.gap(x1, x2)
        return (x1, x2 + overlap) if self.spring1 else (x1 - overlap, x2)

    @cached_property
    def free_pulls(self) -> tuple[float, float]:
        """Accelerations by constant forces on bodies without springs, of two bodies; 0 of one that has a spring."""
        if self.wall:
            return 0.0, 0.0
        e = self.excitation
        return 0.0 if self.spring1 else e.constant1, 0.0 if self.kappa else e.constant2 / self.mass_ratio

    @property
    def free_pull(self) -> float:
        """Acceleration that these give the gap; 0 of two weights, whose accelerations differ by rounding at most."""
        first, second = self.free_pulls
        return 0.0 if abs(second - first) <= 4 * 2.0**-52 * min(abs(first), abs(second)) else second - first

    @property
    def held_pull(self) -> float:
        """The same where the spring of the other body bears it in contact, else 0."""
        return self.free_pull if self.spring1 or self.kappa else 0.0

    @cached_property
    def static_gap(self) -> float:
        """The gap of :attr:`separate_rest`: negative if the bodies press against each other at rest."""
        x1, x2 = self.separate_rest
        return self.clearance + (x2 - x1)

    @property
    def has_free_body(self) -> bool:
        """Whether one of two bodies, or both, have no spring."""
        return not self.wall and not (self.spring1 and self.kappa)

    @property
    def rests_afar(self) -> bool:
        """Whether solvers count from touch beside a wall, the separate rest being far away, or not unique."""
        return self.wall and (self.spring1 == 0.0 or not -FAR <= self.static_gap <= FAR_OPEN)

    @cached_property
    def rest(self) -> tuple[float, float, float, float]:
        """ξ₁, ξ₁′, ξ₂, ξ₂′ of the static equilibrium, contact being rigid: where runs begin unless a start is given.

        A body without a spring that a constant force pulls off a wall has none: then ξ₁ = 0; of two bodies it then
        begins where it touches the other one, and two without springs at 0, or where they touch.
        """
        if self.static_gap > self.play or (self.held_pull > 0.0 and self.two_stops):  # pressed to the second stop
            return tuple(0.0 - value for value in self.mirrored.rest)
        x1, x2 = self.separate_rest
        if x1 == -math.inf:
            x1 = min(0.0, self.clearance)
        if self.held_pull < 0 or (self.static_gap < 0 and not self.held_pull):
            if self.held_pull:  # the other body bears it
                e = self.excitation
                x1 += e.constant2 if self.spring1 else e.constant1 / (self.mass_ratio * self.kappa**2)
            else:
                x1 = self.clearance if self.wall else x1 + self.stiffness_share * self.static_gap
            x2 = 0.0 if self.wall else x1 - self.clearance
            step = 2.0**-53 * (abs(self.clearance) + abs(x1))
            while self.gap(x1, x2) > 0:  # by rounding; Newmark's method would begin without contact
                x2, step = x2 - step, 2 * step
        return x1, 0.0, x2, 0.0

    def gap(self, x1, x2):
        """g = clearance + ξ₂ − ξ₁, of numbers or arrays."""
        return self.clearance + (x2 - x1)

    def nearest_gap(self, x1, x2):
        """The smaller of the gaps of all stops, of numbers or arrays."""
        gap = self.gap(x1, x2)
        return np.minimum(gap, self.play - gap)

    def overlap_of(self, state: Sequence[float]) -> float:
        """How far the bodies overlap in a state ξ₁, ξ₁′, ξ₂, ξ₂′ by more than rounding; 0 if they do not."""
        return float(self.overlaps_of(np.array([state], dtype=float))[0])

    def overlaps_of(self, states: np.ndarray) -> np.ndarray:
        """How far the bodies overlap in each of many states, (n, 4), by more than rounding."""
        x1, x2 = states[:, 0], states[:, 2]
        found = _overlaps(self.clearance, self.gap(x1, x2), x1, x2)
        if not self.two_stops:
            return found
        return np.maximum(found, _overlaps(self.clearance2, self.clearance2 - (x2 - x1), x1, x2))

    def without_penetration(self, state: Sequence[float]) -> tuple[float, float, float, float]:
        """Return the state ξ₁, ξ₁′, ξ₂, ξ₂′ with a negative gap closed: the reference cannot start with g < 0.

        Body 2 is moved; body 1, if body 2 is a wall.
        """
        x1, v1, x2, v2 = (float(value) for value in state)
        farthest = math.inf if self.clearance2 is None else self.clearance2  # of body 2, or the wall, from body 1
        if self.wall:
            return max(-farthest, min(x1, self.clearance)), v1, x2, v2
        return x1, v1, min(x1 + farthest, max(x1 - self.clearance, x2)), v2

    def as_dict(self) -> dict[str, float | bool | None]:
        """The constants by name, in one level: those of the paper's system, and whatever else is not the default.

        :meth:`from_dict` takes them back.
        """
        own = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "excitation"}
        default = {each.name: each.default for each in fields(self)}
        kept = {name: value for name, value in own.items() if name in PAPERS or value != default[name]}
        if self.wall:
            kept = {name: value for name, value in kept.items() if name not in BODY_2}
        if self.mu is not None:
            del kept["kappa3"]  # it follows
        driven = Excitation().as_dict()
        return kept | {name: value for name, value in self.excitation.as_dict().items() if value != driven[name]}

    def changed(self, constants: dict[str, float]) -> "System":
        """The system with other values of some constants, including those of the excitation."""
        own = {name: value for name, value in constants.items() if name not in _DRIVE}
        driven = {name: value for name, value in constants.items() if name in _DRIVE}
        return replace(self, **own, excitation=replace(self.excitation, **driven) if driven else self.excitation)

    @classmethod
    def from_dict(cls, constants: dict[str, float | bool | None]) -> "System":
        """The system of the constants that :meth:`as_dict` returns, or of some of them."""
        return cls().changed(constants)


def _overlaps(clearance: float, gap: np.ndarray, x1: np.ndarray, x2: np.ndarray) -> np.ndarray:
    rounding = 4 * 2.0**-52 * (abs(clearance) + np.abs(x1) + np.abs(x2)) if clearance else 0.0
    return np.where(gap < -rounding, -gap, 0.0)


# What a wall has no use for: attributes of System and of Excitation that belong to body 2 alone.
BODY_2, FORCES_ON_BODY_2 = (
    tuple(name for name, each in described_fields(kind).items() if each.of_body_2) for kind in (System, Excitation)
)
SECOND_STOP = "restitution2", "stiffness_factor2", "damping_factor2"  # what needs a clearance2
PAPERS = ("kappa", "d1", "d2", "kappa3", "d3", "restitution")  # the constants of the paper's system, Table 1


def check_eta(eta: float) -> float:
    """η as float.

    Raises
    ------
    ValueError
        Outside the allowed range.
    """
    return require("eta", eta, *ETA_RANGE, "give the excitation frequency Ω/ω₁; the paper uses 1.08 to 3.25")
