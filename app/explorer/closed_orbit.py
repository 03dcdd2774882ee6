"""A periodic motion that is known by a state on it, as one cycle: also an unstable one, which no long run stays on."""

from __future__ import annotations

from typing import NamedTuple

from vibroscope.app.explorer.compute import Run
from vibroscope.app.explorer.present import Columns, orbit_columns
from vibroscope.app.explorer.state import Setting
from vibroscope.engine import ExactPenalty, Record, Reference, System, simulate

_SAMPLES = 1000  # per period


class ClosedOrbit(NamedTuple):
    """A state at τ = 0 on a motion that repeats after ``period`` excitation periods."""

    system: System
    eta: float
    method: Reference | ExactPenalty
    start: tuple[float, float, float, float]
    period: int

    def columns(self, setting: Setting) -> Columns:
        """One cycle in the phase plots, in the units of a setting."""
        periods = {"periods": self.period, "keep": self.period, "record": Record(self.period, _SAMPLES)}
        response = simulate(self.system, self.eta, self.method, initial=self.start, **periods)
        return orbit_columns(Run(response, None, None, response.trajectory), setting)
