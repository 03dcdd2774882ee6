"""The rules by which recommended settings are chosen: neighbours, the errors that count, and the front."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from vibroscope.engine.recommendation.contact_search import monotone_front, pareto_front
from vibroscope.engine.recommendation.trials import NewmarkSetting, Trial, neighbourhood, tolerant_maximum


def test_the_tolerant_maximum_ignores_the_largest_tenth():
    errors = [0.1 * i for i in range(10)]
    assert tolerant_maximum(errors, 10) == pytest.approx(0.8)
    assert tolerant_maximum([*errors[:9], math.inf], 10) == pytest.approx(0.8)
    assert tolerant_maximum(errors, 10, bound=0.75) == math.inf
    asked = iter([2.0, 2.0, 0.0])
    assert tolerant_maximum(asked, 10, bound=1.0) == math.inf
    assert next(asked) == 0.0  # two of ten missed: no more were asked for


@given(st.integers(4, 100_000))
def test_neighbours_are_evenly_spread_within_their_ranges(steps):
    around = list(neighbourhood(NewmarkSetting(1000.0, 5.0, steps), range(1, 40)))
    most = max(1, round(0.02 * steps))
    assert all(one.steps >= 4 and abs(one.steps - steps) <= most for one in around)
    assert all(abs(one.stiffness / 1000 - 1) <= 0.01 and abs(one.damping / 5 - 1) <= 0.01 for one in around)
    if most >= 10:
        assert abs(np.mean([one.steps - steps for one in around])) <= 0.1 * most
    assert len(set(around)) == 39


trials = st.builds(
    lambda steps, error, luck, more: Trial(NewmarkSetting(1.0, 1.0, steps), error, error * luck, steps + more),
    st.integers(4, 60),
    st.floats(0.01, 1.0),
    st.floats(1.0, 3.0),
    st.integers(0, 20),
)


@given(st.lists(trials, min_size=1, max_size=12))
def test_a_pareto_front_holds_exactly_what_no_trial_beats(found):
    front = pareto_front(found)
    for trial in found:
        beaten = any(t.cost <= trial.cost and t.robust <= trial.robust and t != trial for t in front)
        assert beaten or trial in front
    for through in found:  # of those that meet a tolerance, one that another one beats may have the right motion
        chain = monotone_front(front, through)
        assert through in chain
        for one, other in itertools.pairwise(chain):
            assert one.cost < other.cost
            assert one.setting.steps < other.setting.steps
            assert one.error > other.error
            assert one.robust > other.robust or through not in front
