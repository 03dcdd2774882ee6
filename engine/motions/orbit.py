"""Search for the periodic orbit that a run converges to, by Newton's method on the Poincaré map.

From the end of the run, Newton's method solves P(y*) = y* for the map P over p periods. It also finds unstable orbits,
and orbits that the run does not approach. So an orbit y* is accepted only if the run is seen to converge to it: let DP
be the Jacobian at y* and |·| a norm in which DP shrinks every vector at least by a factor ψ < 1. A state y whose image
differs from the linear prediction by at most

    |P(y) − y* − DP (y − y*)| ≤ ½ (1 − ψ) |y − y*|                                               (47)

has an image that is closer to y* than y itself, by the factor ½ (1 + ψ) at least. The left-hand side is of second order
in y − y* as long as the events occur in the same sequence, so that from there on the condition keeps holding. The
sequence and the condition are checked cycle by cycle until the distance has fallen to a thirtieth. (An orbit with a
basin of attraction smaller than that would be accepted wrongly.)
"""

from typing import NamedTuple

import numpy as np

from .floquet import eigenvalues_by_modulus, fate_of_disturbances, is_stable
from .poincare_map import PoincareMap, Return
from .tolerances import (
    APPROACHED,
    LONGEST_NEWTON_STEP,
    NEAR_RETURN,
    NEARER_RETURN,
    ON_ORBIT,
    RESIDUAL,
    SMALLEST_FRACTION,
)

MOST_NEWTON_STEPS = 30


class FixedPoint(NamedTuple):
    """A fixed point of the Poincaré map over ``period`` periods."""

    period: int
    state: np.ndarray  # ξ₁, ξ₁′, g, g′
    returned: Return  # of the state, over the whole cycle
    iterations: int


class OrbitSearch:
    """Search for the orbit that a run converges to.

    Parameters
    ----------
    poincare : PoincareMap
    max_period : int
        Longest cycle to look for, in excitation periods.
    stable_only : bool
        Accept only an orbit that the run converges to; otherwise the first one that Newton's method finds.

    Attributes
    ----------
    run_periods : int
        Excitation periods of the run so far, set by the caller.
    rejection : str
        Why the last attempt accepted no orbit; empty if no orbit was near.
    """

    def __init__(self, poincare: PoincareMap, max_period: int, stable_only: bool):
        self.map = poincare
        self.max_period = max_period
        self.stable_only = stable_only
        self.run_periods = 0
        self.rejection = ""

    @property
    def all_periods(self) -> int:
        """Excitation periods integrated in all: those of the run and those of the map."""
        return self.run_periods + self.map.periods

    def attempt(self, section: np.ndarray, periods: int) -> FixedPoint | None:
        """Search from the end of a run.

        Parameters
        ----------
        section : (n, 4) ndarray
            Last rows of the run's Poincaré section.
        periods : int
            Excitation periods of the run, up to the last row.

        Returns
        -------
        FixedPoint or None
            Its state belongs to τ ≡ 0 mod pT, τ counted from the start of the run.
        """
        rows = self.map.coordinates(section)
        size = max(np.abs(section).max(), 1e-300)
        self.rejection = ""
        for period in near_returns(rows, size, self.max_period, NEAR_RETURN):
            orbit = fixed_point(self.map, rows[-1], period, size)
            if orbit is None:
                self.rejection = f"Newton's method finds no orbit of period {period} near the end of the run"
            elif self._accepts(orbit, rows[-1], size):
                return self._moved_to_cycle_start(self._with_least_period(orbit, size), periods)
        return None

    def _accepts(self, orbit: FixedPoint, y: np.ndarray, size: float) -> bool:
        """Whether the orbit is stable and the run, which ended at y, converges to it (see the module)."""
        if not self.stable_only:
            return True
        values = eigenvalues_by_modulus(orbit.returned.jacobian)
        largest = abs(values[0])
        if not is_stable(values):
            self.rejection = (
                f"the orbit of period {orbit.period} near the end of the run is not stable: disturbances "
                f"{fate_of_disturbances(values)}, {largest:.4g}-fold in each cycle"
            )
            return False
        if not self._converges(orbit, y - orbit.state, (1 + largest) / 2, size):
            self.rejection = f"the run has not settled to the orbit of period {orbit.period} that lies near"
            return False
        return True

    def _converges(self, orbit: FixedPoint, deviation: np.ndarray, rate: float, size: float) -> bool:
        """Follow a deviation from the orbit until it has died away; False if it stops obeying the condition.

        Parameters
        ----------
        rate : float
            ψ, above the largest modulus of the eigenvalues of DP.
        """
        factor = norm_factor(orbit.returned.jacobian / rate)
        first = np.linalg.norm(factor @ deviation)
        while np.abs(deviation).max() > ON_ORBIT * size and np.linalg.norm(factor @ deviation) > APPROACHED * first:
            returned = self.map(orbit.state + deviation, orbit.period)
            if not contracts(orbit, factor, rate, deviation, returned):
                return False
            deviation = returned.state - orbit.state
        return True

    def _with_least_period(self, orbit: FixedPoint, size: float) -> FixedPoint:
        """Return the same orbit with its least period: a cycle of p periods may consist of equal shorter ones."""
        for period in range(1, orbit.period):
            if orbit.period % period == 0:
                returned = self.map(orbit.state, period)
                # Near a bifurcation the point of several cycles is known less exactly than its residual says.
                if returned is not None and returned.residual <= ON_ORBIT * size:
                    once = fixed_point(self.map, orbit.state, period, size)
                    if once is not None:
                        return once._replace(iterations=orbit.iterations + once.iterations)
        return orbit

    def _moved_to_cycle_start(self, orbit: FixedPoint, periods: int) -> FixedPoint:
        """Return the orbit with its state at τ ≡ 0 mod pT instead of at the end of the run."""
        ahead = -periods % orbit.period
        if ahead == 0:
            return orbit
        state = self.map(orbit.state, ahead).state
        return orbit._replace(state=state, returned=self.map(state, orbit.period))


def fixed_point(poincare: PoincareMap, y: np.ndarray, period: int, size: float) -> FixedPoint | None:
    """Solve P(y*) = y* for the map over ``period`` periods by Newton's method from y on; None if it finds none.

    ``size``: of the motion, of which the residual may be RESIDUAL.
    """
    returned, steps = poincare(y, period), 0
    while returned is not None and steps < MOST_NEWTON_STEPS:
        improved = _newton_step(poincare, y, returned, period, size)
        if improved is None:  # limited by rounding, or there is no orbit nearby
            break
        y, returned = improved
        steps += 1
    found = returned is not None and returned.residual <= RESIDUAL * size
    return FixedPoint(period, y, returned, steps) if found else None


def _newton_step(poincare: PoincareMap, y: np.ndarray, returned: Return, period: int, size: float):
    """One step, halved until it reduces the residual: events may appear and disappear along the way."""
    if returned.residual == 0.0:
        return None
    try:
        full = np.linalg.solve(np.eye(4) - returned.jacobian, returned.state - y)
    except np.linalg.LinAlgError:
        return None
    fraction = 1.0
    while fraction >= SMALLEST_FRACTION:
        tried = y + fraction * full
        there = (
            _image(poincare, tried, period, returned.residual)
            if np.abs(tried).max() <= LONGEST_NEWTON_STEP * size
            else None
        )
        if there is not None and there.residual < returned.residual:
            return tried, there
        if returned.residual <= RESIDUAL * size:  # rounding prevents any further reduction
            return None
        fraction /= 2
    return None


def _image(poincare: PoincareMap, y: np.ndarray, period: int, residual: float) -> Return | None:
    """The return of y; where a Jacobian takes more runs, None unless y reduces the residual."""
    if poincare.by_differences and not poincare.residual(y, period) < residual:
        return None
    return poincare(y, period)


def contracts(
    orbit: FixedPoint, factor: np.ndarray, rate: float, deviation: np.ndarray, returned: Return | None
) -> bool:
    """Whether the condition of the module holds at a deviation from the orbit, the sequence of events included.

    Parameters
    ----------
    orbit : FixedPoint
    factor : (4, 4) ndarray
        Of the norm |factor · x|, in which DP shrinks every vector at least by ``rate``: :func:`norm_factor`.
    rate : float
        ψ.
    deviation : (4,) ndarray
    returned : Return or None
        Of the orbit's state with this deviation, over the whole cycle.
    """
    if returned is None or returned.course != orbit.returned.course:
        return False
    difference = returned.state - orbit.state - orbit.returned.jacobian @ deviation
    return bool(np.linalg.norm(factor @ difference) <= 0.5 * (1 - rate) * np.linalg.norm(factor @ deviation))


def near_returns(rows: np.ndarray, size: float, longest: int, within: float) -> list[int]:
    """Numbers of periods after which the last row nearly recurs, each much closer than all shorter ones.

    ``within``: the distance that counts as near, as a share of ``size``.
    """
    found, nearest = [], within * size
    for period in range(1, min(longest, len(rows) - 1) + 1):
        distance = np.abs(rows[-1] - rows[-1 - period]).max()
        if distance <= nearest:
            found.append(period)
            nearest = NEARER_RETURN * distance
    return found


def norm_factor(contraction: np.ndarray) -> np.ndarray:
    """Return F such that |F x| is a norm in which B, of spectral radius below 1, shrinks every vector x.

    FᵀF = Σ (Bᵏ)ᵀBᵏ over k = 0, 1, …, so that |F B x|² = |F x|² − |x|². The series is summed by doubling.
    """
    total, power = np.eye(4), contraction
    for _ in range(60):  # doublings of the partial sums
        total = total + power.T @ total @ power
        power = power @ power
        if np.abs(power).max() < 1e-18:
            break
    return np.linalg.cholesky(total).T
