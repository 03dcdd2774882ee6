"""Tables of a phase are those of another exponential, and bound the curvature between their instants."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp
from scipy.linalg import expm
from vibroscope.engine.kernels.linear import tables
from vibroscope.engine.kernels.linear.cos_sin import cos_sin
from vibroscope.engine.kernels.linear.tables import curvature_bound

from tests.engine.kernels.linear_motions import TABLES, kinds, states
from tests.share import share


@pytest.mark.parametrize("kind", TABLES)
def test_tables_are_those_of_another_exponential(kind):
    table = TABLES[kind]
    for j in (1, 2, 7, 31, 64):
        exact = expm(table.a * (j * table.h))
        # entries of a stiff contact differ in size by K: each is judged by what its row and column hold
        scale = np.sqrt(np.abs(exact).max(axis=1)[:, None] * np.abs(exact).max(axis=0)[None, :])
        assert (np.abs(table.phase.transitions[j - 1] - exact) < 1e-13 * scale + 1e-15).all()
        values = table.phase.rows[:6, tables.VALUES + j - 1]
        np.testing.assert_allclose(values, table.row @ exact, atol=1e-13 * np.abs(table.row @ exact).max())
    powers = table.phase.rows[:6, tables.POWERS : tables.POSITION]
    for u in (0.25, 0.5, 1.0):
        exact = table.row @ expm(table.a * (u * table.h))
        np.testing.assert_allclose(powers @ u ** np.arange(12), exact, atol=1e-14 * np.abs(exact).max())


@settings(max_examples=share(200))
@given(kinds, states, st.floats(0.0, 1.0))
def test_the_curvature_bound_holds_everywhere(kind, z, where):
    table = TABLES[kind]
    curvature = abs(table.value(where * table.length, np.array(z), derivative=2))
    assert curvature * table.h**2 / 8 <= curvature_bound(table.phase, z) * (1 + 1e-12) + 1e-300


@given(st.floats(0.0, 1.0, exclude_max=True))
def test_cosine_and_sine_are_exact_to_rounding(share):
    c, s = cos_sin(share)
    with mp.workdps(30):
        assert abs(c - mp.cospi(2 * mp.mpf(share))) < 2 * 2.0**-52
        assert abs(s - mp.sinpi(2 * mp.mpf(share))) < 2 * 2.0**-52
