"""What a search for branches is asked."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, asdict, dataclass
from functools import cached_property

import numpy as np
from vibroscope.engine.arguments import shown
from vibroscope.engine.checks import flag, whole
from vibroscope.engine.continuation.family import Family, ParameterRange
from vibroscope.engine.methods import ExactPenalty, Reference
from vibroscope.engine.model import System, check_eta
from vibroscope.engine.motions.poincare_map import unresolved
from vibroscope.engine.motions.steady import MAX_PERIOD_LIMIT


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
        object.__setattr__(self, "eta", check_eta(self.eta))
        span = ParameterRange.of(self.family, self.low, self.high)
        checked = {"low": span.low, "high": span.high, "max_period": longest, "most_orbits": most, "unstable": unstable}
        for name, value in (checked | {"initial": initial if initial is None else tuple(initial)}).items():
            object.__setattr__(self, name, value)

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
    if not system.has_free_body:
        return ""
    return (
        "one of the bodies has no spring: nothing holds it, so that its periodic motions repeat at any place, and no "
        "branch of single orbits can be followed; give it a spring, or ask for a diagram"
    )
