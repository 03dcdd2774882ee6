"""A family of problems, and what a search for branches is asked of it.

A family is one system and method with one number free, as η, K, the clearance or the amplitude.
"""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, asdict, dataclass, replace
from functools import cached_property

import numpy as np
from vibroscope.engine.arguments import flag, require, set_fields, shown, whole
from vibroscope.engine.continuation.tolerances import LOGARITHMIC
from vibroscope.engine.methods import CONTACT_LAWS, METHOD_NUMBERS, ExactPenalty, Reference, check_has
from vibroscope.engine.model import SECOND_STOP, System, check_eta
from vibroscope.engine.motions.poincare_map import unresolved
from vibroscope.engine.motions.steady import MAX_PERIOD_LIMIT

OF_METHOD = {"K": METHOD_NUMBERS["K"], "D": METHOD_NUMBERS["D"], "threshold": "threshold"}
OF_SYSTEM = (
    "kappa", "kappa3", "d1", "d2", "d3", "restitution", "clearance", "clearance2", *SECOND_STOP,
    "base", "force1", "force2", "constant1", "constant2", "base_phase", "force1_phase", "force2_phase",
)  # fmt: skip
LAW = CONTACT_LAWS[0]  # of the exact penalty solution whose orbits have equations
LARGEST_FOLLOWED = 1e12
PARAMETERS = ("eta", *OF_METHOD, *OF_SYSTEM, "mass_ratio")


@dataclass(frozen=True)
class Family:
    """A system, an η and a method whose orbits have equations, with the number ``over`` free.

    Raises
    ------
    ValueError
        If there is no such number, the method does not have it, or its orbits have no equations.
    """

    over: str
    system: System
    eta: float
    method: Reference | ExactPenalty

    def __post_init__(self) -> None:
        if self.over not in PARAMETERS:
            names = ", ".join(PARAMETERS)
            raise ValueError(f"over = {shown(self.over)} is no number to follow a motion over: give one of {names}")
        if self.method.has_step:
            raise ValueError(
                f"{self.method} has a time step: branches are those of a solution in closed form. Give Reference, or "
                "ExactPenalty (--solver exact), to which it tends with smaller steps"
            )
        if not self.method.rigid and self.method.law != LAW:
            raise ValueError(
                f"law = {self.method.law!r} has no branches: give {LAW!r}, or sweep the number over runs with this law"
            )
        check_has(self.method, self.over, self.system)
        if self.over == "clearance2" and not self.system.two_stops:
            raise ValueError("clearance2: there is no second stop; give its clearance, too")
        check_eta(self.eta)

    def at(self, value: float) -> tuple[System, float, Reference | ExactPenalty]:
        """The problem where the number has this value.

        Raises
        ------
        ValueError
            If the value is out of range.
        """
        if self.over == "eta":
            return self.system, check_eta(value), self.method
        if self.over in OF_METHOD:
            return self.system, self.eta, self.method_at(value)
        own = "mu" if self.over == "mass_ratio" else self.over
        return self.system.changed({own: value}), self.eta, self.method

    @property
    def changes_system(self) -> bool:
        """Whether the number is one of the system, not η or one of the method."""
        return self.over != "eta" and self.over not in OF_METHOD

    def method_at(self, value: float) -> Reference | ExactPenalty:
        """The method where the number has this value, which :meth:`at` has checked."""
        own = OF_METHOD.get(self.over)
        return replace(self.method, **{own: value}) if own else self.method

    @property
    def value(self) -> float:
        """The number as the problem has it."""
        if self.over == "eta":
            return self.eta
        if self.over in OF_METHOD:
            return self.method.numbers[self.over]
        if self.over == "restitution2":
            return self.system.second_restitution
        return getattr(self.system.excitation if hasattr(self.system.excitation, self.over) else self.system, self.over)


@dataclass(frozen=True)
class ParameterRange:
    """The range of a number, and its scale; `of` checks it."""

    name: str
    low: float
    high: float

    @classmethod
    def of(cls, family: Family, low: float, high: float) -> "ParameterRange":
        """The range of the number that is free in a family.

        Raises
        ------
        ValueError
            If it is empty, or an end of it is nothing that the number may be.
        """
        name, advice = family.over, "give the ends of the range as numbers"
        low, high = (require(name, end, -LARGEST_FOLLOWED, LARGEST_FOLLOWED, advice) for end in (low, high))
        if not low < high:
            raise ValueError(f"{name} from {low:g} to {high:g} is an empty range: give the smaller number first")
        for end in (low, high):
            family.at(end)
        return cls(name, low, high)

    def check_start(self, value: float) -> None:
        """Raise ValueError if a value, where something is to begin, lies outside."""
        if not self.low <= value <= self.high:
            raise ValueError(
                f"{self.name} = {value:g} lies outside {self.low:g} … {self.high:g}: begin within the range"
            )

    @property
    def width(self) -> float:
        """From one end to the other."""
        return self.high - self.low

    @property
    def logarithmic(self) -> bool:
        """Whether shares of it are those of the logarithm."""
        return self.low > 0 and self.high > LOGARITHMIC * self.low

    def value(self, share: float) -> float:
        """The number at a share of the range."""
        if share in (0.0, 1.0):  # not beyond it by rounding
            return self.high if share else self.low
        if self.logarithmic:
            return self.low * math.exp(share * math.log(self.high / self.low))
        return self.low + share * (self.high - self.low)

    def share(self, value: float) -> float:
        """Where a number lies in the range: 0 at its low end, 1 at the high one; nan if it cannot lie anywhere."""
        if self.logarithmic:
            return math.log(value / self.low) / math.log(self.high / self.low) if value > 0 else math.nan
        return (value - self.low) / (self.high - self.low)


@dataclass(frozen=True)
class BranchQuestion:
    """Branches of periodic motions are asked for, of one system and method through a range of one number.

    Attributes
    ----------
    system : System
    eta : float
        Excitation frequency η = Ω/ω₁.
    method : Reference or ExactPenalty
        The exact penalty with the law "kelvin-voigt".
    over : str
        The number that varies: "eta", "K", "D", "threshold", or a number of the system or its excitation. Where a
        branch starts it has the value that the other attributes give it.
    low, high : float
        The range of that number.
    max_period : int
        Longest cycle, in excitation periods; cascades of period doublings are followed up to it.
    unstable : bool
        Follow also what begins where an unstable motion bifurcates, and motions of several periods however long they
        stay unstable: there may be very many such branches.
    most_orbits : int
        After which a branch is given up, in each direction.
    initial : (4,) sequence, optional
        ξ₁, ξ₁′, ξ₂, ξ₂′ at τ = 0: an orbit, stable or not, that nearly passes through it is followed first, or else the
        one that a run from it settles to. By default rest.

    Raises
    ------
    ValueError
        If a number is out of range, or the orbits of the method have no equations.

    Examples
    --------
    >>> from vibroscope.engine import BranchQuestion, Reference, System
    >>> BranchQuestion(System(), 2.76, Reference(), low=2.7, high=2.85).max_period
    8
    """

    system: System
    eta: float
    method: Reference | ExactPenalty
    _: KW_ONLY
    over: str = "eta"
    low: float
    high: float
    max_period: int = 8
    unstable: bool = False
    most_orbits: int = 5000
    initial: Sequence[float] | None = None

    def __post_init__(self) -> None:
        longest = whole("max_period", self.max_period, 1, MAX_PERIOD_LIMIT, "give the longest cycle to follow")
        most = whole("most_orbits", self.most_orbits, 2, 1_000_000, "give the orbits of a branch")
        unstable, initial = flag("unstable", self.unstable), self.initial
        if not isinstance(self.system, System):
            raise ValueError(f"system = {shown(self.system)} is not a System")
        if initial is not None and not np.iterable(initial):
            raise ValueError(f"initial = {shown(initial)} is not a sequence or None")
        if reason := unresolved(self.system) or _unheld(self.system):
            raise ValueError(reason)
        set_fields(self, eta=check_eta(self.eta), initial=None if initial is None else tuple(initial))
        span = ParameterRange.of(self.family, self.low, self.high)
        set_fields(self, low=span.low, high=span.high, max_period=longest, most_orbits=most, unstable=unstable)

    @cached_property
    def family(self) -> Family:
        """The problems over the number that varies."""
        return Family(self.over, self.system, self.eta, self.method)

    @property
    def span(self) -> ParameterRange:
        """The range of that number."""
        return ParameterRange(self.over, self.low, self.high)

    @property
    def value(self) -> float:
        """The number as system, η and method have it."""
        return self.family.value

    def at(self, value: float) -> tuple[System, float, Reference | ExactPenalty]:
        """System, η and method where the number has a value; a ValueError if it cannot have it."""
        return self.family.at(value)

    def as_dict(self) -> dict[str, object]:
        """All that an answer depends on, as JSON takes it."""
        initial = None if self.initial is None else [float(number) for number in self.initial]
        return asdict(self) | {"method": {"name": self.method.name} | asdict(self.method), "initial": initial}


def _unheld(system: System) -> str:
    """Why no orbit of a system stands alone; empty if there may be one."""
    if not system.has_free_body or system.held_pull < 0.0:
        return ""
    repeat = "so that periodic motions repeat at any place, and no branch of single orbits can be followed"
    if not system.spring1 and not system.kappa:
        return (
            f"neither body has a spring: nothing holds them, {repeat}; give one of them a spring, or ask for a diagram"
        )
    if system.two_stops:  # on the other body
        return ""
    return (
        f"one of the bodies has no spring: nothing holds it, {repeat}; give it a spring, a constant force towards the "
        "other one or a second stop, or ask for a diagram"
    )
