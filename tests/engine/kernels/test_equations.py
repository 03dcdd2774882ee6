"""The equations of motion in their three forms agree, and contact laws are what their formulas say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from vibroscope.engine import ExactPenalty, Newmark, Record, Reference, System, compare, motion, simulate
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.equations.contact_law import contact_rate, force, joint_force
from vibroscope.engine.kernels.equations.motion import (
    accelerations,
    coefficients,
    joined_generator,
    pressed_generator,
    separated_generator,
)

from tests import naive

numbers = st.floats(-10, 10)


@given(numbers, numbers, numbers, numbers, st.floats(-1, 1))
def test_generators_are_the_equations_of_motion(x1, v1, x2, v2, cosine):
    system, eta = System(), 1.3
    p = parameters_of(system, eta, ExactPenalty(300.0, 7.0))
    push = force(300.0, 7.0, x2 - x1, v2 - v1)
    for generator, acting in ((separated_generator(p), 0.0), (pressed_generator(p), push)):
        a1, a2 = accelerations(coefficients(p), x1, v1, x2, v2, acting, cosine)
        derivative = generator @ (x1, v1, x2 - x1, v2 - v1, cosine, 0.0)
        np.testing.assert_allclose(derivative, (v1, a1, v2 - v1, a2 - a1), rtol=1e-11, atol=1e-9)


@given(numbers, numbers, st.floats(-1, 1))
def test_joined_bodies_move_as_the_free_ones_under_the_joint_force(x, v, cosine):
    """With the joint damping that the two dampers add up to."""
    system, eta = System(), 1.3
    p = parameters_of(system, eta, Reference("derived"))
    position, velocity = joint_force(p)
    a1, a2 = accelerations(coefficients(p), x, v, x, v, position * x + velocity * v, cosine)
    joined = joined_generator(eta, p.kappa3, p.d3) @ (x, v, 0.0, 0.0, cosine, 0.0)
    np.testing.assert_allclose((a1, a2), joined[1], rtol=1e-12, atol=1e-10)


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


def test_a_law_that_does_not_exist_is_refused():
    with pytest.raises(ValueError, match="law = 'glue' is not one of kelvin-voigt, cut"):
        Newmark(1.0, 1.0, 100, law="glue")


def test_the_law_that_is_cut_is_refused_where_it_is_not_available():
    with pytest.raises(ValueError, match="law = 'cut' has no located steps"):
        Newmark(1.0, 1.0, 100, located=True, law="cut")
    for study in (compare, motion):
        with pytest.raises(ValueError, match="law = 'cut' is not solved in closed form"):
            study(System(), 2.76, Newmark(12000.0, 18.0, 200, law="cut"))
