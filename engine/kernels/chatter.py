"""The rest of a chatter, infinitely many impacts in a finite time, in closed form.

Let the pendulums part with the speed r from g = 0 under the relative acceleration −a and the jerk j = g‴. The flight

    g = r s − a s²/2 + j s³/6 + …      ends after    t = 2r/a + 4jr²/(3a³) + O(r³)

with the closing speed r − (2/3) j r²/a² + O(r³), of which e is left; the next flight has the acceleration −a + jt.
Summed over the geometric sequence that follows, the chatter lasts

    t∞ = 2r / (a(1 − e)) · [1 + 2jr / (3a²(1 − e))] + O(r³).

Impacts conserve momentum, so the common motion ξ̄ = ξ₁ + μ/(1 + μ) g goes on smoothly; the gap that it feels is of
order r² over a time of order r. Position and velocity at t∞ from the series at g = g′ = 0 therefore are exact to O(r³),
and so is the whole: the threshold ε that sticking needs without this enters in the first power.
"""

from .jit import bare, inlined
from .phase import GAP, find_gap, first_at, gap_at


@inlined
def falling(phase, z, scratch):
    """(a, j) of the free gap at z."""
    h = phase.spacing
    find_gap(phase, z, scratch)
    return -2.0 * scratch.products[GAP + 2] / (h * h), 6.0 * scratch.products[GAP + 3] / (h * h * h)


@bare
def completes(phase, z, restitution, limit, scratch):
    """Whether the chatter that begins at z is sure to end in contact and is short enough to be summed.

    The expansion goes in powers of r |j| / (a²(1 − e)) and of t∞ against the time h/REACH of the fastest oscillation;
    both must be at most ``limit``.
    """
    r = z[3]
    if restitution >= 1.0:
        return False
    a, j = falling(phase, z, scratch)
    small = limit * (1.0 - restitution)
    return a > 0.0 and r * abs(j) <= small * a * a and 2.0 * r <= small * a * phase.spacing


@bare
def complete(phase, z, restitution, mass_share, scratch):
    """How long the chatter lasts, and ξ and ξ′ of the joined pendulums at its end."""
    r, h = z[3], phase.spacing
    a, j = falling(phase, z, scratch)
    share = 2.0 * r / (3.0 * (1.0 - restitution))
    s = 3.0 * share / a * (1.0 + share * j / (a * a))
    together = (z[0], z[1] + mass_share * r, 0.0, 0.0, z[4], z[5])
    x, v = first_at(phase, together, s / h, scratch)
    g, rate = gap_at(phase, together, s / h, scratch)
    return s, x + mass_share * g, v + mass_share * rate
