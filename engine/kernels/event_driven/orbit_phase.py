"""A phase of given length: the state at its end and on its way, and the lowest minimum of what is watched in it.

The event loop searches for the end of a phase; an orbit's equations (:mod:`.orbit`) are given it. So the tables of
:func:`..linear.tables.tabulate_flow` are enough here.
"""

import numpy as np
from vibroscope.engine.kernels.compile.options import jit_no_alloc
from vibroscope.engine.kernels.event_driven.saltation import carry, multiply
from vibroscope.engine.kernels.event_driven.state import absolute
from vibroscope.engine.kernels.event_driven.two_stops import from_first
from vibroscope.engine.kernels.linear.cos_sin import cos_sin
from vibroscope.engine.kernels.linear.tables import (
    CURVATURE,
    GAP,
    POINTS,
    POSITION,
    POWERS,
    VALUES,
    find_powers,
    find_values,
    polynomial_at,
    state_after,
)

BACKWARDS = -3.0  # intervals that a phase can be extended before its beginning
MINIMUM_STEPS = 60  # of the search for a minimum
FINEST = 16  # halvings of the first interval of a phase


@jit_no_alloc
def relative_state(phase, y, turn):
    """z of y = (ξ₁, ξ₁′, g, g′) at a time in excitation periods."""
    c, s = cos_sin(turn - np.floor(turn))
    return y[0] - phase.position, y[1], y[2] - phase.gap, y[3], c, s


@jit_no_alloc
def state_at(phase, z, u):
    """(ξ₁, ξ₁′, g, g′) of z after u intervals, at most one."""
    first = second = third = fourth = 0.0
    for j in range(7 if phase.pulled != 0.0 else 6):
        begin = z[j] if j < 6 else phase.pulled
        value, rate = polynomial_at(phase.rows[j, POSITION:GAP], u)
        first += value * begin
        second += rate * begin
        value, rate = polynomial_at(phase.rows[j, GAP:CURVATURE], u)
        third += value * begin
        fourth += rate * begin
    return first, second / phase.spacing, third, fourth / phase.spacing


@jit_no_alloc
def advanced(phase, z, n, d):
    """z after n whole intervals, and δ with it."""
    step = POINTS
    while n > 0:
        while step > n:
            step //= 2
        z = state_after(phase, z, step)
        multiply(phase.transitions[step - 1], d)
        n -= step
    return z


@jit_no_alloc
def flow(phase, z, length, d):
    """(ξ₁, ξ₁′, g, g′) of z after a length of time, relative to the equilibrium, and δ with it.

    A length below zero extends the phase backwards, as far as the polynomials of its first interval reach.
    """
    intervals = length / phase.spacing
    n = max(int(np.floor(intervals)), 0)
    z = advanced(phase, z, n, d)
    carry(phase, d, 0, intervals - n)
    return state_at(phase, z, intervals - n)


@jit_no_alloc
def state_later(phase, y, turn, length):
    """(ξ₁, ξ₁′, g, g′) a length of time after y, which belongs to a time in excitation periods; without an event."""
    z = relative_state(phase, (y[0], y[1], y[2], y[3]), turn)
    return absolute(phase, flow(phase, z, length, None))


@jit_no_alloc
def write_section(p, phase, z, begin, end, stop, section):
    """Write the states at whole periods from ``begin`` on and before ``end``, z being that at ``begin``.

    z is seen from ``stop``, 0 or 1, what is written from the first one.
    """
    k = max(np.ceil(begin), 0.0)
    while k < min(end, float(section.shape[0])):
        u = (k - begin) * p.period / phase.spacing
        n = int(np.floor(u))
        y = from_first(absolute(phase, state_at(phase, advanced(phase, z, n, None), u - n)), stop, p.play)
        section[int(k), 0], section[int(k), 1], section[int(k), 2], section[int(k), 3] = y
        k += 1.0


@jit_no_alloc
def minimum_between(powers, low, high):
    """Where the slope of a polynomial rises through zero, −1 if it does not."""
    _, below = polynomial_at(powers, low)
    _, above = polynomial_at(powers, high)
    if not below < 0.0 < above:
        return -1.0
    for _ in range(MINIMUM_STEPS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        _, slope = polynomial_at(powers, middle)
        if slope < 0.0:
            low = middle
        else:
            high = middle
    return high


@jit_no_alloc
def lowest_in_interval(phase, z, high, scratch):
    """The minimum of the watched quantity in a share ``high`` of the interval that begins at z, and where; else inf."""
    find_powers(phase, z, scratch)
    return lowest_of_powers(phase, 0.0, high, scratch)


@jit_no_alloc
def lowest_of_powers(phase, low, high, scratch):
    """The same, where the powers of that interval are known."""
    powers = scratch.products[POWERS:POSITION]
    u = minimum_between(powers, low, high)
    if u < 0.0:
        return np.inf, 0.0
    value, _ = polynomial_at(powers, u)
    return value + phase.watched, u


@jit_no_alloc
def lowest_minimum(phase, z, length, from_zero, whole, scratch):
    """The lowest minimum of the watched quantity within a phase, its ends excepted, and its time; inf if there is none.

    A phase that is a ``whole`` cycle goes on where it ends, so that a minimum may lie there, too; but bodies at rest
    that just touch have a value of zero throughout.

    Between two of the tabulated instants there is at most one minimum, seen by their values but in the first and the
    last interval. The first interval of a phase that begins at zero (``from_zero``) may hide a rise and a dip: it is
    divided ever finer towards its beginning.
    """
    lowest, where = np.inf, 0.0
    find_powers(phase, z, scratch)
    if whole:
        value = scratch.products[POWERS] + phase.watched
        lowest = value if value != 0.0 else np.inf
    intervals = length / phase.spacing
    high = min(1.0, intervals)
    for part in range(FINEST if from_zero else 1):
        low = 0.5 * high if from_zero and part < FINEST - 1 else 0.0
        value, u = lowest_of_powers(phase, low, high, scratch)
        if value < lowest:
            lowest, where = value, u
        high = low
    last = int(np.floor(intervals))
    if last >= 1:
        value, u = lowest_in_interval(phase, advanced(phase, z, last, None), intervals - last, scratch)
        if value < lowest:
            lowest, where = value, last + u
    before, here = np.inf, np.inf  # values at the instants k − 2 and k − 1
    k, start = 0, z
    while k < last:
        find_values(phase, start, scratch)
        for j in range(min(POINTS, last - k)):
            value = scratch.products[VALUES + j] + phase.watched
            k += 1
            if before >= here <= value and k >= 2 and here < lowest + abs(lowest):
                for first in range(k - 2, k):
                    if first > 0:
                        least, u = lowest_in_interval(phase, advanced(phase, z, first, None), 1.0, scratch)
                        if least < lowest:
                            lowest, where = least, first + u
            before, here = here, value
        start = state_after(phase, start, POINTS)
    if last > 1 and before >= here and here < lowest + abs(lowest):  # no value behind the last one shows a rise
        least, u = lowest_in_interval(phase, advanced(phase, z, last - 1, None), 1.0, scratch)
        if least < lowest:
            lowest, where = least, last - 1 + u
    return lowest, where * phase.spacing
