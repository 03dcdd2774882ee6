"""A periodic orbit as a sequence of events: its equations, their derivative, and what keeps it an orbit.

The unknowns are the state y₀ = (ξ₁, ξ₁′, g, g′) at τ = 0 and the instants θ₁ … θ_m of the events, in excitation
periods. From y₀ on each phase is a linear motion in closed form that lasts until the next instant, and each event is
its reset. The equations say that the quantity watched in a phase is zero at its end, and that the state returns:

    f_k(y_k⁻, θ_k) = 0,   k = 1 … m,          y(pT) − y₀ = 0                              (52)

All of them are analytic in the unknowns and in the parameters as long as the *sequence* of events is the same, also
where an impact grazes or a flight touches, since nothing is solved for an instant: where the closing speed passes zero
the Jacobian stays regular, although the Poincaré map has no derivative there. Whether a solution is an orbit, that is
whether impacts close and nothing penetrates on the way, its margins say; where one of them passes zero, the
sequence changes. (Event times as unknowns: as in collocation for hybrid systems, e.g. VIVID, arXiv 2510.16218.)

A phase that begins with f = 0 has its own beginning as a trivial zero. The equation of its end is divided by as many
powers of its length as derivatives vanish there: one after an impact, three after a release. So a contact, or a flight,
that shrinks to nothing is followed up to that point.

With M, B, C, D the parts of the Jacobian, [[M − 1, B], [C, D]], the Jacobian of the Poincaré map is M − B D⁻¹ C.

Plain twin: the same orbits solved with many digits (tests/naive_orbit.py, tests/engine/test_branch_truth.py).
"""

import numpy as np

from ..compile.options import jit, jit_no_alloc
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
from .events import joint_force_at
from .saltation import (
    add_row,
    carry,
    carry_over_sum,
    leave_event,
    make_variation,
    multiply,
    scale_row,
    shift,
    slope_of,
)
from .setup import set_up_flow
from .state import absolute, unpack_system

# what happens at an event
IMPACT, STICK, CHATTER, RELEASE, TOUCH, PART = range(6)
UNLOAD, LOAD, LIMIT, UNLIMIT, RELAX, DAMP = range(6, 12)  # within a contact of another law: :mod:`.law_orbit`
JOINS = (STICK, CHATTER, TOUCH, UNLOAD, LOAD, LIMIT, UNLIMIT, RELAX, DAMP)  # events after which the bodies touch
ORDERS = (1, 0, 0, 3, 1, 1)  # derivatives of what is watched that vanish where the phase after an event begins
CLOSING, PARTING, FORCE, LOWEST, WHERE = range(5)  # columns of the facts of an event
FACTS = 5
DEPTH, OTHER_LOWEST, OTHER_WHERE = range(FACTS, FACTS + 3)  # further columns with another contact law
LAW_FACTS = FACTS + 3
BACKWARDS = -3.0  # intervals that a phase can be extended before its beginning
MINIMUM_STEPS = 60  # of the search for a minimum
FINEST = 16  # halvings of the first interval of a phase


@jit_no_alloc
def relative_state(p, phase, y, turn):
    """z of y = (ξ₁, ξ₁′, g, g′) at a time in excitation periods."""
    c, s = cos_sin(turn - np.floor(turn))
    first, speed = (0.0, 0.0) if p.wall else (y[0] - phase.position, y[1])
    return first, speed, y[2] - phase.gap, y[3], c, s


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
def flow(phase, z, length, d):
    """(ξ₁, ξ₁′, g, g′) of z after a length of time, and δ with it.

    A length below zero extends the phase backwards, as far as the polynomials of its first interval reach. Without δ
    the tables may be those of :func:`.setup.set_up_flow`.
    """
    longest = POINTS
    n = max(int(np.floor(length / phase.spacing)), 0)
    u = length / phase.spacing - n
    while n > 0:
        if d is None:
            while longest > n:
                longest //= 2
        step = min(n, longest)
        z = state_after(phase, z, step)
        multiply(phase.transitions[step - 1], d)
        n -= step
    carry(phase, d, 0, u)
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
def write_event_equation(p, d, y, end, kind, k, residual, jacobian):
    """Write the equation of event k at its instant ``end``, gap or contact force = 0, and its derivative."""
    row = jacobian[4 + k]
    residual[4 + k] = joint_force_at(p, y[0], y[1], end - np.floor(end)) if kind == RELEASE else y[2]
    if d is None:
        return
    if kind != RELEASE:
        for j in range(row.shape[0]):
            row[j] = d.state[2, j]
        return
    for j in range(row.shape[0]):
        row[j] = p.force_position * d.state[0, j] + p.force_velocity * d.state[1, j]
    angle = 2.0 * np.pi * end
    row[4 + k] += 2.0 * np.pi * (p.force_sine * np.cos(angle) - p.force_cosine * np.sin(angle))


@jit_no_alloc
def divide_by_length(residual, jacobian, k, order, length, begun):
    """Divide the equation of event k by a power of the length of its phase; ``begun``: derivative of its beginning."""
    row, power = jacobian[4 + k], 1.0
    for _ in range(order):
        power *= length
    value = residual[4 + k] / power
    for j in range(row.shape[0]):
        row[j] = row[j] / power + order * value / length * begun[j]
    row[4 + k] -= order * value / length
    residual[4 + k] = value


@jit_no_alloc
def write_facts(p, kind, y, end, row):
    """Write closing speed, parting speed and force of the joined bodies at an event with the state y before it."""
    row[CLOSING] = -y[3]
    row[PARTING] = y[3] if kind == PART else -p.restitution * y[3]
    row[FORCE] = joint_force_at(p, y[0], y[1] + p.mass_share * y[3], end - np.floor(end)) if p.rigid else 0.0


@jit_no_alloc
def reset(p, d, y, end, kind):
    """The state right after an event and its time in excitation periods, and δ_e with it."""
    left = p.restitution if kind in (IMPACT, CHATTER) else 0.0
    if kind in (IMPACT, STICK, CHATTER):
        gained = p.mass_share * (1.0 + left)
        add_row(d, 1, gained, 3)
        y = y[0], y[1] + gained * y[3], 0.0, -left * y[3]
        scale_row(d, 3, -left)
    elif kind == RELEASE:
        y = y[0], y[1], 0.0, 0.0
        scale_row(d, 3, 0.0)
    else:
        y = y[0], y[1], 0.0, y[3]
    scale_row(d, 2, 0.0)
    if kind != CHATTER:
        return y, end
    z = relative_state(p, p.flight, y, end)
    length, x, v = sum_up(p.flight, z, p.restitution, p.mass_share, p.scratch)
    later = end + length / p.period
    c, s = cos_sin(later - np.floor(later))
    carry_over_sum(p, d, z, length, c, s)
    return (x + p.flight.position, v, 0.0, 0.0), later


@jit_no_alloc
def start_at(p, d, unknowns, touching):
    """y₀ of the unknowns, with the derivatives of what it does not depend on set to zero."""
    if d is not None and p.wall:
        d.state[0, 0] = d.state[1, 1] = 0.0
    if d is not None and touching and p.rigid:
        d.state[2, 2] = d.state[3, 3] = 0.0
    x1, v1 = (0.0, 0.0) if p.wall else (unknowns[0], unknowns[1])
    return (x1, v1, 0.0, 0.0) if touching and p.rigid else (x1, v1, unknowns[2], unknowns[3])


@jit_no_alloc
def write_after(row, y, turn):
    """Write a state and its time in excitation periods."""
    row[0], row[1], row[2], row[3], row[4] = y[0], y[1], y[2], y[3], turn


@jit_no_alloc
def are_within(unknowns, periods):
    """Whether the unknowns are numbers, and all instants near the cycle: Newton's method may have gone astray."""
    for k in range(unknowns.shape[0]):
        if not np.isfinite(unknowns[k]) or (k >= 4 and not -1.0 <= unknowns[k] <= periods + 1.0):
            return False
    return True


@jit_no_alloc
def find_orbit(p, kinds, touching, periods, unknowns, out, d, begun):
    """Fill what :func:`orbit_equations` fills; False if a phase is too short for its tables."""
    residual, jacobian, facts, after, section = out
    m, order, turn = kinds.shape[0], 0, 0.0
    y = start_at(p, d, unknowns, touching)
    for k in range(m + 1):
        end = unknowns[4 + k] if k < m else periods
        phase = p.contact if touching else p.flight
        z, length = relative_state(p, phase, y, turn), (end - turn) * p.period
        if length < BACKWARDS * phase.spacing:
            return False
        if d is not None:
            for j in range(begun.shape[0]):
                begun[j] = d.time[j] / p.period
            leave_event(phase, d, z)
            facts[k, LOWEST], where = lowest_minimum(phase, z, length, order > 0, p.scratch)
            facts[k, WHERE] = turn + where / p.period
            write_section(p, phase, z, turn, end, section)
        x1, v1, gap, rate = flow(phase, z, length, d)
        y = absolute(phase, (x1, v1, gap, rate))
        if k == m:
            break
        if d is not None:
            c, s = cos_sin(end - np.floor(end))
            d.time[4 + k] = p.period
            shift(d, slope_of(phase, (x1, v1, gap, rate, c, s)), 1.0)
        write_event_equation(p, d, y, end, kinds[k], k, residual, jacobian)
        if order > 0:
            divide_by_length(residual, jacobian, k, order, end - turn, begun)
        write_facts(p, kinds[k], y, end, facts[k])
        y, turn = reset(p, d, y, end, kinds[k])
        write_after(after[k], y, turn)
        touching, order = kinds[k] in JOINS, ORDERS[kinds[k]]
    write_after(after[m], y, periods)
    for i in range(4):
        residual[i] = y[i] - unknowns[i]
        if d is not None:
            for j in range(unknowns.shape[0]):
                jacobian[i, j] = d.state[i, j]
            jacobian[i, i] -= 1.0
    return True


@jit_no_alloc
def orbit_equations(packed, wall, kinds, first, periods, unknowns, out, d, begun):
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
        ``residual`` (4 + m,), ``jacobian`` (4 + m, 4 + m), ``facts`` (m + 1, FACTS), ``after`` (m + 1, 5): filled, the
        first three with nan if there is no such orbit. Facts of each event: closing speed, parting speed, force of the
        joined bodies right after it, and the lowest minimum of what is watched in the phase that it ends, with its
        instant; the last row belongs to the end of the cycle. ``after``: the state right after each event and its time
        in periods, last that at the end. ``section`` (p, 4): the states at whole periods.
    d : Variation or None
        Of the 4 + m unknowns, at the start of a run; changed. With None only ``residual`` is filled.
    begun : (4 + m,) float64
        Work space.
    """
    found = are_within(unknowns, periods)
    if found:
        found = find_orbit(unpack_system(packed, wall), kinds, first, periods, unknowns, out, d, begun)
    if not found:
        residual, jacobian, facts, _, _ = out
        residual[:] = np.nan
        jacobian[:] = np.nan
        facts[:] = np.nan


@jit
def evaluate_orbit(packed, wall, kinds, first, periods, unknowns, out):
    """Call :func:`orbit_equations` with work space of its own."""
    n = unknowns.shape[0]
    orbit_equations(packed, wall, kinds, first, periods, unknowns, out, make_variation(n), np.zeros(n))


@jit
def orbit_residuals(packed, rows, rigid, wall, completion, kinds, first, periods, unknowns):
    """The residuals of the same unknowns for several rows of parameters, (k, 4 + m): for differences of these."""
    m = kinds.shape[0]
    n, touching = 4 + m, first
    for kind in kinds:
        touching |= kind in JOINS
    out = np.zeros(n), np.zeros((n, n)), np.zeros((m + 1, FACTS)), np.zeros((m + 1, 5)), np.zeros((0, 4))
    found, begun = np.empty((rows.shape[0], n)), np.zeros(n)
    for i in range(rows.shape[0]):
        set_up_flow(packed, rows[i], rigid, touching, completion)
        orbit_equations(packed, wall, kinds, first, periods, unknowns, out, None, begun)
        found[i] = out[0]
    return found
