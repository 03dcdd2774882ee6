"""What happens at an event: impact, touch, release (MODEL.md, "Motion"; paper, section 2).

Reference: Newton's law; pendulums stick where the paper's do and part when the contact force falls to zero. Penalty:
nothing jumps; contact begins and ends where the gap passes zero.
"""

from ..compile.options import bare, inlined
from ..linear.tables import POWERS
from .chatter import complete, completes
from .state import COLLIDING, SEPARATED, TOUCHING, Anchor, Touch, after, clock, state, untouched

ROUNDING = 16 * 2.0**-52  # a derivative below this share of the numbers that make it up is not told from zero
HIGHEST_ORDER = 5  # derivatives tried where a phase starts on the surface


@inlined
def first_order(p, z, start):
    """Order and sign of the first derivative of the free gap, from order ``start`` on, that is told from zero.

    Returns (HIGHEST_ORDER + 1, 0.0) if none is. Contact changes none but those above the first that is not zero.
    """
    for order in range(start, HIGHEST_ORDER + 1):
        value, scale = 0.0, 0.0
        for i in range(6):
            term = p.flight.rows[i, POWERS + order] * z[i]
            value += term
            scale += abs(term)
        if abs(value) > ROUNDING * scale:
            return order, value
    return HIGHEST_ORDER + 1, 0.0


@inlined
def fly(a, v1, rate, order):
    """The anchor from which the pendulums part."""
    return Anchor(a.period, a.tau, a.x1, v1, 0.0, rate, SEPARATED, order, a.events, untouched())


@inlined
def touch(p, a, rate, order):
    """The anchor from which the pendulums touch.

    Joined ones move at the velocity (ξ₁′ + μξ₂′)/(1 + μ) that conserves momentum; pressed ones keep theirs.
    """
    opened = Touch(clock(p, a), max(-a.rate, 0.0), a.x1, a.v1, a.v1 + a.rate, 0.0)
    if p.rigid:
        return Anchor(a.period, a.tau, a.x1, a.v1 + p.mass_share * a.rate, 0.0, 0.0, TOUCHING, order, a.events, opened)
    return Anchor(a.period, a.tau, a.x1, a.v1, 0.0, rate, TOUCHING, order, a.events, opened)


@bare
def classify(p, a, start):
    """The phase that follows a touch without approach, the gap's derivatives below order ``start`` being zero.

    The first derivative of the free gap that is not zero decides: positive, the pendulums part; negative, or if all
    are zero, they touch.
    """
    order, value = first_order(p, state(p, a), start)
    rate = a.rate if order == 1 else 0.0
    if value > 0.0:
        return fly(a, a.v1, rate, float(order))
    if p.rigid:  # the force behaves as −g″: one derivative of the gap less two is the force's
        return touch(p, a, 0.0, float(max(0, min(order, HIGHEST_ORDER) - 2)))
    return touch(p, a, rate, float(min(order, HIGHEST_ORDER)))


@inlined
def impact(p, a):
    """Newton's law at g = 0, g′ < 0; sticks as the paper does, if g′⁺ ≤ ε and the force is compressive.

    With ε = 0 it sticks at the end of a chatter. The impulse is ξ₁′ before less ξ₁′ after: an impact that sticks takes
    the whole relative velocity, μ/(1 + μ) |g′⁻|, any other μ/(1 + μ) (1 + e) |g′⁻|.
    """
    parting = -p.restitution * a.rate
    common = a.v1 + p.mass_share * a.rate
    compressed = p.force_position * a.x1 + p.force_velocity * common > 0.0
    if parting <= p.threshold and compressed:
        return touch(p, a, 0.0, 0.0)
    return fly(a, common - p.mass_share * parting, parting, 1.0)


@inlined
def strike(p, a):
    """The anchor after an impact or a touch that is due."""
    if a.mode != COLLIDING:
        return a
    if a.rate < 0.0:
        return impact(p, a) if p.rigid else touch(p, a, a.rate, 1.0)
    return classify(p, a, 1)


@inlined
def settle(p, a):
    """The anchor after what follows from the start of a flight alone: too slow a start, or the rest of a chatter."""
    if a.mode != SEPARATED or a.order != 1.0:
        return a
    if p.rigid and p.threshold == 0.0:
        z = state(p, a)
        if completes(p.flight, z, p.restitution, p.completion, p.scratch):
            s, x, v = complete(p.flight, z, p.restitution, p.mass_share, p.scratch)
            return touch(p, after(p, a, s, (x, v, 0.0, 0.0), SEPARATED, 0.0, a.touch), 0.0, 0.0)
    if a.rate <= ROUNDING * (abs(a.v1) + abs(a.x1)):
        return classify(p, a, 2)  # so slow that rounding hides it: higher derivatives decide
    return a


@bare
def parts(p, a):
    """Whether pendulums that the contact force lets go do part.

    The force is −μ/(1 + μ) g″ of the free gap, yet joined pendulums feel a joint damping that free ones do not: where
    it is far from what the two dampers add up to, the free gap may fall although the force falls too.
    """
    if not p.rigid or a.mode != SEPARATED or a.order < 3.0:
        return True
    return first_order(p, state(p, a), 3)[1] >= 0.0


@inlined
def release(p, a, s, x1, v1, slope):
    """The anchor s later, where a contact ends.

    Joined pendulums part with g, g′ and g″ vanishing together; pressed ones with the rate at which penetration ends.
    """
    if p.rigid:
        return after(p, a, s, (x1, v1, 0.0, 0.0), SEPARATED, 3.0, a.touch)
    return after(p, a, s, (x1, v1, 0.0, -slope), SEPARATED if slope < 0.0 else COLLIDING, 1.0, a.touch)
