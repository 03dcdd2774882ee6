"""What happens at an event: impact, touch, release (paper, section 2).

**Reference.** Newton's impact law at g = 0, g′ < 0: with ξ₁′ + μξ₂′ conserved,

    g′⁺ = −e g′⁻,    impulse = μ/(1 + μ) (1 + e) |g′⁻|                                     (9)

Permanent contact begins with an impact that leaves g′⁺ ≤ ε while the contact force of the joined bodies, Eq. (8), is
compressive; it takes the whole relative velocity, impulse μ/(1 + μ) |g′⁻|. It ends when that force falls to zero.

**Penalty.** Nothing jumps: contact begins and ends where the gap passes zero.

**Degenerate starts.** Where gap and gap rate vanish together (a start at rest, the end of a permanent contact), the
first derivative of the free gap that is not zero decides: positive, the bodies separate; negative, they touch.

The end of a chatter, infinitely many impacts in a finite time, summed in closed form.

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
from vibroscope.engine.kernels.compile.record import OpenContact, no_contact
from vibroscope.engine.kernels.equations.motion import displacements
from vibroscope.engine.kernels.event_driven.state import (
    COLLISION,
    CONTACT,
    FLIGHT,
    ROUNDING,
    at_once,
    later_state,
    linear_state,
    load_at,
    time_of,
    time_to_load_change,
)
from vibroscope.engine.kernels.linear.tables import GAP, POWERS, find_gap, gap_at, position_at, pulled_by

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


HIGHEST_ORDER = 5  # derivatives tried where a phase starts on the surface


@jit_inlined
def first_nonzero_derivative(phase, z, start):
    """Order and value of the first derivative of what a phase watches, from ``start`` on, not zero within rounding.

    Returns (HIGHEST_ORDER + 1, 0.0) if there is none. Of the free gap the contact force changes only derivatives of a
    higher order. The value is a coefficient in powers of u = s/h, which has the sign of the derivative.
    """
    for order in range(start, HIGHEST_ORDER + 1):
        value = pulled_by(phase, POWERS + order)
        scale = abs(value)
        for i in range(6):
            term = phase.rows[i, POWERS + order] * z[i]
            value += term
            scale += abs(term)
        if abs(value) > ROUNDING * scale:
            return order, value
    return HIGHEST_ORDER + 1, 0.0


@jit_inlined
def begin_flight(a, v1, rate, order):
    """The hybrid state from which the bodies separate."""
    return at_once(a, v1, 0.0, rate, FLIGHT, order, no_contact())


@jit_inlined
def opened_contact(p, a):
    """The contact that begins at a hybrid state."""
    x1, v1, _, v2 = displacements(p, a.x1, a.v1, a.gap, a.rate)
    return OpenContact(time_of(p, a), max(-a.rate, 0.0), x1, v1, v2, 0.0)


@jit_inlined
def begin_contact(p, a, rate, order):
    """The hybrid state from which the bodies touch.

    Joined bodies move at the velocity (ξ₁′ + μξ₂′)/(1 + μ) that conserves momentum; pressed ones keep theirs.
    """
    opened = opened_contact(p, a)
    if p.rigid:
        return at_once(a, a.v1 + p.mass_share * a.rate, 0.0, 0.0, CONTACT, order, opened)
    return at_once(a, a.v1, 0.0, rate, CONTACT, order, opened)


@jit_no_alloc
def separate_or_touch(p, a, start):
    """The phase that follows a touch without approach, the gap's derivatives below order ``start`` being zero."""
    order, value = first_nonzero_derivative(p.flight, linear_state(p, p.flight, a), start)
    rate = a.rate if order == 1 else 0.0
    if value > 0.0:
        return begin_flight(a, a.v1, rate, float(order))
    if p.rigid:  # the force is proportional to −g″: its first derivative that is not zero is two orders lower
        return begin_contact(p, a, 0.0, float(max(0, min(order, HIGHEST_ORDER) - 2)))
    return begin_contact(p, a, rate, float(min(order, HIGHEST_ORDER)))


@jit_inlined
def other_force(p, share):
    """What the contact force does not owe to the motion; ``share`` of the period."""
    if p.force_cosine == 0.0 and p.force_sine == 0.0:
        return p.force_constant
    c, s = load_at(p, share * p.period, share)
    return p.force_constant + (p.force_cosine * c + p.force_sine * s)


@jit_inlined
def joint_force_at(p, x1, v1, share):
    """Contact force of the joined bodies, Eq. (8); ``share`` of the period."""
    return p.force_position * x1 + p.force_velocity * v1 + other_force(p, share)


@jit_inlined
def impact(p, a):
    """Newton's law, Eq. (9), at g = 0, g′ < 0; or the beginning of a permanent contact.

    With ε = 0 permanent contact begins only at the end of a chatter, or at an impact with e = 0.
    """
    parting = -p.restitution * a.rate  # Eq. (9)
    common = a.v1 + p.mass_share * a.rate
    if parting <= p.threshold and joint_force_at(p, a.x1, common, a.tau / p.period) > 0.0:
        return begin_contact(p, a, 0.0, 0.0)
    return begin_flight(a, common - p.mass_share * parting, parting, 1.0)


@jit_inlined
def resolve_collision(p, a):
    """The hybrid state after an impact or a touch that is due."""
    if a.mode != COLLISION:
        return a
    if a.rate < 0.0:
        return impact(p, a) if p.rigid else begin_contact(p, a, a.rate, 1.0)
    return separate_or_touch(p, a, 1)


@jit_inlined
def is_hidden(p, a):
    """Whether rounding hides the rate with which a flight begins, so that higher derivatives decide.

    What rounds is the motion of body 1, if it is no wall, and the distance of the gap from its equilibrium.
    """
    return a.rate <= ROUNDING * (abs(a.v1) + abs(a.x1) + abs(p.flight.gap))


@jit_inlined
def resolve_flight_start(p, a):
    """The hybrid state after what the start of a flight alone decides: the rest of a chatter, or too slow a start."""
    if a.mode != FLIGHT or a.order != 1.0:
        return a
    if p.rigid and p.threshold == 0.0:
        z = linear_state(p, p.flight, a)
        near = a.rate * p.completion * p.flight.spacing < p.play  # bounces that do not reach another stop
        if near and can_sum(p.flight, z, p.restitution, p.completion, p.scratch):
            s, x, v = sum_up(p.flight, z, p.restitution, p.mass_share, p.scratch)
            if s <= time_to_load_change(p, a.tau):
                end = later_state(p, a, s, (x + p.flight.position, v, 0.0, 0.0), FLIGHT, 0.0, a.contact)
                return begin_contact(p, end, 0.0, 0.0)
    if is_hidden(p, a):
        return separate_or_touch(p, a, 2)
    return a


@jit_inlined
def can_separate(p, a):
    """Whether bodies that the contact force releases do separate.

    The force is −μ/(1 + μ) g″ of the free gap, yet joined bodies feel a joint damping that free ones do not. Where it
    is far from the sum of the two dampers, the free gap may fall although the force falls too.
    """
    if not p.rigid or a.mode != FLIGHT or a.order < 3.0:
        return True
    return first_nonzero_derivative(p.flight, linear_state(p, p.flight, a), 3)[1] >= 0.0


@jit_no_alloc
def remain_in_contact(p, a):
    """The contact that goes on where its force touches zero, from bodies that cannot separate; else ``a`` as it is.

    A force that touches zero may pass it by rounding, as that of a preload whose largest opening force is as large.
    """
    order, value = first_nonzero_derivative(p.contact, linear_state(p, p.contact, a), 1)
    return begin_contact(p, a, 0.0, float(order)) if value > 0.0 else a


@jit_no_alloc
def first_nonzero(phase, z):
    """Order and value of what a phase watches, or of its first derivative that is not zero within rounding."""
    value, scale = phase.watched, abs(phase.watched)
    for i in range(6):
        term = phase.rows[i, POWERS] * z[i]
        value += term
        scale += abs(term)
    return (0, value) if abs(value) > ROUNDING * scale else first_nonzero_derivative(phase, z, 1)


@jit_no_alloc
def resolve_load_change(p, a):
    """The hybrid state where the load jumps or bends: a contact may open at once, and its fast modes are excited."""
    if a.mode == FLIGHT or a.mode == COLLISION:
        return a
    order, value = first_nonzero(p.contact, linear_state(p, p.contact, a))
    gap, mode = (0.0 if order > 0 else a.gap), CONTACT
    if value < 0.0:  # the reference's force is −g″ of the free gap, the penalty's contact ends with −g
        gap, mode, order = 0.0, FLIGHT, order + 2 if p.rigid else max(order, 1)
    return at_once(a, a.v1, gap, a.rate, mode, float(min(order, HIGHEST_ORDER)), a.contact)


@jit_inlined
def release(p, a, s, x1, v1, slope):
    """The hybrid state s later, where a contact ends.

    Joined bodies separate with g, g′ and g″ zero together; pressed ones at the rate at which penetration ends.
    """
    if p.rigid:
        return later_state(p, a, s, (x1, v1, 0.0, 0.0), FLIGHT, 3.0, a.contact)
    return later_state(p, a, s, (x1, v1, 0.0, -slope), FLIGHT if slope < 0.0 else COLLISION, 1.0, a.contact)
