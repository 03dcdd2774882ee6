"""What must hold for the reference whatever the parameters, and its hard starts."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vibroscope.engine import Record, Reference, System, simulate

from tests.share import share

etas = st.floats(0.5, 4.0)
systems = st.builds(
    System.from_mass_ratio,
    mass_ratio=st.floats(0.1, 10.0),
    kappa=st.floats(1.2, 6.0),
    d1=st.floats(0.0005, 0.1),
    d2=st.floats(0.0005, 0.1),
    restitution=st.floats(0.0, 0.9),
)
speeds = st.floats(-5.0, 5.0)
starts = st.tuples(speeds, speeds, st.floats(0.0, 3.0), speeds).map(lambda s: (s[0], s[1], s[0] + s[2], s[3]))


@settings(max_examples=share(150))
@given(systems, etas, starts)
def test_motion_is_admissible(system, eta, start):
    """Gap and permanent force are never negative; impacts conserve momentum, obey Newton's law and create no energy."""
    response = simulate(system, eta, Reference("derived"), periods=30, keep=30, initial=start, record=Record(30, 400))
    assert response.ok
    x1, x2 = response.trajectory.displacement
    scale = np.abs(response.trajectory.displacement).max()
    assert (x2 - x1).min() >= -1e-13 * scale
    assert response.trajectory.force.min() >= -1e-12 * scale
    before, after = response.impacts.velocity_before, response.impacts.velocity_after
    if len(before) == 0:
        return
    mass = np.array([1.0, system.mass_ratio])
    speed = np.abs(before).max()
    np.testing.assert_allclose(after @ mass, before @ mass, atol=1e-13 * speed * mass.sum())
    assert (after**2 @ mass <= before**2 @ mass + 1e-12 * speed**2).all()
    closing = response.impacts.closing_speed
    assert (closing > 0).all()
    np.testing.assert_allclose(before[:, 0] - before[:, 1], closing, atol=1e-14 * speed)
    parting = after[:, 1] - after[:, 0]
    newton = np.abs(parting - system.restitution * closing) <= 1e-12 * speed
    sticks = parting == 0
    assert (newton | sticks).all()
    np.testing.assert_allclose(response.impacts.impulse, before[:, 0] - after[:, 0], atol=1e-12 * speed)


@settings(max_examples=share(60))
@given(etas, starts)
def test_trajectory_obeys_the_equations_of_motion(eta, start):
    """Second differences of the samples against MODEL's equations, away from events."""
    system = System()
    response = simulate(system, eta, Reference("derived"), periods=2, keep=2, initial=start, record=Record(2, 4000))
    t, x, v, force = (
        response.trajectory.time,
        response.trajectory.displacement,
        response.trajectory.velocity,
        response.trajectory.force,
    )
    acceleration = (v[:, 2:] - v[:, :-2]) / (t[2:] - t[:-2])
    k, d, mu = np.array([[1.0], [system.kappa]]), np.array([[system.d1], [system.d2]]), system.mass_ratio
    load = eta**2 * np.cos(eta * t) + np.array([[-1.0], [1 / mu]]) * force
    residual = acceleration + (2 * d * k * v + k**2 * x - load)[:, 1:-1]
    events = np.concatenate([response.impacts.time, response.contacts.ravel()])
    quiet = np.all(np.abs(t[1:-1, None] - events) > 3 * (t[1] - t[0]), axis=1)
    assert np.abs(residual[:, quiet]).max() < 1e-4 * max(1.0, np.abs(x).max() * max(eta, system.kappa) ** 4)


def test_rest_begins_in_contact():
    """All gap derivatives up to the second vanish at rest; the third is negative, so the pendulums stay together."""
    response = simulate(System(), 2.76, Reference(), periods=1, keep=1)
    assert response.contacts[0, 0] == 0.0
    assert response.contacts[0, 1] > 0.1


@pytest.mark.parametrize(
    ("initial", "impacts"),
    [((0, 1, 0, 0), 1), ((0, 0, 0, 1), 0), ((-1, 0, -1, 0), 0), ((1, 0, 1, 0), 0)],
    ids=["approaching", "leaving", "pulled apart", "pressed together"],
)
def test_starts_on_the_surface(initial, impacts):
    response = simulate(System(), 2.76, Reference(), periods=1, keep=1, initial=initial, record=Record(1, 2000))
    assert np.sum(response.impacts.time == 0.0) == impacts
    assert np.any(response.contacts[:, 0] == 0.0) == (initial == (1, 0, 1, 0))
    x = response.trajectory.displacement
    assert (x[1] - x[0]).min() > -1e-13


def test_chatter_flights_are_found_down_to_the_threshold():
    """Closing speeds fall by e from impact to impact, to the threshold, in flights down to 1e-6 T."""
    response = simulate(System(), 1.08, Reference(threshold=1e-7), periods=60, keep=1)
    speeds = response.impacts.closing_speed
    flights = np.diff(response.impacts.time) / response.period
    assert flights.min() < 1e-6
    assert 0.5 * speeds.min() <= 1e-7
    last = speeds[-10:]
    np.testing.assert_allclose(last[1:] / last[:-1], 0.5, rtol=1e-3)


def from_gap(gap):
    return simulate(System(), 2.76, Reference(), periods=1, keep=1, initial=(0, 0, gap, -1.0), record=Record(1, 4000))


def grazing_gaps():
    """Two neighbouring starts: after one impact, the gap of the first dips to zero, that of the second does not."""
    touching, clear = 0.93, 1.34
    assert len(from_gap(touching).impacts) > 1 == len(from_gap(clear).impacts)
    while True:
        middle = 0.5 * (touching + clear)
        if middle in (touching, clear):
            return touching, clear
        touching, clear = (middle, clear) if len(from_gap(middle).impacts) > 1 else (touching, middle)


@pytest.mark.parametrize("depth", [0.0, 1e-14, 1e-12, 1e-8, 1e-5])
def test_a_shallow_dip_is_not_passed(depth):
    """One start touches with almost no speed, its neighbour in the last place does not: a dip shows by its sign."""
    touching, clear = grazing_gaps()
    hit, missed = from_gap(touching - depth), from_gap(clear + depth)
    assert len(missed.impacts) == 1
    # a dip of depth δ is met at a speed of √(2 g″ δ)
    assert hit.impacts.closing_speed[1] == pytest.approx(0.0, abs=10 * np.sqrt(depth + 1e-14))
    for response in (hit, missed):
        assert np.subtract(*response.trajectory.displacement[::-1]).min() > -1e-14


def test_sticking_wants_a_compressive_force():
    """With e = 0 each impact parts with speed 0 ≤ ε: it sticks under pressure and leaves at once under tension."""
    system, left = System(restitution=0.0), 0
    for eta in (1.08, 2.76, 3.25):
        response = simulate(system, eta, Reference(), periods=40, keep=40, record=Record(40, 500))
        assert response.ok
        assert response.trajectory.force.min() > -1e-13
        begins = set(response.contacts[:, 0])
        pulled = [i for i, t in enumerate(response.impacts.time) if t not in begins]
        share = system.mass_share
        velocity = response.impacts.velocity_after[:, 0]
        force = share * (
            (system.kappa**2 - 1) * response.impacts.position + 2 * (system.d2 * system.kappa - system.d1) * velocity
        )
        assert all(force[i] <= 1e-12 for i in pulled)
        left += len(pulled)
    assert left > 0


def test_an_endless_chatter_ends_with_a_status():
    """From a parting speed of 1e-4 under pressure, e = 0.9999 needs 180,000 impacts in a part of a period."""
    start = (3.0, 0.0, 3.0, 1e-4)
    response = simulate(System(restitution=0.9999), 1.08, Reference(threshold=1e-12), periods=2, keep=1, initial=start)
    assert response.status == "piled-up"
    assert "take a larger threshold" in response.message


def test_phase_stays_exact_over_many_periods():
    """A periodic motion repeats itself to rounding after 20,000 periods, bit for bit in its section."""
    response = simulate(System(), 2.76, Reference(), periods=20_000, keep=5)
    assert np.ptp(response.section, axis=0).max() < 1e-12
    assert response.impacts.time[-1] == pytest.approx(20_000 * 2 * math.pi / 2.76, rel=1e-4)
