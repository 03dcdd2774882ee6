"""A periodic orbit as a sequence of events: its equations, their derivative, and what keeps it an orbit.

The unknowns are the state y₀ = (ξ₁, ξ₁′, g, g′) at τ = 0 and the instants θ₁ … θ_m of the events, in excitation
periods. From y₀ on each phase is a linear motion in closed form that lasts until the next instant, and each event is
its reset. The equations say that the quantity watched in a phase is zero at its end, and that the state returns:

    f_k(y_k⁻, θ_k) = 0,   k = 1 … m,          y(pT) − y₀ = 0                              (52)

All of them are analytic in the unknowns and in the parameters as long as the *sequence* of events is the same, also
where an impact grazes or a flight touches, since nothing is solved for an instant: where the closing speed passes zero
the Jacobian stays regular, although the Poincaré map has no derivative there. Whether a solution is an orbit, that is
whether impacts close and nothing penetrates on the way, is told by its margins; where one of them passes zero, the
sequence changes. (Event times as unknowns: as in collocation for hybrid systems, e.g. VIVID, arXiv 2510.16218.)

A phase that begins with f = 0 has its own beginning as a trivial zero. The equation of its end is divided by as many
powers of its length as derivatives vanish there: one after an impact, three after a release. So a contact, or a flight,
that shrinks to nothing is followed up to that point.

With M, B, C, D the parts of the Jacobian, [[M − 1, B], [C, D]], the Jacobian of the Poincaré map is M − B D⁻¹ C.
"""

import numpy as np

from ..compile.options import jit_no_alloc
from ..linear.cos_sin import cos_sin
from ..linear.tables import (
    CURVATURE,
    GAP,
    POINTS,
    POSITION,
    POWERS,
    VALUES,
    find_values,
    find_watched,
    polynomial_at,
    state_after,
)
from .chatter import sum_up
from .events import other_force
from .saltation import slope_of
from .state import absolute, unpack_system

# what happens at an event
IMPACT, STICK, CHATTER, RELEASE, TOUCH, PART = range(6)
CLOSING, PARTING, FORCE, LOWEST, WHERE = range(5)  # columns of the facts of an event
FACTS = 5
BACKWARDS = -3.0  # intervals that a phase can be extended before its beginning
DIFFERENCE = 1e-5  # relative, of central differences of a chatter's sum
MINIMUM_STEPS = 60  # of the search for a minimum
FINEST = 16  # halvings of the first interval of a phase


@jit_no_alloc
def relative_state(p, phase, y, turn):
    """z of y = (ξ₁, ξ₁′, g, g′) at a time in excitation periods."""
    c, s = cos_sin(turn - np.floor(turn))
    first, speed = (0.0, 0.0) if p.wall else (y[0] - phase.position, y[1])
    return first, speed, y[2] - phase.gap, y[3], c, s


@jit_no_alloc
def multiply_columns(matrix, d):
    """Multiply the (4, n) matrix d by the upper left part of a matrix, in place."""
    for k in range(d.shape[1]):
        a, b, g, r = d[0, k], d[1, k], d[2, k], d[3, k]
        for i in range(4):
            d[i, k] = matrix[i, 0] * a + matrix[i, 1] * b + matrix[i, 2] * g + matrix[i, 3] * r


@jit_no_alloc
def state_at(phase, z, u):
    """(ξ₁, ξ₁′, g, g′) of z after u intervals, at most one."""
    first = second = third = fourth = 0.0
    for j in range(6):
        value, rate = polynomial_at(phase.rows[j, POSITION:GAP], u)
        first += value * z[j]
        second += rate * z[j]
        value, rate = polynomial_at(phase.rows[j, GAP:CURVATURE], u)
        third += value * z[j]
        fourth += rate * z[j]
    return first, second / phase.spacing, third, fourth / phase.spacing


@jit_no_alloc
def advanced(phase, z, n):
    """z after n whole intervals."""
    while n > 0:
        step = min(n, POINTS)
        z = state_after(phase, z, step)
        n -= step
    return z


@jit_no_alloc
def state_later(packed, wall, touching, y, turn, length):
    """(ξ₁, ξ₁′, g, g′) at a length of time after y, which belongs to a time in excitation periods; without an event."""
    p = unpack_system(packed, wall)
    phase = p.contact if touching else p.flight
    n = max(int(np.floor(length / phase.spacing)), 0)
    z = advanced(phase, relative_state(p, phase, (y[0], y[1], y[2], y[3]), turn), n)
    return absolute(phase, state_at(phase, z, length / phase.spacing - n))


@jit_no_alloc
def write_section(p, phase, z, begin, end, section):
    """The states at whole periods from ``begin`` on and before ``end``, z being that at ``begin``."""
    k = max(np.ceil(begin), 0.0)
    while k < min(end, float(section.shape[0])):
        u = (k - begin) * p.period / phase.spacing
        n = int(np.floor(u))
        y = absolute(phase, state_at(phase, advanced(phase, z, n), u - n))
        section[int(k), 0], section[int(k), 1], section[int(k), 2], section[int(k), 3] = y
        k += 1.0


@jit_no_alloc
def flow(phase, z, length, d, matrix):
    """(ξ₁, ξ₁′, g, g′) of z after a length of time, and d with it.

    A length below zero extends the phase backwards, as far as the polynomials of its first interval reach.
    """
    n = max(int(np.floor(length / phase.spacing)), 0)
    u = length / phase.spacing - n
    while n > 0:
        step = min(n, POINTS)
        z = state_after(phase, z, step)
        multiply_columns(phase.transitions[step - 1], d)
        n -= step
    for j in range(4):
        matrix[0, j], rate = polynomial_at(phase.rows[j, POSITION:GAP], u)
        matrix[1, j] = rate / phase.spacing
        matrix[2, j], rate = polynomial_at(phase.rows[j, GAP:CURVATURE], u)
        matrix[3, j] = rate / phase.spacing
    multiply_columns(matrix, d)
    return state_at(phase, z, u)


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
def lowest_in_interval(phase, z, low, high, scratch):
    """The minimum of the watched quantity between two shares of the interval that begins at z, and where; else inf."""
    find_watched(phase, z, scratch)
    powers = scratch.products[POWERS:POSITION]
    u = minimum_between(powers, low, high)
    if u < 0.0:
        return np.inf, 0.0
    value, _ = polynomial_at(powers, u)
    return value + phase.watched, u


@jit_no_alloc
def lowest_minimum(phase, z, length, from_zero, scratch):
    """The lowest minimum of the watched quantity within a phase, its ends excepted, and its time; inf if there is none.

    Between two of the tabulated instants there is at most one minimum, seen by their values but in the first and the
    last interval. The first interval of a phase that begins at zero (``from_zero``) may hide a rise and a dip: it is
    divided ever finer towards its beginning.
    """
    lowest, where = np.inf, 0.0
    intervals = length / phase.spacing
    high = min(1.0, intervals)
    for part in range(FINEST if from_zero else 1):
        low = 0.5 * high if from_zero and part < FINEST - 1 else 0.0
        value, u = lowest_in_interval(phase, z, low, high, scratch)
        if value < lowest:
            lowest, where = value, u
        high = low
    last = int(np.floor(intervals))
    if last >= 1:
        value, u = lowest_in_interval(phase, advanced(phase, z, last), 0.0, intervals - last, scratch)
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
                        least, u = lowest_in_interval(phase, advanced(phase, z, first), 0.0, 1.0, scratch)
                        if least < lowest:
                            lowest, where = least, first + u
                find_values(phase, start, scratch)
            before, here = here, value
        start = state_after(phase, start, POINTS)
    return lowest, where * phase.spacing


@jit_no_alloc
def force_on(p, y, turn):
    """Contact force of joined bodies."""
    return p.force_position * y[0] + p.force_velocity * y[1] + other_force(p, turn - np.floor(turn))


@jit_no_alloc
def summed_chatter(p, x1, v1, rate, turn):
    """Duration of the chatter that begins with a parting rate, and ξ₁ and ξ₁′ at its end."""
    z = relative_state(p, p.flight, (x1, v1, 0.0, rate), turn)
    s, x, v = sum_up(p.flight, z, p.restitution, p.mass_share, p.scratch)
    return s, x + p.flight.position, v


@jit_no_alloc
def carry_over_sum(p, y, turn, d, t_row):
    """The state after a summed chatter and its duration; d and t_row, of its end, with them, by central differences."""
    x1, v1, _, rate = y
    s, x, v = summed_chatter(p, x1, v1, rate, turn)
    reach = max(abs(x1), abs(v1), abs(rate), 1e-300) * DIFFERENCE
    small, bit = abs(rate) * DIFFERENCE, DIFFERENCE
    above = summed_chatter(p, x1 + reach, v1, rate, turn), summed_chatter(p, x1, v1 + reach, rate, turn)
    below = summed_chatter(p, x1 - reach, v1, rate, turn), summed_chatter(p, x1, v1 - reach, rate, turn)
    faster, slower = summed_chatter(p, x1, v1, rate + small, turn), summed_chatter(p, x1, v1, rate - small, turn)
    later, sooner = summed_chatter(p, x1, v1, rate, turn + bit), summed_chatter(p, x1, v1, rate, turn - bit)
    for k in range(d.shape[1]):
        a, b, c, t = (
            d[0, k] / (2 * reach),
            d[1, k] / (2 * reach),
            d[3, k] / (2 * small),
            t_row[k] / (2 * bit * p.period),
        )
        t_row[k] += (
            (above[0][0] - below[0][0]) * a
            + (above[1][0] - below[1][0]) * b
            + (faster[0] - slower[0]) * c
            + (later[0] - sooner[0]) * t
        )
        d[0, k] = (
            (above[0][1] - below[0][1]) * a
            + (above[1][1] - below[1][1]) * b
            + (faster[1] - slower[1]) * c
            + (later[1] - sooner[1]) * t
        )
        d[1, k] = (
            (above[0][2] - below[0][2]) * a
            + (above[1][2] - below[1][2]) * b
            + (faster[2] - slower[2]) * c
            + (later[2] - sooner[2]) * t
        )
        d[2, k] = d[3, k] = 0.0
    return (x, v, 0.0, 0.0), s


@jit_no_alloc
def orbit_equations(packed, wall, kinds, first, periods, unknowns, out, work):
    """Evaluate the equations of an orbit and their Jacobian.

    Parameters
    ----------
    packed : (n,) float64
        A :class:`.state.HybridSystem`.
    wall : AT_WALL or TWO_BODIES
    kinds : (m,) int64
        What happens at each event, in the order of time.
    first : bool
        Whether the bodies touch at τ = 0.
    periods : float
        Excitation periods after which the orbit returns.
    unknowns : (4 + m,) float64
        y₀, then the instants in excitation periods.
    out : tuple
        ``residual`` (4 + m,), ``jacobian`` (4 + m, 4 + m), ``facts`` (m + 1, FACTS), ``after`` (m + 1, 5): filled.
        Facts of each event: closing speed, parting speed, force of the joined bodies right after it, and the lowest
        minimum of what is watched in the phase that it ends, with its instant; the last row belongs to the end of the
        cycle. ``after``: the state right after each event and its time in periods, last that at the end. ``section``
        (p, 4): the states at whole periods.
    work : tuple
        (4, 4 + m), (4 + m,) and (4, 4) of work space.
    """
    p = unpack_system(packed, wall)
    residual, jacobian, facts, after, section = out
    d, t_row, matrix = work
    m = kinds.shape[0]
    n = 4 + m
    period = p.period
    for k in range(n):  # Newton's method may have gone astray
        outside = k >= 4 and not -1.0 <= unknowns[k] <= periods + 1.0
        if outside or not np.isfinite(unknowns[k]):
            residual[:] = np.nan
            jacobian[:] = np.nan
            facts[:] = np.nan
            return
    for k in range(n):
        t_row[k] = 0.0
        for i in range(4):
            d[i, k] = 1.0 if i == k else 0.0
    y = unknowns[0], unknowns[1], unknowns[2], unknowns[3]
    if p.wall:
        d[0, 0] = d[1, 1] = 0.0
        y = 0.0, 0.0, y[2], y[3]
    touching, order = first, 0
    if touching and p.rigid:
        d[2, 2] = d[3, 3] = 0.0
        y = y[0], y[1], 0.0, 0.0
    turn = 0.0  # where the phase begins, in periods
    for k in range(m + 1):
        end = unknowns[4 + k] if k < m else periods
        phase = p.contact if touching else p.flight
        z = relative_state(p, phase, y, turn)
        slope = slope_of(phase, z)
        for j in range(n):
            for i in range(4):
                d[i, j] -= slope[i] * t_row[j]
        length = (end - turn) * period
        if length < BACKWARDS * phase.spacing:
            residual[:] = np.nan
            jacobian[:] = np.nan
            facts[:] = np.nan
            return
        facts[k, LOWEST], where = lowest_minimum(phase, z, length, order > 0, p.scratch)
        facts[k, WHERE] = turn + where / period
        write_section(p, phase, z, turn, end, section)
        x1, v1, gap, rate = flow(phase, z, length, d, matrix)
        c, s = cos_sin(end - np.floor(end))
        slope = slope_of(phase, (x1, v1, gap, rate, c, s))
        y = absolute(phase, (x1, v1, gap, rate))
        if k == m:
            break
        for i in range(4):
            d[i, 4 + k] += slope[i] * period
        # the equation of the event
        row = jacobian[4 + k]
        if kinds[k] == RELEASE:
            value = force_on(p, y, end)
            angle = 2.0 * np.pi * end
            turning = 2.0 * np.pi * (-p.force_cosine * np.sin(angle) + p.force_sine * np.cos(angle))
            for j in range(n):
                row[j] = p.force_position * d[0, j] + p.force_velocity * d[1, j]
            row[4 + k] += turning
        else:
            value = y[2]
            for j in range(n):
                row[j] = d[2, j]
        if order > 0:
            power = 1.0
            for _ in range(order):
                power *= end - turn
            value /= power
            for j in range(n):
                row[j] = row[j] / power + order * value / (end - turn) * t_row[j] / period
            row[4 + k] -= order * value / (end - turn)
        residual[4 + k] = value
        for j in range(n):
            t_row[j] = 0.0
        t_row[4 + k] = period
        # its reset
        kind, turn = kinds[k], end
        facts[k, CLOSING] = -y[3]
        facts[k, PARTING] = y[3] if kind == PART else -p.restitution * y[3]
        common = y[0], y[1] + p.mass_share * y[3], 0.0, 0.0
        facts[k, FORCE] = force_on(p, common, end) if p.rigid else 0.0
        for j in range(n):
            d[2, j] = 0.0
        if kind in (IMPACT, CHATTER):
            for j in range(n):
                d[1, j] += p.mass_share * (1.0 + p.restitution) * d[3, j]
                d[3, j] *= -p.restitution
            y = y[0], y[1] + p.mass_share * (1.0 + p.restitution) * y[3], 0.0, -p.restitution * y[3]
            touching, order = False, 1
            if kind == CHATTER:
                y, s = carry_over_sum(p, y, end, d, t_row)
                turn = end + s / period
                touching, order = True, 0
        elif kind == STICK:
            for j in range(n):
                d[1, j] += p.mass_share * d[3, j]
                d[3, j] = 0.0
            y = common
            touching, order = True, 0
        elif kind == RELEASE:
            for j in range(n):
                d[3, j] = 0.0
            y = y[0], y[1], 0.0, 0.0
            touching, order = False, 3
        else:
            y = y[0], y[1], 0.0, y[3]
            touching, order = kind == TOUCH, 1
        after[k, 0], after[k, 1], after[k, 2], after[k, 3], after[k, 4] = y[0], y[1], y[2], y[3], turn
    after[m, 0], after[m, 1], after[m, 2], after[m, 3], after[m, 4] = y[0], y[1], y[2], y[3], periods
    for i in range(4):
        residual[i] = y[i] - unknowns[i]
        for j in range(n):
            jacobian[i, j] = d[i, j]
        jacobian[i, i] -= 1.0
