"""A periodic orbit of Newmark's method with located steps as a sequence of events: its equations and their derivative.

The unknowns and the equations are those of :mod:`.event_driven.orbit`, Eq. (52): the state y₀ = (ξ₁, ξ₁′, g, g′) at
τ = 0 and the instants of touches and parts. A phase is not a motion in closed form but the steps that
:mod:`.time_stepping.located` takes from its beginning to its end, which cut the first of them and the last. As there,
nothing is solved for an instant, and what has its own beginning as a trivial zero is divided by its length.

The derivative is that of the discrete steps. A step of length s is linear in the motion at its beginning. In its length
it is not: with z = (x, v, a) at its beginning and a₁ at its end, x₁ = x + sv + s²(a + a₁)/4 and v₁ = v + s(a + a₁)/2,

    ∂x₁/∂s = v₁ + s²/4 ∂a₁/∂s,         ∂v₁/∂s = (a + a₁)/2 + s/2 ∂a₁/∂s,                             (60)

so that the derivative itself is the end of such a step, from the predictors v₁ and (a + a₁)/2.

For one sequence of events the equations are continuous in the unknowns and in the parameters, and analytic as long as
each event stays within its step; where an event passes a point of the grid the derivative has a kink of second order in
the step. There are two places where they jump, by what one step errs, its third order. Where the age of a contact
reaches a length of Eq. (13) at a point of the grid, a step is halved once less. Where a contact appears or vanishes at
a grazing, its touch begins or ceases to cut a step.

Plain twin: runs of the steps, and differences of them (tests/engine/test_located_branches.py).
"""

import numpy as np

from .compile.options import jit, jit_inlined, jit_no_alloc
from .event_driven.orbit import (
    CLOSING,
    LOWEST,
    PARTING,
    TOUCH,
    WHERE,
    are_within,
    divide_by_length,
    write_after,
    write_nan,
)
from .linear.cos_sin import cos_sin
from .time_stepping.contact_location import forcing_at, side, step, with_accelerations
from .time_stepping.located import halvings_at, points_passed

BACKWARDS = -0.05  # excitation periods that a phase can be extended before its beginning
STILL = (0.0, 0.0)
ROWS = (0, 1, 3, 4)  # of the derivative of a motion (x, v, a, g, u, b), those of a state


@jit_inlined
def place_of(m, turn):
    """The step of the grid within which an instant lies, in excitation periods, and the time since it began."""
    steps = turn * m.steps
    i = int(np.floor(steps))
    return i, (steps - i) * m.h


@jit_inlined
def forcing_rate_at(m, k, s):
    """The rates of f₁ and f at the time s after step k of a period."""
    c, s = cos_sin((k * m.h + s) * m.frequency)
    one, gap = m.forcing
    return m.eta * (one[1] * c - one[0] * s), m.eta * (gap[1] * c - gap[0] * s)


@jit_inlined
def column(d, j):
    """The derivative of the motion with respect to unknown j."""
    return d[0, j], d[1, j], d[2, j], d[3, j], d[4, j], d[5, j]


@jit_no_alloc
def add_to_column(d, j, factor, rate):
    """Add so many times a change of the motion to its derivative with respect to unknown j."""
    for i in range(6):
        d[i, j] += factor * rate[i]


@jit_no_alloc
def rate_by_length(e, z, end, s, forcing_rate):
    """The rate at which the motion at the end of a step grows with its length, Eq. (60)."""
    mean, of_gap = 0.5 * (z[2] + end[2]), 0.5 * (z[5] + end[5])
    return step(e, (end[1] - s * mean, mean, 0.0, end[4] - s * of_gap, of_gap, 0.0), s, forcing_rate)


@jit_no_alloc
def begin_phase(m, pressed, turn, y, d, began):
    """The motion (x, v, a, g, u, b) at a state y, and its accelerations' derivatives; ``began``: as in a phase."""
    e, (i, offset) = side(m, pressed), place_of(m, turn)
    for j in range(d.shape[1]):
        _, _, d[2, j], _, _, d[5, j] = with_accelerations(e, column(d, j), STILL)
    if began >= 0:
        rate = forcing_rate_at(m, i % m.steps, offset)
        d[2, began] += m.h * m.steps * rate[0]
        d[5, began] += m.h * m.steps * rate[1]
    return with_accelerations(e, (y[0], y[1], 0.0, y[2], y[3], 0.0), forcing_at(m, i % m.steps, offset))


@jit_no_alloc
def write_lowest(m, pressed, z, end, place, length, row):
    """Write the lowest point of the watched quantity within a step, and when, if none before is lower.

    The contact changes where both the parabola of the step and the step to its vertex are below zero
    (:func:`.time_stepping.contact_location.locate_change`).
    """
    sign = -1.0 if pressed else 1.0
    rate, curvature = sign * z[4], 0.5 * sign * (z[5] + end[5])
    if not (rate < 0.0 and -rate < curvature * length):
        return
    (i, offset), (facts, event), later = place, row, -rate / curvature
    there = step(side(m, pressed), z, later, forcing_at(m, i % m.steps, offset + later))
    value = max(sign * z[3] + 0.5 * rate * later, sign * there[3])
    if value < facts[event, LOWEST]:
        facts[event, LOWEST], facts[event, WHERE] = value, (i + (offset + later) / m.h) / m.steps


@jit_no_alloc
def next_point(m, parts, offset, backwards):
    """The next point of the grid, or of a grid ``parts`` times as fine, as a time since the step began."""
    piece = m.h / parts
    if backwards:
        return max(0.0, parts - 1.0 - points_passed(piece, m.h - offset)) * piece
    return min(parts, points_passed(piece, offset) + 1.0) * piece


@jit_no_alloc
def follow_phase(m, pressed, since, span, y, d, columns, row, section):
    """The motion (x, v, a, g, u, b) at the end of a phase, its derivative, and the rate of the gap there by (60).

    Parameters
    ----------
    m : LocatedScheme
    pressed : bool
    since : float
        How long the contact has lasted where the phase begins.
    span : tuple of float
        When it begins and ends, in excitation periods; it may end earlier than it begins.
    y : tuple of float
        The state where it begins.
    d : (6, n) float64
        The derivative of the motion with respect to the unknowns, that of y in the rows ROWS; changed in place.
    columns : tuple of int
        The unknowns that are the instants at which it begins and ends, −1 for what is none.
    row : tuple
        The facts, and the row in which the lowest point of the watched quantity is written.
    section : (p, 4) float64
        The states at whole periods are written.
    """
    (turn, end), (began, ends) = span, columns
    e, n, period, backwards = side(m, pressed), m.steps, m.h * m.steps, end < turn
    (i, offset), (last, rest) = place_of(m, turn), place_of(m, end)
    z = begin_phase(m, pressed, turn, y, d, began)
    while True:
        if offset == 0.0 and i % n == 0 and 0 <= i // n < section.shape[0]:
            j = i // n
            section[j, 0], section[j, 1], section[j, 2], section[j, 3] = z[0], z[1], z[3], z[4]
        if ends < 0 and i == last and offset == rest:
            return z, z[4]
        if backwards and offset == 0.0:
            i, offset = i - 1, m.h
        _, parts = halvings_at(m, pressed, since)
        point = next_point(m, parts, offset, backwards)
        final = (i <= last and point <= rest) or i < last if backwards else (i >= last and point >= rest) or i > last
        length = (last - i) * m.h + rest - offset if final else point - offset
        for j in range(d.shape[1]):
            d[0, j], d[1, j], d[2, j], d[3, j], d[4, j], d[5, j] = step(e, column(d, j), length, STILL)
        k = i % n
        after = step(e, z, length, forcing_at(m, k, offset + length))
        if began >= 0:
            add_to_column(d, began, -period, rate_by_length(e, z, after, length, STILL))
            began = -1
        if row[0].shape[0] > 0 and not backwards:
            write_lowest(m, pressed, z, after, (i, offset), length, row)
        if final:
            rate = rate_by_length(e, z, after, length, forcing_rate_at(m, k, offset + length))
            if ends >= 0:
                add_to_column(d, ends, period, rate)
            return after, rate[3]
        z, offset, since = after, point, since + length
        if point == m.h:
            i, offset = i + 1, 0.0


@jit_no_alloc
def find_located_orbit(m, kinds, pressed, periods, unknowns, out, d, begun):
    """Fill what :func:`evaluate_located_orbit` fills; False if a phase ends far before its beginning.

    ``d``: work space, (6, 4 + m); ``begun``: work space, (4 + m,).
    """
    residual, jacobian, facts, after, section = out
    count, turn, began = kinds.shape[0], 0.0, -1
    d[:] = 0.0
    for j in range(4):
        d[ROWS[j], j] = 1.0 if j >= 2 else 1.0 - m.wall  # no start moves a wall
    y = unknowns[0], unknowns[1], unknowns[2], unknowns[3]
    since = (periods - unknowns[3 + count]) * m.h * m.steps if count > 0 else np.inf
    for k in range(count + 1):
        end, ends = (unknowns[4 + k], 4 + k) if k < count else (periods, -1)
        if not end - turn > BACKWARDS:
            return False
        if facts.shape[0] > 0:
            facts[k, LOWEST] = np.inf
        z, rate = follow_phase(m, pressed, since, (turn, end), y, d, (began, ends), (facts, k), section)
        if k == count:
            break
        residual[4 + k] = z[3]
        for j in range(unknowns.shape[0]):
            jacobian[4 + k, j] = d[3, j]
        if k > 0:
            for j in range(begun.shape[0]):
                begun[j] = 1.0 if j == began else 0.0
            divide_by_length(residual, jacobian, k, 1, end - turn, begun)
        if facts.shape[0] > 0:
            facts[k, CLOSING], facts[k, PARTING] = -max(z[4], rate), min(z[4], rate)
        d[3] = 0.0
        y, turn, since, pressed, began = (z[0], z[1], 0.0, z[4]), end, 0.0, kinds[k] == TOUCH, ends
        write_after(after[k], y, turn)
    y = z[0], z[1], z[3], z[4]
    write_after(after[count], y, periods)
    for i in range(4):
        residual[i] = y[i] - unknowns[i]
        for j in range(unknowns.shape[0]):
            jacobian[i, j] = d[ROWS[i], j]
        jacobian[i, i] -= 1.0
    return True


@jit
def evaluate_located_orbit(m, kinds, pressed, periods, unknowns, out):
    """Evaluate the equations of an orbit and their Jacobian, as :func:`.event_driven.orbit.evaluate_orbit` does.

    Parameters
    ----------
    m : LocatedScheme
        Without stages: Newmark's own step.
    kinds : (m,) int64
        TOUCH and PART.
    pressed : bool
        Whether the bodies touch at τ = 0.
    periods, unknowns, out
        As there.
    """
    d, begun = np.zeros((6, unknowns.shape[0])), np.zeros(unknowns.shape[0])
    if not are_within(unknowns, periods) or not find_located_orbit(m, kinds, pressed, periods, unknowns, out, d, begun):
        write_nan(out)


@jit
def located_state_later(m, pressed, y, turn, length):
    """(ξ₁, ξ₁′, g, g′) a number of excitation periods after y, which belongs to a time in them; without an event."""
    nothing, since = np.zeros((0, 0)), 0.0
    d, span = np.zeros((6, 0)), (turn, turn + length)
    z, _ = follow_phase(m, pressed, since, span, y, d, (-1, -1), (nothing, 0), nothing)
    return z[0], z[1], z[3], z[4]
