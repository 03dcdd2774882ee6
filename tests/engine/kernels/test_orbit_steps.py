"""Prediction along a curve, and what margins are made of, against plain twins."""

import numpy as np
from vibroscope.engine.kernels.event_driven.orbit import CHATTER, FACTS, FORCE, IMPACT, PARTING, STICK
from vibroscope.engine.kernels.event_driven.orbit_steps import (
    BEGINS,
    ENDS,
    LENGTH,
    impact_that_may_stick,
    interpolated,
    margin_values,
)

RANDOM = np.random.default_rng(5)


def test_a_polynomial_is_predicted_from_points_and_tangents():
    # of degree 4, through three points, at two of which the tangent is known; s is the first component
    powers = RANDOM.normal(size=(5, 3))
    powers[:, 0] = [0.0, 1.0, 0.0, 0.0, 0.0]
    slopes = powers[1:] * np.arange(1, 5)[:, None]
    nodes = np.array([0.0, -0.3, 0.5])
    values = np.array([[np.polyval(column[::-1], s) for column in powers.T] for s in nodes])
    along = np.array([[np.polyval(column[::-1], s) for column in slopes.T] for s in nodes])
    along *= np.array([1.0, -2.5, np.nan])[:, None]  # of any length and sense
    found = interpolated(nodes, values, along, np.array([1.0, 0.0, 0.0]), 0.8)
    np.testing.assert_allclose(found, [np.polyval(column[::-1], 0.8) for column in powers.T], rtol=1e-13)


def test_margins_are_of_facts_lengths_and_what_lets_an_impact_stick():
    facts, instants, threshold = RANDOM.normal(size=(4, FACTS)), np.array([0.1, 0.4, 0.9]), 0.2
    conditions = np.array([[0, 3, 2, 1, 1], [2, 4, LENGTH, BEGINS, ENDS]])
    begins = max(facts[1, PARTING] - threshold, -facts[1, FORCE])
    expected = [facts[0, 2], facts[3, 4], instants[2] - instants[1], begins, -begins]
    np.testing.assert_array_equal(margin_values(facts, instants, threshold, conditions), expected)


def test_an_impact_may_stick_between_orbits_where_it_does_not_for_different_reasons():
    kinds = np.array([IMPACT, STICK, CHATTER, IMPACT, IMPACT, IMPACT])
    before, after = np.zeros((2, 7, FACTS))
    before[:, FORCE] = after[:, FORCE] = 1.0
    before[:, PARTING] = 2.0
    after[:, FORCE] = -1.0
    before[3, FORCE] = -1.0  # pulled at both
    after[4, PARTING] = 2.0  # fast at both
    assert impact_that_may_stick(kinds, before, after, 1.0, 0) == 0
    assert impact_that_may_stick(kinds, before, after, 1.0, 1) == 5
    assert impact_that_may_stick(kinds, before, after, 1.0, 6) == -1
