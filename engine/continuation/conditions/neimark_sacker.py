"""Neimark–Sacker points: a pair of multipliers lies on the unit circle."""

from ..margins import NEIMARK_SACKER, indicator
from ..plane import Place
from .condition import Condition


class NeimarkSacker(Condition):
    """The indicator of a branch is zero."""

    kinds = (NEIMARK_SACKER,)

    def value(self, _, place: Place) -> float:
        """The indicator."""
        return indicator(self.kind, place)
