"""Uncertainty exponent and dimension of boundaries that are known."""

import numpy as np
import pytest
from vibroscope.engine.sweeps.basin_study import boundary, share_error

CELLS = 243


def cantor_stripes(cells, levels=20):
    """Stripes between the points of the middle-third Cantor set: a boundary of dimension 1 + log 2/log 3."""
    rest, stripes = (np.arange(cells) + np.sqrt(0.5)) / cells, np.zeros(cells, int)
    for level in range(1, levels + 1):
        digit, rest = np.divmod(3 * rest, 1)
        stripes[(stripes == 0) & (digit == 1)] = level
    return np.tile(stripes, (cells, 1))


def test_a_straight_boundary_has_dimension_one():
    x, y = np.meshgrid(np.arange(CELLS), np.arange(CELLS), indexing="ij")
    found = boundary((2 * x + y > 1.3 * CELLS).astype(int))
    assert found.dimension == pytest.approx(1, abs=0.03)
    assert found.exponent == pytest.approx(2 - found.dimension)
    assert found.error < 0.05


def test_stripes_of_a_cantor_set_have_its_dimension():
    found = boundary(cantor_stripes(CELLS))
    assert found.dimension == pytest.approx(1 + np.log(2) / np.log(3), abs=3 * found.error)
    assert 0 < found.error < 0.06


def test_noise_has_the_dimension_of_the_plane():
    found = boundary(np.random.default_rng(0).integers(0, 2, (CELLS, CELLS)))
    assert found.dimension == pytest.approx(2, abs=0.01)


def test_cells_without_a_motion_make_no_pair():
    x, y = np.meshgrid(np.arange(128), np.arange(128), indexing="ij")
    motion = (x > 40).astype(int)
    motion[y < x] = -4
    assert boundary(motion).dimension == pytest.approx(1, abs=0.1)
    motion[motion == 1] = 0
    assert np.isnan(boundary(motion).dimension)
    motion = np.where(x > 40, 1, 0)
    motion[(x > 36) & (x <= 42)] = -4  # over the gap only pairs 8 and 16 cells apart differ: too few for a fit
    assert np.isnan(boundary(motion)).all()


@pytest.mark.parametrize("shape", [(1, 1), (2, 200), (20, 20)])
def test_too_few_cells_have_no_dimension(shape):
    motion = np.indices(shape).sum(axis=0) % 2
    assert np.isnan(boundary(motion)).all()


def test_the_error_of_a_share():
    assert share_error(0.5, 100) == pytest.approx(0.05)
    assert share_error(0.0, 100) == 0
    assert np.isnan(share_error(0.0, 0))
