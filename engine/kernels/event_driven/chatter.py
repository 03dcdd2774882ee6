"""The rest of a chatter, infinitely many impacts in a finite time, in closed form.

Impacts conserve momentum, so the common motion ξ̄ = ξ₁ + s g, s = μ/(1 + μ), goes on smoothly, and the pendulums bounce
on each other in it: with k₁, k₂, c₁, c₂ as in :mod:`..equations.motion`, to first order in g,

    g″ = −A + J t − γ g′,    γ = c₂ − s (c₂ − c₁),    A = −g″ and J = g‴ − γA of the free motion from g = g′ = 0.

(γ matters: an impact turns g′, and so changes the acceleration at once.) Parting with the speed r, the flight

    g = r t − (A + γr) t²/2 + (J + γA + …) t³/6      ends after    t = 2r/A · [1 + r (2J/(3A²) − γ/(3A)) + …]

and leaves e of the speed at which it ends. Summed over the sequence that follows, the chatter lasts

    t∞ = 2r / (A(1 − e)) · [1 + r (2J/(3A²) − γ/(3A)) / (1 − e)] + O(r³).

The common motion feels a gap of order r² over a time of order r. Its series is taken from g = g′ = 0 as free motion,
where g falls to −At²/2 in place of bouncing back to zero; of what ξ̄″ = … − s(1 − s)(c₂ − c₁) g′ makes of that, the
part in ξ̄′ is of order r² and is taken back. So is all exact to O(r³), where the threshold ε that sticking needs
without this enters in the first power.
"""

from ..compile.options import bare
from ..linear.tables import GAP, find_gap, first_at, gap_at


@bare
def falling(phase, z, scratch):
    """−g″ and g‴ of the free gap at z."""
    h = phase.spacing
    find_gap(phase, z, scratch)
    return -2.0 * scratch.products[GAP + 2] / (h * h), 6.0 * scratch.products[GAP + 3] / (h * h * h)


@bare
def completes(phase, z, restitution, limit, scratch):
    """Whether the chatter that begins at z is sure to end in contact and is short enough to be summed.

    The expansion goes in powers of r |g‴| / (A²(1 − e)) and of t∞ against the time h/REACH of the fastest oscillation;
    both must be at most ``limit``.
    """
    r = z[3]
    if restitution >= 1.0:
        return False
    a, j = falling(phase, z, scratch)
    small = limit * (1.0 - restitution)
    return a > 0.0 and r * abs(j) <= small * a * a and 2.0 * r <= small * a * phase.spacing


@bare
def dampers(phase, mass_share):
    """c₂ − c₁ and γ, from how g″ holds −(c₂ − c₁) ξ₁′ − c₂ g′."""
    square = 2.0 / (phase.spacing * phase.spacing)
    apart = -square * phase.rows[1, GAP + 2]
    return apart, -square * phase.rows[3, GAP + 2] - mass_share * apart


@bare
def complete(phase, z, restitution, mass_share, scratch):
    """How long the chatter lasts, and ξ and ξ′ of the joined pendulums at its end."""
    r, h = z[3], phase.spacing
    together = (z[0], z[1] + mass_share * r, 0.0, 0.0, z[4], z[5])
    a, j = falling(phase, together, scratch)
    apart, gamma = dampers(phase, mass_share)
    bent = 2.0 * (j - gamma * a) / (3.0 * a * a) - gamma / (3.0 * a)
    s = 2.0 * r / (a * (1.0 - restitution)) * (1.0 + r * bent / (1.0 - restitution))
    x, v = first_at(phase, together, s / h, scratch)
    g, rate = gap_at(phase, together, s / h, scratch)
    return s, x + mass_share * g, v + mass_share * rate + mass_share * (1.0 - mass_share) * apart * g
