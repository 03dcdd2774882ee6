"""The solution methods, as small frozen objects that hold their numbers and nothing else."""

from dataclasses import dataclass
from typing import ClassVar

from .model import require, whole

JOINT_DAMPINGS = ("table", "derived")
THRESHOLD_RANGE = (0.0, 1e3)
STIFFNESS_RANGE = (1e-6, 1e12)
DAMPING_RANGE = (0.0, 1e9)
STEPS_RANGE = (4, 10_000_000)


@dataclass(frozen=True)
class Reference:
    """Semi-analytical reference: closed form between events, Newton's impact law (paper, section 2).

    Attributes
    ----------
    joint_damping : {"table", "derived"}
        Damping of the joined pendulums: measured (Table 1), or what the two dampers add up to, which is what a
        penalty model tends to as K → ∞.
    threshold : float
        ε: an impact that leaves a parting speed of at most ε under compression begins a permanent contact. 0 is the
        limit ε → 0: a chatter goes through all its infinitely many impacts, completed in closed form.

    Raises
    ------
    ValueError
        If a value is out of range.
    """

    joint_damping: str = "table"
    threshold: float = 0.002
    name: ClassVar[str] = "reference"

    def __post_init__(self):
        if self.joint_damping not in JOINT_DAMPINGS:
            raise ValueError(f"joint_damping = {self.joint_damping!r} is not one of {', '.join(JOINT_DAMPINGS)}")
        advice = "give a parting speed, or 0 for its limit; the paper uses 0.002"
        object.__setattr__(self, "threshold", require("threshold", self.threshold, *THRESHOLD_RANGE, advice))


@dataclass(frozen=True)
class ExactPenalty:
    """Penalty contact without a time step: closed form in flight and in contact (MODEL.md, "Exact penalty").

    It is what Newmark's solution tends to as Δτ → 0.

    Attributes
    ----------
    stiffness : float
        K of the contact spring, in units of pendulum 1's own stiffness.
    damping : float
        D of the contact damper; the force is K(ξ₁ − ξ₂) + 2D(ξ₁′ − ξ₂′).

    Raises
    ------
    ValueError
        If a value is out of range.
    """

    stiffness: float
    damping: float
    name: ClassVar[str] = "exact"

    def __post_init__(self):
        _check_contact(self)


@dataclass(frozen=True)
class Newmark:
    """Penalty contact integrated by Newmark's method, α = ½, β = ¼, constant step T/n (paper, section 4).

    Attributes
    ----------
    stiffness : float
        K of the contact spring, in units of pendulum 1's own stiffness.
    damping : float
        D of the contact damper; the force is K(ξ₁ − ξ₂) + 2D(ξ₁′ − ξ₂′).
    steps : int
        n, steps per excitation period: Δτ = T/n.
    every_step : bool
        Walk through every step, as an FE code must, instead of leaping over those at which contact does not change.
        The solution is the same but for rounding, the cost is not. Rounding shows where it is multiplied: in chaotic
        motion after some hundred periods (also in how many of them are kept, since those are always walked), in the
        step at which a run blows up, and in the scatter that a coarse step causes.
    located : bool
        Cut a step at each contact change, located within it, instead of finding contact at the start of steps alone;
        contacts shorter than some steps are resolved by shorter ones. All steps are walked; the cost counts each solve.

    Raises
    ------
    ValueError
        If a value is out of range.
    """

    stiffness: float
    damping: float
    steps: int
    every_step: bool = False
    located: bool = False
    name: ClassVar[str] = "newmark"

    def __post_init__(self):
        _check_contact(self)
        n = whole("steps", self.steps, *STEPS_RANGE, "give steps per excitation period; the paper uses 2000 to 8000")
        object.__setattr__(self, "steps", n)


def _check_contact(method: ExactPenalty | Newmark) -> None:
    k = require("K", method.stiffness, *STIFFNESS_RANGE, "give a contact stiffness; the paper uses 100 to 12000")
    d = require("D", method.damping, *DAMPING_RANGE, "give a contact damping; the paper uses 8 to 50")
    object.__setattr__(method, "stiffness", k)
    object.__setattr__(method, "damping", d)


Method = Reference | ExactPenalty | Newmark
