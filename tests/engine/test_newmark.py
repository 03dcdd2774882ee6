"""Newmark's kernel against its textbook twin, and its end."""

import math

import numpy as np
import pytest
from vibroscope.engine import Newmark, Record, Status, System, simulate

from tests import naive

CASES = [(1.08, 2500.0, 8.0, 500), (2.76, 12000.0, 18.0, 2000), (1.08, 100.0, 50.0, 300), (3.25, 1000.0, 0.0, 700)]


@pytest.mark.parametrize(("eta", "stiffness", "damping", "n"), CASES)
def test_every_step_is_that_of_the_textbook(eta, stiffness, damping, n):
    periods = 6
    record = Record(periods, n)
    response = simulate(System(), eta, Newmark(stiffness, damping, n), periods=periods, keep=periods, record=record)
    states, contact = naive.newmark(System(), eta, stiffness, damping, n, periods * n)
    sampled = response.trajectory
    np.testing.assert_allclose(sampled.time, np.arange(periods * n + 1) * (2 * math.pi / eta / n), rtol=1e-14)
    np.testing.assert_allclose(sampled.displacement.T, states[:, [0, 2]], atol=1e-8)
    np.testing.assert_allclose(sampled.velocity.T, states[:, [1, 3]], atol=1e-7)
    np.testing.assert_allclose(response.section, states[n::n], atol=1e-7)
    changes = np.flatnonzero(np.diff(contact.astype(int))) + 1
    if contact[0]:
        changes = np.insert(changes, 0, 0)
    found = np.rint(response.contacts.ravel() / (2 * math.pi / eta / n)).astype(int)
    np.testing.assert_array_equal(found[: len(changes)], changes)


def test_force_is_that_of_the_spring_and_damper():
    response = simulate(System(), 1.08, Newmark(2500, 8, 400), periods=20, keep=2, record=Record(2, 400))
    x, v, force = response.trajectory.displacement, response.trajectory.velocity, response.trajectory.force
    touching = x[1] - x[0] <= 0
    expected = np.where(touching, 2500 * (x[0] - x[1]) + 2 * 8 * (v[0] - v[1]), 0)
    np.testing.assert_allclose(force, expected, rtol=1e-12, atol=1e-12)
    assert touching.any()
    assert not touching.all()


def test_impulse_is_the_change_of_momentum():
    """Over one short contact the springs of the pendulums hardly act: μ Δξ₂′ ≈ impulse ≈ −Δξ₁′."""
    system = System()
    response = simulate(system, 2.76, Newmark(1e5, 50, 32000), periods=300, keep=20)
    impacts = response.impacts
    gained = system.mass_ratio * (impacts.velocity_after[:, 1] - impacts.velocity_before[:, 1])
    np.testing.assert_allclose(impacts.impulse, gained, rtol=0.05)
    assert (impacts.closing_speed > 0).all()


def test_blow_up_names_the_step():
    response = simulate(System(), 2.76, Newmark(60000, 1, 100))
    assert response.status is Status.DIVERGED
    step = response.cost.steps
    assert f"step {step} " in response.message
    assert len(response.section) == 0
    assert np.isfinite(response.checkpoint.state).all()


def test_section_of_a_run_that_blows_up_holds_the_completed_periods():
    method = Newmark(60000, 1, 100)
    last = simulate(System(), 2.76, method).cost.steps // 100
    response = simulate(System(), 2.76, method, periods=last + 5, keep=last + 5)
    assert response.status is Status.DIVERGED
    assert response.section.shape == (last, 4)
    assert np.isfinite(response.section).all()
    assert response.trajectory is None
