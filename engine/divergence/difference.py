"""The difference of two solutions as numbers: the only place that verdict, bars, tables and texts take them from."""

from dataclasses import dataclass

import numpy as np

from ..facts import Choice, Statement, stated
from ..methods import CONTACT_LAWS

PART_NAMES = {"time_step": "time step", "regularisation": "K and D", "joint_damping": "joint damping"}


@dataclass(frozen=True)
class Difference:
    """The difference of a penalty solution from the reference, and its parts as far as they are known.

    Attributes
    ----------
    measure : {"displacements", "sections"}
        Rms of the displacements over the kept periods, where the reference repeats itself; else the distance of the
        Poincaré sections (:mod:`.statistics`).
    total : float
        Relative to the reference; nan if a solution does not reach the end of the longer runs for the sections.
    parts : dict of str to float
        The same of each of PARTS (:mod:`.parts`), of the joint damping only where the reference has one of its own;
        empty where the displacements are compared and not all four motions repeat themselves. They add up at each
        instant, not as numbers.
    chance : float
        The largest distance of sections that may be chance; 0 for displacements.
    law : str
        The contact law of the penalty solution.
    """

    measure: str
    total: float
    parts: dict[str, float]
    chance: float = 0.0
    law: str = CONTACT_LAWS[0]

    def name(self, part: str) -> str | Statement:
        """Return the words for a part; of K and D with a law that is another one than the spring and the damper."""
        named = part == "regularisation" and self.law != CONTACT_LAWS[0]
        return stated("{} (law {})", PART_NAMES[part], Choice("law", (self.law,))) if named else PART_NAMES[part]

    @property
    def largest(self) -> str:
        """The name of the largest part; "" where the parts are not known."""
        return max(self.parts, key=self.parts.__getitem__, default="")


def known(values: dict[str, float]) -> dict[str, float]:
    """Only the finite ones."""
    return {name: float(value) for name, value in values.items() if np.isfinite(value)}
