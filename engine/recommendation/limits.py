"""The limits of a search for K, D and the time step."""

from dataclasses import dataclass

from ..checks import require, whole
from ..methods import DAMPING_RANGE, STIFFNESS_RANGE

STIFFNESS_MAX_RANGE = (1.0, 1e11)
STEPS_MAX_RANGE = (4, 1_000_000)


@dataclass(frozen=True)
class Limits:
    """Limits of a search, and what it holds fixed.

    Parameters
    ----------
    stiffness_max : float
        Largest K to try.
    steps_max : int
        Largest number of steps per period to try.
    stiffness, damping : float, optional
        K and D, if they are given and not looked for.

    Raises
    ------
    ValueError
        If a number is out of range: the text names it, the range and what to do.
    """

    stiffness_max: float = 1e6
    steps_max: int = 65_536
    stiffness: float | None = None
    damping: float | None = None

    def __post_init__(self):
        checked = {
            "stiffness_max": require(
                "stiffness_max", self.stiffness_max, *STIFFNESS_MAX_RANGE, "give the largest K to try"
            ),
            "steps_max": whole("steps_max", self.steps_max, *STEPS_MAX_RANGE, "give the most steps per period to try"),
        }
        if self.stiffness is not None:
            checked["stiffness"] = require("stiffness", self.stiffness, *STIFFNESS_RANGE, "give the K to hold")
        if self.damping is not None:
            checked["damping"] = require("damping", self.damping, *DAMPING_RANGE, "give the D to hold")
        for name, value in checked.items():
            object.__setattr__(self, name, value)
