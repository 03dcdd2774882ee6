"""The derivative of the motion with respect to its start, within a phase and over an event: saltation matrices.

Let δ be the change of y = (ξ₁, ξ₁′, g, g′) *at a fixed time* that a small change of the start causes. Within a phase
the excitation does not change, so δ(s) = E(s) δ(0), with the upper left part of the phase's E (:mod:`..linear.tables`):
a tabulated transition, then the polynomials of ξ₁ and g, and of their rates, over the rest.

An event takes place where the watched quantity f = w·y falls to zero, so the change moves its time and the state there:

    dτ = −w·δ / f′,        δ_e = δ + y′ dτ        the change *along the event*, y′ before it,    (39)

and after it, with the y′ of the phase that follows, δ = δ_e − y′ dτ. Between the two lies the reset y⁺ = R(y⁻),
δ_e⁺ = R δ_e⁻:

    δ⁺ = [R + (y′⁺ − R y′⁻) wᵀ/f′] δ⁻,                                                             (40)

which is known as the saltation matrix. Only the resets have to be written down:

- *Impact*: ξ₁′ gains (1 + e) μ/(1 + μ) g′, and g′ becomes −e g′.
- *Impact that begins a permanent contact*, and any other beginning of one: ξ₁′ gains μ/(1 + μ) g′; g = g′ = 0 whatever
  the start: the rank falls to two.
- *Release*: no reset. If the joined bodies feel no other damping than the free ones, y′ does not jump either (the force
  is zero); with the measured joint damping ξ₁″ jumps by the rest of it.
- *Contact of the exact penalty*: no reset, but the damper's 2D g′ sets in, and ends, at once: y′ jumps.
- *End of a chatter*, which moves by dτ + dt∞. In the names of :mod:`.events`, with B_c = 2J_g/(3a_g²) − γ/(3a_g) =
  2g‴/(3a_g²) − γ/a_g, it lasts t∞ = 2r(1 + rB_c/(1 − e)) / ((1 − e)a_g), and

      dt∞ = t∞ (dr/r − da_g/a_g) + 2r (B_c dr + r dB_c) / ((1 − e)²a_g),                         (41)
      dB_c = 2 dg‴/(3a_g²) − (4g‴/(3a_g) − γ) da_g/a_g²,                                         (42)

  a_g = −g″ and g‴ being those of the common motion: with the rows w of the gap's derivatives da_g = −w₂·δ − g‴ dτ and
  dg‴ = w₃·δ + g⁗ dτ. The common motion is a solution of the free equations, and has a δ of its own.
- *The fast part of a contact is dropped*: δ is projected as the state is.

At a grazing impact f′ = 0: there is no derivative, and the result is not finite.

The functions that the event loop calls do nothing where ``d`` is None: the loop is compiled without them then.
"""

from typing import NamedTuple

import numpy as np
from vibroscope.engine.kernels.compile.options import jit, jit_no_alloc
from vibroscope.engine.kernels.event_driven.events import damper_terms, gap_acceleration_and_jerk
from vibroscope.engine.kernels.event_driven.output import evaluate
from vibroscope.engine.kernels.event_driven.state import (
    COLLISION,
    CONTACT,
    SLOW_CONTACT,
    in_contact,
    linear_state,
    time_of,
)
from vibroscope.engine.kernels.linear.tables import (
    CURVATURE,
    GAP,
    POINTS,
    POSITION,
    POWERS,
    gap_at,
    polynomial_at,
    position_at,
    pulled_by,
    unpulled,
)

COURSES = 2**61 - 1  # a prime


class Variation(NamedTuple):
    """What a unit change of each of n numbers changes, the first four being the start; rows: what is changed."""

    state: np.ndarray  # (4, n) δ within a phase, δ_e at an event
    time: np.ndarray  # (n,) dτ of the event; zero within a phase
    end: np.ndarray  # (4,) the motion (ξ₁, ξ₁′, g, g′) at the end of the run
    course: np.ndarray  # (1,) int64: differs between different sequences of phases
    matrix: np.ndarray  # (4, 4) work space
    rows: np.ndarray  # (2, n) work space


@jit
def make_variation(numbers=4):
    """The variation at the start of a run: δ = 1 for the start, and 0 for what comes later."""
    course = np.ones(1, dtype=np.int64)
    return Variation(
        np.eye(4, numbers), np.zeros(numbers), np.zeros(4), course, np.zeros((4, 4)), np.zeros((2, numbers))
    )


# -- within a phase ----------------------------------------------------------------------------------------------------


@jit_no_alloc
def carry(phase, d, i, u):
    """δ after i + u intervals of the phase."""
    if d is None:
        return
    rest = d.matrix
    for j in range(4):
        rest[0, j], rate = polynomial_at(phase.rows[j, POSITION:GAP], u)
        rest[1, j] = rate / phase.spacing
        rest[2, j], rate = polynomial_at(phase.rows[j, GAP:CURVATURE], u)
        rest[3, j] = rate / phase.spacing
    if i > 0:
        multiply(phase.transitions[i - 1], d)
    multiply(rest, d)


@jit_no_alloc
def carry_along(p, phase, d, i, u):
    """The work of :func:`carry`; for the change of a single number two polynomials do the work of eight."""
    if d is None:
        return
    if d.state.shape[1] > 1:
        carry(phase, d, i, u)
        return
    if i > 0:
        multiply(phase.transitions[i - 1], d)
    change, linear = (d.state[0, 0], d.state[1, 0], d.state[2, 0], d.state[3, 0], 0.0, 0.0), unpulled(phase)
    d.state[0, 0], d.state[1, 0] = position_at(linear, change, u, p.scratch)
    d.state[2, 0], d.state[3, 0] = gap_at(linear, change, u, p.scratch)


@jit_no_alloc
def carry_to_end(p, phase, d, z, s):
    """δ and the motion at s within the block that begins at z, where the run ends."""
    if d is None:
        return
    i = min(max(int(s / phase.spacing), 0), POINTS - 1)
    carry_along(p, phase, d, i, s / phase.spacing - i)
    d.end[0], d.end[1], d.end[2], d.end[3] = evaluate(p, phase, z, s)


@jit_no_alloc
def multiply(matrix, d):
    """Multiply δ, or δ_e, by the upper left part of a matrix."""
    if d is None:
        return
    for k in range(d.state.shape[1]):
        old = d.state[0, k], d.state[1, k], d.state[2, k], d.state[3, k]
        for i in range(4):
            d.state[i, k] = (
                matrix[i, 0] * old[0] + matrix[i, 1] * old[1] + matrix[i, 2] * old[2] + matrix[i, 3] * old[3]
            )


@jit_no_alloc
def add_row(d, i, factor, j):
    """Add so many times row j of δ, or δ_e, to row i."""
    if d is None:
        return
    for k in range(d.state.shape[1]):
        d.state[i, k] += factor * d.state[j, k]


@jit_no_alloc
def scale_row(d, i, factor):
    """Scale row i of δ, or δ_e."""
    if d is None:
        return
    for k in range(d.state.shape[1]):
        d.state[i, k] = factor * d.state[i, k] if factor != 0.0 else 0.0


# -- over an event -----------------------------------------------------------------------------------------------------


@jit_no_alloc
def slope_of(phase, z):
    """y′ at z."""
    square = 2.0 / (phase.spacing * phase.spacing)
    first, gap = pulled_by(phase, POSITION + 2), pulled_by(phase, GAP + 2)
    for i in range(6):
        first += phase.rows[i, POSITION + 2] * z[i]
        gap += phase.rows[i, GAP + 2] * z[i]
    return z[1], first * square, z[3], gap * square


@jit_no_alloc
def shift(d, slope, sign):
    """From fixed time to the event (sign = 1), or back (−1)."""
    if d is None:
        return
    for k in range(d.state.shape[1]):
        for i in range(4):
            d.state[i, k] += sign * slope[i] * d.time[k]


@jit_no_alloc
def meet_event(phase, d, z, slope):
    """From δ to δ_e at the event z that ends a phase, f′ = ``slope``."""
    for k in range(d.state.shape[1]):
        value = 0.0
        for i in range(4):
            value += phase.rows[i, POWERS] * d.state[i, k]
        d.time[k] = -value / slope
    shift(d, slope_of(phase, z), 1.0)


@jit_no_alloc
def leave_event(phase, d, z):
    """From δ_e to δ at the beginning z of a phase."""
    if d is None:
        return
    shift(d, slope_of(phase, z), -1.0)
    for k in range(d.time.shape[0]):
        d.time[k] = 0.0


@jit_no_alloc
def hold_wall(p, d):
    """No start moves a wall: the derivatives with respect to ξ₁ and ξ₁′ at the start are zero there."""
    scale_row(d, 0, 1.0 - p.wall)
    scale_row(d, 1, 1.0 - p.wall)


@jit_no_alloc
def start_variation(p, d, a):
    """Begin at a hybrid state, where a collision may be due."""
    if d is None:
        return
    hold_wall(p, d)
    if a.mode == COLLISION and a.rate < 0.0:
        meet_event(p.flight, d, linear_state(p, p.flight, a), a.rate)


@jit_no_alloc
def carry_to_event(p, phase, d, a, slope):
    """From δ to δ_e at the event a that ends a phase, which adds to the course of events."""
    if d is None:
        return
    meet_event(phase, d, linear_state(p, phase, a), slope)
    d.course[0] = (d.course[0] * 4 + int(a.mode)) % COURSES


@jit_no_alloc
def carry_over_reset(p, d, before, after):
    """d over what joins the bodies or reverses their approach, between two hybrid states."""
    if d is None or not p.rigid:
        return
    joins = in_contact(after) and not in_contact(before)
    bounces = before.mode == COLLISION and before.rate < 0.0
    if joins or bounces:
        left = 0.0 if joins else p.restitution
        add_row(d, 1, p.mass_share * (1.0 + left), 3)
        scale_row(d, 2, 0.0)
        scale_row(d, 3, -left)
    elif after.rate != before.rate:  # a rate that rounding hides
        scale_row(d, 3, 0.0)


@jit_no_alloc
def carry_over_fast_decay(p, d, before, after):
    """d over the loss of the fast part of a contact."""
    if d is None or before.mode != CONTACT or after.mode != SLOW_CONTACT:
        return
    for i in range(4):
        for j in range(4):
            d.matrix[i, j] = (1.0 if i == j else 0.0) - p.fast[i, j]
    multiply(d.matrix, d)


# -- over the end of a chatter -----------------------------------------------------------------------------------------


@jit_no_alloc
def join(p, d, z):
    """Common motion of bodies that are about to be one: its d and its z."""
    add_row(d, 1, p.mass_share, 3)
    scale_row(d, 2, 0.0)
    scale_row(d, 3, 0.0)
    return z[0], z[1] + p.mass_share * z[3], z[2], 0.0, z[4], z[5]


@jit_no_alloc
def chatter_lengthening(p, d, z, r, parting, out):
    """dt∞ of the chatter that the common motion z begins with the parting rate r, d of that being ``parting``."""
    phase, k = p.flight, 1.0 / (1.0 - p.restitution)
    h = phase.spacing
    a, j = gap_acceleration_and_jerk(phase, z, p.scratch)
    _, gamma = damper_terms(phase, p.mass_share)
    snap = pulled_by(phase, GAP + 4) * 24.0 / (h * h * h * h)
    for i in range(6):
        snap += phase.rows[i, GAP + 4] * z[i] * 24.0 / (h * h * h * h)
    y, b = slope_of(phase, z), 2.0 * j / (3.0 * a * a) - gamma / a
    first = 2.0 * r * k / a
    for i in range(d.time.shape[0]):
        da, dj = -j * d.time[i], snap * d.time[i]
        for n in range(4):
            delta = d.state[n, i] - y[n] * d.time[i]
            da -= phase.rows[n, GAP + 2] * delta * 2.0 / (h * h)
            dj += phase.rows[n, GAP + 3] * delta * 6.0 / (h * h * h)
        db = 2.0 * dj / (3.0 * a * a) - (4.0 * j / (3.0 * a) - gamma) * da / (a * a)
        share = parting[i] / r - da / a
        out[i] = first * ((1.0 + r * k * b) * share + k * (parting[i] * b + r * db))


@jit_no_alloc
def carry_over_chatter(p, d, before, after, stop):
    """d over the summed end of a chatter; whether the run ends within it, and d with it."""
    if d is None:
        return False
    if (stop - after.period) * p.period < after.tau:
        z = join(p, d, linear_state(p, p.contact, before))
        leave_event(p.contact, d, z)
        carry_to_end(p, p.contact, d, z, (stop - before.period) * p.period - before.tau)
        return True
    _, _, _, _, c, s = linear_state(p, p.flight, after)
    carry_over_sum(p, d, linear_state(p, p.flight, before), time_of(p, after) - time_of(p, before), c, s)
    return False


@jit_no_alloc
def carry_over_sum(p, d, z, length, c, s):
    """δ_e over the summed end of a chatter that begins at z and lasts a time; c, s: cos ητ and sin ητ at its end."""
    if d is None:
        return
    parting, end, r = d.rows[0], d.rows[1], z[3]
    for k in range(d.time.shape[0]):
        parting[k] = d.state[3, k]
    z = join(p, d, z)
    chatter_lengthening(p, d, z, r, parting, end)
    for k in range(d.time.shape[0]):
        end[k] += d.time[k]
    leave_event(p.flight, d, z)
    u = length / p.flight.spacing
    carry_along(p, p.flight, d, 0, u)
    x, v = position_at(p.flight, z, u, p.scratch)
    g, rate = gap_at(p.flight, z, u, p.scratch)
    for k in range(d.time.shape[0]):
        d.time[k] = end[k]
    shift(d, slope_of(p.flight, (x, v, g, rate, c, s)), 1.0)
    difference, _ = damper_terms(p.flight, p.mass_share)
    add_row(d, 0, p.mass_share, 2)
    add_row(d, 1, p.mass_share * (1.0 - p.mass_share) * difference, 2)
    join(p, d, z)
