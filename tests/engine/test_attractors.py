"""Coexisting motions: found from many starts, the same ones each time, and each confirmed by a long run."""

from dataclasses import replace

import numpy as np
import pytest
from vibroscope.engine import Cancelled, ExactPenalty, Newmark, Reference, System, attractors, simulate
from vibroscope.engine.motions.description import Kind
from vibroscope.engine.motions.search import KnownMotion, apart, random_states

from tests.share import every

SYSTEM = System()


def distance(section, points):
    """Distance from the last row of a section to the nearest of some points."""
    return np.abs(points - section[-1]).max(axis=1).min()


@pytest.mark.parametrize(
    "system", [SYSTEM, System(clearance=0.3), System(clearance=-0.2), System(wall=True, clearance=0.5)]
)
def test_random_starts_have_the_bodies_apart_and_stay_where_they_are(system):
    drawn = random_states(np.random.default_rng(1), 500, np.array([2.0, 3.0]))
    found = apart(system, drawn)
    assert system.overlaps_of(drawn).any()
    assert not system.overlaps_of(found).any()
    assert np.array_equal(apart(system, found), found)
    assert np.array_equal(found[0], apart(system, drawn[0]))


def test_two_cycles_coexist_at_eta_3_2():
    found = attractors(SYSTEM, 3.2, Reference())
    assert [(each.motion.type, each.motion.period) for each in found] == [("periodic", 6), ("periodic", 2)]
    assert sum(each.share for each in found) == 1
    for each in found:
        assert each.share > 0.1
        assert np.abs(each.motion.multipliers).max() < 1
        long = simulate(SYSTEM, 3.2, Reference(), periods=20_000, keep=12, initial=each.start)
        assert distance(long.section, each.motion.section) < 1e-8
    first, second = (each.motion.section for each in found)
    assert distance(second, first) > 0.01


def test_cycles_that_lie_close_together_are_distinguished():
    """At η = 3.22 two cycles of 6 periods, with 14 and with 15 impacts, come within 1e-3 of each other."""
    found = attractors(SYSTEM, 3.22, Reference())
    impacts = sorted((each.motion.period, round(each.motion.impacts_per_period * 6)) for each in found)
    assert impacts == [(2, 3), (6, 14), (6, 15)]


@pytest.mark.parametrize(
    ("eta", "method", "name"),
    every(
        [
            (1.70, Reference(), "chaotic"),
            (1.70, Newmark(12000, 18, 2000), "chaotic"),
            (2.88, Reference(), "quasi-periodic"),
            (1.08, ExactPenalty(2500, 8), "periodic"),
        ]
    ),
)
def test_one_motion_is_found_once(eta, method, name):
    (found,) = attractors(SYSTEM, eta, method, starts=5)
    assert (found.motion.type, found.share) == (name, 1)


def test_time_step_scatter_is_not_counted_as_attractors():
    found = attractors(SYSTEM, 2.76, Newmark(12000, 18, 2000))
    assert [each.motion.period for each in found] == [1, 2]
    exact = attractors(SYSTEM, 2.76, ExactPenalty(12000, 18))
    assert {each.motion.period for each in exact} == {1, 2}  # the second motion exists without a time step


def test_starts_that_diverge_are_one_of_the_attractors():
    found = attractors(SYSTEM, 2.76, Newmark(1e9, 1e3, 20), starts=4)
    assert [(each.motion.type, each.share) for each in found] == [("diverged", 1)]


def test_the_same_seed_gives_the_same_starts_and_shares():
    first, again, other = (attractors(SYSTEM, 3.2, Reference(), starts=12, seed=seed) for seed in (1, 1, 2))
    assert [(each.share, *each.start) for each in first] == [(each.share, *each.start) for each in again]
    assert [tuple(each.start) for each in first] != [tuple(each.start) for each in other]


def test_progress_is_reported_and_the_search_can_be_cancelled():
    reported = []
    attractors(SYSTEM, 1.08, Reference(), starts=3, progress=reported.append)
    assert reported == [1, 2, 3]
    with pytest.raises(Cancelled):
        attractors(SYSTEM, 1.08, Reference(), cancelled=lambda: len(reported) > 0)
    with pytest.raises(ValueError, match="starts = 0"):
        attractors(SYSTEM, 1.08, Reference(), starts=0)


def test_a_cycle_that_the_step_scatters_from_one_start_and_locks_from_another_is_listed_once():
    """Of three motions that were listed, two were one: both tend to the same cycle without a time step."""
    found = attractors(System(), 3.2, Newmark(2500, 8, 4000), starts=24)
    assert sorted(each.motion.period for each in found) == [2, 6]


def test_a_motion_tends_to_another_where_both_have_the_same_limit():
    cycle = np.array([[0.1, 0.2, 0.3, 0.4], [0.5, 0.6, 0.7, 0.8]])
    known = KnownMotion(Kind.PERIODIC, 2, cycle, limit=cycle)
    assert known.tends_to(replace(known, limit=cycle[::-1]))
    for other in (replace(known, limit=None), replace(known, limit=-cycle), replace(known, period=1)):
        assert not known.tends_to(other)
        assert not other.tends_to(known)
