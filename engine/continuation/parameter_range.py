"""The range of a number over which orbits are followed."""

import math
from dataclasses import dataclass

from ..checks import require
from .family import Family
from .tolerances import LOGARITHMIC

LARGEST_FOLLOWED = 1e12


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
