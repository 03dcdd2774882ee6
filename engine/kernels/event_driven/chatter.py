"""The end of a chatter, infinitely many impacts in a finite time, summed in closed form.

Impacts conserve momentum, so the common motion ξ̄ = ξ₁ + μ̂ g, μ̂ = μ/(1 + μ), is smooth, and the bodies bounce on
each other in it. With the coefficients of :mod:`..equations.motion`, to first order in g,

    g″ = −a_g + J_g t − γ g′,    γ = c₂ − μ̂ (c₂ − c₁),                                          (36)

where a_g = −g″ and J_g = g‴ − γa_g belong to the free motion from g = g′ = 0.

(γ matters: an impact reverses g′, and so changes the acceleration at once.) After a parting rate r the flight

    g = r t − (a_g + γr) t²/2 + (J_g + γa_g + …) t³/6

ends after

    t = 2r/a_g · [1 + r (2J_g/(3a_g²) − γ/(3a_g)) + …]                                           (37)

and the next one begins with e times the rate at which it ends. Summed over the whole sequence, the chatter lasts

    t∞ = 2r / (a_g(1 − e)) · [1 + r (2J_g/(3a_g²) − γ/(3a_g)) / (1 − e)] + O(r³).                (38)

The common motion feels a gap of order r² over a time of order r. Its series is taken from g = g′ = 0 as free motion,
in which g falls to −a_g t²/2 instead of bouncing back to zero. What ξ̄″ = … − μ̂(1 − μ̂)(c₂ − c₁) g′ makes of this is
of order r² in ξ̄′ and is subtracted. So everything is exact to O(r³), while the threshold ε that permanent contact
needs without this sum enters in the first power.

Plain twin: the impacts one by one, with a small threshold (tests/engine/kernels/test_chatter.py).
"""

from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.linear.tables import GAP, find_gap, gap_at, position_at

SMALL, LIFT = 2.0**-400, 2.0**600  # a motion that has died away: squares of what is below SMALL may be zero by rounding


@jit_inlined
def lift(a):
    """A factor without which products of two numbers of the size of ``a`` may be zero by rounding; 1 for most."""
    return LIFT if abs(a) < SMALL else 1.0


@jit_no_alloc
def gap_acceleration_and_jerk(phase, z, scratch):
    """−g″ and g‴ of the free gap at z."""
    h = phase.spacing
    find_gap(phase, z, scratch)
    return -2.0 * scratch.products[GAP + 2] / (h * h), 6.0 * scratch.products[GAP + 3] / (h * h * h)


@jit_no_alloc
def can_sum(phase, z, restitution, limit, scratch):
    """Whether the chatter that begins at z is sure to end in contact and short enough to be summed.

    The expansion is in powers of r |g‴| / (a_g²(1 − e)) and of t∞/h, with h, the spacing of the tables, a share of the
    fastest oscillation's time; both must be at most ``limit``.
    """
    return room_for_sum(phase, z, restitution, limit, scratch) >= 0.0


@jit_no_alloc
def room_for_sum(phase, z, restitution, limit, scratch):
    """By how much the two ratios of :func:`can_sum` may grow, as a share of them; at most −1 if the gap grows."""
    r = z[3]
    a, j = gap_acceleration_and_jerk(phase, z, scratch)
    factor = lift(a)
    r, a, j = factor * r, factor * a, factor * j
    small = limit * (1.0 - restitution)
    return min(small * a * abs(a) / (r * abs(j)), small * a * phase.spacing / (2.0 * r)) - 1.0


@jit_no_alloc
def damper_terms(phase, mass_share):
    """c₂ − c₁ and γ, from the coefficients −(c₂ − c₁) and −c₂ of ξ₁′ and g′ in g″."""
    square = 2.0 / (phase.spacing * phase.spacing)
    difference = -square * phase.rows[1, GAP + 2]
    return difference, -square * phase.rows[3, GAP + 2] - mass_share * difference


@jit_no_alloc
def sum_up(phase, z, restitution, mass_share, scratch):
    """Duration t∞ of the chatter that begins at z, and ξ and ξ′ of the joined bodies at its end.

    ξ is relative to the equilibrium of the flight, and so is z; at its beginning the gap itself is zero.
    """
    r, h = z[3], phase.spacing
    together = (z[0], z[1] + mass_share * r, z[2], 0.0, z[4], z[5])
    a, j = gap_acceleration_and_jerk(phase, together, scratch)
    factor = lift(a)
    r, a, j = factor * r, factor * a, factor * j
    difference, gamma = damper_terms(phase, mass_share)
    second = 2.0 * (j - gamma * a) / (3.0 * a * a) - gamma / (3.0 * a)
    s = 2.0 * r / (a * (1.0 - restitution)) * (1.0 + r * second / (1.0 - restitution))
    x, v = position_at(phase, together, s / h, scratch)
    g, rate = gap_at(phase, together, s / h, scratch)
    g -= z[2]
    return s, x + mass_share * g, v + mass_share * rate + mass_share * (1.0 - mass_share) * difference * g
