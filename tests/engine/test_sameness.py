"""Whether two solvers have the same motion: the tolerance against what it has to tell apart, on the paper's system."""

import numpy as np
import pytest
from vibroscope.engine import ExactPenalty, Reference, System, steady
from vibroscope.engine.motions.section import distance_between_solvers, same_between_solvers
from vibroscope.engine.motions.tolerances import BETWEEN_SOLVERS
from vibroscope.engine.sweeps.basin_motions import StartPlane, basin_search

SYSTEM, PENALTY = System(), ExactPenalty(12000.0, 18.0)
PLANE = StartPlane(("xi2", "v2"), ((-8.0, 8.0), (-8.0, 8.0)), (0.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize("eta", [0.6, 0.8, 1.2, 1.6, 2.0, 2.5, 2.9, 3.3, 3.6])
def test_a_penalty_model_moves_a_cycle_by_less_than_the_tolerance(eta):
    reference, penalty = steady(SYSTEM, eta, Reference()), steady(SYSTEM, eta, PENALTY)
    sections = reference.response.section, penalty.response.section
    assert 0 < distance_between_solvers(*sections, reference.period) < 0.5 * BETWEEN_SOLVERS
    assert same_between_solvers(sections[0], reference.period, sections[1], penalty.period)


def test_coexisting_cycles_of_equal_period_lie_farther_apart():
    """At η = 1.8 the reference has two of period 2, of which the penalty model has one."""
    first, second = basin_search(SYSTEM, 1.8, Reference(), PLANE, 1800, 256).motions()
    assert first.period == second.period == 2
    assert distance_between_solvers(first.section, second.section, 2) > 1.2 * BETWEEN_SOLVERS
    (penalty,) = (m for m in basin_search(SYSTEM, 1.8, PENALTY, PLANE, 1800, 256).motions() if m.period == 2)
    alike = [same_between_solvers(each.section, 2, penalty.section, 2) for each in (first, second)]
    assert sorted(alike) == [False, True]


def test_a_cycle_is_the_same_wherever_it_begins_and_another_period_is_another_motion():
    cycle = np.arange(12.0).reshape(3, 4)
    assert distance_between_solvers(cycle, np.roll(cycle, 1, axis=0), 3) == 0
    assert same_between_solvers(cycle, 3, np.roll(cycle, 2, axis=0), 3)
    assert not same_between_solvers(cycle, 3, cycle[:1], 1)


def test_irregular_motions_are_compared_by_mean_and_spread():
    rng = np.random.default_rng(0)
    one, other = rng.normal(0, 1, (400, 4)), rng.normal(0, 1, (300, 4))
    assert same_between_solvers(one, 0, other, 0)
    assert not same_between_solvers(one, 0, 3 * other, 0)
    assert not same_between_solvers(one, 0, other + 2, 0)
    assert not same_between_solvers(one, 0, other[:1], 1)
