"""The first root of a watched quantity: found, to rounding, and never an earlier one missed."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp
from vibroscope.engine.kernels.linear.first_root import (
    NONE,
    first_root,
    first_zero_by_bisection,
    first_zero_in_interval,
    to_bernstein,
)
from vibroscope.engine.kernels.linear.tables import POINTS

from tests.engine.kernels.linear_motions import TABLES, WORK, angles, kinds, size, states
from tests.share import share


def root_of(table, z, order):
    """Where the first root lies, inf if there is none in the block."""
    i, u, slope, _ = first_root(table.phase, z, order, WORK)
    return (math.inf if i == POINTS else (i + u) * table.phase.spacing), slope


def check(table, z, order, noise=1e-13):
    """No sample before the root is negative, and the root is one."""
    s, slope = root_of(table, z, order)
    scale, samples = size(table, np.array(z)), table.samples(np.array(z))
    before = np.arange(len(samples)) * (table.length / table.SAMPLES) < s
    assert samples[before].min() > -noise * scale
    if math.isfinite(s):
        assert 0 < s <= table.length
        assert abs(table.value(s, np.array(z))) < noise * scale
        assert slope <= 1e-9 * scale / table.h
    return s


@settings(max_examples=share(400))
@given(kinds, states)
def test_the_first_root_is_not_passed(kind, z):
    table = TABLES[kind]
    assume(table.row @ z + table.constant > 1e-9 * size(table, np.array(z)))
    check(table, z, 0)


def moved_exactly(table, z, s):
    """E(s) z to 30 digits."""
    with mp.workdps(30):
        return mp.expm(mp.matrix(table.a.tolist()) * mp.mpf(s)) * mp.matrix([mp.mpf(x) for x in z])


@settings(max_examples=share(20))
@given(st.floats(0.05, 3.5), st.sampled_from([1e-14, 1e-12, 1e-9, 1e-6, 1e-3]), st.floats(-3, 3), angles)
def test_a_dip_is_a_root_if_it_goes_below_zero(when, depth, speed, turn):
    """The gap turns near ``when``, ± the depth from zero: found below, passed over above."""
    table = TABLES["flight"]
    for sign in (1, -1):
        there = np.array([-1.0, speed, sign * depth, 0.0, math.cos(turn), math.sin(turn)])
        bend2 = table.value(0.0, there, derivative=2)
        z = tuple(float(x) for x in moved_exactly(table, there, -when))
        at = moved_exactly(table, z, when)  # what rounding the start has made of the dip
        dip, late = float(at[2] - at[3] ** 2 / (2 * bend2)), float(at[3]) / bend2
        rounding = 4 * 2.0**-52 * size(table, np.array(z))
        earlier = table.samples(np.array(z))[: int(when / table.length * table.SAMPLES * 0.98)]
        # there is a dip, rounding does not decide, and no other root comes first
        assume(bend2 >= 0.1 and abs(dip) >= rounding and len(earlier) > 0 and earlier.min() > 0)
        s, _ = root_of(table, z, 0)
        if dip < 0:
            fall = math.sqrt(-2 * dip / bend2)
            assert s == pytest.approx(when - late - fall, abs=fall * (rounding / -dip + 5 * fall) + 1e-15)
        else:
            assert s > when


@settings(max_examples=share(300))
@given(st.lists(st.floats(0.01, 0.99), min_size=1, max_size=6), st.floats(-12, -2), st.booleans())
def test_the_first_of_many_roots_in_one_interval_is_found(roots, exponent, paired):
    """More than one change of sign: the interval is halved until one is left, down to roots 1e-12 apart."""
    roots = sorted({round(r, 2) for r in roots})
    if paired:
        roots = sorted([*roots, roots[0] + 10.0**exponent])
    terms = np.zeros(12)
    coefficients = np.array([1.0])
    for r in roots:
        coefficients = np.convolve(coefficients, [r, -1.0])  # (r − u), in powers of u
    terms[: len(coefficients)] = coefficients
    b = np.zeros(12)
    to_bernstein(terms, b)
    u, _ = first_zero_by_bisection(terms, b, WORK)
    rounding = 64 * 2.0**-52 * np.polyval(np.abs(coefficients[::-1]), roots[0])
    slope = abs(np.prod([r - roots[0] for r in roots[1:]]))
    if slope > 10 * math.sqrt(rounding):
        assert abs(u - roots[0]) < 2 * rounding / slope
    else:  # a pair so close is known to the square root of rounding, or cannot be distinguished from a touch
        later = [r for r in roots if r > roots[0] + 0.005]
        near = 10 * math.sqrt(rounding / abs(np.prod([r - roots[0] for r in later])))
        assert abs(u - roots[0]) < near or (later and abs(u - later[0]) < 1e-5) or (u == NONE and not later)


@given(st.floats(0.05, 0.95), st.floats(-12, -1))
def test_a_touch_without_a_root_is_passed_over(where, exponent):
    terms, b = np.zeros(12), np.zeros(12)
    terms[:3] = where**2 + 10.0**exponent, -2 * where, 1.0
    to_bernstein(terms, b)
    assert first_zero_by_bisection(terms, b, WORK)[0] == NONE


STARTS = {
    1: ("flight", (-0.5, 0.3, 0.0, 1.0, 1.0, 0.0)),
    2: ("flight", (-0.7, 0.3, 0.0, 0.0, 0.0, 1.0)),
    3: ("flight", (-2 * (2.41 * 0.012 - 0.0033) * -1.0 / (2.41**2 - 1), -1.0, 0.0, 0.0, 0.0, 1.0)),
    4: ("flight, undamped", (0.0, 0.0, 0.0, 0.0, -1.0, 0.0)),
}


@pytest.mark.parametrize("order", STARTS)
def test_a_start_on_the_surface_is_not_its_own_root(order):
    """f = 0 at the start with ``order`` − 1 derivatives: the root found is the next one."""
    kind, z = STARTS[order]
    table = TABLES[kind]
    for lower in range(1, order):
        assert abs(table.value(0.0, np.array(z), derivative=lower)) < 1e-14
    assert table.value(0.0, np.array(z), derivative=order) > 0.1
    s = check(table, z, order)
    assert math.isinf(s) or s > 0.1


@pytest.mark.parametrize("exponent", range(-301, -8, 23))
@pytest.mark.parametrize("kind", ["flight", "flight, with a clearance"])
def test_a_flight_of_any_duration_keeps_its_digits(kind, exponent):
    """g = rs − as²/2 + …: ends at 2r/a."""
    table, rate = TABLES[kind], 10.0**exponent
    z = 9.0, 0.0, -table.constant, rate, 1.0, 0.0
    a = -table.value(0.0, np.array([*z[:3], 0.0, *z[4:]]), derivative=2)
    u, slope = first_zero_in_interval(table.phase, z, 1, WORK)
    assert u * table.h == pytest.approx(2 * rate / a, rel=100 * rate + 1e-14)
    assert slope == pytest.approx(-rate, rel=100 * rate + 1e-14)
