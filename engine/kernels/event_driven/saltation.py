"""The derivative of the motion with respect to its start, within a phase and over an event: saltation matrices.

Let δ be what a small change of the start changes of y = (ξ₁, ξ₁′, g, g′) *at a fixed time*. Within a phase the
excitation does not change, so δ(s) = E(s) δ(0), with the upper left part of the phase's own E: a
move of the table, then the polynomials of ξ₁ and g, and of their rates, over the rest.

An event takes place where the watched f = w·y falls to zero, so the change moves its time, and the state that it meets:

    dτ = −w·δ / f′,        d = δ + y′ dτ        the change *along the event*, y′ before it,

and after it, with the y′ of the phase that follows, δ = d − y′ dτ. Between the two is the reset y⁺ = R(y⁻), d⁺ = R d⁻:

    δ⁺ = [R + (y′⁺ − R y′⁻) (−wᵀ/f′)] δ⁻,

which is known as the saltation matrix. It needs the resets alone:

- *Impact*: ξ₁′ gains (1 + e) μ/(1 + μ) g′, and g′ becomes −e g′.
- *Impact that sticks*, and any other beginning of a permanent contact: ξ₁′ gains μ/(1 + μ) g′; g = g′ = 0 whatever the
  start: the rank falls to two.
- *Release*: nothing is reset. If the joined pendulums feel no other damping than the free ones, y′ does not jump either
  (the force is zero), and δ goes on as it is; with the measured joint damping ξ₁″ jumps by the rest of it.
- *Contact of the exact penalty*: nothing is reset, but the damper's 2D g′ sets in, and lets go, at once: y′ jumps.
- *Rest of a chatter*, whose end moves by dτ + dt∞. In the names of :mod:`.chatter`, with b = 2J/(3A²) − γ/(3A) =
  2g‴/(3A²) − γ/A, it lasts t∞ = 2r(1 + rb/(1 − e)) / ((1 − e)A), and

      dt∞ = t∞ (dr/r − dA/A) + 2r (b dr + r db) / ((1 − e)²A),    db = 2 dg‴/(3A²) − (4g‴/(3A) − γ) dA/A²,

  A = −g″ and g‴ being those of the common motion: with the rows w of the gap's derivatives dA = −w₂·δ − g‴ dτ and
  dg‴ = w₃·δ + g⁗ dτ. The common motion is a solution of the free equations, and has a δ of its own.
- *What was fast in a contact is dropped*: δ is projected as the state is.

At a grazing impact f′ = 0: there is no derivative, and the result is not finite.
"""

from typing import NamedTuple

import numpy as np

from ..compile.options import jit
from ..linear.tables import BEND, FIRST, GAP, POWERS, first_at, gap_at, polynomial_at
from .chatter import dampers, falling
from .state import COLLIDING, clock, state, touches


class Change(NamedTuple):
    """What each unit change of the start changes; columns belong to the start, rows to what is changed."""

    state: np.ndarray  # (4, 4) δ within a phase, d at an event
    time: np.ndarray  # (4,) dτ of the event; zero within a phase


@jit
def flow(phase, z):
    """y′ at z."""
    square = 2.0 / (phase.spacing * phase.spacing)
    first, gap = 0.0, 0.0
    for i in range(6):
        first += phase.rows[i, FIRST + 2] * z[i]
        gap += phase.rows[i, GAP + 2] * z[i]
    return z[1], first * square, z[3], gap * square


@jit
def shift(change, rate, sign):
    """From fixed time to the event (sign = 1), or back (−1)."""
    for k in range(4):
        for i in range(4):
            change.state[i, k] += sign * rate[i] * change.time[k]


@jit
def advance(phase, change, i, u):
    """δ after i + u spacings of the phase."""
    rest = np.empty((4, 4))
    for j in range(4):
        rest[0, j], rate = polynomial_at(phase.rows[j, FIRST:GAP], u)
        rest[1, j] = rate / phase.spacing
        rest[2, j], rate = polynomial_at(phase.rows[j, GAP:BEND], u)
        rest[3, j] = rate / phase.spacing
    if i > 0:
        apply(phase.moves[i - 1], change)
    apply(rest, change)


@jit
def apply(matrix, change):
    """δ, or d, times the upper left part of a matrix."""
    for k in range(4):
        old = change.state[0, k], change.state[1, k], change.state[2, k], change.state[3, k]
        for i in range(4):
            change.state[i, k] = (
                matrix[i, 0] * old[0] + matrix[i, 1] * old[1] + matrix[i, 2] * old[2] + matrix[i, 3] * old[3]
            )


@jit
def meet(phase, change, z, slope):
    """From δ to d at the event z that ends a phase, f′ = ``slope``."""
    for k in range(4):
        value = 0.0
        for i in range(4):
            value += phase.rows[i, POWERS] * change.state[i, k]
        change.time[k] = -value / slope
    shift(change, flow(phase, z), 1.0)


@jit
def leave(phase, change, z):
    """From d to δ at the beginning z of a phase."""
    shift(change, flow(phase, z), -1.0)
    change.time[:] = 0.0


@jit
def reset(p, change, before, after):
    """d over what joins the pendulums, or throws them back; the anchors are those before and after it."""
    if not p.rigid:
        return
    joins = touches(after) and not touches(before)
    bounces = before.mode == COLLIDING and before.rate < 0.0
    if joins or bounces:
        left = 0.0 if joins else p.restitution
        change.state[1] += p.mass_share * (1.0 + left) * change.state[3]
        change.state[2] = 0.0
        change.state[3] *= -left
    elif after.rate != before.rate:  # a speed that rounding hides
        change.state[3] = 0.0


@jit
def common(p, change, z):
    """Common motion of separated pendulums that are about to be one: d and z of it."""
    change.state[1] += p.mass_share * change.state[3]
    change.state[2:] = 0.0
    return z[0], z[1] + p.mass_share * z[3], 0.0, 0.0, z[4], z[5]


@jit
def lengthened(p, change, z, r, parted):
    """dt∞ of the chatter that the common motion z begins with the parting speed r, from d of both."""
    phase, k = p.flight, 1.0 / (1.0 - p.restitution)
    h = phase.spacing
    a, j = falling(phase, z, p.scratch)
    _, gamma = dampers(phase, p.mass_share)
    snap = 0.0
    for i in range(6):
        snap += phase.rows[i, GAP + 4] * z[i] * 24.0 / (h * h * h * h)
    y, bent = flow(phase, z), 2.0 * j / (3.0 * a * a) - gamma / a
    once = 2.0 * r * k / a
    out = np.empty(4)
    for i in range(4):
        da, dj = -j * change.time[i], snap * change.time[i]
        for n in range(4):
            delta = change.state[n, i] - y[n] * change.time[i]
            da -= phase.rows[n, GAP + 2] * delta * 2.0 / (h * h)
            dj += phase.rows[n, GAP + 3] * delta * 6.0 / (h * h * h)
        dbent = 2.0 * dj / (3.0 * a * a) - (4.0 * j / (3.0 * a) - gamma) * da / (a * a)
        share = parted[i] / r - da / a
        out[i] = once * ((1.0 + r * k * bent) * share + k * (parted[i] * bent + r * dbent))
    return out


@jit
def over_chatter(p, change, before, after):
    """d over the rest of a chatter, from the anchor at its beginning to that at its end."""
    z, length = state(p, before), clock(p, after) - clock(p, before)
    r, parted = z[3], change.state[3].copy()
    z = common(p, change, z)
    end = change.time + lengthened(p, change, z, r, parted)
    leave(p.flight, change, z)
    u = length / p.flight.spacing
    advance(p.flight, change, 0, u)
    x, v = first_at(p.flight, z, u, p.scratch)
    g, rate = gap_at(p.flight, z, u, p.scratch)
    _, _, _, _, c, s = state(p, after)
    change.time[:] = end
    shift(change, flow(p.flight, (x, v, g, rate, c, s)), 1.0)
    apart, _ = dampers(p.flight, p.mass_share)
    change.state[0] += p.mass_share * change.state[2]
    change.state[1] += p.mass_share * (1.0 - p.mass_share) * apart * change.state[2]
    common(p, change, z)
