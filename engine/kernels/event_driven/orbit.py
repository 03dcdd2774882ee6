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
that shrinks to nothing is followed up to that point. Within the first interval of its tables f is a polynomial: there
the quotient is that of its terms, which rounding leaves as it is however short the phase.

Between two stops each event belongs to one of them, and the state after it is seen from that one (:mod:`.two_stops`): a
flight that ends at the other stop is mirrored there. In a flight the least gaps of both stops are margins. Unknowns and
states that are returned are those seen from the first stop.

With M, B, C, D the parts of the Jacobian, [[M − 1, B], [C, D]], the Jacobian of the Poincaré map is M − B D⁻¹ C.

Plain twin: the same orbits solved with many digits (tests/naive_orbit.py, tests/engine/test_branch_truth.py).
"""

import numpy as np
from vibroscope.engine.kernels.compile.options import jit, jit_no_alloc
from vibroscope.engine.kernels.event_driven.events import joint_force_at, room_for_sum, sum_up
from vibroscope.engine.kernels.event_driven.orbit_phase import (
    BACKWARDS,
    flow,
    lowest_minimum,
    relative_state,
    state_later,
    write_section,
)
from vibroscope.engine.kernels.event_driven.saltation import (
    add_row,
    carry_over_sum,
    hold_wall,
    leave_event,
    make_variation,
    scale_row,
    shift,
    slope_of,
)
from vibroscope.engine.kernels.event_driven.setup import set_up_flow
from vibroscope.engine.kernels.event_driven.state import absolute, unpack_system
from vibroscope.engine.kernels.event_driven.two_stops import flight_of_other, from_first, turn_variation, turned
from vibroscope.engine.kernels.linear.cos_sin import cos_sin
from vibroscope.engine.kernels.linear.tables import CURVATURE, GAP

# what happens at an event; at the second stop its number is greater by SECOND
IMPACT, STICK, CHATTER, RELEASE, TOUCH, PART = range(6)
SECOND = 6
JOINS = (STICK, CHATTER, TOUCH, STICK + SECOND, CHATTER + SECOND, TOUCH + SECOND)  # after which the bodies touch
ORDERS = (1, 0, 0, 3, 1, 1)  # derivatives of what is watched that vanish where the phase after an event begins
# columns of the facts of an event: those of minima are followed by that of their instant
CLOSING, PARTING, FORCE, LOWEST, WHERE, ROOM, ACROSS, WHERE_ACROSS = range(8)
FACTS = 8


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
def write_short_phase(phase, d, z, span, order, k, begun, equations):
    """Write the equation of event k, gap = 0 over a power of the length of its phase, from the terms of the gap.

    The phase begins at z, where the first ``order`` terms vanish; δ is still that along the event that began it.
    ``span``: the intervals of its tables that it lasts, and those of an excitation period; ``equations``: residual and
    Jacobian.
    """
    (u, per_period), (residual, jacobian) = span, equations
    scale, value, rate = 1.0, 0.0, 0.0
    for _ in range(order):
        scale *= per_period
    row = jacobian[4 + k]
    for j in range(row.shape[0]):
        row[j] = 0.0
    for i in range(7 if phase.pulled != 0.0 else 6):
        term = slope = 0.0
        for n in range(CURVATURE - GAP - 1, order - 1, -1):
            slope = slope * u + term
            term = term * u + phase.rows[i, GAP + n]
        begin = z[i] if i < 6 else phase.pulled
        value += term * begin
        rate += slope * begin
        if d is None or i == 6:
            continue
        turning = 2.0 * np.pi * (-z[5] if i == 4 else z[4])
        for j in range(row.shape[0]):
            row[j] += scale * term * (d.state[i, j] if i < 4 else turning * begun[j])
    residual[4 + k] = scale * value
    if d is not None:
        for j in range(row.shape[0]):
            row[j] -= scale * rate * per_period * begun[j]
        row[4 + k] += scale * rate * per_period


@jit_no_alloc
def write_facts(p, kind, y, end, row):
    """Write closing speed, parting speed and force of the joined bodies at an event with the state y before it."""
    row[CLOSING] = -y[3]
    row[PARTING] = y[3] if kind == PART else -p.restitution * y[3]
    row[FORCE] = joint_force_at(p, y[0], y[1] + p.mass_share * y[3], end - np.floor(end)) if p.rigid else 0.0
    if kind == CHATTER:
        z = relative_state(p.flight, parted(p, y, p.restitution), end)
        row[ROOM] = room_for_sum(p.flight, z, p.restitution, p.completion, p.scratch)


@jit_no_alloc
def parted(p, y, left):
    """The state after an impact that leaves a share of the closing speed."""
    return y[0], y[1] + p.mass_share * (1.0 + left) * y[3], 0.0, -left * y[3]


@jit_no_alloc
def reset(p, d, y, end, kind):
    """The state right after an event and its time in excitation periods, and δ_e with it."""
    left = p.restitution if kind in (IMPACT, CHATTER) else 0.0
    if kind in (IMPACT, STICK, CHATTER):
        add_row(d, 1, p.mass_share * (1.0 + left), 3)
        y = parted(p, y, left)
        scale_row(d, 3, -left)
    elif kind == RELEASE:
        y = y[0], y[1], 0.0, 0.0
        scale_row(d, 3, 0.0)
    else:
        y = y[0], y[1], 0.0, y[3]
    scale_row(d, 2, 0.0)
    if kind != CHATTER:
        return y, end
    z = relative_state(p.flight, y, end)
    length, x, v = sum_up(p.flight, z, p.restitution, p.mass_share, p.scratch)
    later = end + length / p.period
    c, s = cos_sin(later - np.floor(later))
    carry_over_sum(p, d, z, length, c, s)
    return (x + p.flight.position, v, 0.0, 0.0), later


@jit_no_alloc
def start_at(p, d, unknowns, touching, stop):
    """y₀ of the unknowns as seen from a stop, with the derivatives of what it does not depend on set to zero."""
    if d is not None:
        hold_wall(p, d)
        if touching and p.rigid:
            d.state[2, 2] = d.state[3, 3] = 0.0
        if stop == 1:
            turn_variation(d)
    x1, v1, gap, rate = from_first((unknowns[0], unknowns[1], unknowns[2], unknowns[3]), stop, p.play)
    return (x1, v1, 0.0, 0.0) if touching and p.rigid else (x1, v1, gap, rate)


@jit_no_alloc
def stop_at_start(kinds, first):
    """The stop, 0 or 1, from which the cycle is seen at τ = 0: that of its last event, or of a contact that lasts."""
    m = kinds.shape[0]
    return kinds[m - 1] // SECOND if m > 0 else int(first == 2)


@jit_no_alloc
def write_minima(p, phase, z, span, row, from_zero, whole, touching):
    """Write the lowest minimum of what is watched in a phase, and of the gap of the other stop in a flight.

    ``span``: when the phase begins, in excitation periods, and how long it lasts, in time.
    """
    turn, length = span
    row[LOWEST], where = lowest_minimum(phase, z, length, from_zero, whole, p.scratch)
    row[WHERE] = turn + where / p.period
    row[ACROSS] = row[WHERE_ACROSS] = np.inf
    if p.play < np.inf and not touching:
        other, mirrored = flight_of_other(p, phase, z)
        row[ACROSS], where = lowest_minimum(other, mirrored, length, False, whole, p.scratch)
        row[WHERE_ACROSS] = turn + where / p.period


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
def close_cycle(y, periods, unknowns, out, d):
    """Write the equations y(pT) − y₀ = 0, and their derivative."""
    residual, jacobian, _, after, _ = out
    write_after(after[after.shape[0] - 1], y, periods)
    for i in range(4):
        residual[i] = y[i] - unknowns[i]
        if d is not None:
            for j in range(unknowns.shape[0]):
                jacobian[i, j] = d.state[i, j]
            jacobian[i, i] -= 1.0


@jit_no_alloc
def write_nan(out):
    """Write that there is no such orbit."""
    residual, jacobian, facts, _, _ = out
    residual[:] = np.nan
    jacobian[:] = np.nan
    facts[:] = np.nan


@jit_no_alloc
def find_orbit(packed, kinds, first, periods, unknowns, out, d, begun):
    """Fill what :func:`evaluate_orbit` fills; False if a phase is too short for its tables, or ends far from the cycle.

    ``d``: the variation of all unknowns, or None, with which the residual alone is filled; ``begun``: work space,
    (4 + m,).
    """
    residual, jacobian, facts, after, section = out
    m, order, turn, touching, stop = kinds.shape[0], 0, 0.0, first > 0, stop_at_start(kinds, first)
    p = unpack_system(packed[stop])
    y = start_at(p, d, unknowns, touching, stop)
    for k in range(m + 1):
        end = unknowns[4 + k] if k < m else periods
        phase = p.contact if touching else p.flight
        z, length = relative_state(phase, y, turn), (end - turn) * p.period
        if length < BACKWARDS * phase.spacing:
            return False
        if facts.shape[0] > 0:
            write_minima(p, phase, z, (turn, length), facts[k], order > 0, m == 0, touching)
            write_section(p, phase, z, turn, end, stop, section)
        there = kinds[k] // SECOND if k < m else 0  # from where the end is seen
        if there != stop:
            order = 0  # the gap of the other stop is not zero where the flight begins
        if d is not None:
            for j in range(begun.shape[0]):
                begun[j] = d.time[j] / p.period
        short = order > 0 and k < m and length < phase.spacing
        if short:
            span = length / phase.spacing, p.period / phase.spacing
            write_short_phase(phase, d, z, span, order, k, begun, (residual, jacobian))
        leave_event(phase, d, z)
        x1, v1, gap, rate = flow(phase, z, length, d)
        y = absolute(phase, (x1, v1, gap, rate))
        if d is not None and k < m:
            c, s = cos_sin(end - np.floor(end))
            d.time[4 + k] = p.period
            shift(d, slope_of(phase, (x1, v1, gap, rate, c, s)), 1.0)
        if there != stop:
            y, stop, p = turned(y, p.play), there, unpack_system(packed[there])
            turn_variation(d)
        if k == m:
            break
        kind = kinds[k] % SECOND
        if not short:
            write_event_equation(p, d, y, end, kind, k, residual, jacobian)
            if order > 0:
                divide_by_length(residual, jacobian, k, order, end - turn, begun)
        if facts.shape[0] > 0:
            write_facts(p, kind, y, end, facts[k])
        y, turn = reset(p, d, y, end, kind)
        if not -1.0 <= turn <= periods + 1.0:
            return False  # the sum of a chatter that does not end
        write_after(after[k], from_first(y, stop, p.play), turn)
        touching, order = kind in JOINS, ORDERS[kind]
    close_cycle(y, periods, unknowns, out, d)
    return True


@jit
def touches(kinds, first):
    """Whether the bodies touch at some time of the cycle."""
    touching = first > 0
    for kind in kinds:
        touching |= kind in JOINS
    return touching


@jit
def set_up_stops(tables, rows, problem, touching, exact):
    """Set up the tables of each stop, :func:`.setup.set_up_flow`."""
    packed, keys = tables
    _, rigid, completion = problem
    for stop in range(packed.shape[0]):
        set_up_flow(packed[stop], keys[stop], rows[stop], rigid, touching, completion, exact)


@jit
def fill_orbit(tables, rows, problem, sequence, unknowns, out, d, exact):
    """Set up the tables for ``rows`` and fill ``out``, with nan if there is no such orbit; ``d``: as of find_orbit."""
    kinds, first, periods = sequence
    set_up_stops(tables, rows, problem, touches(kinds, first), exact)
    begun = np.zeros(unknowns.shape[0])
    if not are_within(unknowns, periods) or not find_orbit(tables[0], kinds, first, periods, unknowns, out, d, begun):
        write_nan(out)


@jit
def evaluate_orbit(tables, problem, sequence, unknowns, out):
    """Evaluate the equations of an orbit and their Jacobian.

    Parameters
    ----------
    tables : tuple
        A packed :class:`.state.HybridSystem` of each stop and their keys (:func:`.setup.set_up_flow`): set up where
        ``problem`` has other numbers than they have.
    problem : tuple
        The parameters of each stop, (1, n) or (2, n), whether the contact is the reference's, and how far a chatter
        must have come to be summed up.
    sequence : tuple
        ``kinds`` (m,) of int64: what happens at each event, in the order of time, and at which stop; ``first``: the
        stop at which the bodies touch at τ = 0, 1 or 2, and 0 if they do not; the excitation periods after which the
        orbit returns.
    unknowns : (4 + m,) float64
        y₀, then the instants in excitation periods.
    out : tuple
        ``residual`` (4 + m,), ``jacobian`` (4 + m, 4 + m), ``facts`` (m + 1, FACTS), ``after`` (m + 1, 5): filled, the
        first three with nan if there is no such orbit. Facts of each event: closing speed, parting speed, force of the
        joined bodies right after it, the lowest minimum of what is watched in the phase that it ends, with its
        instant, of a chatter the room for its sum, and the lowest minimum of the gap of the other stop in a flight,
        with its instant; the last row belongs to the end of the cycle. ``after``: the
        state right after each event and its time in periods, last that at the end. ``section`` (p, 4): the states at
        whole periods. ``facts`` and ``section`` are left out where they have no rows.
    """
    fill_orbit(tables, problem[0], problem, sequence, unknowns, out, make_variation(unknowns.shape[0]), True)


@jit
def orbit_slope(tables, rows, problem, sequence, unknowns, residual, h):
    """∂F/∂α₁, (4 + m,), by a difference; ``residual``: F without it, ``rows``: the parameters with α₁ greater by h.

    The other arguments are those of :func:`evaluate_orbit`, but for the tables: their transitions are not exact, since
    a difference errs more.
    """
    n = unknowns.shape[0]
    there = np.zeros(n), np.zeros((n, n)), np.zeros((0, FACTS)), np.zeros((n - 3, 5)), np.zeros((0, 4))
    fill_orbit(tables, rows, problem, sequence, unknowns, there, None, False)
    return (there[0] - residual) / h


@jit
def orbit_state_later(tables, problem, kind, y, turn, length):
    """(ξ₁, ξ₁′, g, g′) a number of excitation periods after y, which belongs to a time in them; without an event.

    ``kind``: of the event that began the phase.
    """
    touching, stop = kind in JOINS, kind // SECOND
    set_up_stops(tables, problem[0], problem, touching, True)
    p = unpack_system(tables[0][stop])
    y = from_first((y[0], y[1], y[2], y[3]), stop, p.play)
    later = state_later(p.contact if touching else p.flight, y, turn, length * p.period)
    return from_first(later, stop, p.play)
