"""Accelerations, peaks, spectra and transmissibility of runs, against differences and closed forms."""

import numpy as np
import pytest
from vibroscope.engine import (
    PEAKS,
    ExactPenalty,
    Excitation,
    Newmark,
    Record,
    Reference,
    System,
    absolute_accelerations,
    peaks,
    simulate,
    spectrum,
    transmissibility,
)

FREE = System(clearance=1e3, excitation=Excitation(base=1.0, base_phase=0.3))
FORCED = System(mu=0.5, d3=None, clearance=0.2, excitation=Excitation(base=0.4, force1=1.5, force2=0.3, constant1=0.1))
WALL = System(wall=True, clearance=0.5, d1=0.07, restitution=0.8)


def run(system, eta, method, periods=2, per_period=4000):
    return simulate(system, eta, method, record=Record(periods, per_period))


@pytest.mark.parametrize("method", [Reference(), ExactPenalty(2500, 8)], ids=["reference", "exact"])
@pytest.mark.parametrize(("system", "eta"), [(System(), 1.08), (FORCED, 1.3), (WALL, 1.2), (System(clearance=-1), 1.4)])
def test_accelerations_are_the_slopes_of_the_velocities(system, eta, method):
    found = run(system, eta, method, per_period=40_000)
    time, h = found.trajectory.time, np.diff(found.trajectory.time)[0]
    base = -(eta**2) * system.excitation.base_motion(eta, time)[0]
    slopes = np.gradient(found.trajectory.velocity, h, axis=1) + base
    away = np.ones(len(time), bool)
    for instant in (*found.impacts.time, *found.contacts.ravel()):
        away &= np.abs(time - instant) > 3 * h
    away[[0, -1]] = False
    assert away.sum() > 1000
    error = np.abs(absolute_accelerations(found) - slopes)[:, away]
    assert error.max() < 2e-4 * (1 + np.abs(slopes[:, away]).max())


def test_a_free_motion_has_one_line_and_the_transmissibility_of_textbooks():
    eta = 1.3
    found = spectrum(run(FREE, eta, Reference(), periods=3))
    assert found.order[3] == 1.0
    assert np.delete(found.displacement, 3, axis=1).max() < 1e-6
    assert np.abs(found.force).max() == 0
    for body, (omega, d) in enumerate(((1.0, FREE.d1), (FREE.kappa, FREE.d2))):
        r = eta / omega
        expected = np.sqrt((1 + (2 * d * r) ** 2) / ((1 - r**2) ** 2 + (2 * d * r) ** 2))
        assert found.displacement[body, 3] == pytest.approx(expected, rel=1e-6)
        assert transmissibility(run(FREE, eta, Reference()))[body] == pytest.approx(expected, rel=1e-6)
        assert found.acceleration[body, 3] == pytest.approx(eta**2 * expected, rel=1e-6)


def test_the_mean_force_is_the_impulse_of_a_period():
    """Of the reference impulses count, of the penalty model the force; both come from the same mean motion."""
    reference, penalty = (spectrum(run(WALL, 1.2, method)) for method in (Reference(), ExactPenalty(1e5, 20)))
    assert reference.force[0] > 0
    assert penalty.force[0] == pytest.approx(reference.force[0], rel=0.03)
    impacts = run(WALL, 1.2, Reference()).impacts
    assert reference.force[0] == pytest.approx(impacts.impulse.sum() / (50 * 2 * np.pi / 1.2), rel=1e-3)


def test_peaks_are_those_of_the_samples():
    penalty, reference = (peaks(run(WALL, 1.2, method)) for method in (Newmark(584, 2, 20000), Reference()))
    assert penalty.keys() == reference.keys() == PEAKS.keys()
    assert np.isnan(reference["contact_force"])
    assert np.isnan(reference["acceleration1"])
    assert reference["penetration"] < 1e-9
    assert reference["contact_time"] == 0
    assert penalty["contact_force"] > 584 * penalty["penetration"] * 0.9
    assert penalty["impulse"] == pytest.approx(reference["impulse"], rel=0.05)
    assert 0 < penalty["contact_time"] < 0.3
    assert penalty["displacement1"] == pytest.approx(0.5 + penalty["penetration"], abs=2.0)


def test_a_lasting_contact_and_its_chatter_have_one_impulse():
    """A body of mass 1 that is thrown at a wall and pressed against it: by momentum, whatever bounces it makes."""
    pressed = System(wall=True, clearance=0.5, restitution=0.5, d1=0.02, excitation=Excitation(base=0, constant1=1.5))
    start, record = (-0.5, 0.0, 0.0, 0.0), Record(2, 4000)
    found = {
        method.name: simulate(pressed, 1.0, method, periods=2, keep=2, initial=start, record=record)
        for method in (Reference(), ExactPenalty(1e4, 21))  # of the same restitution
    }
    reference, penalty = (peaks(run) for run in found.values())
    sampled = found["reference"].trajectory
    from_start = -sampled.velocity[0, -1] - 2 * 0.02 * (sampled.displacement[0, -1] + 0.5)
    from_start += np.trapezoid(1.5 - sampled.displacement[0], sampled.time)
    assert len(found["reference"].impacts) > 4
    assert reference["impulse"] == pytest.approx(from_start, rel=1e-3)
    assert penalty["impulse"] == pytest.approx(reference["impulse"], rel=0.02)
    assert reference["contact_force"] == pytest.approx(1.0, rel=1e-3)  # of the permanent contact
    assert np.isnan(reference["acceleration1"])


def test_impacts_that_end_in_no_lasting_contact_have_an_impulse_each():
    for method in (Reference(), ExactPenalty(1e5, 20)):
        found = run(WALL, 1.2, method)
        inside = found.impacts.time > found.trajectory.time[0]
        assert peaks(found)["impulse"] == np.abs(found.impacts.impulse[inside]).max()


def test_a_contact_that_never_ends_lasts_as_long_as_the_samples():
    pressed = System(wall=True, clearance=-40.0, d1=0.07)
    for method in (Reference(), Newmark(584, 2, 2000)):
        found = run(pressed, 1.2, method, periods=3)
        read = peaks(found)
        assert len(found.contacts) == 1
        assert read["contact_time"] == pytest.approx(3 * 2 * np.pi / 1.2)
        assert read["impulse"] == pytest.approx(np.trapezoid(found.trajectory.force, found.trajectory.time))


def test_what_cannot_be_said_is_refused():
    bare = simulate(WALL, 1.2, Reference())
    for ask in (peaks, spectrum, absolute_accelerations):
        with pytest.raises(ValueError, match="no samples"):
            ask(bare)
    with pytest.raises(ValueError, match="needs more than 80 samples"):
        spectrum(run(WALL, 1.2, Reference(), per_period=50), 40)
