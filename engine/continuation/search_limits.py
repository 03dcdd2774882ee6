"""How far a search for branches goes."""

from dataclasses import dataclass

from ..checks import flag, whole
from ..motions.steady import MAX_PERIOD_LIMIT


@dataclass(frozen=True)
class SearchLimits:
    """What a search follows, in the words of :func:`.find.search_branches`.

    Raises
    ------
    ValueError
        If a number is out of range.
    """

    max_period: int
    most_orbits: int
    unstable: bool = False

    def __post_init__(self) -> None:
        longest = whole("max_period", self.max_period, 1, MAX_PERIOD_LIMIT, "give the longest cycle to follow")
        most = whole("most_orbits", self.most_orbits, 2, 1_000_000, "give the orbits of a branch")
        object.__setattr__(self, "max_period", longest)
        object.__setattr__(self, "most_orbits", most)
        object.__setattr__(self, "unstable", flag("unstable", self.unstable))
