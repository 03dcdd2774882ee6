"""Types of motions and the numbers of a cycle: the paper's four motions, and one of each type."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import (
    ExactPenalty,
    Newmark,
    Record,
    Reference,
    System,
    lyapunov,
    motion,
    simulate,
    steady,
)

SYSTEM = System()
# Found by a random search: a complex pair of multipliers of the cycle has left the unit circle (Neimark–Sacker).
TORUS = System(kappa=1.834, d1=0.002427, d2=0.009116, kappa3=1.1776, restitution=0.8965)


@pytest.mark.parametrize(
    ("eta", "period", "impacts", "contacts"),
    [(1.08, 1, 10, 1), (2.76, 1, 1, 0), (3.25, 2, 0.5, 0)],
    ids=["A", "C", "D"],
)
def test_the_papers_periodic_motions_have_their_periods_and_impacts(eta, period, impacts, contacts):
    found = motion(SYSTEM, eta, Reference())
    assert (found.type, found.period) == ("periodic", period)
    assert (found.impacts_per_period, found.permanent_per_period) == (impacts, contacts)
    assert len(found.section) == period
    assert len(found.impact_phases) == impacts * period
    assert found.lyapunov == pytest.approx(np.log(np.abs(found.multipliers).max()) / period, rel=1e-12)
    long = motion(simulate(SYSTEM, eta, Reference()))
    np.testing.assert_allclose(np.sort(found.closing_speeds), np.sort(long.closing_speeds), rtol=1e-8)
    np.testing.assert_allclose(np.sort(found.impact_phases), np.sort(long.impact_phases), atol=1e-9)


def test_the_papers_motion_b_is_chaotic():
    found = motion(SYSTEM, 1.70, Reference())
    assert (found.type, found.period) == ("chaotic", 0)
    assert 0.24 <= found.lyapunov <= 0.28
    assert 0 < found.lyapunov_error < 0.005
    assert len(found.multipliers) == 0


def test_the_rotation_number_is_the_argument_of_the_unstable_multipliers():
    """Near a Neimark–Sacker bifurcation, quasi-periodic motion turns about the cycle that lost its stability."""
    found = motion(TORUS, 2.134, Reference("derived"))
    assert found.type == "quasi-periodic"
    assert abs(found.lyapunov) < 1e-6
    centre = found.section.mean(axis=0)
    cycle = steady(TORUS, 2.134, Reference("derived"), initial=centre, stable_only=False)
    assert (cycle.periodic, cycle.period, cycle.stable) == (True, 1, False)
    leading = cycle.multipliers[0]
    assert abs(leading) > 1
    assert abs(leading.imag) > 0.1
    assert found.rotation == pytest.approx(abs(np.angle(leading)) / (2 * np.pi), abs=0.01)
    stable = motion(TORUS, 2.18, Reference("derived"))  # on the other side the cycle is stable
    assert (stable.type, stable.period, stable.bifurcation) == ("periodic", 1, "Neimark-Sacker")


def test_a_quasi_periodic_motion_of_the_papers_system_lies_on_two_closed_curves():
    """Every other point of the section lies on the same curve; ordered by their phase they follow it."""
    found = motion(SYSTEM, 2.88, Reference())
    assert found.type == "quasi-periodic"
    followed = lyapunov(SYSTEM, 2.88, Reference(), initial=found.section[-1]).section[::2, [0, 2]]
    turns = 2 * found.rotation * np.arange(len(followed)) % 1.0
    along = followed[np.argsort(turns)]
    steps = np.linalg.norm(np.diff(along, axis=0), axis=1)
    assert steps.max() < 0.02 * np.ptp(followed, axis=0).max()  # 4,096 points in order along a curve
    assert np.linalg.norm(np.diff(followed, axis=0), axis=1).max() > 0.2 * np.ptp(followed, axis=0).max()


def test_a_run_that_grows_without_bound_is_diverged():
    found = motion(SYSTEM, 2.76, Newmark(1e9, 1e3, 20))
    assert found.type == "diverged"
    assert "step" in found.reason
    assert found.as_dict()["impacts_per_period"] is None


def test_newmark_and_exact_penalty_agree_on_the_numbers_of_a_cycle():
    exact = motion(SYSTEM, 1.08, ExactPenalty(100, 50))
    fine = motion(SYSTEM, 1.08, Newmark(100, 50, 1000, located=True))
    assert (exact.period, fine.period) == (1, 1)
    for name in ("impulse", "energy_lost", "lyapunov", "contact_share", "peak_force", "approach"):
        assert getattr(fine, name) == pytest.approx(getattr(exact, name), rel=1e-3), name


def test_the_impulse_without_lasting_contact_is_that_of_the_impacts():
    found = motion(SYSTEM, 2.76, Reference())
    run = simulate(SYSTEM, 2.76, Reference())
    assert found.impulse == pytest.approx(run.impacts.impulse.sum() / run.keep, rel=1e-5)
    pressed = motion(SYSTEM, 2.76, ExactPenalty(12000, 18))
    run = simulate(SYSTEM, 2.76, ExactPenalty(12000, 18))
    assert pressed.impulse == pytest.approx(run.impacts.impulse.sum() / run.keep, rel=1e-5)


@pytest.mark.parametrize("method", [Reference(), ExactPenalty(1000, 5), Newmark(1000, 5, 500)])
def test_a_motion_that_touches_nothing_has_no_impulse(method):
    """Its terms cancel but for rounding."""
    assert motion(System(clearance=50.0), 1.2, method).impulse == 0.0
    pressed = motion(System(wall=True, clearance=-60.0), 1.2, method)
    assert pressed.impulse == pytest.approx(60 * 2 * math.pi / 1.2, rel=0.1)


def test_the_impulse_of_permanent_contact_is_the_integral_of_its_force():
    run = simulate(SYSTEM, 1.08, Reference(), record=Record(10, 20000))
    time, force = run.trajectory.time, run.trajectory.force
    pressed = np.trapezoid(force, time) / 10
    by_impacts = run.impacts.impulse.sum() / run.keep
    assert motion(run).impulse == pytest.approx(pressed + by_impacts, rel=2e-4)


def test_a_second_stop_out_of_reach_leaves_the_impulse_of_permanent_contact():
    far = replace(SYSTEM, clearance2=100.0)
    assert motion(far, 1.08, Reference()).impulse == pytest.approx(motion(SYSTEM, 1.08, Reference()).impulse, rel=1e-3)


def test_the_energy_lost_is_that_of_the_impact_and_the_dampers():
    """Motion [C]: one impact per period, and dampers integrated over finely sampled motion."""
    found = motion(SYSTEM, 2.76, Reference())
    run = simulate(SYSTEM, 2.76, Reference(), record=Record(1, 20000))
    v1, v2 = run.trajectory.velocity
    dampers = 2 * SYSTEM.d1 * v1**2 + 2 * SYSTEM.mass_ratio * SYSTEM.d2 * SYSTEM.kappa * v2**2
    by_impact = 0.5 * SYSTEM.mass_share * (1 - SYSTEM.restitution**2) * run.impacts.closing_speed[-1] ** 2
    assert found.energy_lost == pytest.approx(np.trapezoid(dampers, run.trajectory.time) + by_impact, rel=1e-3)


def test_the_peak_force_is_unknown_without_samples_in_the_contact():
    rich = motion(simulate(SYSTEM, 2.76, ExactPenalty(12000, 18), record=Record(1, 20000)))
    poor = motion(simulate(SYSTEM, 2.76, ExactPenalty(12000, 18), record=Record(1, 100)))
    assert motion(SYSTEM, 2.76, ExactPenalty(12000, 18)).peak_force == pytest.approx(rich.peak_force, rel=1e-3)
    assert np.isnan(poor.peak_force)


def test_the_approach_of_a_chatter_is_its_first_impact():
    found = motion(SYSTEM, 1.08, Reference())
    assert found.approach == found.closing_speeds.max()
    assert found.closing_speeds.min() < 0.01 * found.approach


def test_as_dict_is_valid_json_with_the_documented_keys():
    for found in (motion(SYSTEM, 1.08, Reference()), motion(simulate(SYSTEM, 1.70, Reference()))):
        plain = json.loads(json.dumps(found.as_dict(), allow_nan=False))
        assert {"type", "period", "impacts_per_period", "contact_share", "lyapunov", "floquet"} <= plain.keys()
    assert plain["type"] == "undecided"
    assert plain["floquet"] == []
    assert plain["lyapunov"] is None


def test_contradictory_arguments_are_refused():
    run = simulate(SYSTEM, 1.08, Reference())
    with pytest.raises(ValueError, match="a response knows"):
        motion(run, 1.08, Reference())
    with pytest.raises(ValueError, match="a system alone"):
        motion(SYSTEM)
    with pytest.raises(ValueError, match="eta = -1"):
        motion(SYSTEM, -1, Reference())
    with pytest.raises(ValueError, match="ended as diverged"):
        motion(simulate(SYSTEM, 2.76, Newmark(1e9, 1e3, 20)))


def test_a_cycle_longer_than_newtons_method_looks_for_is_found_in_the_section():
    found = motion(SYSTEM, 3.09, Reference())
    assert (found.type, found.period) == ("periodic", 100)
    assert found.lyapunov == pytest.approx(
        lyapunov(SYSTEM, 3.09, Reference(), initial=found.section[-1]).exponent, rel=0.01
    )
