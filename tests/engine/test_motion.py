"""What moves: the paper's four motions, Newmark's noise told from motion, and the numbers of a cycle."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vibroscope.engine import (
    Cancelled,
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
from vibroscope.engine.drivers.newmark import pack
from vibroscope.engine.motions.floquet import multipliers, nearest
from vibroscope.engine.motions.section import (
    TOLERANCE,
    band,
    irregularity,
    nearly_repeats_after,
    repeats_after,
    rotation,
)

SYSTEM = System()
# Found by a search at random: the cycle of one impact has lost its stability on the circle (Neimark–Sacker).
TORUS = System(kappa=1.834, d1=0.002427, d2=0.009116, kappa3=1.1776, restitution=0.8965)
FREE, PRESSED = False, True


# ------------------------------------------------------------------------------------------------- the paper's motions


@pytest.mark.parametrize(
    ("eta", "period", "impacts", "contacts"),
    [(1.08, 1, 10, 1), (2.76, 1, 1, 0), (3.25, 2, 0.5, 0)],
    ids=["A", "C", "D"],
)
def test_the_papers_periodic_motions(eta, period, impacts, contacts):
    found = motion(SYSTEM, eta, Reference())
    assert (found.type, found.period) == ("periodic", period)
    assert (found.impacts_per_period, found.permanent_per_period) == (impacts, contacts)
    assert len(found.section) == period
    assert len(found.impact_phases) == impacts * period
    assert found.lyapunov == pytest.approx(np.log(np.abs(found.multipliers).max()) / period, rel=1e-12)
    long = motion(simulate(SYSTEM, eta, Reference()))
    np.testing.assert_allclose(np.sort(found.closing_speeds), np.sort(long.closing_speeds), rtol=1e-8)
    np.testing.assert_allclose(np.sort(found.impact_phases), np.sort(long.impact_phases), atol=1e-9)


def test_the_papers_chaotic_motion():
    found = motion(SYSTEM, 1.70, Reference())
    assert (found.type, found.period) == ("chaotic", 0)
    assert 0.24 <= found.lyapunov <= 0.28
    assert 0 < found.lyapunov_error < 0.005
    assert len(found.multipliers) == 0


def test_quasi_periodic_motion_turns_about_the_cycle_that_it_left():
    """Its frequency on the section is, near the bifurcation, the argument of the unstable pair of multipliers."""
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
    stable = motion(TORUS, 2.18, Reference("derived"))  # before it the cycle attracts, and its pair is what is near
    assert (stable.type, stable.period, stable.bifurcation) == ("periodic", 1, "Neimark-Sacker")


def test_quasi_periodic_motion_of_the_papers_system():
    """A torus of two tubes: every other point of the section lies on one closed curve, visited without order."""
    found = motion(SYSTEM, 2.88, Reference())
    assert found.type == "quasi-periodic"
    followed = lyapunov(SYSTEM, 2.88, Reference(), initial=found.section[-1]).section[::2, [0, 2]]
    turns = 2 * found.rotation * np.arange(len(followed)) % 1.0
    along = followed[np.argsort(turns)]
    steps = np.linalg.norm(np.diff(along, axis=0), axis=1)
    assert steps.max() < 0.02 * np.ptp(followed, axis=0).max()  # 4,096 points in order along a curve
    assert np.linalg.norm(np.diff(followed, axis=0), axis=1).max() > 0.2 * np.ptp(followed, axis=0).max()


def test_a_run_that_blows_up_is_diverged():
    found = motion(SYSTEM, 2.76, Newmark(1e9, 1e3, 20))
    assert found.type == "diverged"
    assert "step" in found.reason
    assert found.as_dict()["impacts_per_period"] is None


def test_numbers_of_a_cycle_agree_between_solvers():
    """Newmark with fine steps is the exact penalty solution: force, impulse, energy, multipliers."""
    exact = motion(SYSTEM, 1.08, ExactPenalty(100, 50))
    fine = motion(SYSTEM, 1.08, Newmark(100, 50, 1000, located=True))
    assert (exact.period, fine.period) == (1, 1)
    for name in ("impulse", "energy_lost", "lyapunov", "contact_share", "peak_force", "approach"):
        assert getattr(fine, name) == pytest.approx(getattr(exact, name), rel=1e-3), name


def test_impulse_is_that_of_the_impacts_where_nothing_else_presses():
    found = motion(SYSTEM, 2.76, Reference())
    run = simulate(SYSTEM, 2.76, Reference())
    assert found.impulse == pytest.approx(run.impacts.impulse.sum() / run.keep, rel=1e-5)
    pressed = motion(SYSTEM, 2.76, ExactPenalty(12000, 18))
    run = simulate(SYSTEM, 2.76, ExactPenalty(12000, 18))
    assert pressed.impulse == pytest.approx(run.impacts.impulse.sum() / run.keep, rel=1e-5)


def test_impulse_of_permanent_contact_is_the_integral_of_its_force():
    run = simulate(SYSTEM, 1.08, Reference(), record=Record(10, 20000))
    time, force = run.trajectory.time, run.trajectory.force
    pressed = np.trapezoid(force, time) / 10
    by_impacts = run.impacts.impulse.sum() / run.keep
    assert motion(run).impulse == pytest.approx(pressed + by_impacts, rel=2e-4)


def test_energy_lost_is_that_of_the_impact_and_the_dampers():
    """[C]: one impact a period, and dampers on a motion known from its samples."""
    found = motion(SYSTEM, 2.76, Reference())
    run = simulate(SYSTEM, 2.76, Reference(), record=Record(1, 20000))
    v1, v2 = run.trajectory.velocity
    dampers = 2 * SYSTEM.d1 * v1**2 + 2 * SYSTEM.mass_ratio * SYSTEM.d2 * SYSTEM.kappa * v2**2
    by_impact = 0.5 * SYSTEM.mass_share * (1 - SYSTEM.restitution**2) * run.impacts.closing_speed[-1] ** 2
    assert found.energy_lost == pytest.approx(np.trapezoid(dampers, run.trajectory.time) + by_impact, rel=1e-3)


def test_peak_force_needs_samples_in_the_contact():
    rich = motion(simulate(SYSTEM, 2.76, ExactPenalty(12000, 18), record=Record(1, 20000)))
    poor = motion(simulate(SYSTEM, 2.76, ExactPenalty(12000, 18), record=Record(1, 100)))
    assert motion(SYSTEM, 2.76, ExactPenalty(12000, 18)).peak_force == pytest.approx(rich.peak_force, rel=1e-3)
    assert np.isnan(poor.peak_force)


def test_a_chatter_counts_by_its_first_impact():
    found = motion(SYSTEM, 1.08, Reference())
    assert found.approach == found.closing_speeds.max()
    assert found.closing_speeds.min() < 0.01 * found.approach


# ------------------------------------------------------------------------------------------------------ step and motion


@pytest.mark.parametrize(("eta", "stiffness", "damping", "period"), [(2.76, 12000, 18, 1), (3.25, 12000, 18, 2)])
def test_a_band_that_shrinks_with_the_step_is_an_artefact(eta, stiffness, damping, period):
    found = motion(SYSTEM, eta, Newmark(stiffness, damping, 2000))
    assert (found.type, found.period) == ("periodic", period)
    assert found.step_noise > 0.03
    assert "artefact of the time step" in found.reason
    assert found.bands[0] == (2000, found.step_noise)
    assert found.bands[-1][1] < 0.5 * found.step_noise
    limit = motion(SYSTEM, eta, ExactPenalty(stiffness, damping), initial=found.section[-1])
    np.testing.assert_allclose(found.multipliers, limit.multipliers, atol=1e-8)


def test_a_band_that_keeps_its_width_is_motion():
    found = motion(SYSTEM, 1.70, Newmark(12000, 18, 2000))
    assert (found.type, found.step_noise) == ("chaotic", 0)
    assert 0.24 <= found.lyapunov <= 0.30
    widths = [width for _, width in found.bands]
    assert max(widths) < 1.5 * min(widths)


def test_a_step_that_hits_the_cycle_makes_no_noise():
    fixed, located = Newmark(2500, 8, 2000), Newmark(2500, 8, 500, located=True)
    for method in (fixed, located):
        found = motion(SYSTEM, 1.08, method)
        assert (found.type, found.period, found.step_noise, found.bands) == ("periodic", 1, 0, ())


def test_the_derivative_of_the_steps_decides_nothing():
    """It expands about a motion that is periodic, and contracts within a chaotic one (see stepnoise)."""
    assert _own_exponent(2.76, Newmark(12000, 18, 2000)) > 0.1
    assert _own_exponent(1.70, Newmark(12000, 18, 2000)) < 0


def test_multipliers_of_steps_are_products_of_their_matrices():
    """The derivative by differences, against the matrices of the steps with and without contact."""
    method = Newmark(2500, 8, 2000)
    run = simulate(SYSTEM, 1.08, method, periods=1200, keep=2)
    product = np.eye(4)
    for matrix in _matrices(run):
        product = matrix @ product
    by_matrices = np.linalg.eigvals(product)
    found = multipliers(SYSTEM, 1.08, method, run.section[0], 1)
    np.testing.assert_allclose(np.sort(np.abs(found))[2:], np.sort(np.abs(by_matrices))[2:], rtol=1e-6)


def _matrices(run, last=1):
    """Powers of the matrices of the steps over the last periods, from contact change to contact change."""
    scheme, n = pack(run.system, run.eta, run.method), run.method.steps
    free, pressed = _step_matrix(scheme, FREE), _step_matrix(scheme, PRESSED)
    end = run.periods * n
    position = end - last * n
    for begin, stop in np.rint(run.contacts / scheme.h).astype(int):
        if stop <= position:
            continue
        begin, stop = max(begin, position), min(stop, end)
        yield np.linalg.matrix_power(free, begin - position)
        yield np.linalg.matrix_power(pressed, stop - begin)
        position = stop
    yield np.linalg.matrix_power(free, end - position)


def _step_matrix(m, contact):
    """One step of Newmark on (p₁, Q₁, p₂, Q₂), as engine/kernels/newmark.py derives it."""
    a1, a2 = np.array([-m.stiffness1, -m.damping1, 0, 0]), np.array([0, 0, -m.stiffness2, -m.damping2])
    if contact:
        force = np.array([m.contact_p, m.contact_q, -m.contact_p, -m.contact_q]) + m.contact_a * (a1 - a2)
        a1, a2 = a1 - m.react1 * force, a2 + m.react2 * force
    q1, q2 = np.eye(4)[1] + a1, np.eye(4)[3] + a2
    return np.array([np.eye(4)[0] + q1, q1, np.eye(4)[2] + q2, q2])


def _own_exponent(eta, method, periods=1000):
    run = simulate(SYSTEM, eta, method, periods=1000 + periods, keep=periods)
    v, growth = np.full(4, 0.5), 0.0
    for matrix in _matrices(run, periods):
        v = matrix @ v
        growth += np.log(np.linalg.norm(v))
        v /= np.linalg.norm(v)
    return growth / periods


# ---------------------------------------------------------------------------------------------------------- the section


@settings(max_examples=60, derandomize=True, deadline=None)
@given(st.integers(1, 9), st.integers(2, 6), st.integers(0, 2**32 - 1))
def test_the_period_of_a_section_is_the_shortest(period, cycles, seed):
    cycle = np.random.default_rng(seed).normal(size=(period, 4))
    assert repeats_after(np.tile(cycle, (cycles, 1))) == period
    assert band(np.tile(cycle, (cycles, 1)), period) < 1e-15
    blurred = np.tile(cycle, (cycles, 1))
    blurred[-1, 2] += 100 * TOLERANCE * np.abs(cycle).max()
    assert repeats_after(blurred) != period


def test_a_section_with_scatter_nearly_repeats():
    rng = np.random.default_rng(3)
    cycle = np.tile([[5.0, 1, -5, 1], [4.0, -1, 4, 2]], (20, 1))
    assert nearly_repeats_after(cycle + rng.normal(0, 0.02, cycle.shape)) == 2
    assert nearly_repeats_after(rng.normal(0, 5, cycle.shape)) == 0


@pytest.mark.parametrize("turns", [np.sqrt(2) - 1, (np.sqrt(5) - 1) / 2 - 0.2, np.sqrt(3) / 5, 1 / np.pi])
def test_regular_sections_are_told_from_random_ones(turns):
    """Closed curves, a torus of two tubes, and as many random points of the same size."""
    n, golden = np.arange(8192), (np.sqrt(5) - 1) / 2
    angle, other = 2 * np.pi * turns * n, 2 * np.pi * golden * n
    curve = np.transpose([np.cos(angle), np.sin(angle), np.cos(angle + 0.3), np.exp(np.sin(angle))])
    tubes = curve + np.where(n % 2, 5.0, -5.0)[:, None]
    torus = curve + 0.1 * np.cos(other)[:, None]
    for section in (curve, tubes, torus):
        assert irregularity(section) < 1e-6
        assert rotation(section) == pytest.approx(turns, abs=1e-5)
    assert irregularity(np.random.default_rng(1).normal(size=(8192, 4))) > 1e-3


# ------------------------------------------------------------------------------------------------------------ the rest


@pytest.mark.parametrize(
    ("values", "approach", "name", "margin"),
    [
        ([-0.9, 0.5, 0.1, 0.0], 5.0, "period doubling", 0.1),
        ([0.95, 0.5, -0.9, 0.0], 5.0, "fold", 0.05),
        ([0.6 + 0.7j, 0.6 - 0.7j, 0.5, 0.1], 5.0, "Neimark-Sacker", 1 - np.hypot(0.6, 0.7)),
        ([-0.9, 0.5, 0.1, 0.0], 0.2, "grazing", 0.02),
        ([-0.9, 0.5, 0.1, 0.0], np.nan, "period doubling", 0.1),
    ],
)
def test_the_nearest_bifurcation(values, approach, name, margin):
    found = nearest(np.array(values, complex), np.array([10.0, 3.0]), approach)
    assert found == (name, pytest.approx(margin))


def test_the_bifurcation_that_is_near_takes_place():
    """A multiplier that nears −1 as η grows: beyond it the period is doubled, and the new cycle is near a fold."""
    found = [motion(SYSTEM, eta, Reference()) for eta in (2.76, 2.77, 2.79)]
    assert [each.period for each in found] == [1, 1, 2]
    assert [each.bifurcation for each in found] == ["period doubling", "period doubling", "fold"]
    assert found[0].margin > found[1].margin


def test_as_dict_is_the_contract():
    for found in (motion(SYSTEM, 1.08, Reference()), motion(simulate(SYSTEM, 1.70, Reference()))):
        plain = json.loads(json.dumps(found.as_dict(), allow_nan=False))
        assert {"type", "period", "impacts_per_period", "contact_share", "lyapunov", "floquet"} <= plain.keys()
    assert plain["type"] == "undecided"
    assert plain["floquet"] == []
    assert plain["lyapunov"] is None


def test_what_makes_no_sense_is_refused():
    run = simulate(SYSTEM, 1.08, Reference())
    with pytest.raises(ValueError, match="a response knows"):
        motion(run, 1.08, Reference())
    with pytest.raises(ValueError, match="a system alone"):
        motion(SYSTEM)
    with pytest.raises(ValueError, match="eta = -1"):
        motion(SYSTEM, -1, Reference())
    with pytest.raises(ValueError, match="ended as diverged"):
        motion(simulate(SYSTEM, 2.76, Newmark(1e9, 1e3, 20)))


@pytest.mark.parametrize("method", [Reference(), Newmark(12000, 18, 2000)])
def test_it_can_be_cancelled(method):
    with pytest.raises(Cancelled):
        motion(SYSTEM, 1.70, method, cancelled=lambda: True)


def test_long_cycles_are_periodic():
    """A cycle of more periods than Newton's method looks for is seen in the section, with its multipliers."""
    found = motion(SYSTEM, 3.09, Reference())
    assert (found.type, found.period) == ("periodic", 100)
    assert found.lyapunov == pytest.approx(
        lyapunov(SYSTEM, 3.09, Reference(), initial=found.section[-1]).exponent, rel=0.01
    )
