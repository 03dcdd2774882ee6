"""Double-double matrices against mpmath."""

import numpy as np
from mpmath import mp
from vibroscope.engine import ExactPenalty, System
from vibroscope.engine.drivers.parameters import parameters_of
from vibroscope.engine.kernels.equations.motion import pressed_generator
from vibroscope.engine.kernels.linear.double_double import exponential, quick_exponential
from vibroscope.engine.kernels.linear.tables import full_generator

STIFF = System(), 2.76, ExactPenalty(1e8, 3e4)


def exact(pair):
    """The numbers of a (2, 6, 6) double-double matrix."""
    high, low = (mp.matrix(part.tolist()) for part in pair)
    return high + low


def error_of(a, h, found):
    """The largest error of an exponential."""
    with mp.workdps(50):
        right = mp.expm(mp.matrix(a.tolist()) * mp.mpf(h))
        error = exact(found) - right
        return max(abs(error[i, j]) / max(1, abs(right[i, j])) for i in range(6) for j in range(6))


def test_an_exponential_has_twice_the_digits():
    a = full_generator(pressed_generator(parameters_of(*STIFF)), 2.76)
    h = 0.5 / np.abs(a).sum(axis=1).max()
    assert error_of(a, h, exponential(a, h, 24)) < 1e-28


def test_a_quick_exponential_of_a_small_matrix_has_more_digits_than_a_power_of_it_needs():
    a = full_generator(pressed_generator(parameters_of(*STIFF)), 2.76)
    h = 0.15 / np.abs(a).sum(axis=1).max()
    assert 64 * error_of(a, h, quick_exponential(a, h, 12, 4)) < 0.01 * 2.0**-52
