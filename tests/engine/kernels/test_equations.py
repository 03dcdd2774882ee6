"""The equations of motion in their three forms agree, and contact laws are what their formulas say."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from vibroscope.engine import ExactPenalty, Newmark, Record, Reference, System, simulate
from vibroscope.engine.drivers.event_driven import contact_state
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.equations.contact_law import contact_rate, force, joint_force
from vibroscope.engine.kernels.equations.motion import (
    accelerations,
    coefficients,
    free_equilibrium,
    joined_equilibrium,
    joined_generator,
    pressed_equilibrium,
    pressed_generator,
    separated_generator,
)
from vibroscope.engine.kernels.event_driven.setup import other_force_factors

from tests import naive
from tests.systems_strategy import general_systems

numbers = st.floats(-10, 10)


def textbook(system, eta, x1, v1, x2, v2, acting, angle):
    """ξ₁″ and ξ₂″ of Eqs. (1) and (2), written out; of a wall ξ₂″ = 0."""
    (one, constant1), (two, constant2) = naive.drive(system, eta)
    c, s = math.cos(angle), math.sin(angle)
    a1 = one[0] * c + one[1] * s + constant1 - 2 * system.d1 * v1 - x1 - acting
    a2 = two[0] * c + two[1] * s + constant2 - 2 * system.d2 * system.kappa * v2 - system.kappa**2 * x2
    return a1, 0.0 if system.wall else a2 + acting / system.mass_ratio


@given(general_systems, numbers, numbers, numbers, numbers, st.floats(0, 6))
def test_generators_are_the_equations_of_motion(system, x1, v1, x2, v2, angle):
    eta, turn = 1.3, (math.cos(angle), math.sin(angle))
    p = parameters_of(system, eta, ExactPenalty(300.0, 7.0))
    x2, v2 = (0.0, 0.0) if system.wall else (x2, v2)
    y = contact_state(system, (x1, v1, x2, v2))
    push = force(300.0, 7.0, y[2], y[3])
    sides = (
        (separated_generator(p), free_equilibrium(p), 0.0),
        (pressed_generator(p), pressed_equilibrium(p), push),
    )
    for generator, (position, gap), acting in sides:
        a1, a2 = textbook(system, eta, x1, v1, x2, v2, acting, angle)
        derivative = generator @ (y[0] - position, y[1], y[2] - gap, y[3], *turn, 1.0)
        expected = (0.0, 0.0, -v1, -a1) if system.wall else (v1, a1, v2 - v1, a2 - a1)
        np.testing.assert_allclose(derivative, expected, rtol=1e-10, atol=1e-8)
        if system.wall:
            continue
        rest = system.separate_rest
        found = accelerations(coefficients(p), x1 - rest[0], v1, x2 - rest[1], v2, acting, *turn)
        np.testing.assert_allclose(found, (a1, a2), rtol=1e-10, atol=1e-8)


@given(general_systems, numbers, numbers, st.floats(0, 6))
def test_joined_bodies_move_as_the_free_ones_under_the_joint_force(system, x, v, angle):
    """With the joint damping that the two dampers add up to."""
    eta, turn = 1.3, (math.cos(angle), math.sin(angle))
    x, v = (system.clearance, 0.0) if system.wall else (x, v)
    p = parameters_of(system, eta, Reference("derived"))
    position, velocity = joint_force(p)
    y = contact_state(system, (x, v, 0.0 if system.wall else x - system.clearance, v))
    cosine, sine, constant = other_force_factors(p, True)
    push = position * y[0] + velocity * y[1] + constant + cosine * turn[0] + sine * turn[1]
    a1, a2 = textbook(system, eta, x, v, x - system.clearance, v, push, angle)
    if system.wall:
        np.testing.assert_allclose(a1, 0.0, atol=1e-9)
        return
    at, gap = joined_equilibrium(p)
    joined = joined_generator(p) @ (y[0] - at, y[1], y[2] - gap, 0.0, *turn, 1.0)
    np.testing.assert_allclose((a1, a2), joined[1], rtol=1e-10, atol=1e-8)


@pytest.mark.parametrize(("stiffness", "damping"), [(12000.0, 18.0), (100.0, 50.0), (1.0, 0.0)])
def test_the_contact_rate_is_the_fastest_eigenvalue_of_the_contact_mode(stiffness, damping):
    inverse_mass = 1 + 1 / System().mass_ratio
    roots = np.roots([1.0, 2 * damping * inverse_mass, stiffness * inverse_mass])
    assert contact_rate(stiffness, damping, inverse_mass) == pytest.approx(np.abs(roots).max(), rel=1e-14)


CUT = [(1.08, 2500.0, 8.0, 500), (2.76, 12000.0, 100.0, 2000), (1.08, 100.0, 50.0, 300)]


@pytest.mark.parametrize(("eta", "stiffness", "damping", "n"), CUT)
def test_the_law_that_is_cut_never_pulls(eta, stiffness, damping, n):
    how = {"periods": 6, "keep": 6, "record": Record(6, n)}
    cut, whole = (
        simulate(System(), eta, Newmark(stiffness, damping, n, law=law), **how) for law in ("cut", "kelvin-voigt")
    )
    assert cut.trajectory.force.min() == 0.0
    assert whole.trajectory.force.min() < 0.0
    x, v = cut.trajectory.displacement, cut.trajectory.velocity
    linear = stiffness * (x[0] - x[1]) + 2 * damping * (v[0] - v[1])
    expected = np.where(x[1] - x[0] <= 0, np.maximum(linear, 0.0), 0.0)
    np.testing.assert_allclose(cut.trajectory.force, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("eta", "stiffness", "damping", "n"), CUT)
def test_every_step_with_the_law_that_is_cut_is_that_of_the_textbook(eta, stiffness, damping, n):
    periods = 3  # many bounces in a period amplify rounding
    method = Newmark(stiffness, damping, n, law="cut")
    response = simulate(System(), eta, method, periods=periods, keep=periods, record=Record(periods, n))
    states, _ = naive.newmark(System(), eta, stiffness, damping, n, periods * n, cut=True)
    np.testing.assert_allclose(response.trajectory.displacement.T, states[:, [0, 2]], atol=1e-8)
