"""Small systems of equations, and what is made of the Jacobian of an orbit, against numpy.linalg."""

import itertools

import numpy as np
import pytest
from vibroscope.engine.kernels.event_driven.orbit_steps import (
    doubling_indicator,
    monodromy_of,
    neimark_sacker_indicator,
    step_in_plane,
)
from vibroscope.engine.kernels.linear.matrices import null_vector, relative_determinant, solve


def relative(matrix):
    """Determinant over the product of the lengths of the rows."""
    return np.linalg.det(matrix) / np.prod(np.linalg.norm(matrix, axis=1))


@pytest.mark.parametrize("n", [1, 4, 5, 23])
def test_a_solution_a_determinant_and_a_null_vector_are_those_of_numpy(n):
    rng = np.random.default_rng(n)
    for _ in range(20):
        matrix, right = rng.normal(size=(n, n)), rng.normal(size=(n, 3))
        matrix[0, 0] = 0.0 if n > 1 else 2.0  # a pivot must be sought
        found = right.copy()
        solve(matrix.copy(), found)
        assert np.abs(matrix @ found - right).max() < 1e-9 * max(1.0, np.abs(found).max())
        assert abs(relative_determinant(matrix) - relative(matrix)) < 1e-13
        wide = rng.normal(size=(n, n + 1))
        vector, rows = null_vector(wide), np.linalg.svd(wide)[2]
        assert min(np.abs(vector - rows[-1]).max(), np.abs(vector + rows[-1]).max()) < 1e-11


def test_what_has_no_solution_gives_no_finite_number():
    singular, right = np.array([[1.0, 2.0], [2.0, 4.0]]), np.array([[1.0], [1.0]])
    assert relative_determinant(singular) == 0.0
    solve(singular, right)
    assert not np.isfinite(right).any()
    assert np.isnan(relative_determinant(np.array([[1.0, np.nan], [0.0, 1.0]])))
    assert np.isnan(null_vector(np.array([[1.0, np.inf]]))).all()


def test_indicators_change_their_sign_with_the_multipliers():
    rng = np.random.default_rng(8)
    for _ in range(20):
        jacobian = rng.normal(size=(7, 7))
        monodromy = monodromy_of(jacobian)
        events, corner = jacobian[4:, 4:], jacobian[:4, :4] + np.eye(4)
        expected = corner - jacobian[:4, 4:] @ np.linalg.solve(events, jacobian[4:, :4])
        assert np.abs(monodromy - expected).max() < 1e-11 * max(1.0, np.abs(expected).max())
        values, sign = np.linalg.eigvals(expected), np.sign(np.linalg.det(events))
        pairs = np.prod([1 - a * b for a, b in itertools.combinations(values, 2)]).real
        assert np.sign(neimark_sacker_indicator(jacobian)) == sign * np.sign(pairs)
        assert np.sign(doubling_indicator(jacobian)) == sign * np.sign(np.prod(values + 1).real)


def test_a_step_in_a_plane_ends_in_it_and_corrects_the_slope_by_what_was_missed():
    rng = np.random.default_rng(9)
    jacobian, slope, right, row = rng.normal(size=(4, 4)), rng.normal(size=4), rng.normal(size=4), rng.normal(size=5)
    x, scales, step = np.zeros(5), rng.uniform(0.5, 2.0, 5), np.zeros((5, 1))
    guess = slope * 1.05
    for _ in range(30):
        residual = jacobian @ x[:4] + slope * x[4] - right
        length = step_in_plane((residual, jacobian), scales, (row, 0.7), x, guess, step)
    assert length < 1e-12
    assert abs(row @ x - 0.7) < 1e-12
    assert np.abs(jacobian @ x[:4] + slope * x[4] - right).max() < 1e-12
