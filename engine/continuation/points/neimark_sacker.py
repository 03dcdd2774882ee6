"""Neimark–Sacker points: a pair of multipliers lies on the unit circle."""

from ..kinds import NEIMARK_SACKER, indicator
from ..plane import Place
from .problem import PointProblem


class NeimarkSacker(PointProblem):
    """The indicator of a branch is zero."""

    kinds = (NEIMARK_SACKER,)

    def condition(self, place: Place) -> float:
        """The indicator."""
        return indicator(self.kind, place)
