"""Trapping regions of stable cycles: ellipsoids of the Poincaré section from which every motion comes to the cycle.

Let P be the map over so many turns of a cycle that disturbances fall to a half, y* a point of the cycle and |F·| a norm
in which DP shrinks every vector at least by ψ < 1 (:mod:`.steady`). The ball |F (y − y*)| ≤ r is trapping if each y in
it satisfies

    |F (P(y) − y* − DP (y − y*))| ≤ ½ (1 − ψ) |F (y − y*)|                                       (48)

with the cycle's own sequence of events: P(y) then lies in the ball of ½ (1 + ψ) r, and the motion comes to the cycle.
The left-hand side grows with the square of the distance, and the sequence changes where the ball crosses a surface of
grazing. Both are examined in DIRECTIONS random directions at several distances up to r/SHARE. If such a surface is as
good as flat there and comes within r of y*, it cuts off a seventh of the directions at r/SHARE or more, and the chance
that none of them shows it is (6/7) to the power of DIRECTIONS, 3e-9. Over a single turn of a weakly stable cycle the
balls would be far smaller: of η = 3.2, period 2, by a factor of 30. The plain twin of what follows from a region is the
run itself (`tests/engine/test_basin_twin.py`).

Bodies that nothing drives lose energy to their dampers until they rest, and contact adds none. Their potential energy
is convex, so that there is one place to rest: where both have dampers, the region is the whole section. Of motions by
time steps this is not true: a step in which contact changes may create energy, and a free vibration grow without end.
"""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.arguments import Poll
from vibroscope.engine.drivers.event_driven import contact_state
from vibroscope.engine.methods import ExactPenalty, Reference
from vibroscope.engine.model import System
from vibroscope.engine.motions.poincare_map import PoincareMap
from vibroscope.engine.motions.steady import Contraction, FixedPoint, Steady, contraction
from vibroscope.engine.motions.tolerances import FALLEN, JOINED

DIRECTIONS = 128
DISTANCES = (1.0, 0.5)  # of the radius that is examined
SHARE = 0.6  # of the radius that is examined: the radius of the region
SMALLER, RADII = 0.75, 60  # each radius that is examined of the one before; how many, from the section's size on
MOST_REGIONS = 8  # of a cycle: a motion comes by all of its points in turn
MOST_TURNS = 64  # … if it falls so far within these


class Region(NamedTuple):
    """A trapping region: the states x = (ξ₁, ξ₁′, ξ₂, ξ₂′) with |factor (x − centre)| ≤ 1; all, where that is zero.

    Attributes
    ----------
    centre : (4,) ndarray
    factor : (4, 4) ndarray
    """

    centre: np.ndarray
    factor: np.ndarray


def trapping_regions(
    system: System,
    eta: float,
    method: Reference | ExactPenalty,
    found: Steady,
    cancelled: Poll | None = None,
) -> list[Region]:
    """A trapping region around each point of a stable cycle where there is one of more than rounding.

    Parameters
    ----------
    system : System
    eta : float
    method : Reference or ExactPenalty
    found : Steady
        Periodic, of the same system, η and method.
    cancelled : callable, optional
        Polled many times a second.

    Returns
    -------
    list of Region
        Around points of the cycle, MOST_REGIONS at most; empty if the cycle is not stable.

    Raises
    ------
    Cancelled
        If ``cancelled`` returned true.
    """
    poincare = PoincareMap(system, eta, method, cancelled)
    if (
        not system.excitation.drives
        and system.spring1
        and not system.has_free_body
        and all(d > 0 for d in _dampers(system, method))
    ):
        return [Region(poincare.displacements(poincare.coordinates(found.state)), np.zeros((4, 4)))]
    state, regions = poincare.coordinates(found.state), []
    to_map = _linear_part(system)
    size = np.abs(found.response.section).max()
    turns = _turns(np.abs(found.multipliers).max())
    apart = -(-found.period // MOST_REGIONS)  # periods from one of the points to the next
    for _ in range(0, found.period, apart):
        returned = poincare(state, turns * found.period)
        if returned is None:
            return regions
        orbit = FixedPoint(turns * found.period, state, returned, 0)
        factor = _factor_of_region(poincare, orbit, method.rigid, size)
        if factor is not None:
            regions.append(Region(poincare.displacements(state), factor @ to_map))
        state = poincare(state, apart).state
    return regions


def _dampers(system: System, method: Reference | ExactPenalty) -> tuple[float, ...]:
    """Every damper that a motion may have to come to rest by: of each body, and of both joined."""
    if system.wall:
        return (system.d1,)
    joined = (system.joint_damping(method.joint_damping),) if method.rigid else ()
    return (system.d1, system.d2, *joined)


def _turns(largest: float) -> int:
    """Turns of a cycle in which disturbances fall to FALLEN, by the largest modulus of its multipliers."""
    if not 0 < largest < 1:
        return 1
    return int(np.clip(np.ceil(np.log(FALLEN) / np.log(largest)), 1, MOST_TURNS))


def _linear_part(system: System) -> np.ndarray:
    """The matrix of the map's coordinates by displacements, (4, 4)."""
    origin = contact_state(system, np.zeros(4))
    return np.stack([contact_state(system, unit) - origin for unit in np.eye(4)], axis=1)


def _factor_of_region(poincare: PoincareMap, orbit: FixedPoint, rigid: bool, size: float) -> np.ndarray | None:
    """F/r around a point of a cycle; None if it is not stable, r is not above rounding, or a wall holds the body."""
    norm = contraction(orbit)
    if norm is None:
        return None
    factor = norm.factor
    joined = rigid and np.abs(orbit.state[2:]).max() <= JOINED * size  # whoever comes there has no gap, either
    free = np.array([True, True, not joined, not joined])
    if poincare.mechanics.wall:
        free[:2] = False
    if not free.any():
        return None
    units = _directions(factor, free)
    radius = size / np.abs(units).max()
    for _ in range(RADII):
        if all(
            _holds(poincare, orbit, norm, rigid, distance * radius * unit) for unit in units for distance in DISTANCES
        ):
            scaled = factor / (SHARE * radius)
            return scaled if not joined else _without_gap(factor[:, free], SHARE * radius, JOINED * size)
        radius *= SMALLER
    return None


def _directions(factor: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Deviations of norm 1, (DIRECTIONS, 4), in the coordinates that can deviate."""
    drawn = np.random.default_rng(0).standard_normal((DIRECTIONS, int(free.sum())))
    inverse = np.linalg.inv(np.linalg.qr(factor[:, free])[1])  # R of the columns that are free: |F x| = |R x|
    units = np.zeros((DIRECTIONS, 4))
    units[:, free] = (drawn / np.linalg.norm(drawn, axis=1, keepdims=True)) @ inverse.T
    return units


def _holds(poincare: PoincareMap, orbit: FixedPoint, norm: Contraction, rigid: bool, deviation: np.ndarray) -> bool:
    """Whether the condition holds at a deviation; a reference cannot deviate into penetration."""
    state = orbit.state + deviation
    if rigid:
        state[2] = max(state[2], 0.0)
    return norm.contracts(orbit, state - orbit.state, poincare(state, orbit.period))


def _without_gap(columns: np.ndarray, radius: float, nothing: float) -> np.ndarray:
    """F/r of bodies that move as one: the gap and its rate may be no more than ``nothing``."""
    triangle = np.linalg.qr(columns)[1]
    found = np.zeros((4, 4))
    found[:2, :2] = triangle / radius
    found[2, 2] = found[3, 3] = 1 / nothing
    return found
