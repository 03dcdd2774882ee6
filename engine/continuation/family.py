"""A family of problems: one system and method with one number free, as η, K, the clearance or the amplitude."""

from dataclasses import dataclass, replace

from ..arguments import shown
from ..methods import CONTACT_LAWS, METHOD_NUMBERS, ExactPenalty, Reference
from ..model import System, check_eta

OF_METHOD = {"K": METHOD_NUMBERS["K"], "D": METHOD_NUMBERS["D"], "threshold": "threshold"}
OF_SYSTEM = (
    "kappa", "kappa3", "d1", "d2", "d3", "restitution", "clearance",
    "base", "force1", "force2", "constant1", "constant2", "base_phase", "force1_phase", "force2_phase",
)  # fmt: skip
LAW = CONTACT_LAWS[0]  # of the exact penalty solution whose orbits have equations
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
        if self.over in OF_METHOD and self.over not in self.method.numbers:
            raise ValueError(f"the {self.method.name} method has no {self.over}: give another number or solver")
        if self.over == "restitution" and not self.method.rigid:
            raise ValueError("the exact method has no impact law and so no restitution: follow the motion over D")
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
        return getattr(self.system.excitation if hasattr(self.system.excitation, self.over) else self.system, self.over)
