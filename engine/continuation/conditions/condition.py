"""What every condition has in common."""

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..margins import Margin
from ..orbit import Orbit
from ..plane import Place, Plane

if TYPE_CHECKING:
    from ..point_equations import Equations


class Condition:
    """What is zero at a point of a kind. A subclass names the kinds that it serves.

    Parameters
    ----------
    kind : str
        Of the points.
    event : int, optional
        The event of the cycle that the condition is about.
    """

    kinds: tuple[str, ...] = ()
    by_kind: ClassVar[dict[str, type["Condition"]]] = {}

    def __init_subclass__(cls) -> None:
        cls.by_kind.update(dict.fromkeys(cls.kinds, cls))

    def __init__(self, kind: str, event: int | None = None) -> None:
        self.kind, self.event = kind, event

    @classmethod
    def serves(cls, kind: str, rigid: bool) -> bool:
        """Whether points of a kind are followed, with rigid bodies or with compliant ones."""
        return True

    @classmethod
    def begun(cls, kind: str, plane: Plane, place: Place) -> Iterator[tuple["Condition", Orbit]]:
        """Conditions that may be meant at the orbit of a point, with guesses of the orbit, the likeliest first."""
        yield cls(kind), place.orbit

    def value(self, equations: "Equations", place: Place) -> float:
        """What is zero."""
        raise NotImplementedError

    def gradient(self, equations: "Equations", place: Place) -> np.ndarray:
        """Its derivative in scaled X, (n + 2,)."""
        return equations.gradient(partial(self.value, equations), place)

    def is_own(self, margin: Margin, place: Place) -> bool:
        """Whether a margin is zero all along the curve, and so does not end it."""
        return False

    def turned(self, turn: int, events: int) -> "Condition":
        """The same with the events of the cycle counted from another one."""
        return type(self)(self.kind, None if self.event is None else (self.event + turn) % events)

    def renewed(self) -> None:
        """Choose what is arbitrary in it anew, at the next place."""
