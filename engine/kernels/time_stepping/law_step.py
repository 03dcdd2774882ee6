"""The contact force of any law within a stage of a step.

Where the law takes them, the gap and its rate at the end of a stage are linear in λ, g = g₀ + aλ and g′ = r₀ + bλ with
a, b ≥ 0, so that one scalar equation is left,

    λ = L(−g₀ − aλ, −r₀ − bλ),                                                            (27)

L by Eqs. (6), (16) to (21) and (60) of :mod:`..equations.contact_law`. L falls with λ, hence the root lies between zero
and L(−g₀, −r₀), and that of the larger, or the smaller, of two forces is the larger, or the smaller, of their roots: so
are those of the laws that are piecewise linear,

    max(0, Kδ + cv),   Kδ + min(max(cv, −Kδ), Kδ) = max(0, min(Kδ + cv, 2Kδ)),   Kδ + c max(v, 0) = max(Kδ + cv, Kδ),
    Kδ + (r − 1)K max(δ − d, 0) + cv = max(Kδ + cv, rKδ + cv + (1 − r)Kd).

For the others Newton's method finds it. Where that does not converge, the secants of a bracket that always holds the
root do (Illinois: Dowell & Jarratt, BIT 11 (1971) 168), across the kinks of a law as well, to the last digits. Only the
law of constant restitution does not fall everywhere: where a contact is about to end, it pulls by √δ or more, and the
root lies beyond L(−g₀, −r₀).
"""

import math

from vibroscope.engine.kernels.compile.options import jit_inlined, jit_no_alloc
from vibroscope.engine.kernels.equations.contact_law import (
    FLORES,
    HUNT_CROSSLEY,
    IMPACT,
    OTHER,
    count_kinks,
    factors,
    gain_at,
    is_piecewise_linear,
    law_force,
    law_slopes,
    of_both,
)

SOLVES = 100  # secants, of which 6 to 10 are needed
WIDENINGS = 200  # of a bracket, each twice as far
CLOSE = 4 * 2.0**-52
NEWTON = 6  # iterations of Newton's method, of which two are needed
SLIGHT = 1e-6  # its step, times what of the slope is not 1, as a share of the force, after which another is rounding


@jit_inlined
def linear_root(stiffness, gain, push, gap, rate, by_gap, by_rate):
    """λ of Eq. (27) with the force Kδ + cv + f."""
    return (push - (stiffness * gap + gain * rate)) / (1.0 + stiffness * by_gap + gain * by_rate)


@jit_no_alloc
def solve_force(law, gain, gap, rate, by_gap, by_rate):
    """λ of Eq. (27).

    Parameters
    ----------
    law : ContactLaw
    gain : float
        c, or h of Eq. (18).
    gap, rate : float
        g₀ and r₀.
    by_gap, by_rate : float
        a and b.
    """
    if is_piecewise_linear(law.kind):  # the force of a step grows with that of the law, so that it has the same form
        found = linear_root(law.stiffness, gain, 0.0, gap, rate, by_gap, by_rate)
        for piece in range(OTHER, OTHER + count_kinks(law.kind)):
            a, b, f = factors(law, piece)
            push = f * law.stiffness * law.penetration
            own = linear_root(a * law.stiffness, b * gain, push, gap, rate, by_gap, by_rate)
            found = of_both(law.kind, piece, found, own)
        return found
    push = newton_root(law, gain, gap, rate, by_gap, by_rate) if HUNT_CROSSLEY <= law.kind <= IMPACT else math.nan
    return push if push == push else bracketed_root(law, gain, gap, rate, by_gap, by_rate)


@jit_inlined
def excess(law, gain, gap, rate, by_gap, by_rate, push):
    """What λ of Eq. (27) exceeds the force of the law by; it is zero at the root."""
    depth, speed = -gap - by_gap * push, -rate - by_rate * push
    return push - law_force(law, gain, depth, speed)


@jit_inlined
def newton_root(law, gain, gap, rate, by_gap, by_rate):
    """λ of Eq. (27) by Newton's method from λ = 0, its second step with the curvature that two slopes show; or NaN."""
    push, last, before = 0.0, 0.0, 0.0
    for i in range(NEWTON):
        depth, speed = -gap - by_gap * push, -rate - by_rate * push
        value = excess(law, gain, gap, rate, by_gap, by_rate, push)
        if abs(value) <= CLOSE * abs(push):
            return push
        if not depth > 0.0:
            break
        by_depth, by_speed = law_slopes(law, gain, depth, speed)
        by_depth, by_speed = by_gap * by_depth, by_rate * by_speed
        slope = 1.0 + (by_depth + by_speed)
        if not slope > 0.0:
            break
        over = 1.0 / slope
        change = -value * over
        if i > 0:
            change *= 1.0 - 0.5 * (slope - before) / (push - last) * change * over
            if law.kind <= FLORES and abs(change) * (abs(by_depth) + abs(by_speed)) <= SLIGHT * abs(push):
                return push + change  # these laws have no kink between the two
        last, before = push, slope
        push += change
    return math.nan


@jit_no_alloc
def bracketed_root(law, gain, gap, rate, by_gap, by_rate):
    """λ of Eq. (27) of a law that is not linear."""
    low, below = 0.0, excess(law, gain, gap, rate, by_gap, by_rate, 0.0)
    push = high = -below
    above = excess(law, gain, gap, rate, by_gap, by_rate, high)
    if above == 0.0 or high == 0.0:
        return push
    for _ in range(WIDENINGS):
        if (above > 0.0) != (below > 0.0):
            break
        low, below, high = high, above, 2.0 * high
        above = excess(law, gain, gap, rate, by_gap, by_rate, high)
    for _ in range(SOLVES):
        push = high - above * (high - low) / (above - below)
        value = excess(law, gain, gap, rate, by_gap, by_rate, push)
        if abs(value) <= CLOSE * abs(push) or abs(high - low) <= CLOSE * abs(push):
            break
        if (value > 0.0) != (above > 0.0):
            low, below = high, above
        else:
            below *= 0.5
        high, above = push, value
    return push


@jit_inlined
def gain_of(m, contact):
    """c, or h of Eq. (18), of the open contact."""
    return gain_at(m.law, m.sign * (contact.speed1 - contact.speed2))
