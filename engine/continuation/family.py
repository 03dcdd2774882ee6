"""A family of problems: one system and method with one number free, as η, K, the clearance or the amplitude."""

from dataclasses import dataclass, replace

from ..arguments import shown
from ..drivers.law_driven import by_steps
from ..drivers.orbit_equations import Followed
from ..law_table import PIECEWISE_LINEAR
from ..methods import METHOD_NUMBERS, NEWMARK_LAWS, ExactPenalty, Newmark, Reference
from ..model import System, check_eta

OF_METHOD = {"K": METHOD_NUMBERS["K"], "D": METHOD_NUMBERS["D"], "threshold": "threshold"}
OF_SYSTEM = (
    "kappa", "kappa3", "d1", "d2", "d3", "restitution", "clearance",
    "base", "force1", "force2", "constant1", "constant2", "base_phase", "force1_phase", "force2_phase",
)  # fmt: skip
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
    method: Followed

    def __post_init__(self) -> None:
        if self.over not in PARAMETERS:
            names = ", ".join(PARAMETERS)
            raise ValueError(f"over = {shown(self.over)} is no number to follow a motion over: give one of {names}")
        if not isinstance(self.method, Followed):
            raise ValueError(
                f"{self.method} has a time step: branches need a closed form, Reference or ExactPenalty, or Newmark's "
                "method with located=True"
            )
        if isinstance(self.method, Newmark):
            _check_located(self.method)
        if by_steps(self.method):
            laws = ", ".join(PIECEWISE_LINEAR)
            raise ValueError(
                f"law = {self.method.law!r} has no closed form in contact: branches are followed with {laws}"
            )
        own = OF_METHOD.get(self.over)
        if own and not hasattr(self.method, own):
            raise ValueError(f"the {self.method.name} method has no {self.over}: give another number or solver")
        if self.over == "restitution" and not isinstance(self.method, Reference):
            raise ValueError("the exact method has no impact law and so no restitution: follow the motion over D")
        check_eta(self.eta)

    def at(self, value: float) -> tuple[System, float, Followed]:
        """The problem where the number has this value.

        Raises
        ------
        ValueError
            If the value is out of range.
        """
        if self.over == "eta":
            return self.system, check_eta(value), self.method
        if self.over == "D" and value == 0.0 and self.method.law != PIECEWISE_LINEAR[0]:
            law = self.method.law
            raise ValueError(
                f"D = 0: without a damper the law {law} is kelvin-voigt: follow from a D above 0, or take that"
            )
        if self.over in OF_METHOD:
            return self.system, self.eta, self.method_at(value)
        own = "mu" if self.over == "mass_ratio" else self.over
        return self.system.changed({own: value}), self.eta, self.method

    @property
    def jumps(self) -> bool:
        """Whether the equations of a sequence of events may jump (:mod:`..kernels.located_orbit`)."""
        return isinstance(self.method, Newmark)

    @property
    def searched(self) -> Reference | ExactPenalty:
        """The method whose runs show where motions are: the own one, or what Newmark's method tends to."""
        return self.method.limit if self.jumps else self.method

    def searched_at(self, value: float) -> tuple[System, float, Reference | ExactPenalty]:
        """The problem of those runs where the number has this value."""
        return replace(self, method=self.searched).at(value)

    @property
    def changes_system(self) -> bool:
        """Whether the number is one of the system, not η or one of the method."""
        return self.over != "eta" and self.over not in OF_METHOD

    def method_at(self, value: float) -> Followed:
        """The method where the number has this value, which :meth:`at` has checked."""
        own = OF_METHOD.get(self.over)
        return replace(self.method, **{own: value}) if own else self.method

    @property
    def value(self) -> float:
        """The number as the problem has it."""
        if self.over == "eta":
            return self.eta
        if self.over in OF_METHOD:
            return getattr(self.method, OF_METHOD[self.over])
        return getattr(self.system.excitation if hasattr(self.system.excitation, self.over) else self.system, self.over)


def _check_located(method: Newmark) -> None:
    """Raise ValueError unless the map over a period is continuous in the state."""
    if not method.located:
        raise ValueError(
            "Newmark's method with whole steps has no branches: contact begins and ends with a step, so that its map "
            "over a period jumps wherever a contact passes one, and no orbit can be followed across. Give located=True "
            "(--located), which cuts the step there, or ExactPenalty (--solver exact), what it tends to"
        )
    if method.law != NEWMARK_LAWS[0]:
        raise ValueError(
            f"branches of Newmark's method are followed with the law {NEWMARK_LAWS[0]}, not with {method.law}: "
            "give ExactPenalty (--solver exact) with that law"
        )
