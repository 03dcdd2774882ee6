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
from vibroscope.engine.motions.floquet import eigenvalues_by_modulus, fate_of_disturbances, is_stable
from vibroscope.engine.motions.poincare_map import PoincareMap, Return
from vibroscope.engine.motions.tolerances import (
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


def approached_orbit(
    poincare: PoincareMap, section: np.ndarray, periods: int, max_period: int, stable_only: bool
) -> FixedPoint | str:
    """The orbit that a run converges to, from its end.

    Parameters
    ----------
    poincare : PoincareMap
    section : (n, 4) ndarray
        Last rows of the run's Poincaré section.
    periods : int
        Excitation periods of the run, up to the last row.
    max_period : int
        Longest cycle to look for, in excitation periods.
    stable_only : bool
        Accept only an orbit that the run converges to; otherwise the first one that Newton's method finds.

    Returns
    -------
    FixedPoint or str
        Its state belongs to τ ≡ 0 mod pT, τ counted from the start of the run. If no orbit is accepted, why not the
        last one; empty if none was near.
    """
    rows, size, rejection = poincare.coordinates(section), max(np.abs(section).max(), 1e-300), ""
    for period in near_returns(rows, size, max_period, NEAR_RETURN):
        orbit = fixed_point(poincare, rows[-1], period, size)
        if orbit is None:
            rejection = f"Newton's method finds no orbit of period {period} near the end of the run"
            continue
        rejection = _why_not(poincare, orbit, rows[-1], size) if stable_only else ""
        if not rejection:
            return _moved_to_cycle_start(poincare, _with_least_period(poincare, orbit, size), periods)
    return rejection


def _why_not(poincare: PoincareMap, orbit: FixedPoint, y: np.ndarray, size: float) -> str:
    """Why a run that ended at y is not seen to converge to an orbit; empty if it is, and that is stable."""
    norm = contraction(orbit)
    if norm is None:
        values = eigenvalues_by_modulus(orbit.returned.jacobian)
        return (
            f"the orbit of period {orbit.period} near the end of the run is not stable: disturbances "
            f"{fate_of_disturbances(values)}, {abs(values[0]):.4g}-fold in each cycle"
        )
    if not _converges(poincare, orbit, norm, y - orbit.state, size):
        return f"the run has not settled to the orbit of period {orbit.period} that lies near"
    return ""


def _converges(
    poincare: PoincareMap, orbit: FixedPoint, norm: "Contraction", deviation: np.ndarray, size: float
) -> bool:
    """Follow a deviation from the orbit until it has died away; False if it stops obeying the condition."""
    first = np.linalg.norm(norm.factor @ deviation)
    while np.abs(deviation).max() > ON_ORBIT * size and np.linalg.norm(norm.factor @ deviation) > APPROACHED * first:
        returned = poincare(orbit.state + deviation, orbit.period)
        if not norm.contracts(orbit, deviation, returned):
            return False
        deviation = returned.state - orbit.state
    return True


def _with_least_period(poincare: PoincareMap, orbit: FixedPoint, size: float) -> FixedPoint:
    """The same orbit with its least period: a cycle of p periods may consist of equal shorter ones."""
    for period in range(1, orbit.period):
        if orbit.period % period == 0:
            returned = poincare(orbit.state, period)
            # Near a bifurcation the point of several cycles is known less exactly than its residual says.
            if returned is not None and returned.residual <= ON_ORBIT * size:
                once = fixed_point(poincare, orbit.state, period, size)
                if once is not None:
                    return once._replace(iterations=orbit.iterations + once.iterations)
    return orbit


def _moved_to_cycle_start(poincare: PoincareMap, orbit: FixedPoint, periods: int) -> FixedPoint:
    """The orbit with its state at τ ≡ 0 mod pT instead of at the end of a run of so many periods."""
    ahead = -periods % orbit.period
    if ahead == 0:
        return orbit
    state = poincare(orbit.state, ahead).state
    return orbit._replace(state=state, returned=poincare(state, orbit.period))


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


class Contraction(NamedTuple):
    """A norm in which DP of an orbit shrinks every vector: |factor · x|, by ``rate`` = ψ at least."""

    rate: float
    factor: np.ndarray  # (4, 4)

    def contracts(self, orbit: FixedPoint, deviation: np.ndarray, returned: Return | None) -> bool:
        """Whether the condition of the module holds at a deviation from the orbit, the sequence of events included.

        ``returned``: of the orbit's state with this deviation, over the whole cycle.
        """
        if returned is None or returned.course != orbit.returned.course:
            return False
        difference = self.factor @ (returned.state - orbit.state - orbit.returned.jacobian @ deviation)
        return bool(np.linalg.norm(difference) <= 0.5 * (1 - self.rate) * np.linalg.norm(self.factor @ deviation))


def contraction(orbit: FixedPoint) -> Contraction | None:
    """The norm with ψ halfway between the largest multiplier and 1; None if the orbit is not stable."""
    values = eigenvalues_by_modulus(orbit.returned.jacobian)
    if not is_stable(values):
        return None
    rate = (1 + abs(values[0])) / 2
    return Contraction(rate, norm_factor(orbit.returned.jacobian / rate))


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
