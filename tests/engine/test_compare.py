"""The three parts of the difference add up, and each responds to the number that it belongs to."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from vibroscope.engine import (
    ComparisonQuestion,
    ExactPenalty,
    Impacts,
    Newmark,
    Record,
    Reference,
    System,
    compare,
    motion,
    simulate,
)
from vibroscope.engine.divergence.compare import error_from_penalty_state, wasserstein_distance
from vibroscope.engine.divergence.encounters import match_encounters
from vibroscope.engine.divergence.error import Target
from vibroscope.engine.divergence.grid import settled_length
from vibroscope.engine.divergence.parts import PARTS
from vibroscope.engine.law_table import restitution_of, restitution_without_pull

from tests.answers import compared

SYSTEM = System()
EQUAL = 0.21545 * math.sqrt(2500 * SYSTEM.mass_share)  # D of equal restitution at K = 2500


@pytest.mark.parametrize(
    ("eta", "penalty"),
    [
        (1.08, Newmark(2500, 8, 2000)),
        (1.70, Newmark(12000, 18, 1000)),
        (2.76, Newmark(12000, 18, 2050)),  # 2050 steps and 100 samples: every 21st step, the last interval shorter
        (3.25, Newmark(12000, 18, 500, located=True)),
    ],
)
def test_the_parts_add_up_at_every_instant(eta, penalty):
    found = compared(SYSTEM, eta, penalty)
    parts = found.parts
    total = parts.runs.penalty - parts.runs.reference
    residual = np.abs(sum(getattr(parts, name) for name in PARTS) - total).max()
    assert found.residual == residual < 1e-10
    assert total.shape == (4, len(parts.time))
    assert parts.time[0] == pytest.approx(found.runs.penalty.window[0])


def test_each_series_is_that_of_an_ordinary_sampled_run():
    penalty = Newmark(2500, 8, 2000)
    found = compared(SYSTEM, 1.08, penalty, periods=300, keep=4, per_period=250)
    methods = penalty, ExactPenalty(2500, 8), Reference("derived"), Reference()
    for method, rows in zip(methods, found.parts.runs, strict=True):
        sampled = simulate(SYSTEM, 1.08, method, periods=300, keep=4, record=Record(4, 250, 2000)).trajectory
        assert found.parts.time == pytest.approx(sampled.time[:-1])
        assert rows[:2] == pytest.approx(
            sampled.displacement[:, :-1], abs=1e-5
        )  # 300 periods: the transient still fades
        assert rows[2:] == pytest.approx(sampled.velocity[:, :-1], abs=1e-4)


def test_the_total_is_the_error_that_searches_use():
    for eta, penalty in ((1.08, Newmark(2500, 8, 2000)), (2.76, Newmark(12000, 18, 2000))):
        error = Target.find(SYSTEM, eta).error(simulate(SYSTEM, eta, penalty))
        assert compared(SYSTEM, eta, penalty).total == pytest.approx(error, rel=1e-6)


def test_each_part_responds_to_its_own_number_alone():
    """The time step, K and D, and the joint damping are changed one after the other."""
    base = compared(SYSTEM, 1.08, Newmark(2500, 8, 2000))
    finer = compared(SYSTEM, 1.08, Newmark(2500, 8, 2000, located=True))
    assert finer.time_step < 0.5 * base.time_step
    assert finer.regularisation == pytest.approx(base.regularisation, rel=1e-3)
    stiffer = compared(SYSTEM, 1.08, Newmark(250_000, 10 * EQUAL, 100, located=True))
    assert stiffer.regularisation < 0.5 * base.regularisation
    assert stiffer.joint_damping == pytest.approx(base.joint_damping, rel=1e-3)
    derived = compared(SYSTEM, 1.08, Newmark(2500, 8, 2000), reference=Reference("derived"))
    assert derived.joint_damping == 0
    assert derived.total < 0.1 * base.total


def test_without_permanent_contact_the_part_of_the_joint_damping_vanishes():
    found = compared(SYSTEM, 2.76, Newmark(12000, 18, 2000))
    assert found.joint_damping < 1e-10
    assert found.parts.without("time_step") == pytest.approx(found.regularisation, rel=1e-6)


def test_a_doubled_motion_is_aligned_with_its_own_limit():
    """Newmark and its limit have two periods, the reference one: they must not end up one period apart."""
    found = compared(SYSTEM, 2.76, Newmark(12000, 2, 8000))
    assert (found.reference.period, found.motions.exact.period) == (1, 2)
    assert found.time_step < 0.05 < found.regularisation
    one, two = (compared(SYSTEM, 3.25, Newmark(12000, 18, 2000, located=True), periods=p) for p in (2050, 2051))
    assert two.total == pytest.approx(one.total, rel=1e-6)


def test_existing_runs_are_reused_and_foreign_ones_refused():
    penalty = Newmark(12000, 18, 2000)
    fresh = compared(SYSTEM, 2.76, penalty)
    again = compare(ComparisonQuestion(SYSTEM, 2.76, penalty), responses=fresh.runs)
    assert all(one is other for one, other in zip(fresh.runs, again.runs, strict=True))
    assert again.total == fresh.total
    with pytest.raises(ValueError, match="none of the four"):
        compare(ComparisonQuestion(SYSTEM, 2.76, penalty, periods=100), responses=fresh.runs)
    with pytest.raises(ValueError, match="no time step"):
        compared(SYSTEM, 2.76, ExactPenalty(12000, 18))


def test_a_run_that_diverged_leaves_no_numbers():
    found = compared(SYSTEM, 2.76, Newmark(60000, 1, 100))
    assert np.isnan([found.total, found.time_step, found.residual]).all()
    assert (found.parts, found.pointwise, found.complete) == (None, False, False)
    assert found.penalty.type == "diverged"
    with pytest.raises(ValueError, match="ended early"):
        found.split()


# ------------------------------------------------------------------------------------------------------ regularisation


@given(st.floats(0.0, 30.0))
def test_the_restitution_formulas_are_those_of_the_gaps_oscillation(ratio):
    """The oscillation is evaluated at small steps until the gap opens, and until the force vanishes."""
    assume(abs(ratio - 1) >= 0.02)  # nearly equal eigenvalues
    matrix = np.array([[0.0, 1.0], [-1.0, -2 * ratio]])
    values, vectors = np.linalg.eig(matrix + np.diag([0.0, 1e-13]))
    time = np.linspace(0, 2 * np.pi / math.sqrt(1 - ratio**2) if ratio < 0.99 else 10.0, 40_001)
    path = (vectors * np.linalg.solve(vectors, np.array([0.0, 1.0]))) @ np.exp(np.outer(values, time))
    position, rate = path.real
    released = np.flatnonzero((position + 2 * ratio * rate <= 0) & (time > 0))
    assert -rate[released[0]] == pytest.approx(restitution_without_pull(ratio), abs=1e-3)
    opened = np.flatnonzero((position <= 0) & (time > 1e-3))
    assert (-rate[opened[0]] if ratio < 0.98 else 0.0) == pytest.approx(restitution_of(ratio), abs=1e-3)


def test_restitution_without_pull_is_continuous_at_critical_damping():
    assert restitution_without_pull(1.0) == math.exp(-2)
    assert restitution_without_pull(1 - 1e-9) == pytest.approx(math.exp(-2), rel=1e-4)
    assert restitution_without_pull(1 + 1e-9) == pytest.approx(math.exp(-2), rel=1e-4)


def test_the_parts_of_the_regularisation_add_up():
    found = compared(SYSTEM, 2.76, Newmark(12000, 18, 2000))
    split = found.split()
    together = split.contact_time + split.pulling + split.damper
    assert np.abs(together - found.parts.regularisation).max() < 1e-10
    assert split.in_step
    assert split.restitution == pytest.approx(0.459, abs=1e-3)
    assert split.without_pull > split.restitution


def test_at_equal_restitution_only_the_contact_time_is_left_and_falls_as_one_over_root_K():
    left = []
    for stiffness in (1e5, 1e7):
        damping = EQUAL * math.sqrt(stiffness / 2500)
        found = compared(SYSTEM, 2.76, Newmark(stiffness, damping, 40, located=True), keep=10)
        split = found.split()
        assert found.parts.relative(split.wrong_restitution) < 1e-3
        assert found.parts.relative(split.pulling) > 0.01
        left.append(found.parts.relative(split.contact_time))
    assert left[0] / left[1] == pytest.approx(10, rel=0.3)


# --------------------------------------------------------------------------------------------------------- encounters


def test_a_lasting_contact_replaces_a_chatter():
    found = compared(SYSTEM, 1.08, Newmark(2500, 8, 2000)).encounters
    assert (found.matched + found.lost, found.matched + found.added) == (10, 3)
    assert found.phase_error < 0.01


def test_a_single_impact_is_matched_and_its_restitution_delivered():
    found = compared(SYSTEM, 2.76, Newmark(12000, 18, 200, located=True)).encounters
    assert (found.matched, found.lost, found.added) == (1, 0, 0)
    assert found.restitution == pytest.approx(restitution_of(18 / math.sqrt(12000 * SYSTEM.mass_share)), abs=0.01)


@pytest.mark.parametrize("seed", range(200))
def test_impacts_and_contacts_are_matched_where_each_is_nearest_on_the_circle_of_kept_periods(seed):
    rng = np.random.default_rng(seed)
    period, repeated, shift = (int(rng.integers(1, most)) for most in (4, 4, 3))
    keep = period * repeated
    cycle = np.sort(rng.uniform(0, period, rng.integers(3 * period)))
    cycle[: seed % 2] = 0.0  # at the seam
    impacts = ((cycle - shift) % period + period * np.arange(repeated)[:, None]).ravel()
    moved = impacts + rng.normal(0, 0.08, len(impacts))
    contacts = np.sort(np.append(moved[rng.random(len(moved)) < 0.8], rng.uniform(0, keep, rng.integers(3))) % keep)

    away = (contacts - impacts[:, None] + keep / 2) % keep - keep / 2
    far = np.abs(away)
    pairs = [(i, j) for i, j in np.argwhere(far <= 0.125) if far[i].min() == far[:, j].min() == far[i, j]]
    found = match_encounters(run_with(cycle, keep), run_with(contacts, keep), period, shift)
    counts = len(pairs), len(impacts) - len(pairs), len(contacts) - len(pairs)
    assert (found.matched, found.lost, found.added) == pytest.approx(tuple(np.array(counts) / keep))
    if pairs:
        delays = np.array([away[pair] for pair in pairs])
        assert found.delay == pytest.approx(delays.mean(), abs=1e-9)
        assert found.phase_error == pytest.approx(np.sqrt((delays**2).mean()), abs=1e-9)
    else:
        assert np.isnan([found.delay, found.phase_error]).all()


def run_with(instants, keep):
    """A run with impacts at these of its kept periods, and with nothing else."""
    run, zeros = simulate(SYSTEM, 3.25, Reference(), periods=9, keep=1), np.zeros((len(instants), 2))
    times = run.window[0] + instants * run.period
    impacts = Impacts(times, zeros[:, 0], zeros, zeros, zeros[:, 0], zeros[:, 0])
    return replace(run, keep=keep, impacts=impacts, contacts=np.empty((0, 2)), method=ExactPenalty(1e3, 1))


def test_runs_are_made_no_longer_than_until_they_repeat():
    asked = []
    base = simulate(SYSTEM, 2.76, Newmark(12000, 18, 2000), periods=2, keep=1)

    def run(name, periods, keep):
        asked.append(periods)
        rows = np.arange(keep) if (name, periods) == ("reference", 2000) else np.zeros(keep)
        return replace(base, keep=keep, section=np.column_stack([1.0 + rows] * 4))

    settled, kept = settled_length(run, 2000, 50)
    assert (settled, kept) == (max(asked), 50)
    assert len(set(asked)) == 2


# --------------------------------------------------------------------------------------------------------- statistics


def test_chaotic_motions_are_compared_by_their_sections():
    found = compared(SYSTEM, 1.7, Newmark(12000, 18, 8000))
    assert not found.pointwise
    statistics = found.statistics
    assert statistics.time_step < 3 * statistics.floor  # the distribution does not depend on the time step
    assert statistics.total > 5 * statistics.floor  # but on the restitution
    assert statistics.total > statistics.chance
    same = compared(SYSTEM, 1.7, Newmark(1e6, 0.21545 * math.sqrt(1e6 * SYSTEM.mass_share), 400, located=True))
    assert same.statistics.total < 0.5 * statistics.total


@given(st.integers(0, 2**32 - 1))
def test_the_wasserstein_distance_is_that_of_scipy(seed):
    from scipy.stats import wasserstein_distance as wasserstein  # not at the top: a second in each process

    rng = np.random.default_rng(seed)
    one, other = rng.normal(size=(50, 2)), rng.normal(1.0, 2.0, size=(50, 2))
    expected = np.mean([wasserstein(a, b) for a, b in zip(one.T, other.T, strict=True)])
    assert wasserstein_distance(one, other) == pytest.approx(expected, rel=1e-12)


def test_evidence_adds_lyapunov_exponents_and_scatter():
    found = compared(SYSTEM, 2.76, Newmark(12000, 18, 2000)).with_evidence()
    assert found.reference.lyapunov == pytest.approx(motion(SYSTEM, 2.76, Reference()).lyapunov)
    assert found.penalty.step_noise > 0
    assert np.isnan(compared(SYSTEM, 2.76, Newmark(12000, 18, 2000)).reference.lyapunov)


def test_agreement_with_another_motion_of_the_reference_is_recognised():
    """At η = 3.2 the reference has a motion of two periods, from rest, and one of six, which Newmark reaches."""
    found = compared(SYSTEM, 3.2, Newmark(2500, 8, 2000))
    assert (found.reference.period, found.motions.exact.period) == (2, 6)
    assert error_from_penalty_state(found) < 0.1 < 1.0 < found.total
    alone = compared(SYSTEM, 2.76, Newmark(12000, 18, 2000))
    assert error_from_penalty_state(alone) == pytest.approx(alone.total, rel=1e-6)
