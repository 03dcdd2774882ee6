"""The limits of a search for K, D and the time step."""

from dataclasses import dataclass, replace

from vibroscope.engine.checks import require, whole
from vibroscope.engine.methods import DAMPING_RANGE, STIFFNESS_RANGE
from vibroscope.engine.model import System
from vibroscope.engine.wording import rounded_to

STIFFNESS_MAX_RANGE = (1.0, 1e11)
STEPS_MAX_RANGE = (4, 1_000_000)
STIFFEST = 1e6  # times the stiffer spring: the largest K that is tried unless another is given


def largest_stiffness(system: System) -> float:
    """Return the largest K that a search tries unless another is given, of two digits."""
    return min(rounded_to(STIFFEST * system.stiffer_spring, 2), STIFFNESS_MAX_RANGE[1])


@dataclass(frozen=True)
class Limits:
    """Limits of a search, and what it holds fixed.

    Parameters
    ----------
    stiffness_max : float, optional
        Largest K to try; by default :func:`largest_stiffness` of the system.
    steps_max : int
        Largest number of steps per period to try.
    stiffness, damping : float, optional
        K and D, if they are given and not looked for.

    Raises
    ------
    ValueError
        If a number is out of range: the text names it, the range and what to do.
    """

    stiffness_max: float | None = None
    steps_max: int = 65_536
    stiffness: float | None = None
    damping: float | None = None

    def __post_init__(self):
        most = "give the most steps per period to try"
        checked = {"steps_max": whole("steps_max", self.steps_max, *STEPS_MAX_RANGE, most)}
        if self.stiffness_max is not None:
            largest = "give the largest K to try"
            checked["stiffness_max"] = require("stiffness_max", self.stiffness_max, *STIFFNESS_MAX_RANGE, largest)
        if self.stiffness is not None:
            checked["stiffness"] = require("stiffness", self.stiffness, *STIFFNESS_RANGE, "give the K to hold")
        if self.damping is not None:
            checked["damping"] = require("damping", self.damping, *DAMPING_RANGE, "give the D to hold")
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def of(self, system: System) -> "Limits":
        """The limits for a system, all of them numbers."""
        return self if self.stiffness_max is not None else replace(self, stiffness_max=largest_stiffness(system))
