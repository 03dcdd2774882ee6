"""A periodic motion that is known by a state on it, as one cycle: also an unstable one, which no long run stays on."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.compute import SolverRun
from vibroscope.app.explorer.present import Columns, orbit_columns
from vibroscope.app.explorer.state import Setting
from vibroscope.engine import ExactPenalty, Record, Reference, System, simulate
from vibroscope.engine.motions.poincare_map import multipliers

_SAMPLES = 1000  # per period
_CLOSED = 1e-3  # of its largest number: how closely a cycle returns to a start that was printed and read again
SOLVERS = {"reference_orbit": "reference", "penalty_orbit": "exact penalty"}  # by the name of the period in a link
LONGEST = 64  # periods of a cycle in a link
FARTHEST = 1e6  # ξ₁ in a link


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
        return orbit_columns(SolverRun(response, None, None, response.trajectory), setting)

    @property
    def _name(self) -> str:
        return "reference_orbit" if self.method.rigid else "penalty_orbit"

    @property
    def solver(self) -> str:
        """The solver whose motion it is, in words."""
        return SOLVERS[self._name]

    def linked(self, setting: Setting) -> dict[str, float]:
        """Numbers for a link from which `linked_orbit` has the motion again, beside a setting with its start.

        ξ₁ is among them where the start that is set is not on the motion, since the bodies overlap in it.
        """
        moved = {"orbit_xi1": float(self.start[0])} if self.start[0] != setting.initial[0] else {}
        return {self._name: self.period} | moved

    def returns(self) -> bool:
        """Whether the cycle does return to its start."""
        run = simulate(self.system, self.eta, self.method, initial=self.start, periods=self.period, keep=1)
        return run.ok and np.abs(run.section[-1] - self.start).max() < _CLOSED * max(np.abs(self.start).max(), 1e-9)

    def largest_multiplier(self) -> complex | None:
        """The largest Floquet multiplier, by the derivative of the cycle from its start; None if it has none."""
        try:
            found = multipliers(self.system, self.eta, self.method, np.array(self.start), self.period)
        except np.linalg.LinAlgError:  # at a grazing impact the derivative is infinite
            return complex(np.inf)
        return complex(found[0]) if len(found) else None


def linked_orbit(choice: Mapping[str, float], setting: Setting) -> ClosedOrbit | None:
    """The motion that a link names beside its setting; None if it names none, or there is no such motion."""
    name = next((name for name in SOLVERS if name in choice), None)
    if name is None:
        return None
    start = np.array(setting.initial, dtype=float)
    start[0] = choice.get("orbit_xi1", start[0])
    try:  # a law may have no solution without a time step, and a start may be none of this system
        method = setting.reference if name == "reference_orbit" else setting.penalty.limit
        orbit = ClosedOrbit(setting.system, setting.eta, method, start, int(choice[name]))
        return orbit if orbit.returns() else None
    except ValueError:
        return None
