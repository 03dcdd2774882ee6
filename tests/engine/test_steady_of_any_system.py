"""Steady motion, multipliers and exponents of walls, preload, forces and weights, against `simulate` alone."""

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Excitation, Reference, System, lyapunov, motion, simulate, steady

WIDTH = 1e-5  # of a central difference: its error is of the order of its square
LIGHT = {"d1": 0.05, "d2": 0.05, "d3": None, "restitution": 0.6}
OWN_FORCES = Excitation(base=0, force1=1.5, force2=-1.0, force2_phase=0.7, constant2=-0.3)
AT_A_WALL = Excitation(base=0, force1=2.0, force1_phase=0.4, constant1=0.2)
SYSTEMS = {
    "wall": (System(wall=True, clearance=0.5, d1=0.07, restitution=0.8), 2.0),
    "wall, preload": (System(wall=True, clearance=-0.5, d1=0.07, restitution=0.6), 2.0),
    "wall, preload, force, weight": (System(wall=True, clearance=-0.3, d1=0.05, excitation=AT_A_WALL), 2.3),
    "clearance": (System(clearance=1.0, **LIGHT), 2.0),
    "preload": (System(clearance=-0.5, **LIGHT), 2.76),
    "forces on both, weight": (System(mu=0.5, kappa=1.6, clearance=0.4, excitation=OWN_FORCES, **LIGHT), 1.3),
    "preload, chatter, sticking": (System(clearance=-2.0, **LIGHT), 1.2),
}
CASES = [
    pytest.param(*SYSTEMS[name], method, id=f"{name}, {method.name}")
    for name in SYSTEMS
    for method in (Reference(), ExactPenalty(3000, 9))
]
every_case = pytest.mark.parametrize(("system", "eta", "method"), CASES)


def directions(system, found):
    """Of a state ξ₁, ξ₁′, ξ₂, ξ₂′, those in which it can be disturbed: a wall stands, joined bodies move together."""
    if system.wall:
        return np.eye(4)[:2]
    joined = system.gap(found.state[0], found.state[2]) == 0
    return np.array([[1.0, 0, 1, 0], [0, 1.0, 0, 1]]) if joined else np.eye(4)


def measured_jacobian(system, eta, method, found):
    """Derivative of the state after one cycle by that at its beginning, by differences of runs."""
    moved = directions(system, found)
    ends = [
        [
            simulate(
                system, eta, method, periods=found.period, keep=1, initial=found.state + sign * WIDTH * way
            ).section
            for sign in (1, -1)
        ]
        for way in moved
    ]
    columns = [(ahead[-1] - back[-1]) / (2 * WIDTH) for ahead, back in ends]
    return np.transpose(columns)[: len(moved)]


@every_case
def test_the_multipliers_are_those_of_the_poincare_map_of_simulate(system, eta, method):
    """Their elementary symmetric functions are compared: a double multiplier has half of the digits."""
    found = steady(system, eta, method)
    assert (found.periodic, found.stable) == (True, True)
    measured = measured_jacobian(system, eta, method, found)
    count = len(measured)
    np.testing.assert_allclose(np.poly(found.multipliers[:count]), np.poly(measured), rtol=0, atol=1e-7)
    assert np.abs(found.multipliers[count:]).max(initial=0) == 0
    assert np.abs(found.multipliers[0]) > 0.3  # and so there is something to compare


@every_case
def test_the_steady_motion_is_that_of_a_long_run(system, eta, method):
    found, long = steady(system, eta, method), simulate(system, eta, method, periods=600, keep=24)
    np.testing.assert_allclose(found.state, long.section[-1], atol=1e-10 * max(1.0, np.abs(long.section).max()))
    described = motion(long)
    assert described.period == found.period
    assert len(found.response.impacts) == described.impacts_per_period * found.period
    assert found.response.impacts.time.size > 0


@every_case
def test_the_exponent_is_the_logarithm_of_the_largest_multiplier(system, eta, method):
    cycle = steady(system, eta, method)
    found = lyapunov(system, eta, method, initial=cycle.state, periods=2048)
    assert found.exponent == pytest.approx(np.log(np.abs(cycle.multipliers).max()) / cycle.period, abs=1e-3)
    assert found.regular
