"""The orbit that a run is caught by: Newton's method on the Poincaré map from the end of the run, and proof that it is.

Newton's method finds unstable orbits as well, and orbits that the transient does not lead to. So an orbit z is taken
only if the run is caught by it: in a norm in which DP shrinks every vector, to γ < 1 of it at most, the return of the
last state y differs so little from what the Jacobian foretells,

    |P(y) − z − DP (y − z)| ≤ ½ (1 − γ) |y − z|,

that it comes closer to z. The difference is of second order in y − z as long as events come in the same sequence, so
that this holds from there on. Both are checked, cycle by cycle, until a thirtieth of y − z is left. (An orbit whose
basin ends still closer would deceive it.)
"""

from typing import NamedTuple

import numpy as np

from .poincare_map import PoincareMap, Return, coordinates

NEAR = 0.3  # of the section's size: a return within this is worth an attempt …
NEARER = 0.5  # … if it is so much nearer than all earlier ones
STEPS = 30  # of Newton's method
SMALLEST_STEP = 2.0**-10
FARTHEST = 1e3  # sizes of the section that a step may lead away
RESIDUAL = 1e-12  # of the section's size
FOLLOWED = 0.03  # the run is followed until it is so much nearer to the orbit
CAUGHT = 1e-10  # so near to the orbit, a state is on it but for rounding
GROWTH_TERMS = 60  # doublings of the sum that makes up the norm


class Orbit(NamedTuple):
    """A fixed point of the map over ``period`` periods."""

    period: int
    state: np.ndarray
    back: Return
    iterations: int


class OrbitSearch:
    """Looks for the orbit that the end of a run is caught by.

    Parameters
    ----------
    poincare : PoincareMap
    max_period : int
        Longest cycle to look for, in excitation periods.
    stable_only : bool
        Take only an orbit that the run is caught by; otherwise the first that Newton's method comes to.
    """

    def __init__(self, poincare: PoincareMap, max_period: int, stable_only: bool):
        self.map = poincare
        self.max_period = max_period
        self.stable_only = stable_only
        self.periods = 0  # of the runs
        self.rejected = ""  # why the last orbit was

    @property
    def all_periods(self) -> int:
        """Periods of the runs and of the maps."""
        return self.periods + self.map.periods

    def attempt(self, section: np.ndarray, reached: int) -> Orbit | None:
        """From the last rows of the section of the run, which has come so many periods from its start."""
        rows = coordinates(section)
        size = max(np.abs(section).max(), 1e-300)
        self.rejected = ""
        for p in _near_returns(rows, size, self.max_period):
            orbit = self._newton(rows[-1], p, size)
            if orbit is not None and self._taken(orbit, rows[-1], size):
                return self._in_step(self._shortest(orbit, size), reached)
        return None

    def _newton(self, y: np.ndarray, p: int, size: float) -> Orbit | None:
        back, steps = self.map(y, p), 0
        while back is not None and steps < STEPS:
            further = self._step(y, back, p, size)
            if further is None:  # rounding, or no orbit near
                break
            y, back = further
            steps += 1
        if back is None or back.miss > RESIDUAL * size:
            self.rejected = f"Newton's method finds no orbit of period {p} near the end of the run"
            return None
        return Orbit(p, y, back, steps)

    def _step(self, y, back, p, size):
        """One step, shortened until it brings y nearer to its return: events may come and go on the way."""
        if back.miss == 0.0:
            return None
        try:
            full = np.linalg.solve(np.eye(4) - back.jacobian, back.state - y)
        except np.linalg.LinAlgError:
            return None
        share = 1.0
        while share >= SMALLEST_STEP:
            tried = y + share * full
            there = self.map(tried, p) if np.abs(tried).max() <= FARTHEST * size else None
            if there is not None and there.miss < back.miss:
                return tried, there
            if back.miss <= RESIDUAL * size:  # as near as rounding lets it
                return None
            share /= 2
        return None

    def _taken(self, orbit: Orbit, y: np.ndarray, size: float) -> bool:
        """Whether the run that ended at y goes on to the orbit."""
        if not self.stable_only:
            return True
        jacobian = orbit.back.jacobian
        largest = np.abs(np.linalg.eigvals(jacobian)).max()
        if not largest < 1 - 1e-9:
            self.rejected = f"the orbit of period {orbit.period} near the end of the run is unstable: it grows "
            self.rejected += f"{largest:.4g}-fold in each cycle"
            return False
        shrinks = (1 + largest) / 2
        factor = _norm(jacobian / shrinks)
        away, farthest = y - orbit.state, np.linalg.norm(factor @ (y - orbit.state))
        while np.abs(away).max() > CAUGHT * size and np.linalg.norm(factor @ away) > FOLLOWED * farthest:
            back = self.map(orbit.state + away, orbit.period)
            foretold, here = jacobian @ away, np.linalg.norm(factor @ away)
            if back is None or back.course != orbit.back.course:
                break
            away = back.state - orbit.state
            if np.linalg.norm(factor @ (away - foretold)) > 0.5 * (1 - shrinks) * here:
                break
        else:
            return True
        self.rejected = f"the run has not settled to the orbit of period {orbit.period} that lies near"
        return False

    def _shortest(self, orbit: Orbit, size: float) -> Orbit:
        """The same with the least number of periods: two equal cycles are one."""
        for p in range(1, orbit.period):
            if orbit.period % p == 0:
                back = self.map(orbit.state, p)
                if back is not None and back.miss <= RESIDUAL * size:
                    once = self._newton(orbit.state, p, size)  # what is left after two cycles may be more after one
                    return once._replace(iterations=orbit.iterations + once.iterations)
        return orbit

    def _in_step(self, orbit: Orbit, reached: int) -> Orbit:
        """The same, its state not that at the end of the run but at τ ≡ 0 mod pT."""
        ahead = -reached % orbit.period
        if ahead == 0:
            return orbit
        state = self.map(orbit.state, ahead).state
        return orbit._replace(state=state, back=self.map(state, orbit.period))


def _near_returns(rows: np.ndarray, size: float, longest: int) -> list[int]:
    """Numbers of periods after which the last row nearly recurs, each much nearer than all before."""
    found, nearest = [], NEAR * size
    for p in range(1, min(longest, len(rows) - 1) + 1):
        distance = np.abs(rows[-1] - rows[-1 - p]).max()
        if distance <= nearest:
            found.append(p)
            nearest = NEARER * distance
    return found


def _norm(shrinking: np.ndarray) -> np.ndarray:
    """F, so that |F x| is a norm in which x shrinks: FᵀF = Σ (Bᵏ)ᵀBᵏ, B the matrix; summed by doubling."""
    total, power = np.eye(4), shrinking
    for _ in range(GROWTH_TERMS):
        total = total + power.T @ total @ power
        power = power @ power
        if np.abs(power).max() < 1e-18:
            break
    return np.linalg.cholesky(total).T
